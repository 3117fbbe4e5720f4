//! How far the reduction of the parts puts frequencies and map off, over the positions of a run.

use super::PipelineError;
use crate::coupling::CoupledModel;
use crate::frf::{FrfError, FrfRequest, ModalSystem, Quantity, modal_sum};
use crate::machine::Machine;
use crate::modal::{ModeFamilies, ModeTableRow, Modes, ReductionEstimate, modes_at, reduction_estimate};
use crate::reduction::Superelement;
use rayon::prelude::*;

/// Largest estimate of a frequency's relative error that passes.
pub const FREQUENCY_BOUND: f64 = 1e-3;
/// Largest estimate of the map's relative error (Frobenius norm over outputs and inputs) that passes.
pub const MAP_BOUND: f64 = 0.05;
/// Frequencies at which the map's error is looked at.
const PROBES: usize = 200;
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
    if superelements.iter().all(|s| s.beyond.n() == 0) {
        // Every part is whole: nothing was left out.
        let exact = |m: &Modes| ReductionEstimate {
            position: m.position,
            frequencies: vec![0.0; m.eigenvalues.len() - m.free],
        };
        return Ok(ReductionErrors { estimates: modes.first().map(exact).into_iter().collect() });
    }
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
        Ok(reduction_estimate(model, superelements, modes, wanted)?)
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

    /// One list a position, by rank, free motions (which have none) included.
    pub fn by_rank(&self, families: &ModeFamilies, modes: &[Modes]) -> Vec<Vec<Option<f64>>> {
        let of = |(tracked, modes): (&Vec<crate::modal::TrackedMode>, &Modes)| {
            tracked.iter().map(|t| self.at(modes.position, (t.rank - 1).checked_sub(modes.free)?)).collect()
        };
        families.modes.iter().zip(modes).map(of).collect()
    }

    /// Writes the largest estimate of each family into the mode table.
    pub fn fill(&self, table: &mut [ModeTableRow], families: &ModeFamilies, modes: &[Modes]) {
        let errors = self.by_rank(families, modes);
        for row in table {
            let own = families.modes.iter().zip(&errors).flat_map(|(tracked, errors)| tracked.iter().zip(errors));
            let own = own.filter(|(t, _)| t.family == row.family).filter_map(|(_, error)| *error);
            row.reduction_error = own.reduce(f64::max);
        }
    }

    /// Largest relative change of the receptance (Frobenius norm over outputs and inputs) over frequencies up to
    /// `highest` (Hz) when every mode is lowered by its estimate; 0 Hz and undamped maps, which have no finite
    /// peak, give `None`.
    ///
    /// # Errors
    /// [`FrfError`] of the sum.
    pub fn map(&self, positions: &[f64], systems: &[ModalSystem], highest: f64) -> Result<Option<f64>, FrfError> {
        let damped = |s: &ModalSystem| {
            let each = s.frequencies.iter().zip(s.damping_ratios.iter().zip(&s.loss_factors));
            each.clone().all(|(f, (zeta, eta))| *f == 0.0 || zeta + eta > 0.0)
        };
        if highest <= 0.0 || !systems.iter().all(damped) {
            return Ok(None);
        }
        let grid: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).collect();
        let mut worst: f64 = 0.0;
        for estimate in &self.estimates {
            let Some(at) = positions.iter().position(|p| *p == estimate.position) else { continue };
            let mut lowered = systems[at].clone();
            let free = lowered.frequencies.iter().take_while(|f| **f == 0.0).count();
            for (f, error) in lowered.frequencies.iter_mut().skip(free).zip(&estimate.frequencies) {
                *f *= 1.0 - error.min(1.0);
            }
            // A mode at a probe would be judged by its flank: the peaks are looked at too.
            let peaks = systems[at].frequencies.iter().copied().filter(|f| *f > 0.0 && *f <= highest);
            let mut grid: Vec<f64> = grid.iter().copied().chain(peaks).collect();
            grid.sort_by(f64::total_cmp);
            grid.dedup();
            let names = |n: usize| (0..n).map(|k| k.to_string()).collect::<Vec<_>>();
            let (outputs, inputs) = (names(lowered.outputs.nrows()), names(lowered.inputs.nrows()));
            let pair = outputs.len() * inputs.len();
            let sum = |system: &ModalSystem| {
                modal_sum(&FrfRequest {
                    positions: &positions[at..=at],
                    systems: std::slice::from_ref(system),
                    frequencies: &grid,
                    outputs: &outputs,
                    inputs: &inputs,
                    quantity: Quantity::Receptance,
                })
            };
            let (own, other) = (sum(&systems[at])?, sum(&lowered)?);
            for (a, b) in own.values.chunks(pair).zip(other.values.chunks(pair)) {
                let size = a.iter().map(|h| h.norm_sqr()).sum::<f64>();
                let change = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum::<f64>();
                worst = worst.max((change / size.max(f64::MIN_POSITIVE)).sqrt());
            }
        }
        Ok(Some(worst))
    }
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
