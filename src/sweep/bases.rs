//! Which prepared machine answers which design.

use super::{Design, Evaluation, Kept, PartScale, Prepared, Request, SweepError};
use crate::interrupt::Interrupt;
use crate::machine::Machine;
use crate::reduction::Superelement;

/// The nominal machine, prepared, and what it takes to prepare another.
#[derive(Debug)]
pub(super) struct Bases<'a> {
    pub machine: &'a Machine,
    pub superelements: &'a [Superelement],
    pub request: Request,
    pub nominal: Prepared,
    pub interrupt: &'a Interrupt,
}

impl<'a> Bases<'a> {
    pub fn new(
        machine: &'a Machine,
        superelements: &'a [Superelement],
        request: Request,
        probes: &[Design],
        interrupt: &'a Interrupt,
    ) -> Result<Self, SweepError> {
        let nominal = Prepared::new(machine, superelements, &request, probes, interrupt)?;
        Ok(Self { machine, superelements, request, nominal, interrupt })
    }

    /// Answers designs in groups that share a prepared machine: the nominal one, one for each set of part
    /// scales, and one of its own for each design too far from nominal.
    pub fn answer(
        &self,
        designs: &[Design],
        evaluate: impl Fn(&Prepared, &[&Design]) -> Vec<Result<Evaluation, SweepError>>,
    ) -> Vec<Result<Evaluation, SweepError>> {
        let (mut answers, mut far) = (Vec::with_capacity(designs.len()), Vec::with_capacity(designs.len()));
        for design in designs {
            let is_far = self.is_far(design);
            far.push(matches!(is_far, Ok(true)));
            answers.push(is_far.err().map(Err));
        }
        while let Some(first) = answers.iter().position(Option::is_none) {
            let group: Vec<usize> = (first..designs.len())
                .filter(|&d| {
                    d == first
                        || answers[d].is_none() && designs[d].parts == designs[first].parts && !far[first] && !far[d]
                })
                .collect();
            let members: Vec<&Design> = group.iter().map(|&d| &designs[d]).collect();
            let scales = &designs[first].parts;
            let results = if scales.iter().all(|s| *s == PartScale::NOMINAL) && !far[first] {
                evaluate(&self.nominal, &members)
            } else {
                let base = if far[first] { &designs[first].machine } else { self.machine };
                match self.nominal.scaled(base, self.superelements, scales, &self.request, self.interrupt) {
                    Ok(prepared) => evaluate(&prepared, &members),
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

    /// Answers a design of other parts without truncation: in a basis of its own that keeps every coordinate.
    pub fn answer_untruncated(
        &self,
        design: &Design,
        evaluate: impl Fn(&Prepared, &[&Design]) -> Vec<Result<Evaluation, SweepError>>,
    ) -> Result<Evaluation, SweepError> {
        let request = Request { kept: Kept::All, ..self.request.clone() };
        let base = if self.is_far(design)? { &design.machine } else { self.machine };
        let prepared = self.nominal.scaled(base, self.superelements, &design.parts, &request, self.interrupt);
        let prepared = prepared.map_err(|error| SweepError::Parts { message: error.to_string() })?;
        evaluate(&prepared, &[design]).swap_remove(0)
    }

    pub fn is_far(&self, design: &Design) -> Result<bool, SweepError> {
        for around in &self.nominal.around {
            let values = self.nominal.model.spring_values(&design.machine, around.position)?;
            for (&stiffness, &base) in values.stiffness.iter().zip(&around.base) {
                if !stiffness.is_finite() || stiffness < 0.0 {
                    let what = format!("a spring's stiffness at position {} m", around.position);
                    return Err(SweepError::Value { what, seen: stiffness, allowed: "0 or more, finite" });
                }
                if stiffness > (1.0 + 1e-9) * self.nominal.model.stiffest * base {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }
}
