//! Joints in series with the flexibility that the basis leaves out.
//!
//! With D = diag(k) and C = T^T T the residual flexibility between the springs, a spring that the basis feels
//! has D' = (D^-1 + C)^-1. It is formed from the factor of [D^-1/2; T], so that springs may differ by any
//! power of ten: a stiff one is a small number here, and soft ones keep all their digits beside it.

use crate::linalg::{LinalgError, graded_factor, multiply};
use nalgebra::DMatrix;

/// The joints at one position in series with the residual flexibility.
#[derive(Clone, Debug)]
pub(super) struct Series {
    /// Springs with a stiffness above zero.
    active: Vec<usize>,
    /// D^-1/2 of the active springs.
    soft: Vec<f64>,
    /// D' = S S^T, n_springs x n_active; rows of springs without stiffness are zero.
    pub root: DMatrix<f64>,
    /// The orthonormal complement of the factor: rows of [D^-1/2; T], P = [P_1; P_2].
    complement: DMatrix<f64>,
}

impl Series {
    /// From the factor T of the residual flexibility, whose first columns are the springs.
    pub fn new(factor: &DMatrix<f64>, stiffness: &[f64]) -> Result<Self, LinalgError> {
        let active: Vec<usize> = (0..stiffness.len()).filter(|&s| stiffness[s] > 0.0).collect();
        let soft: Vec<f64> = active.iter().map(|&s| stiffness[s].sqrt().recip()).collect();
        let a = active.len();
        let stacked = DMatrix::from_fn(a + factor.nrows(), a, |i, j| match i.checked_sub(a) {
            None if i == j => soft[j],
            None => 0.0,
            Some(row) => factor[(row, active[j])],
        });
        let graded = graded_factor(&stacked)?;
        let mut root = DMatrix::zeros(stiffness.len(), a);
        for (k, &s) in active.iter().enumerate() {
            root.row_mut(s).copy_from(&graded.inverse.row(k));
        }
        Ok(Self { active, soft, root, complement: graded.rest })
    }

    /// The one S with D' = S S^T that is lower triangular with a positive diagonal over the active springs: while D'
    /// changes smoothly, so does it. n_springs x n_active.
    pub fn smooth_root(&self) -> DMatrix<f64> {
        let active = self.root.select_rows(&self.active);
        let mut upper = active.transpose().qr().r();
        for mut row in upper.row_iter_mut() {
            if let Some(first) = row.iter().find(|x| **x != 0.0).copied().filter(|x| *x < 0.0) {
                row *= first.signum();
            }
        }
        let mut root = DMatrix::zeros(self.root.nrows(), self.root.ncols());
        for (k, &s) in self.active.iter().enumerate() {
            root.row_mut(s).copy_from(&upper.column(k).transpose());
        }
        root
    }

    /// D', n_springs x n_springs, N/m.
    pub fn stiffness(&self) -> DMatrix<f64> {
        multiply(&self.root, &self.root.transpose())
    }

    /// The residual flexibility between all rows with the springs in place, C - C_.s D' C_s., m/N.
    ///
    /// It is a sum of squares, T^T P_2 P_2^T T, and a row of T^T P_2 is that of -D^-1/2 P_1 too: the smaller one
    /// has the digits.
    pub fn residual_in_place(&self, factor: &DMatrix<f64>) -> DMatrix<f64> {
        let a = self.active.len();
        let (upper, lower) = (self.complement.rows(0, a), self.complement.rows_range(a..).into_owned());
        let mut root = multiply(&factor.transpose(), &lower);
        for (k, &s) in self.active.iter().enumerate() {
            if self.soft[k] < factor.column(s).norm() {
                root.row_mut(s).copy_from(&(upper.row(k) * -self.soft[k]));
            }
        }
        multiply(&root, &root.transpose())
    }

    /// Elongations of all springs for unit coordinates, from the forces D' B: the force over the stiffness, or
    /// of a spring without stiffness (I - C D') B.
    pub fn elongations(
        &self,
        springs: &DMatrix<f64>,
        flexibility: &DMatrix<f64>,
        forces: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let mut out = if self.active.len() == springs.nrows() {
            DMatrix::zeros(springs.nrows(), springs.ncols())
        } else {
            springs - multiply(flexibility, forces)
        };
        for (&s, soft) in self.active.iter().zip(&self.soft) {
            out.row_mut(s).copy_from(&(forces.row(s) * (soft * soft)));
        }
        out
    }
}
