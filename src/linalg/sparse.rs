//! Sparse symmetric matrices, stored whole by rows (which are its columns too).

use nalgebra::DMatrix;
use rayon::prelude::*;

/// Columns that a product treats side by side.
const PANEL: usize = 8;

/// A sparse symmetric matrix with both triangles stored: row i is column i.
#[derive(Clone, Debug)]
pub struct SparseSymmetric {
    n: usize,
    row_start: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
}

impl SparseSymmetric {
    /// Order of the matrix.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Stored entries, both triangles.
    pub fn entries(&self) -> usize {
        self.value.len()
    }

    /// Where each row starts in [`Self::columns`] and [`Self::values`]; n + 1 numbers.
    pub fn row_starts(&self) -> &[usize] {
        &self.row_start
    }

    /// Column of each entry, ascending within a row.
    pub fn columns(&self) -> &[usize] {
        &self.column
    }

    /// Value of each entry.
    pub fn values(&self) -> &[f64] {
        &self.value
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.n).map(|i| self.row(i).find(|&(j, _)| j == i).map_or(0.0, |(_, v)| v)).collect()
    }

    /// Column and value of each entry of a row.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.row_start[i]..self.row_start[i + 1];
        self.column[range.clone()].iter().copied().zip(self.value[range].iter().copied())
    }

    /// The product with a dense n x b block.
    pub fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        assert_eq!(x.nrows(), self.n, "rows of the block against the order of the matrix");
        let mut out = DMatrix::<f64>::zeros(self.n, x.ncols());
        if self.n > 0 {
            let panel = PANEL * self.n;
            out.as_mut_slice()
                .par_chunks_mut(panel)
                .zip(x.as_slice().par_chunks(panel))
                .for_each(|(out, x)| self.multiply_panel(x, out));
        }
        out
    }

    /// Up to [`PANEL`] columns at once: one pass over the matrix serves them all, their values side by side.
    fn multiply_panel(&self, x: &[f64], out: &mut [f64]) {
        let columns = x.len() / self.n;
        let mut rows = vec![[0.0; PANEL]; self.n];
        for (c, column) in x.chunks_exact(self.n).enumerate() {
            for (row, value) in rows.iter_mut().zip(column) {
                row[c] = *value;
            }
        }
        // Compiled once for each vector width and picked at run time.
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for i in 0..self.n {
                    let mut sum = [0.0; PANEL];
                    for (j, v) in self.row(i) {
                        let row = &rows[j];
                        for c in 0..PANEL {
                            sum[c] += v * row[c];
                        }
                    }
                    for (c, sum) in sum.iter().enumerate().take(columns) {
                        out[c * self.n + i] = *sum;
                    }
                }
            },
        );
    }

    /// self + factor * other; both have the same pattern.
    pub fn plus_scaled(&self, factor: f64, other: &Self) -> Self {
        assert_eq!(self.column, other.column, "the two matrices have one pattern");
        let value = self.value.iter().zip(&other.value).map(|(a, b)| a + factor * b).collect();
        Self { value, ..self.clone() }
    }

    /// factor diag(scale) self diag(scale).
    pub fn scaled(mut self, factor: f64, scale: &[f64]) -> Self {
        assert_eq!(scale.len(), self.n, "one scale a row");
        for i in 0..self.n {
            for k in self.row_start[i]..self.row_start[i + 1] {
                self.value[k] *= factor * scale[i] * scale[self.column[k]];
            }
        }
        self
    }

    /// A copy with another diagonal, made from the old one.
    pub fn with_diagonal(&self, mut new: impl FnMut(usize, f64) -> f64) -> Self {
        let mut out = self.clone();
        for i in 0..self.n {
            for k in self.row_start[i]..self.row_start[i + 1] {
                if self.column[k] == i {
                    out.value[k] = new(i, self.value[k]);
                }
            }
        }
        out
    }

    /// A copy in which the given rows and columns are uncoupled: only their diagonal is left.
    pub fn with_uncoupled(&self, unknowns: &[usize]) -> Self {
        let mut out = self.clone();
        let cut: std::collections::BTreeSet<usize> = unknowns.iter().copied().collect();
        for i in 0..self.n {
            for k in self.row_start[i]..self.row_start[i + 1] {
                let j = self.column[k];
                if i != j && (cut.contains(&i) || cut.contains(&j)) {
                    out.value[k] = 0.0;
                }
            }
        }
        out
    }
}

/// Collects entries of a symmetric matrix on a pattern that is known in advance.
#[derive(Clone, Debug)]
pub struct SparseBuilder {
    matrix: SparseSymmetric,
}

impl SparseBuilder {
    /// An empty matrix whose row i holds the columns `pattern[i]` (ascending, symmetric, with the diagonal).
    pub fn new(pattern: &[Vec<usize>]) -> Self {
        let n = pattern.len();
        let mut row_start = Vec::with_capacity(n + 1);
        row_start.push(0);
        for row in pattern {
            row_start.push(row_start[row_start.len() - 1] + row.len());
        }
        let column: Vec<usize> = pattern.iter().flatten().copied().collect();
        let value = vec![0.0; column.len()];
        Self { matrix: SparseSymmetric { n, row_start, column, value } }
    }

    /// Adds to one entry; the mirrored entry is the caller's to add.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let range = self.matrix.row_start[i]..self.matrix.row_start[i + 1];
        match self.matrix.column[range.clone()].binary_search(&j) {
            Ok(k) => self.matrix.value[range.start + k] += value,
            Err(_) => panic!("entry ({i}, {j}) is not in the pattern"),
        }
    }

    /// The matrix.
    pub fn finish(self) -> SparseSymmetric {
        self.matrix
    }
}
