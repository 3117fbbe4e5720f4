//! The plain way to answer a design: its modes at every position, nothing shared between designs but the model.

use super::{Design, Evaluation, Evaluator, PartScale, PositionMetrics, SweepError};
use crate::coupling::{AtPosition, CoupledModel};
use crate::frf::metrics::{direct_pairs, metrics};
use crate::frf::{FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use crate::modal::{ModalError, Modes, modes_of, track};
use rayon::prelude::*;

/// Modes of the whole basis at each position, then the modal sum on the grid, then refined extrema.
#[derive(Debug)]
pub struct ModesDirect {
    model: CoupledModel,
    at: Vec<AtPosition>,
    positions: Vec<f64>,
    frequencies: Vec<f64>,
    families: Vec<usize>,
}

impl ModesDirect {
    /// Prepares the positions (m), a frequency grid (Hz) and the families whose frequencies are wanted.
    ///
    /// # Errors
    /// [`SweepError::Coupling`] for a position outside the travel.
    pub fn new(
        model: CoupledModel,
        positions: &[f64],
        frequencies: &[f64],
        families: &[usize],
    ) -> Result<Self, SweepError> {
        let at = positions.iter().map(|p| model.at(*p)).collect::<Result<Vec<_>, _>>()?;
        let (positions, frequencies) = (positions.to_vec(), frequencies.to_vec());
        Ok(Self { model, at, positions, frequencies, families: families.to_vec() })
    }

    fn one(&self, design: &Design) -> Result<Evaluation, SweepError> {
        if let Some(scale) = design.parts.iter().find(|s| **s != PartScale::NOMINAL) {
            let seen = if scale.young == 1.0 { scale.density } else { scale.young };
            let what = "a factor on a part's material by the plain route".to_owned();
            return Err(SweepError::Value { what, seen, allowed: "1" });
        }
        let mut model = self.model.clone();
        for (joint, changed) in model.side_by_side.joints.iter_mut().zip(&design.machine.joints) {
            joint.loss_factor = changed.loss_factor;
            for (spring, changed) in joint.springs.iter_mut().zip(&changed.springs) {
                (spring.stiffness, spring.damping) = (changed.stiffness, changed.damping);
            }
        }
        let damping = &design.machine.analysis.damping;
        let reported = self.families.iter().copied().max().unwrap_or(0);
        let solve = |at: &AtPosition| -> Result<Modes, ModalError> {
            let stiffness = model.stiffness(at.position)?;
            modes_of(&model, damping, at, &stiffness, model.n().min(reported + 30))
        };
        let modes = self.at.par_iter().map(solve).collect::<Result<Vec<Modes>, ModalError>>()?;
        let highest = self.frequencies.last().copied().unwrap_or_default();
        let (systems, _) = modal_systems(&modes, highest, Selection::Controlled { tolerance: 1e-4 })?;
        let (outputs, inputs) = (model.output_names(), model.input_names());
        let request = FrfRequest {
            positions: &self.positions,
            systems: &systems,
            frequencies: &self.frequencies,
            outputs: &outputs,
            inputs: &inputs,
            quantity: Quantity::Receptance,
        };
        let pairs = metrics(&request, &modal_sum(&request)?, &direct_pairs(&request))?;
        let families = track(&modes, reported, &|position| solve(&model.at(position)?))?;
        let found = |at: usize, family: &usize| {
            families.modes[at].iter().find(|mode| mode.family == *family).map(|mode| mode.frequency)
        };
        let position = |(p, pairs): (usize, Vec<_>)| PositionMetrics {
            static_compliance: (0..pairs.len()).map(|i| static_compliance(&modes[p], i)).collect(),
            families: self.families.iter().map(|family| found(p, family)).collect(),
            pairs,
        };
        Ok(pairs.into_iter().enumerate().map(position).collect())
    }
}

/// H_ii(0) over all modes, m/N.
fn static_compliance(modes: &Modes, i: usize) -> f64 {
    let amplitude = |r: usize| modes.outputs[(i, r)] * modes.inputs[(i, r)];
    if (0..modes.free).any(|r| modes.is_felt(r) && amplitude(r) != 0.0) {
        return f64::INFINITY;
    }
    let elastic = modes.free..modes.eigenvalues.len();
    modes.direct[(i, i)] + elastic.map(|r| amplitude(r) / modes.eigenvalues[r]).sum::<f64>()
}

impl Evaluator for ModesDirect {
    fn route(&self) -> &'static str {
        "modes"
    }

    fn positions(&self) -> &[f64] {
        &self.positions
    }

    fn batch(&self) -> usize {
        1
    }

    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>> {
        designs.iter().map(|design| self.one(design)).collect()
    }
}
