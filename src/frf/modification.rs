//! Structural modification: the compliance of a machine whose springs change, from that of the base.
//!
//! With the base's receptances between ports p and springs s (a spring's motion is its elongation) at
//! one frequency, and Delta = diag(dk) the complex change of the springs' dynamic stiffness,
//!
//! ```text
//! H = H_pp - H_ps (Delta^-1 + H_ss)^-1 H_sp
//! ```
//!
//! exactly, damping included. It is the Schur complement of the bordered symmetric matrix
//! [[Delta^-1 + H_ss, H_sp], [H_ps, H_pp]] after its springs are eliminated, and is computed so, with
//! frequencies across the lanes.
//!
//! Source: Ewins, Modal Testing, 2nd ed., section 6.4; the identity is Woodbury's.

use crate::linalg::multiply;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use std::ops::Range;

/// Frequencies side by side.
pub(crate) const LANES: usize = 8;

/// A mode of the base as the receptances see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMode {
    /// Natural frequency, Hz.
    pub frequency: f64,
    /// Viscous damping ratio.
    pub damping_ratio: f64,
    /// Structural loss factor.
    pub loss_factor: f64,
}

/// Receptances of the base between its springs, then its ports, at every frequency.
#[derive(Clone, Debug)]
pub struct BaseReceptance {
    /// Frequencies, Hz, ascending, as asked for.
    pub frequencies: Vec<f64>,
    /// Springs.
    pub n_springs: usize,
    /// Springs and ports.
    pub n_rows: usize,
    /// `[block][entry of the lower triangle, row by row][real, imaginary][lane]`.
    values: Vec<[f64; 2 * LANES]>,
}

/// A change of one spring's dynamic stiffness: stiffness + j omega damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringChange {
    /// Complex change of stiffness, N/m or N m/rad.
    pub stiffness: Complex<f64>,
    /// Change of viscous damping, N s/m or N m s/rad.
    pub damping: f64,
}

impl SpringChange {
    /// Whether anything changes.
    pub fn is_zero(&self) -> bool {
        self.stiffness == Complex::new(0.0, 0.0) && self.damping == 0.0
    }
}

impl BaseReceptance {
    /// Receptances from the base's modes: rows (n_springs + n_ports) x n_modes, mass-normalised, and the
    /// flexibility between rows that no mode carries, m/N.
    pub fn new(
        frequencies: &[f64],
        modes: &[BaseMode],
        rows: &DMatrix<f64>,
        residual: &DMatrix<Complex<f64>>,
        n_springs: usize,
    ) -> Self {
        let n_rows = rows.nrows();
        let entries: Vec<(usize, usize)> = (0..n_rows).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
        let residues = DMatrix::from_fn(entries.len(), modes.len(), |e, r| {
            let (i, j) = entries[e];
            rows[(i, r)] * rows[(j, r)] / (TAU * TAU)
        });
        let n = frequencies.len();
        let mut weights = DMatrix::zeros(modes.len(), 2 * n);
        for (k, &f) in frequencies.iter().enumerate() {
            for (r, mode) in modes.iter().enumerate() {
                let f_r = mode.frequency;
                let imaginary = mode.loss_factor * f_r * f_r + 2.0 * mode.damping_ratio * f_r * f;
                let w = Complex::new((f_r - f) * (f_r + f), imaginary).inv();
                (weights[(r, 2 * k)], weights[(r, 2 * k + 1)]) = (w.re, w.im);
            }
        }
        let sums = multiply(&residues, &weights);
        let blocks = n.div_ceil(LANES);
        let mut values = vec![[0.0; 2 * LANES]; blocks * entries.len()];
        for (block, values) in values.chunks_exact_mut(entries.len()).enumerate() {
            for lane in 0..LANES {
                let k = (block * LANES + lane).min(n - 1);
                for (e, value) in values.iter_mut().enumerate() {
                    let rest = residual[entries[e]];
                    value[lane] = sums[(e, 2 * k)] + rest.re;
                    value[LANES + lane] = sums[(e, 2 * k + 1)] + rest.im;
                }
            }
        }
        Self { frequencies: frequencies.to_vec(), n_springs, n_rows, values }
    }

    /// The receptances at frequency k, n_rows x n_rows, m/N.
    pub fn at(&self, k: usize) -> DMatrix<Complex<f64>> {
        let block = self.block(k / LANES);
        DMatrix::from_fn(self.n_rows, self.n_rows, |a, b| {
            let v = &block[entry(a.max(b), a.min(b))];
            Complex::new(v[k % LANES], v[LANES + k % LANES])
        })
    }

    pub(crate) fn block(&self, block: usize) -> &[[f64; 2 * LANES]] {
        let entries = entry(self.n_rows, 0);
        &self.values[block * entries..][..entries]
    }

    /// Receptances of the changed machine between pairs of ports, `[pair][frequency]`, m/N.
    ///
    /// # Shapes and units
    /// `changes` has one entry a spring; `pairs` are ports (row, column), counted from 0.
    ///
    /// # Accuracy
    /// That of the elimination without pivoting: the tests hold 1e-10 of the largest entry against a
    /// direct complex solve.
    pub fn modified(
        &self,
        changes: &[SpringChange],
        pairs: &[(usize, usize)],
        work: &mut Work,
    ) -> Vec<Vec<Complex<f64>>> {
        self.modified_in(changes, pairs, std::slice::from_ref(&(0..self.frequencies.len())), work)
    }

