//! How far the reduction of the parts, and the fixed basis after it, put frequencies and map off, over the positions
//! of a run.

use super::{GUARD, PipelineError};
use crate::coupling::CoupledModel;
use crate::frf::{FrfError, FrfRequest, ModalSystem, Quantity, modal_sum};
use crate::machine::Machine;
use crate::modal::{
    MissingMotion, ModeFamilies, ModeTableRow, Modes, ReductionEstimate, SAFETY, modes_at, reduction_estimate,
};
use crate::reduction::Superelement;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Largest estimate of a frequency's relative error that passes.
pub const FREQUENCY_BOUND: f64 = 1e-3;
/// Largest estimate of the map's relative error (Frobenius norm over outputs and inputs) that passes.
pub const MAP_BOUND: f64 = 0.05;
/// Frequencies at which the map's error is looked at, besides those of the modes.
const PROBES: usize = 40;
/// Component modes should reach to this multiple of the highest frequency.
const ENOUGH: f64 = 1.5;

/// The estimates at the first, middle and last position of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReductionErrors {
    /// One a position that was looked at.
    pub estimates: Vec<ReductionEstimate>,
}

/// A mode and the estimate of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstMode {
    /// Relative error of its frequency.
    pub error: f64,
    /// Position, m.
    pub position: f64,
    /// Rank among the elastic modes, 1-based.
    pub rank: usize,
    /// Frequency, Hz.
    pub frequency: f64,
}

/// The estimates for the `reported` lowest elastic modes and all others up to `highest` (Hz).
///
/// # Errors
/// [`PipelineError::Modal`].
pub fn reduction_errors(
    machine: &Machine,
    superelements: &[Superelement],
    model: &CoupledModel,
    modes: &[Modes],
    reported: usize,
    highest: f64,
) -> Result<ReductionErrors, PipelineError> {
    let mut looked_at = vec![0, modes.len() / 2, modes.len().saturating_sub(1)];
    looked_at.dedup();
    let one = |&k: &usize| -> Result<ReductionEstimate, PipelineError> {
        let again;
        let modes = if modes[k].shapes.ncols() == modes[k].eigenvalues.len() {
            &modes[k]
        } else {
            again = modes_at(model, &machine.analysis.damping, modes[k].position)?;
            &again
        };
        let wanted = reported.max(modes.count_up_to(highest).saturating_sub(modes.free));
        let mut estimate = reduction_estimate(model, superelements, modes, wanted)?;
        // What the fixed basis adds is known: the superelements themselves say it.
        let block = (modes.free + wanted + GUARD).min(modes.eigenvalues.len());
        let start = model.over_parts(&modes.shapes.columns(0, block).into_owned());
        let exact = model.side_by_side.eigenvalues_near(modes.position, &start, model.shift())?;
        for (r, error) in estimate.frequencies.iter_mut().enumerate() {
            let r = modes.free + r;
            *error += ((modes.eigenvalues[r] / exact[r]).sqrt() - 1.0).max(0.0);
        }
        Ok(estimate)
    };
    Ok(ReductionErrors { estimates: looked_at.par_iter().map(one).collect::<Result<_, _>>()? })
}

impl ReductionErrors {
    /// The estimate of an elastic mode (rank from 0) at the position looked at that is nearest.
    pub fn at(&self, position: f64, rank: usize) -> Option<f64> {
        let distance = |e: &ReductionEstimate| (e.position - position).abs();
        let nearest = self.estimates.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        nearest.frequencies.get(rank).copied()
    }

    /// The mode with the largest estimate.
    pub fn worst(&self, modes: &[Modes]) -> Option<WorstMode> {
        let of = |e: &ReductionEstimate| {
            let modes = modes.iter().find(|m| m.position == e.position)?;
            let (rank, error) = e.frequencies.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            let frequency = modes.frequency(modes.free + rank);
            Some(WorstMode { error: *error, position: e.position, rank: rank + 1, frequency })
        };
        self.estimates.iter().filter_map(of).max_by(|a, b| a.error.total_cmp(&b.error))
    }

    /// One list a position, by rank; free motions are exact.
    pub fn by_rank(&self, families: &ModeFamilies, modes: &[Modes]) -> Vec<Vec<Option<f64>>> {
        let of = |(tracked, modes): (&Vec<crate::modal::TrackedMode>, &Modes)| {
            let error = |rank: usize| match rank.checked_sub(modes.free) {
                Some(rank) => self.at(modes.position, rank),
                None => Some(0.0),
            };
            tracked.iter().map(|t| error(t.rank - 1)).collect()
        };
        families.modes.iter().zip(modes).map(of).collect()
    }

    /// Writes the largest estimate of each family into the mode table.
    pub fn fill(&self, table: &mut [ModeTableRow], families: &ModeFamilies, modes: &[Modes]) {
        let errors = self.by_rank(families, modes);
        for row in table {
            let own = families.modes.iter().zip(&errors).flat_map(|(tracked, errors)| tracked.iter().zip(errors));
            let own = own.filter(|(t, _)| t.family == row.family && t.frequency > 0.0).filter_map(|(_, error)| *error);
            row.reduction_error = own.reduce(f64::max);
        }
    }

