//! The frequency response of modes that dampers couple.

use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// A mode that only dampers between modes damp has no damping in the sum; this ratio keeps the sum finite at its
/// frequency, and changes the mode's damping by its own small amount.
const FLOOR: f64 = 5e-10;

/// Modes between inputs and outputs with dampers between them.
///
/// ```text
/// H = H_oi - H_og (1 / (j omega) + H_gg)^-1 H_gi     each a modal sum without the dampers; o, i, g: outputs, inputs, G
/// ```
pub struct DampedSum<'a> {
    /// omega_r, rad/s.
    pub omega: &'a [f64],
    /// Viscous ratio of each mode, without the dampers.
    pub zeta: &'a [f64],
    /// n_output x n, kg^(-1/2).
    pub outputs: &'a DMatrix<f64>,
    /// n_input x n, kg^(-1/2).
    pub inputs: &'a DMatrix<f64>,
    /// Rows G of the dampers, n_damper x n.
    pub dampers: &'a DMatrix<f64>,
}

impl DampedSum<'_> {
    /// Receptance of the modes at a frequency (Hz), n_output x n_input, m/N.
    pub fn at(&self, frequency: f64) -> DMatrix<Complex<f64>> {
        let omega = TAU * frequency;
        let floor = if self.dampers.nrows() > 0 { FLOOR } else { 0.0 };
        let weights: Vec<Complex<f64>> = self
            .omega
            .iter()
            .zip(self.zeta)
            .map(|(w, zeta)| Complex::new(w * w - omega * omega, 2.0 * zeta.max(floor) * w * omega).inv())
            .collect();
        let sum = |left: &DMatrix<f64>, right: &DMatrix<f64>| {
            DMatrix::from_fn(left.nrows(), right.nrows(), |i, j| {
                weights.iter().enumerate().map(|(r, weight)| weight * (left[(i, r)] * right[(j, r)])).sum()
            })
        };
        let plain: DMatrix<Complex<f64>> = sum(self.outputs, self.inputs);
        if self.dampers.nrows() == 0 || omega == 0.0 {
            return plain;
        }
        let mut between: DMatrix<Complex<f64>> = sum(self.dampers, self.dampers);
        for k in 0..between.nrows() {
            between[(k, k)] += Complex::new(0.0, omega).inv();
        }
        let to_dampers = sum(self.dampers, self.inputs);
        match between.lu().solve(&to_dampers) {
            Some(forces) => plain - sum(self.outputs, self.dampers) * forces,
            // A damper without any motion of its own: no force.
            None => plain,
        }
    }
}
