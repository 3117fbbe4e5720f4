//! The response and its first two derivatives by frequency at a single frequency: what peak refinement steps on.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::packing::PackedSystem;
use super::request::Quantity;

/// A response and its derivatives by the frequency in Hz.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    pub value: Complex<f64>,
    pub slope: Complex<f64>,
    pub curvature: Complex<f64>,
}

impl Response {
    /// A receptance at a frequency (Hz) as another quantity.
    pub fn as_quantity(self, quantity: Quantity, frequency: f64) -> Response {
        let j_tau = Complex::new(0.0, TAU);
        (0..quantity.power()).fold(self, |h, _| Response {
            value: j_tau * h.value * frequency,
            slope: j_tau * (h.slope * frequency + h.value),
            curvature: j_tau * (h.curvature * frequency + h.slope * 2.0),
        })
    }
}

/// The modes' weights 1/D_r and their derivatives at one frequency, for any number of pairs.
pub(super) struct Weights {
    frequency: f64,
    /// 1/D, (1/D)', (1/D)'' of each mode.
    modes: Vec<[Complex<f64>; 3]>,
}

impl Weights {
    /// With D = f_r^2 - f^2 + j (l + v f), w = 1/D: w' = -D' w^2 and w'' = 2 w^2 (1 + D'^2 w).
    pub fn new(system: &PackedSystem, frequency: f64) -> Weights {
        let modes = system
            .modes
            .iter()
            .map(|m| {
                let u = (m.frequency - frequency) * (m.frequency + frequency);
                let w = Complex::new(u, m.loss + m.viscous * frequency).inv();
                let slope = Complex::new(-2.0 * frequency, m.viscous);
                let square = w * w;
                [w, -slope * square, square * (slope * slope * w + 1.0) * 2.0]
            })
            .collect();
        Weights { frequency, modes }
    }

    /// The response of one packed pair.
    pub fn response(&self, system: &PackedSystem, n_pairs: usize, pair: usize, quantity: Quantity) -> Response {
        let f = self.frequency;
        let mut h = Response::default();
        // A free motion's share of an accelerance is its residue at every frequency, 0 Hz among them.
        let mut of_free_motions = 0.0;
        for (r, w) in self.modes.iter().enumerate() {
            if quantity == Quantity::Accelerance && system.modes[r].frequency == 0.0 {
                of_free_motions += system.residues[r * n_pairs + pair] * TAU * TAU;
                continue;
            }
            let a = system.residues[r * n_pairs + pair];
            h.value += w[0] * a;
            h.slope += w[1] * a;
            h.curvature += w[2] * a;
        }
        let mut polynomial = Response::default();
        for c in system.residual.chunks_exact(n_pairs).rev() {
            polynomial.curvature = polynomial.curvature * f + polynomial.slope * 2.0;
            polynomial.slope = polynomial.slope * f + polynomial.value;
            polynomial.value = polynomial.value * f + c[pair];
        }
        h.value += polynomial.value;
        h.slope += polynomial.slope;
        h.curvature += polynomial.curvature;
        h = h.as_quantity(quantity, f);
        h.value += of_free_motions;
        h
    }
}
