//! The f32 kernel, readable: what `shaders/modal_sum.wgsl` computes for one entry, in the same order and arithmetic.

use nalgebra::Complex;

use crate::frf::{FrfRequest, PackedSystem, Packing};

/// A frequency as hi + lo, both f32: 48 bits of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// The value rounded to f32.
    pub high: f32,
    /// What is left of it, rounded to f32.
    pub low: f32,
}

impl Split {
    /// Splits an f64.
    pub fn new(x: f64) -> Split {
        let high = x as f32;
        Split { high, low: (x - f64::from(high)) as f32 }
    }

    /// `self - other`: the high parts' difference is exact near a resonance, and the low parts restore what f32 lost.
    pub fn minus(self, other: Split) -> f32 {
        (self.high - other.high) + (self.low - other.low)
    }
}

/// One entry of the map as the f32 kernel computes it, in the map's unit.
///
/// # Accuracy
/// 8 eps sum_r |term_r|, as [`super::modal_sum`].
pub fn entry(request: &FrfRequest, position: usize, frequency: usize, output: usize, input: usize) -> Complex<f64> {
    let packing = Packing::new(request);
    let system = PackedSystem::new(&request.systems[position], &packing);
    let n_pairs = packing.pairs.len();
    let pair = packing.pair_of_value[output * request.inputs.len() + input];
    let f = Split::new(request.frequencies[frequency]);
    if request.frequencies[frequency] == 0.0
        && let Some(at_rest) = system.at_rest(&packing, request.quantity)
    {
        return at_rest[output * request.inputs.len() + input];
    }
    let mut sum = Complex::new(0.0f32, 0.0);
    for c in system.residual.chunks_exact(n_pairs).rev() {
        sum = sum * f.high + Complex::new((c[pair].re * 1e6) as f32, (c[pair].im * 1e6) as f32);
    }
    for (r, mode) in system.modes.iter().enumerate() {
        let f_r = Split::new(mode.frequency);
        let u = f_r.minus(f) * (f_r.high + f.high);
        let v = mode.viscous as f32 * f.high + mode.loss as f32;
        let inverse = 1.0 / (u * u + v * v);
        let residue = (system.residues[r * n_pairs + pair] * 1e6) as f32;
        sum += Complex::new(residue * (u * inverse), residue * (-v * inverse));
    }
    for _ in 0..request.quantity.power() {
        sum = Complex::new(-sum.im, sum.re) * (f.high * std::f32::consts::TAU);
    }
    Complex::new(f64::from(sum.re), f64::from(sum.im)) * 1e-6
}