    /// [`Self::modified`] at the frequencies of some runs, as [`Self::runs_around`] makes them, one after the other.
    ///
    /// # Accuracy
    /// The same numbers, bit for bit.
    pub fn modified_in(
        &self,
        changes: &[SpringChange],
        pairs: &[(usize, usize)],
        runs: &[Range<usize>],
        work: &mut Work,
    ) -> Vec<Vec<Complex<f64>>> {
        assert_eq!(changes.len(), self.n_springs, "one change a spring");
        assert!(runs.iter().all(|run| run.start % LANES == 0), "runs {runs:?} begin with a block of {LANES}");
        work.order.clear();
        work.order.extend((0..self.n_springs).filter(|&s| !changes[s].is_zero()));
        let springs = work.order.len();
        work.order.extend(self.n_springs..self.n_rows);
        work.matrix.resize(entry(work.order.len(), 0), [0.0; 2 * LANES]);
        let n = runs.iter().map(Range::len).sum();
        let mut out = vec![Vec::with_capacity(n); pairs.len()];
        pulp::Arch::new().dispatch(|| {
            for run in runs {
                for (block, frequencies) in (run.start / LANES..).zip(self.frequencies[run.clone()].chunks(LANES)) {
                    self.gather(block, frequencies, changes, springs, work);
                    eliminate(&mut work.matrix, springs, work.order.len());
                    for (out, &(a, b)) in out.iter_mut().zip(pairs) {
                        let value = &work.matrix[entry(springs + a.max(b), springs + a.min(b))];
                        out.extend((0..frequencies.len()).map(|lane| Complex::new(value[lane], value[LANES + lane])));
                    }
                }
            }
        });
        out
    }

    /// Runs of frequencies, ascending and apart, that hold each index and its neighbours up to `reach`: whole blocks
    /// of those that are eliminated side by side.
    pub fn runs_around(&self, indices: &[usize], reach: usize) -> Vec<Range<usize>> {
        let n = self.frequencies.len();
        let mut wanted = vec![false; n.div_ceil(LANES)];
        for &index in indices {
            assert!(index < n, "frequency {index} of {n}");
            wanted[index.saturating_sub(reach) / LANES..=(index + reach).min(n - 1) / LANES].fill(true);
        }
        let mut runs: Vec<Range<usize>> = Vec::new();
        for (block, _) in wanted.iter().enumerate().filter(|(_, wanted)| **wanted) {
            let (start, end) = (block * LANES, ((block + 1) * LANES).min(n));
            match runs.last_mut() {
                Some(run) if run.end == start => run.end = end,
                _ => runs.push(start..end),
            }
        }
        runs
    }

    /// The bordered matrix of a block of frequencies.
    #[inline(always)]
    fn gather(&self, block: usize, frequencies: &[f64], changes: &[SpringChange], springs: usize, work: &mut Work) {
        let base = self.block(block);
        let mut next = 0;
        for (i, &row) in work.order.iter().enumerate() {
            for &column in &work.order[..=i] {
                work.matrix[next] = base[entry(row, column)];
                next += 1;
            }
            if i < springs {
                let change = changes[row];
                let diagonal = &mut work.matrix[next - 1];
                for lane in 0..LANES {
                    let omega = TAU * frequencies[lane.min(frequencies.len() - 1)];
                    let (re, im) = (change.stiffness.re, change.stiffness.im + omega * change.damping);
                    let square = re * re + im * im;
                    diagonal[lane] += re / square;
                    diagonal[LANES + lane] -= im / square;
                }
            }
        }
    }
}

/// Memory of [`BaseReceptance::modified`], to be kept between calls.
#[derive(Clone, Debug, Default)]
pub struct Work {
    order: Vec<usize>,
    matrix: Vec<[f64; 2 * LANES]>,
}

/// Place of an entry of the lower triangle.
#[inline(always)]
pub(crate) fn entry(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Eliminates the first rows of a complex symmetric matrix in every lane.
#[inline(always)]
fn eliminate(matrix: &mut [[f64; 2 * LANES]], pivots: usize, n: usize) {
    for k in 0..pivots {
        let pivot = matrix[entry(k, k)];
        let mut inverse = [0.0; 2 * LANES];
        for lane in 0..LANES {
            let square = pivot[lane] * pivot[lane] + pivot[LANES + lane] * pivot[LANES + lane];
            inverse[lane] = pivot[lane] / square;
            inverse[LANES + lane] = -pivot[LANES + lane] / square;
        }
        for i in k + 1..n {
            let a = matrix[entry(i, k)];
            let mut factor = [0.0; 2 * LANES];
            for lane in 0..LANES {
                factor[lane] = a[lane] * inverse[lane] - a[LANES + lane] * inverse[LANES + lane];
                factor[LANES + lane] = a[lane] * inverse[LANES + lane] + a[LANES + lane] * inverse[lane];
            }
            for j in k + 1..=i {
                let b = matrix[entry(j, k)];
                let target = &mut matrix[entry(i, j)];
                for lane in 0..LANES {
                    target[lane] -= factor[lane] * b[lane] - factor[LANES + lane] * b[LANES + lane];
                    target[LANES + lane] -= factor[lane] * b[LANES + lane] + factor[LANES + lane] * b[lane];
                }
            }
        }
    }
}
