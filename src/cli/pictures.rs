//! The map that pictures are drawn from: the same modes on a grid fine enough for narrow peaks, and never more of it than
//! a picture shows.

use super::map::Axes;
use anyhow::Result;
use nalgebra::Complex;
use stiffmap::frf::{ComplianceMap, ModalSystem, Tile, modal_sum_tiles};
use stiffmap::interrupt::Interrupt;
use stiffmap::pipeline::PipelineError;

/// Positions that a picture is made of, at most.
const POSITIONS: usize = 200;
/// Frequencies that a picture is made of, about: a coarser grid is divided, a finer one gathered.
const FREQUENCIES: usize = 3600;
/// Values that a picture's map may hold.
const VALUES: usize = 6_000_000;

/// The map for pictures. Of frequencies that are gathered the largest value stands for all, so that peaks stay.
pub fn picture_map(axes: &Axes, systems: &[ModalSystem], interrupt: &Interrupt) -> Result<ComplianceMap> {
    let chosen = spread(axes.positions.len(), POSITIONS);
    let per_pair = axes.outputs.len() * axes.inputs.len();
    let wanted = FREQUENCIES.min(VALUES / (chosen.len() * per_pair)).max(1);
    let (evaluated, group) = grid(&axes.frequencies, wanted);
    let shown: Vec<f64> = evaluated.chunks(group).map(|c| 0.5 * (c[0] + c[c.len() - 1])).collect();
    let fine =
        Axes { positions: chosen.iter().map(|&p| axes.positions[p]).collect(), frequencies: evaluated, ..axes.clone() };
    let systems: Vec<ModalSystem> = chosen.iter().map(|&p| systems[p].clone()).collect();
    let n_shown = shown.len();
    let mut values = vec![Complex::default(); chosen.len() * n_shown * per_pair];
    let mut sink = |tile: Tile<'_>| {
        if interrupt.requested() {
            return Err(PipelineError::Interrupted.into());
        }
        let rows = tile.values.chunks_exact(tile.range.frequencies.len() * per_pair);
        for (p, row) in tile.range.positions.zip(rows) {
            for (f, pair) in tile.range.frequencies.clone().zip(row.chunks_exact(per_pair)) {
                let at = (p * n_shown + f / group) * per_pair;
                for (held, value) in values[at..at + per_pair].iter_mut().zip(pair) {
                    if value.norm_sqr() > held.norm_sqr() {
                        *held = *value;
                    }
                }
            }
        }
        Ok(())
    };
    let computed = modal_sum_tiles(&fine.request(&systems), 0, &mut sink);
    if interrupt.requested() {
        return Err(PipelineError::Interrupted.into());
    }
    computed?;
    Ok(ComplianceMap {
        positions: fine.positions,
        frequencies: shown,
        outputs: fine.outputs,
        inputs: fine.inputs,
        quantity: fine.quantity,
        values,
    })
}

/// At most `most` of `n` indices, evenly spread, both ends among them.
fn spread(n: usize, most: usize) -> Vec<usize> {
    if n <= most { (0..n).collect() } else { (0..most).map(|i| i * (n - 1) / (most - 1)).collect() }
}

/// The frequencies to evaluate for about `wanted`, and how many of them are gathered into one.
fn grid(given: &[f64], wanted: usize) -> (Vec<f64>, usize) {
    let divide = (wanted / given.len()).max(1);
    let mut frequencies: Vec<f64> = given
        .windows(2)
        .flat_map(|w| (0..divide).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / divide as f64))
        .collect();
    frequencies.extend(given.last());
    let group = if divide > 1 { 1 } else { frequencies.len().div_ceil(wanted) };
    (frequencies, group)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use stiffmap::frf::Quantity;

    #[test]
    fn a_picture_shows_the_peaks_of_a_map_that_is_too_large_for_it() {
        let n = 1001;
        let shapes = DMatrix::from_element(1, 1, 0.05);
        let system = |p: usize| ModalSystem {
            frequencies: vec![100.0 + 0.001 * p as f64],
            damping_ratios: vec![1e-4],
            loss_factors: vec![0.0],
            outputs: shapes.clone(),
            inputs: shapes.clone(),
            residual: Vec::new(),
            exact: None,
        };
        let systems: Vec<ModalSystem> = (0..n).map(system).collect();
        let axes = Axes {
            positions: (0..n).map(|p| -1e-3 * p as f64).collect(),
            frequencies: (0..20_001).map(|k| 90.0 + 1e-3 * k as f64).collect(),
            outputs: vec!["x".into()],
            inputs: vec!["x".into()],
            quantity: Quantity::Receptance,
        };
        let map = picture_map(&axes, &systems, &Interrupt::default()).unwrap();
        assert_eq!((map.positions.len(), map.positions[0], map.positions[199]), (200, 0.0, -1.0));
        assert!(map.frequencies.len() <= 3600 && map.frequencies.windows(2).all(|w| w[0] < w[1]));
        let peak = 0.05f64.powi(2) / (std::f64::consts::TAU * 100.0).powi(2) / 2e-4;
        let row = &map.values[..map.frequencies.len()];
        let shown = row.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!((shown / peak - 1.0).abs() < 1e-3, "{shown:e} of {peak:e}");
        let sampled = row.iter().step_by(2).map(|v| v.norm()).fold(0.0, f64::max);
        assert!(sampled <= shown);
        assert_eq!(grid(&[0.0, 1.0], 5), (vec![0.0, 0.5, 1.0], 1));
    }
}
