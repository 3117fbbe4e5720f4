//! The recursions with modes across the lanes and a stretch of samples at a time, dispatched at run time on what the processor has.

use super::{Forces, Plant, Recording};
use pulp::{Arch, Simd, WithSimd};

/// Modes are padded to a multiple of two of the widest vectors.
const LANES: usize = 16;

/// One output row: what it adds up of displacements or rates.
struct Term {
    row: usize,
    of_rate: bool,
    weights: Vec<f64>,
}

/// A plant's numbers in the order of the recursion, padded with zeros.
pub(super) struct Coefficients {
    /// phi_11, phi_12, phi_21, phi_22, from_q, to_q, from_v, to_v.
    step: [Vec<f64>; 8],
    inputs: Vec<Vec<f64>>,
    terms: Vec<Term>,
    /// L R^T for accelerations, by (row, input), after the terms.
    direct: Vec<(usize, Vec<f64>)>,
    n_modes: usize,
    rows: usize,
}

impl Coefficients {
    pub fn new(plant: &Plant, step: f64, recording: Recording) -> Self {
        let n = plant.omega.len();
        let padded = n.next_multiple_of(LANES).max(LANES);
        let steps = plant.steps(step);
        let pad =
            |of: &dyn Fn(usize) -> f64| (0..padded).map(|r| if r < n { of(r) } else { 0.0 }).collect::<Vec<f64>>();
        let n_outputs = plant.outputs.nrows();
        let mut terms = Vec::new();
        let mut direct = Vec::new();
        let mut row = n_outputs;
        for i in 0..n_outputs {
            terms.push(Term { row: i, of_rate: false, weights: pad(&|r| plant.outputs[(i, r)]) });
        }
        if recording.velocity {
            for i in 0..n_outputs {
                terms.push(Term { row: row + i, of_rate: true, weights: pad(&|r| plant.outputs[(i, r)]) });
            }
            row += n_outputs;
        }
        if recording.acceleration {
            // q'' = R u - 2 zeta omega q' - omega^2 q.
            for i in 0..n_outputs {
                let l = |r: usize| plant.outputs[(i, r)];
                let stiffness = pad(&|r| -l(r) * plant.omega[r] * plant.omega[r]);
                terms.push(Term { row: row + i, of_rate: false, weights: stiffness });
                let damping = pad(&|r| -l(r) * 2.0 * plant.zeta[r] * plant.omega[r]);
                terms.push(Term { row: row + i, of_rate: true, weights: damping });
                let input = |j: usize| (0..n).map(|r| l(r) * plant.inputs[(j, r)]).sum();
                direct.push((row + i, (0..plant.inputs.nrows()).map(input).collect()));
            }
            row += n_outputs;
        }
        Self {
            step: [
                pad(&|r| steps[r].phi[0][0]),
                pad(&|r| steps[r].phi[0][1]),
                pad(&|r| steps[r].phi[1][0]),
                pad(&|r| steps[r].phi[1][1]),
                pad(&|r| steps[r].from[0]),
                pad(&|r| steps[r].to[0]),
                pad(&|r| steps[r].from[1]),
                pad(&|r| steps[r].to[1]),
            ],
            inputs: (0..plant.inputs.nrows()).map(|j| pad(&|r| plant.inputs[(j, r)])).collect(),
            terms,
            direct,
            n_modes: n,
            rows: row,
        }
    }
}

/// One plant under one set of forces.
pub(super) struct Run<'a> {
    pub coefficients: &'a Coefficients,
    pub forces: &'a Forces,
    /// `[sample, row]`.
    pub out: &'a mut [f64],
}

impl Run<'_> {
    /// Runs from rest; returns displacements and rates of the modes at the last sample.
    pub fn all(self) -> [Vec<f64>; 2] {
        Arch::new().dispatch(self)
    }
}

/// Samples that one pair of vectors of modes goes through before the next pair: their sums stay in the
/// first cache, and a mode's numbers are read once for all of them.
const CHUNK: usize = 64;
/// Vectors of modes side by side, so that one recursion need not wait for the other.
const WIDE: usize = 2;

