//! The recursions with modes across the lanes, dispatched at run time on what the processor has.

use super::{Forces, Plant, Recording};
use pulp::{Arch, Simd, WithSimd};

/// Modes are padded to a multiple of the widest vector.
const LANES: usize = 8;

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
    n_outputs: usize,
}

impl Coefficients {
    pub fn new(plant: &Plant, step: f64, recording: Recording) -> Self {
        let n = plant.omega.len();
        let padded = n.next_multiple_of(LANES).max(LANES);
        let steps = plant.steps(step);
        let pad = |of: &dyn Fn(usize) -> f64| (0..padded).map(|r| if r < n { of(r) } else { 0.0 }).collect::<Vec<f64>>();
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
            n_outputs,
        }
    }

    /// Displacements, and velocities and accelerations if recorded.
    pub fn blocks(&self) -> usize {
        self.rows / self.n_outputs.max(1)
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

impl WithSimd for Run<'_> {
    type Output = [Vec<f64>; 2];

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "closures would not be compiled for the processor that was found")]
    fn with_simd<S: Simd>(self, simd: S) -> [Vec<f64>; 2] {
        let Run { coefficients: c, forces, out } = self;
        let [a, b, d, e, from_q, to_q, from_v, to_v] = c.step.each_ref().map(|v| S::as_simd_f64s(v).0);
        let inputs: Vec<&[S::f64s]> = c.inputs.iter().map(|v| S::as_simd_f64s(v).0).collect();
        let terms: Vec<(usize, bool, &[S::f64s])> =
            c.terms.iter().map(|t| (t.row, t.of_rate, S::as_simd_f64s(&t.weights).0)).collect();
        let (n, n_inputs) = (a.len(), inputs.len());
        let zero = simd.splat_f64s(0.0);
        let (mut q, mut v, mut p) = (vec![zero; n], vec![zero; n], vec![zero; n]);
        for (k, (u, y)) in forces.values.chunks_exact(n_inputs).zip(out.chunks_exact_mut(c.rows)).enumerate() {
            let first = simd.splat_f64s(u[0]);
            for m in 0..n {
                let mut now = simd.mul_f64s(inputs[0][m], first);
                for j in 1..n_inputs {
                    now = simd.mul_add_f64s(inputs[j][m], simd.splat_f64s(u[j]), now);
                }
                let before = p[m];
                p[m] = now;
                if k > 0 {
                    let (x, w) = (q[m], v[m]);
                    let forced_q = simd.mul_add_f64s(to_q[m], now, simd.mul_f64s(from_q[m], before));
                    let forced_v = simd.mul_add_f64s(to_v[m], now, simd.mul_f64s(from_v[m], before));
                    q[m] = simd.mul_add_f64s(a[m], x, simd.mul_add_f64s(b[m], w, forced_q));
                    v[m] = simd.mul_add_f64s(d[m], x, simd.mul_add_f64s(e[m], w, forced_v));
                }
            }
            for t in 0..terms.len() {
                let (row, of_rate, weights) = terms[t];
                let state = if of_rate { &v } else { &q };
                // Two sums, so that one addition need not wait for the other.
                let (mut even, mut odd) = (zero, zero);
                let mut m = 0;
                while m + 1 < n {
                    even = simd.mul_add_f64s(weights[m], state[m], even);
                    odd = simd.mul_add_f64s(weights[m + 1], state[m + 1], odd);
                    m += 2;
                }
                if m < n {
                    even = simd.mul_add_f64s(weights[m], state[m], even);
                }
                y[row] += simd.reduce_sum_f64s(simd.add_f64s(even, odd));
            }
            for i in 0..c.direct.len() {
                let (row, weights) = (c.direct[i].0, &c.direct[i].1);
                for j in 0..n_inputs {
                    y[row] += weights[j] * u[j];
                }
            }
        }
        let plain = |x: &[S::f64s]| bytemuck::cast_slice::<S::f64s, f64>(x)[..c.n_modes].to_vec();
        [plain(&q), plain(&v)]
    }
}
