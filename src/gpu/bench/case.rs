//! A machine-like request of any size.

use nalgebra::DMatrix;

use crate::frf::{FrfRequest, ModalSystem, Quantity};

/// The parts of a request.
pub(super) struct Case {
    positions: Vec<f64>,
    systems: Vec<ModalSystem>,
    frequencies: Vec<f64>,
    names: Vec<String>,
}

impl Case {
    pub(super) fn new(positions: usize, frequencies: usize, modes: usize, ports: usize) -> Case {
        let system = |p: usize| {
            let shapes = DMatrix::from_fn(ports, modes, |i, r| 0.05 * (1.7 * (1 + i + 3 * r + 7 * p) as f64).sin());
            ModalSystem {
                frequencies: (0..modes).map(|r| 14.1 + 29.3 * r as f64 + 1e-3 * p as f64).collect(),
                damping_ratios: vec![0.02; modes],
                loss_factors: vec![0.0; modes],
                outputs: shapes.clone(),
                inputs: shapes,
                residual: Vec::new(),
                exact: None,
            }
        };
        Case {
            positions: (0..positions).map(|p| -0.005 * p as f64).collect(),
            systems: (0..positions).map(system).collect(),
            frequencies: (0..frequencies).map(|k| 900.0 * k as f64 / frequencies as f64).collect(),
            names: (0..ports).map(|i| format!("port {i}")).collect(),
        }
    }

    pub(super) fn request(&self) -> FrfRequest<'_> {
        FrfRequest {
            positions: &self.positions,
            systems: &self.systems,
            frequencies: &self.frequencies,
            outputs: &self.names,
            inputs: &self.names,
            quantity: Quantity::Receptance,
        }
    }
}
