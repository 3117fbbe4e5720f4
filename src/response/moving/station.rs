//! A station of the path: a position whose modes carry the machine near it.

use super::mode_table::ModeTable;
use super::model::LocalModel;
use crate::modal::Modes;
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// A position whose modes are known.
#[derive(Debug)]
pub(super) struct Station {
    /// Which tabulated position it is.
    pub at: usize,
    /// omega_r, rad/s; 0 for free motions.
    pub omega: Vec<f64>,
    /// Viscous ratio of each mode, without the dampers of joints where these act between modes.
    pub ratios: Vec<f64>,
    /// Phi over the fixed basis, n x n.
    pub shapes: DMatrix<f64>,
    /// The tabulated positions around it over its modes, made when the path comes there.
    pub turned: OnceLock<Vec<OnceLock<LocalModel>>>,
}

impl Station {
    pub fn new(at: usize, modes: Modes) -> Self {
        Self {
            at,
            omega: modes.eigenvalues.iter().map(|l| l.sqrt()).collect(),
            ratios: modes.viscous().ratios,
            shapes: modes.shapes,
            turned: OnceLock::new(),
        }
    }

    /// Its modes over a step of a length, s.
    pub fn over(&self, step: f64) -> Vec<ModeTable> {
        self.omega.iter().zip(&self.ratios).map(|(omega, zeta)| ModeTable::new(*omega, *zeta, step)).collect()
    }
}
