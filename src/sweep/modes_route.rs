//! The modes route: an eigenproblem per (design, position) around the nominal design, then the modal
//! sum with refined extrema.

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
    machine: &'a Machine,
    superelements: &'a [Superelement],
    request: Request,
    prepared: Prepared,
    interrupt: &'a Interrupt,
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
        let prepared = Prepared::new(machine, superelements, &request, probes, interrupt)?;
        let (outputs, inputs) = (prepared.model.output_names(), prepared.model.input_names());
        Ok(Self { machine, superelements, request, prepared, interrupt, outputs, inputs })
    }

    /// The prepared positions.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
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

    fn at(&self, prepared: &Prepared, design: &Design, index: usize) -> Result<PositionMetrics, SweepError> {
        if self.interrupt.requested() {
            return Err(SweepError::Interrupted);
        }
        let modes = self.modes(prepared, design, index)?;
        let systems = [full_system(&modes)];
        let positions = [modes.position];
        let request = FrfRequest {
            positions: &positions,
            systems: &systems,
            frequencies: &self.request.frequencies,
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
        let n = self.request.positions.len();
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
        &self.request.positions
    }

    fn batch(&self) -> usize {
        BATCH
    }

    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>> {
        let mut answers: Vec<Option<Result<Evaluation, SweepError>>> = designs.iter().map(|_| None).collect();
        while let Some(first) = answers.iter().position(Option::is_none) {
            let scales = &designs[first].parts;
            let group: Vec<usize> = (first..designs.len()).filter(|&d| designs[d].parts == *scales).collect();
            let members: Vec<&Design> = group.iter().map(|&d| &designs[d]).collect();
            let nominal = scales.iter().all(|s| *s == PartScale::NOMINAL);
            let results = if nominal {
                self.evaluate_with(&self.prepared, &members)
            } else {
                let scaled =
                    self.prepared.scaled(self.machine, self.superelements, scales, &self.request, self.interrupt);
                match scaled {
                    Ok(prepared) => self.evaluate_with(&prepared, &members),
                    Err(error) => {
                        let message = error.to_string();
                        members.iter().map(|_| Err(SweepError::Parts { message: message.clone() })).collect()
                    }
                }
            };
            for (d, result) in group.into_iter().zip(results) {
                answers[d] = Some(result);
            }
        }
        answers.into_iter().flatten().collect()
    }
}

/// H_ij(0) without damping, m/N; infinite where a free motion is felt.
fn static_compliance(modes: &Modes, i: usize, j: usize) -> f64 {
    let one = |r: usize| modes.outputs[(i, r)] * modes.inputs[(j, r)] / modes.eigenvalues[r];
    if (0..modes.free).any(|r| modes.is_felt(r)) {
        return f64::INFINITY;
    }
    modes.direct[(i, j)] + (modes.free..modes.eigenvalues.len()).map(one).sum::<f64>()
}

/// Frequency of the mode that has more than half of a family's shape, Hz.
fn family(modes: &Modes, shape: &DVector<f64>) -> Option<f64> {
    (0..modes.eigenvalues.len())
        .find(|&r| modes.shapes.column(r).dot(shape).powi(2) > SAME_FAMILY)
        .map(|r| modes.frequency(r))
}