    /// Largest relative change of the receptance (Frobenius norm over outputs and inputs) over frequencies up to
    /// `highest` (Hz) by the motions that the reduction lacks; a map without frequencies or damping, which has no
    /// finite peak, gives `None`.
    ///
    /// # Errors
    /// [`FrfError`] of the sum.
    pub fn map(&self, positions: &[f64], systems: &[ModalSystem], highest: f64) -> Result<Option<f64>, FrfError> {
        if systems.iter().any(|s| s.frequencies.is_empty()) {
            return Ok(None);
        }
        let damped = |s: &ModalSystem| {
            let each = s.frequencies.iter().zip(s.damping_ratios.iter().zip(&s.loss_factors));
            each.clone().all(|(f, (zeta, eta))| *f == 0.0 || zeta + eta > 0.0)
        };
        if highest <= 0.0 || !systems.iter().all(damped) {
            return Ok(None);
        }
        let mut worst: f64 = 0.0;
        for estimate in &self.estimates {
            let Some(at) = positions.iter().position(|p| *p == estimate.position) else { continue };
            let system = &systems[at];
            // A mode at a probe would be judged by its flank: the peaks are looked at too.
            let peaks = system.frequencies.iter().copied().filter(|f| *f > 0.0 && *f <= highest);
            let mut grid: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).chain(peaks).collect();
            grid.sort_by(f64::total_cmp);
            grid.dedup();
            let names = |n: usize| (0..n).map(|k| k.to_string()).collect::<Vec<_>>();
            let (outputs, inputs) = (names(system.outputs.nrows()), names(system.inputs.nrows()));
            let map = modal_sum(&FrfRequest {
                positions: &positions[at..=at],
                systems: std::slice::from_ref(system),
                frequencies: &grid,
                outputs: &outputs,
                inputs: &inputs,
                quantity: Quantity::Receptance,
            })?;
            for (f, own) in grid.iter().zip(map.values.chunks(outputs.len() * inputs.len())) {
                let size = own.iter().map(|h| h.norm_sqr()).sum::<f64>().sqrt();
                worst = worst.max(SAFETY * change(system, &estimate.motions, *f).norm() / size.max(f64::MIN_POSITIVE));
            }
        }
        Ok(Some(worst))
    }
}

/// What the motions that the reduction lacks change of the receptance at a frequency (Hz), m/N: with the modes'
/// weights w_r = 1 / (lambda_r - omega^2 + ..) and the residual of each mode, g_zr = z^T (K - lambda_r M) V x_r,
///
/// ```text
/// dH = sum_z (sum_r L_r w_r g_zr) (sum_q g_zq w_q R_q) / (Lambda_z - omega^2 + ..)
/// ```
fn change(system: &ModalSystem, motions: &[MissingMotion], frequency: f64) -> DMatrix<Complex<f64>> {
    let omega = TAU * frequency;
    let free = system.frequencies.iter().take_while(|f| **f == 0.0).count();
    let last = system.frequencies.len() - 1;
    let weight = |lambda: f64, r: usize| {
        let viscous = 2.0 * system.damping_ratios[r] * lambda.sqrt() * omega;
        Complex::new(lambda - omega * omega, lambda * system.loss_factors[r] + viscous).inv()
    };
    let modes = (system.frequencies.len() - free).min(motions.first().map_or(0, |z| z.mass.len()));
    let squares: Vec<f64> = (0..modes).map(|r| (TAU * system.frequencies[free + r]).powi(2)).collect();
    let weights: Vec<Complex<f64>> = (0..modes).map(|r| weight(squares[r], free + r)).collect();
    let (outputs, inputs) = (system.outputs.nrows(), system.inputs.nrows());
    let mut out = DMatrix::zeros(outputs, inputs);
    for z in motions {
        let own = weight(z.eigenvalue, last);
        let felt: Vec<Complex<f64>> =
            (0..modes).map(|r| weights[r] * (z.stiffness[r] - squares[r] * z.mass[r])).collect();
        let through = |rows: &DMatrix<f64>, k: usize| {
            felt.iter().enumerate().map(|(r, g)| g * rows[(k, free + r)]).sum::<Complex<f64>>()
        };
        let left: Vec<_> = (0..outputs).map(|i| through(&system.outputs, i)).collect();
        let right: Vec<_> = (0..inputs).map(|j| through(&system.inputs, j)).collect();
        for (i, l) in left.iter().enumerate() {
            for (j, r) in right.iter().enumerate() {
                out[(i, j)] += own * l * r;
            }
        }
    }
    out
}

/// The parts whose component modes, fixed in number by the machine file, end below 1.5 times the highest
/// frequency (Hz), in words.
pub fn few_component_modes(machine: &Machine, superelements: &[Superelement], highest: f64) -> Vec<String> {
    if machine.analysis.component.follows {
        return Vec::new();
    }
    let few = superelements.iter().filter(|s| s.beyond.n() > 0).filter_map(|s| {
        let last = s.component_frequencies.last().copied().unwrap_or(0.0);
        (last < ENOUGH * highest).then(|| format!("\"{}\" ({last:.0} Hz)", s.part))
    });
    let few: Vec<String> = few.collect();
    if few.is_empty() {
        return few;
    }
    vec![format!(
        "the component modes that the machine file fixes end below {ENOUGH} times the highest frequency of {highest} Hz \
         for {}; give [analysis] component more `modes`, or leave `modes` and `band` out, so that they follow the \
         frequency",
        few.join(", ")
    )]
}
