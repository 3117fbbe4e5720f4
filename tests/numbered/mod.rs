//! Maps whose every value tells its place.

use nalgebra::Complex;
use stiffmap::frf::{ComplianceMap, Quantity};

/// The first `n` of four port names.
pub fn names(n: usize) -> Vec<String> {
    ["tool.x", "tool.y", "tool.z", "sensor.x"][..n].iter().map(|s| (*s).to_owned()).collect()
}

/// A map whose every value is different and tells its place.
pub fn map(n_position: usize, n_frequency: usize, n_out: usize, n_in: usize) -> ComplianceMap {
    let count = n_position * n_frequency * n_out * n_in;
    ComplianceMap {
        positions: (0..n_position).map(|p| -0.1 * p as f64).collect(),
        frequencies: (0..n_frequency).map(|f| 0.5 * f as f64).collect(),
        outputs: names(n_out),
        inputs: names(n_in),
        quantity: Quantity::Receptance,
        values: (0..count).map(|k| Complex::new(1e-8 * (k as f64 + 0.1).sqrt(), -1e-9 * (k as f64 + 1.0))).collect(),
    }
}
