//! The inner sum in f64: frequencies across the lanes, dispatched at run time on what the processor has.
//!
//! For a group of frequencies the modes' weights 1/D_r(f) are computed once (one division serves four modes), then each
//! pair's residues are summed over them. Real and imaginary parts are interleaved in registers at the end, for which
//! the grid is laid out in the order that the processor's shuffle expects ([`lay_out`]).

use std::f64::consts::TAU;

use nalgebra::Complex;
use pulp::{Arch, Simd, WithSimd};

use super::packing::{Denominator, PackedSystem, Packing};
use super::request::Quantity;
use super::scatter::{finish, scatter};

/// Frequencies in a group at most: two vectors of eight lanes. Blocks start at multiples of it.
pub(super) const GROUP: usize = 16;

/// The grid padded to whole groups, in lane order.
pub(super) fn lay_out(frequencies: &[f64]) -> Vec<f64> {
    Arch::new().dispatch(LayOut { frequencies })
}

struct LayOut<'a> {
    frequencies: &'a [f64],
}

impl WithSimd for LayOut<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let lanes = S::F64_LANES;
        let iota: Vec<f64> = (0..2 * lanes).map(|i| i as f64).collect();
        let (low, high) = S::as_simd_f64s(&iota).0.split_at(1);
        let shuffled = simd.interleave_shfl_f64s([low[0], high[0]]);
        let shuffled: &[f64] = bytemuck::cast_slice(&shuffled);
        let last = self.frequencies[self.frequencies.len() - 1];
        let mut laid_out = vec![last; self.frequencies.len().next_multiple_of(GROUP)];
        for (start, vector) in laid_out.chunks_exact_mut(lanes).enumerate() {
            for k in 0..lanes {
                let lane = shuffled[2 * k] as usize;
                assert_eq!(shuffled[2 * k + 1] as usize, lane + lanes, "the shuffle pairs equal lanes");
                vector[lane] = *self.frequencies.get(start * lanes + k).unwrap_or(&last);
            }
        }
        laid_out
    }
}

/// One position's numbers.
#[derive(Clone, Copy)]
pub(super) struct Model<'a> {
    pub system: &'a PackedSystem,
    pub packing: &'a Packing,
    pub quantity: Quantity,
}

/// Sums one position's responses at a block of frequencies.
pub(super) struct Block<'a> {
    pub model: Model<'a>,
    /// Whole groups in lane order.
    pub frequencies: &'a [f64],
    /// Whether the values are written past the caches.
    pub stream: bool,
    /// `[frequency, output, input]`, of as many frequencies as wanted.
    pub values: &'a mut [Complex<f64>],
}

impl Block<'_> {
    pub(super) fn sum(self) {
        Arch::new().dispatch(self)
    }
}

impl WithSimd for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // 24 accumulators need the 32 registers that come with eight lanes.
        if S::F64_LANES == 8 { self.groups::<S, 2>(simd) } else { self.groups::<S, 1>(simd) }
    }
}

type Weight<S, const W: usize> = ([<S as Simd>::f64s; W], [<S as Simd>::f64s; W]);

impl Block<'_> {
    #[inline(always)]
    fn groups<S: Simd, const W: usize>(self, simd: S) {
        let Block { model, frequencies, stream, values } = self;
        let Model { system, packing, .. } = model;
        let (n_pairs, n_values) = (packing.pairs.len(), packing.pair_of_value.len());
        let zero = simd.splat_f64s(0.0);
        let mut weights: Vec<Weight<S, W>> = vec![([zero; W], [zero; W]); system.modes.len()];
        // [vector, pair] of interleaved complex numbers.
        let mut sums: Vec<[S::f64s; 2]> = vec![[zero; 2]; W * n_pairs];
        let group = W * S::F64_LANES;
        let vectors = S::as_simd_f64s(frequencies).0;
        for (f, values) in vectors.chunks_exact(W).zip(values.chunks_mut(group * n_values)) {
            let f: [S::f64s; W] = std::array::from_fn(|w| f[w]);
            fill_weights::<S, W>(simd, &system.modes, f, &mut weights);
            let mut first = 0;
            while first < n_pairs {
                first += match n_pairs - first {
                    1 => model.pairs::<S, W, 1>(simd, f, &weights, first, &mut sums),
                    2 => model.pairs::<S, W, 2>(simd, f, &weights, first, &mut sums),
                    3 => model.pairs::<S, W, 3>(simd, f, &weights, first, &mut sums),
                    4 => model.pairs::<S, W, 4>(simd, f, &weights, first, &mut sums),
                    5 => model.pairs::<S, W, 5>(simd, f, &weights, first, &mut sums),
                    _ => model.pairs::<S, W, 6>(simd, f, &weights, first, &mut sums),
                };
            }
            let sums: &[Complex<f64>] = bytemuck::cast_slice(&sums);
            for (sums, values) in
                sums.chunks_exact(n_pairs * S::F64_LANES).zip(values.chunks_mut(S::F64_LANES * n_values))
            {
                scatter(sums, &packing.pair_of_value, S::F64_LANES, stream, values);
            }
        }
        if stream {
            finish();
        }
    }
}