impl WithSimd for Run<'_> {
    type Output = [Vec<f64>; 2];

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "closures would not be compiled for the processor that was found")]
    fn with_simd<S: Simd>(self, simd: S) -> [Vec<f64>; 2] {
        let Run { coefficients: c, forces, out } = self;
        let step = c.step.each_ref().map(|v| S::as_simd_f64s(v).0);
        let inputs: Vec<&[S::f64s]> = c.inputs.iter().map(|v| S::as_simd_f64s(v).0).collect();
        let terms: Vec<(usize, bool, &[S::f64s])> =
            c.terms.iter().map(|t| (t.row, t.of_rate, S::as_simd_f64s(&t.weights).0)).collect();
        let (n, n_inputs, n_terms) = (step[0].len(), inputs.len(), terms.len());
        let zero = simd.splat_f64s(0.0);
        let (mut q, mut v, mut p) = (vec![zero; n], vec![zero; n], vec![zero; n]);
        let mut sums = vec![zero; CHUNK * n_terms];
        for m in 0..n {
            for j in 0..n_inputs {
                p[m] = simd.mul_add_f64s(inputs[j][m], simd.splat_f64s(forces.values[j]), p[m]);
            }
        }
        // From rest: the first sample has no motion of the modes.
        let (first, rest) = out.split_at_mut(c.rows);
        accelerate(c, &forces.values[..n_inputs], first);
        for (u, y) in forces.values[n_inputs..].chunks(CHUNK * n_inputs).zip(rest.chunks_mut(CHUNK * c.rows)) {
            let samples = u.len() / n_inputs;
            sums.fill(zero);
            let mut m = 0;
            while m < n {
                let [a, b, d, e, from_q, to_q, from_v, to_v] =
                    step.map(|s| -> [S::f64s; WIDE] { std::array::from_fn(|w| s[m + w]) });
                let mut x: [S::f64s; WIDE] = std::array::from_fn(|w| q[m + w]);
                let mut r: [S::f64s; WIDE] = std::array::from_fn(|w| v[m + w]);
                let mut before: [S::f64s; WIDE] = std::array::from_fn(|w| p[m + w]);
                for k in 0..samples {
                    let mut now = [zero; WIDE];
                    for j in 0..n_inputs {
                        let u = simd.splat_f64s(u[k * n_inputs + j]);
                        for w in 0..WIDE {
                            now[w] = simd.mul_add_f64s(inputs[j][m + w], u, now[w]);
                        }
                    }
                    for w in 0..WIDE {
                        let forced_q = simd.mul_add_f64s(to_q[w], now[w], simd.mul_f64s(from_q[w], before[w]));
                        let forced_v = simd.mul_add_f64s(to_v[w], now[w], simd.mul_f64s(from_v[w], before[w]));
                        let (old, rate) = (x[w], r[w]);
                        x[w] = simd.mul_add_f64s(a[w], old, simd.mul_add_f64s(b[w], rate, forced_q));
                        r[w] = simd.mul_add_f64s(d[w], old, simd.mul_add_f64s(e[w], rate, forced_v));
                        before[w] = now[w];
                    }
                    for t in 0..n_terms {
                        let (_, of_rate, weights) = terms[t];
                        let mut sum = sums[k * n_terms + t];
                        for w in 0..WIDE {
                            sum = simd.mul_add_f64s(weights[m + w], if of_rate { r[w] } else { x[w] }, sum);
                        }
                        sums[k * n_terms + t] = sum;
                    }
                }
                for w in 0..WIDE {
                    (q[m + w], v[m + w], p[m + w]) = (x[w], r[w], before[w]);
                }
                m += WIDE;
            }
            rest_if_still(bytemuck::cast_slice_mut(&mut q), bytemuck::cast_slice_mut(&mut v));
            for k in 0..samples {
                let y = &mut y[k * c.rows..][..c.rows];
                for t in 0..n_terms {
                    y[terms[t].0] += simd.reduce_sum_f64s(sums[k * n_terms + t]);
                }
                accelerate(c, &u[k * n_inputs..][..n_inputs], y);
            }
        }
        let plain = |x: &[S::f64s]| bytemuck::cast_slice::<S::f64s, f64>(x)[..c.n_modes].to_vec();
        [plain(&q), plain(&v)]
    }
}

/// Motions this small are none: a mode that has rung down would else run into subnormal numbers, which cost
/// a hundred times as much.
const STILL: f64 = 1e-200;

fn rest_if_still(q: &mut [f64], v: &mut [f64]) {
    for (q, v) in q.iter_mut().zip(v) {
        if q.abs() < STILL && v.abs() < STILL {
            (*q, *v) = (0.0, 0.0);
        }
    }
}

/// The forces' own share of the accelerations.
fn accelerate(c: &Coefficients, u: &[f64], y: &mut [f64]) {
    for (row, weights) in &c.direct {
        y[*row] += weights.iter().zip(u).map(|(w, u)| w * u).sum::<f64>();
    }
}
