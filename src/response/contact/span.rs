//! What a step of a given length does to modes and contacts.

use super::{Element, Law};
use crate::response::{Plant, ResponseError};
use crate::state_space::ModeStep;
use nalgebra::DMatrix;

/// What a step of a given length does.
pub(super) struct Span {
    pub steps: Vec<ModeStep>,
    pub influence: DMatrix<f64>,
    pub time: f64,
    /// Weight of a step's end for the motion that friction sees: 1/2 is the trapezoidal rule, 1 the end alone.
    pub end: f64,
}

impl Span {
    /// Steps of all modes over a time, and what a unit tension does by its end.
    pub fn new(plant: &Plant, elements: &[Element], time: f64) -> Result<Self, ResponseError> {
        let steps = plant.steps(time);
        let m = elements.len();
        let rubs = |i: usize| matches!(elements[i].law, Law::Friction(_));
        let modal = |a: usize, b: usize| {
            let row = usize::from(rubs(a));
            let weight = |s: &ModeStep| if rubs(b) { s.constant[row] } else { s.to[row] };
            let (x, y) = (&elements[a].row, &elements[b].row);
            steps.iter().zip(x.iter().zip(y)).map(|(s, (x, y))| x * weight(s) * y).sum::<f64>()
        };
        // The trapezoidal rule as long as the contact's own oscillation is resolved; what is stiffer follows the end.
        let stiffness = |i: usize| time * modal(i, i) / elements[i].flexibility;
        let stiffest = (0..m).filter(|&i| rubs(i)).map(stiffness).fold(0.0, f64::max);
        let end = if stiffest > 4.0 { 1.0 - 1.0 / stiffest.max(8.0).sqrt().max(2.0) } else { 0.5 };
        let end = if stiffest.is_finite() { end } else { 1.0 };
        let influence = DMatrix::from_fn(m, m, |a, b| {
            let own = elements[a].towards(a, b);
            match (rubs(a), rubs(b)) {
                (true, true) => end * modal(a, b) + own / (end * time),
                (true, false) => end * modal(a, b) + own / time,
                (false, true) => modal(a, b) + own / end,
                (false, false) => modal(a, b) + own,
            }
        });
        for (i, element) in elements.iter().enumerate() {
            let problem = match element.law {
                Law::Friction(_) if influence[(i, i)] <= 0.0 => "a force on the joint does not move it",
                Law::Backlash { stiffness, .. } if stiffness * influence[(i, i)] >= 1.0 => {
                    "the play's spring is too stiff"
                }
                _ => continue,
            };
            return Err(ResponseError::Contact { joint: element.joint.clone(), problem: problem.into(), step: time });
        }
        Ok(Self { steps, influence, time, end })
    }
}