impl Model<'_> {
    /// Sums `N` pairs from `first` on; returns N.
    #[inline(always)]
    fn pairs<S: Simd, const W: usize, const N: usize>(
        &self,
        simd: S,
        f: [S::f64s; W],
        weights: &[Weight<S, W>],
        first: usize,
        sums: &mut [[S::f64s; 2]],
    ) -> usize {
        let n_pairs = self.packing.pairs.len();
        let zero = simd.splat_f64s(0.0);
        let mut re = [[zero; N]; W];
        let mut im = [[zero; N]; W];
        for c in self.system.residual.chunks_exact(n_pairs).rev() {
            let c = &c[first..first + N];
            for n in 0..N {
                let (c_re, c_im) = (simd.splat_f64s(c[n].re), simd.splat_f64s(c[n].im));
                for w in 0..W {
                    re[w][n] = simd.mul_add_f64s(re[w][n], f[w], c_re);
                    im[w][n] = simd.mul_add_f64s(im[w][n], f[w], c_im);
                }
            }
        }
        for ((g, h), residues) in weights.iter().zip(self.system.residues.chunks_exact(n_pairs)) {
            let residues = &residues[first..first + N];
            for n in 0..N {
                let a = simd.splat_f64s(residues[n]);
                for w in 0..W {
                    re[w][n] = simd.mul_add_f64s(a, g[w], re[w][n]);
                    im[w][n] = simd.mul_add_f64s(a, h[w], im[w][n]);
                }
            }
        }
        for w in 0..W {
            let omega = simd.mul_f64s(f[w], simd.splat_f64s(TAU));
            for n in 0..N {
                let (x, y) = (re[w][n], im[w][n]);
                let (x, y) = match self.quantity {
                    Quantity::Receptance => (x, y),
                    Quantity::Mobility => (simd.neg_f64s(simd.mul_f64s(omega, y)), simd.mul_f64s(omega, x)),
                    Quantity::Accelerance => {
                        let factor = simd.neg_f64s(simd.mul_f64s(omega, omega));
                        (simd.mul_f64s(factor, x), simd.mul_f64s(factor, y))
                    }
                };
                sums[w * n_pairs + first + n] = simd.interleave_shfl_f64s([x, y]);
            }
        }
        N
    }
}

/// The weights 1 / D_r(f) of every mode: real and imaginary parts.
#[expect(
    clippy::needless_range_loop,
    reason = "closures of iterators would not be compiled for the processor that was found"
)]
#[inline(always)]
fn fill_weights<S: Simd, const W: usize>(
    simd: S,
    modes: &[Denominator],
    f: [S::f64s; W],
    weights: &mut [Weight<S, W>],
) {
    let one = simd.splat_f64s(1.0);
    let (mode_fours, mode_rest) = modes.as_chunks::<4>();
    let (weight_fours, weight_rest) = weights.as_chunks_mut::<4>();
    for (mode, weight) in mode_fours.iter().zip(weight_fours) {
        for w in 0..W {
            // Spelled out: a closure would not be compiled for the processor that was found.
            let d = [
                denominator(simd, &mode[0], f[w]),
                denominator(simd, &mode[1], f[w]),
                denominator(simd, &mode[2], f[w]),
                denominator(simd, &mode[3], f[w]),
            ];
            // 1/n0 = n1 n2 n3 / (n0 n1 n2 n3); the accepted range of frequencies keeps the product inside f64.
            let (low, high) = (simd.mul_f64s(d[0].2, d[1].2), simd.mul_f64s(d[2].2, d[3].2));
            let inverse = simd.div_f64s(one, simd.mul_f64s(low, high));
            let (low, high) = (simd.mul_f64s(inverse, high), simd.mul_f64s(inverse, low));
            let inverses = [(low, d[1].2), (low, d[0].2), (high, d[3].2), (high, d[2].2)];
            for k in 0..4 {
                let inverse = simd.mul_f64s(inverses[k].0, inverses[k].1);
                weight[k].0[w] = simd.mul_f64s(d[k].0, inverse);
                weight[k].1[w] = simd.mul_f64s(d[k].1, inverse);
            }
        }
    }
    for (mode, weight) in mode_rest.iter().zip(weight_rest) {
        for w in 0..W {
            let (u, v, n) = denominator(simd, mode, f[w]);
            let inverse = simd.div_f64s(one, n);
            weight.0[w] = simd.mul_f64s(u, inverse);
            weight.1[w] = simd.mul_f64s(v, inverse);
        }
    }
}

