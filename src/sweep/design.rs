//! One design of a sweep.

use crate::machine::Machine;
use crate::reduction::Superelement;

/// A machine whose springs, dampers, loss factors and homogeneous parts differ from the nominal one's.
#[derive(Clone, Debug)]
pub struct Design {
    /// The machine with the design's joints and damping; everything else is the nominal machine's.
    pub machine: Machine,
    /// Factors on each part's material.
    pub parts: Vec<PartScale>,
}

/// Factors on a homogeneous part's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartScale {
    /// On Young's modulus.
    pub young: f64,
    /// On density.
    pub density: f64,
}

impl PartScale {
    /// The part as it is.
    pub const NOMINAL: Self = Self { young: 1.0, density: 1.0 };

    /// The superelement of the part with its scaled material: M = I again, with mode shapes divided by the root of
    /// the density's factor.
    ///
    /// ```text
    /// lambda' = lambda e / rho        rows' = rows / sqrt(rho)
    /// ```
    pub fn of(self, part: &Superelement) -> Superelement {
        let mut scaled = part.clone();
        let shapes = self.density.sqrt().recip();
        scaled.eigenvalues.iter_mut().for_each(|l| *l *= self.young / self.density);
        scaled.component_frequencies.iter_mut().for_each(|f| *f *= (self.young / self.density).sqrt());
        scaled.interfaces.iter_mut().for_each(|interface| interface.rows *= shapes);
        scaled.rails.iter_mut().for_each(|rail| rail.basis *= shapes);
        scaled.impulses /= shapes;
        scaled.mass *= self.density;
        scaled.inertia *= self.density;
        scaled
    }
}

impl Design {
    /// The nominal machine as a design.
    pub fn nominal(machine: &Machine) -> Self {
        Self { machine: machine.clone(), parts: vec![PartScale::NOMINAL; machine.parts.len()] }
    }
}
