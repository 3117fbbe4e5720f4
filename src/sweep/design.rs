//! One design of a sweep.

use crate::machine::Machine;

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
}

impl Design {
    /// The nominal machine as a design.
    pub fn nominal(machine: &Machine) -> Self {
        Self { machine: machine.clone(), parts: vec![PartScale::NOMINAL; machine.parts.len()] }
    }
}