/// Real part, negated imaginary part and squared magnitude of a denominator.
#[inline(always)]
fn denominator<S: Simd>(simd: S, mode: &Denominator, f: S::f64s) -> (S::f64s, S::f64s, S::f64s) {
    let f_r = simd.splat_f64s(mode.frequency);
    let u = simd.mul_f64s(simd.sub_f64s(f_r, f), simd.add_f64s(f_r, f));
    let v = simd.mul_add_f64s(simd.splat_f64s(-mode.viscous), f, simd.splat_f64s(-mode.loss));
    (u, v, simd.mul_add_f64s(u, u, simd.mul_f64s(v, v)))
}

#[cfg(test)]
mod tests {
    use super::super::request::{FrfRequest, ModalSystem};
    use super::*;
    use nalgebra::DMatrix;

    /// The sum of a small system at 37 frequencies on one kind of processor.
    fn sum_on<S: Simd>(simd: S, n_ports: usize, stream: bool) -> Vec<Complex<f64>> {
        let shapes = DMatrix::from_fn(n_ports, 7, |i, r| ((1 + i + 3 * r) as f64).sin());
        let system = ModalSystem {
            frequencies: (0..7).map(|r| 10.0 + 31.0 * r as f64).collect(),
            damping_ratios: vec![0.01; 7],
            loss_factors: vec![0.002; 7],
            outputs: shapes.clone(),
            inputs: shapes,
            residual: vec![DMatrix::from_element(n_ports, n_ports, Complex::new(1e-3, 1e-4)); 2],
            exact: None,
        };
        let frequencies: Vec<f64> = (0..37).map(|k| 1.0 + 6.1 * k as f64).collect();
        let names: Vec<String> = (0..n_ports).map(|i| i.to_string()).collect();
        let systems = [system];
        let request = FrfRequest {
            positions: &[0.0],
            systems: &systems,
            frequencies: &frequencies,
            outputs: &names,
            inputs: &names,
            quantity: Quantity::Mobility,
        };
        let packing = Packing::new(&request);
        let packed = PackedSystem::new(&systems[0], &packing);
        let model = Model { system: &packed, packing: &packing, quantity: request.quantity };
        let laid_out = simd.vectorize(LayOut { frequencies: &frequencies });
        let mut values = vec![Complex::default(); 37 * n_ports * n_ports];
        simd.vectorize(Block { model, frequencies: &laid_out, stream, values: &mut values });
        values
    }

    /// Largest difference relative to the largest value.
    fn difference(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
        let largest = b.iter().map(|x| x.norm()).fold(0.0, f64::max);
        a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / largest
    }

    #[test]
    fn every_kind_of_processor_sums_the_same() {
        for n_ports in 1..=4 {
            let scalar = sum_on(pulp::Scalar::new(), n_ports, false);
            assert!(scalar.iter().all(|x| x.norm() > 0.0));
            #[cfg(target_arch = "x86_64")]
            {
                if let Some(simd) = pulp::x86::V3::try_new() {
                    assert!(difference(&sum_on(simd, n_ports, true), &scalar) < 1e-14);
                }
                if let Some(simd) = pulp::x86::V4::try_new() {
                    assert!(difference(&sum_on(simd, n_ports, true), &scalar) < 1e-14);
                }
            }
            let mut shifted = scalar.clone();
            shifted.rotate_left(1);
            assert!(difference(&shifted, &scalar) > 1e-14, "the comparison notices another order");
        }
    }
}
