//! The modes route: an eigenproblem per (design, position) around the nominal design, then the modal
//! sum with refined extrema.

use super::bases::Bases;
use super::{Design, Evaluation, Evaluator, PartScale, PositionMetrics, Prepared, Request, SweepError};
use crate::frf::metrics::{direct_pairs, metrics};
use crate::frf::{FrfRequest, Quantity, full_system, modal_sum};
use crate::interrupt::Interrupt;
use crate::machine::Machine;
use crate::modal::{Modes, modes_around};
use crate::reduction::Superelement;
use nalgebra::DVector;
use rayon::prelude::*;

/// Share of a shape's square that makes a mode its family's: above one half no other mode has as much.
const SAME_FAMILY: f64 = 0.5;
/// Designs of a batch.
const BATCH: usize = 16;

/// Evaluates designs by their modes.
#[derive(Debug)]
pub struct ModesRoute<'a> {
    bases: Bases<'a>,
    outputs: Vec<String>,
    inputs: Vec<String>,
}

impl<'a> ModesRoute<'a> {
    /// Prepares the positions for designs that differ from the machine as `probes` do.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    pub fn new(
        machine: &'a Machine,
        superelements: &'a [Superelement],
        request: Request,
        probes: &[Design],
        interrupt: &'a Interrupt,
    ) -> Result<Self, SweepError> {
        let bases = Bases::new(machine, superelements, request, probes, interrupt)?;
        let (outputs, inputs) = (bases.nominal.model.output_names(), bases.nominal.model.input_names());
        Ok(Self { bases, outputs, inputs })
    }

    /// The prepared positions.
    pub fn prepared(&self) -> &Prepared {
        &self.bases.nominal
    }

    /// Modes of a design at a position, in the coordinates around the nominal design.
    ///
    /// # Errors
    /// [`SweepError`] of coupling or modes.
    pub fn modes(&self, prepared: &Prepared, design: &Design, index: usize) -> Result<Modes, SweepError> {
        let around = &prepared.around[index];
        let springs = prepared.model.spring_values(&design.machine, around.position)?;
        let part_losses: Vec<Option<f64>> = design.machine.parts.iter().map(|p| p.loss_factor).collect();
        Ok(modes_around(around, &design.machine.analysis.damping, &springs, &part_losses)?)
    }

    /// Whether a design is answered around the nominal machine.
    pub(super) fn is_near(&self, design: &Design) -> Result<bool, SweepError> {
        Ok(design.parts.iter().all(|s| *s == PartScale::NOMINAL) && !self.bases.is_far(design)?)
    }

    /// A design answered by all coordinates of its parts, where differences to a part's material must have no steps.
    pub(super) fn evaluate_untruncated(&self, design: &Design) -> Result<Evaluation, SweepError> {
        self.bases.answer_untruncated(design, |prepared, members| self.evaluate_with(prepared, members))
    }

    fn at(&self, prepared: &Prepared, design: &Design, index: usize) -> Result<PositionMetrics, SweepError> {
        if self.bases.interrupt.requested() {
            return Err(SweepError::Interrupted);
        }
        let modes = self.modes(prepared, design, index)?;
        let systems = [full_system(&modes)?];
        let positions = [modes.position];
        let request = FrfRequest {
            positions: &positions,
            systems: &systems,
            frequencies: &self.bases.request.frequencies,
            outputs: &self.outputs,
            inputs: &self.inputs,
            quantity: Quantity::Receptance,
        };
        let pairs = direct_pairs(&request);
        let mut found = metrics(&request, &modal_sum(&request)?, &pairs)?;
        Ok(PositionMetrics {
            pairs: found.swap_remove(0),
            static_compliance: pairs.iter().map(|&(i, j)| static_compliance(&modes, i, j)).collect(),
            families: prepared.families[index].iter().map(|f| f.as_ref().and_then(|f| family(&modes, f))).collect(),
        })
    }

    fn evaluate_with(&self, prepared: &Prepared, designs: &[&Design]) -> Vec<Result<Evaluation, SweepError>> {
        let n = self.bases.request.positions.len();
        let each = (0..designs.len() * n).into_par_iter().map(|k| self.at(prepared, designs[k / n], k % n));
        let mut each = each.collect::<Vec<_>>().into_iter();
        designs.iter().map(|_| each.by_ref().take(n).collect::<Vec<_>>().into_iter().collect()).collect()
    }
}

impl Evaluator for ModesRoute<'_> {
    fn route(&self) -> &'static str {
        "modes"
    }

    fn positions(&self) -> &[f64] {
        &self.bases.request.positions
    }

    fn batch(&self) -> usize {
        BATCH
    }

    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>> {
        self.bases.answer(designs, |prepared, members| self.evaluate_with(prepared, members))
    }
}

/// H_ij(0) without damping, m/N; infinite where a free motion is felt.
pub(super) fn static_compliance(modes: &Modes, i: usize, j: usize) -> f64 {
    let one = |r: usize| modes.outputs[(i, r)] * modes.inputs[(j, r)] / modes.eigenvalues[r];
    if (0..modes.free).any(|r| modes.is_felt(r)) {
        return f64::INFINITY;
    }
    modes.direct[(i, j)] + (modes.free..modes.eigenvalues.len()).map(one).sum::<f64>()
}

/// Frequency of the mode that has more than half of a family's shape, Hz.
fn family(modes: &Modes, shape: &DVector<f64>) -> Option<f64> {
    family_mode(modes, shape).map(|r| modes.frequency(r))
}

/// The mode that has more than half of a family's shape.
pub(super) fn family_mode(modes: &Modes, shape: &DVector<f64>) -> Option<usize> {
    (0..modes.eigenvalues.len()).find(|&r| modes.shapes.column(r).dot(shape).powi(2) > SAME_FAMILY)
}
