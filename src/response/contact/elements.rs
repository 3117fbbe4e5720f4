//! The nonlinear joints of a machine at a position, in modal coordinates.

use crate::coupling::{AtPosition, CoupledModel, CouplingError};
use crate::linalg::multiply;
use crate::machine::{Contact, Friction};
use crate::modal::Modes;

/// A nonlinear law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Against sliding.
    Friction(Friction),
    /// A spring with play whose stiffness the linear model holds.
    Backlash {
        /// Play, m.
        gap: f64,
        /// Stiffness, N/m.
        stiffness: f64,
    },
}

/// One nonlinear joint.
#[derive(Clone, Debug)]
pub struct Element {
    /// Joint.
    pub joint: String,
    /// Its law.
    pub law: Law,
    /// j: relative motion of side 1 against side 0 of each mode, kg^(-1/2); as many as the plant has modes.
    pub row: Vec<f64>,
    /// Flexibility of the joint's own sides that no mode carries, m/N.
    pub flexibility: f64,
    /// The same towards every element, its own among them; empty where there is none towards others.
    pub towards: Vec<f64>,
    /// The same towards every output of the plant; empty for none.
    pub outputs: Vec<f64>,
    /// The same towards every input of the plant; empty for none.
    pub inputs: Vec<f64>,
}

impl Element {
    /// Flexibility towards element k, which is number `own` itself, m/N.
    pub(super) fn towards(&self, own: usize, k: usize) -> f64 {
        if own == k { self.flexibility } else { self.towards.get(k).copied().unwrap_or(0.0) }
    }
}

impl Friction {
    /// Force at a sliding speed, N.
    pub fn at(&self, speed: f64) -> f64 {
        self.coulomb + (self.breakaway - self.coulomb) * (-(speed / self.stribeck).powi(2)).exp()
    }
}

/// The joints with friction or backlash, for the modes of [`super::super::Plant::whole`].
///
/// # Errors
/// [`CouplingError`] as of [`CoupledModel::coupled`].
pub fn elements(
    model: &CoupledModel,
    at: &AtPosition,
    stiffness: &[f64],
    modes: &Modes,
) -> Result<Vec<Element>, CouplingError> {
    let coupled = model.coupled(at, stiffness)?;
    let residual = model.residual_in_place(at, stiffness)?;
    let kept: Vec<usize> = (0..modes.eigenvalues.len()).filter(|&r| r >= modes.free || modes.is_felt(r)).collect();
    let shapes = modes.shapes.select_columns(&kept);
    let mut out = Vec::new();
    let mut rows = Vec::new();
    let mut spring = 0;
    for joint in model.joints() {
        let first = spring;
        spring += joint.springs.len();
        let Some(contact) = joint.contact else { continue };
        // Friction acts on the row along the travel, which the machine file puts last; a screw has one spring.
        let row = match contact {
            Contact::Friction(_) => spring - 1,
            Contact::Backlash(_) => first,
        };
        let motion = multiply(&coupled.elongations.rows(row, 1).into_owned(), &shapes);
        let law = match contact {
            Contact::Friction(friction) => Law::Friction(friction),
            Contact::Backlash(gap) => Law::Backlash { gap, stiffness: stiffness[row] },
        };
        rows.push(row);
        out.push(Element {
            joint: joint.name.clone(),
            law,
            row: motion.iter().copied().collect(),
            flexibility: residual[(row, row)],
            towards: Vec::new(),
            outputs: Vec::new(),
            inputs: Vec::new(),
        });
    }
    let (springs, ports) = (at.springs.nrows(), at.outputs.nrows());
    for (element, &row) in out.iter_mut().zip(&rows) {
        element.towards = rows.iter().map(|&other| residual[(row, other)]).collect();
        element.outputs = (springs..springs + ports).map(|k| residual[(row, k)]).collect();
        element.inputs = (springs + ports..residual.ncols()).map(|k| residual[(row, k)]).collect();
    }
    Ok(out)
}
