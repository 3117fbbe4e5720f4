//! The eigenproblem of the coupled machine.
//!
//! It is solved by its flexibility H = (K + s)^-1, in which a stiff joint is a small number and a rigid one
//! is zero, so the accuracy of the low modes does not hang on the stiffest spring. The shift s lies below the
//! band and keeps free motions finite; which motions are free is known from the mechanism, not from a size.

use super::mechanism::free_motions;
use super::{AtPosition, Coupled, CoupledModel};
use crate::linalg::{LinalgError, eigen_of_flexibility, flexibility_with_springs, multiply, multiply_transposed};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Modes of the coupled machine over the coordinates that they were solved in.
#[derive(Clone, Debug)]
pub struct CoupledEigen {
    /// omega^2, (rad/s)^2, ascending; exactly 0 for the free motions, which come first.
    pub values: DVector<f64>,
    /// Mass-normalised shapes, n x n.
    pub vectors: DMatrix<f64>,
    /// Free motions.
    pub free: usize,
}

/// The shift lies at this share of the frequency that the basis is made for: modes from a thousandth of it
/// to a thousand times as high keep eight digits.
const SHIFT: f64 = 1.0 / 300.0;
/// Below this share of the shift an eigenvalue is taken from Rayleigh's quotient, a sum of positive terms.
const SMALL: f64 = 1e-2;

/// The shift for a basis made for a frequency (Hz), (rad/s)^2.
pub(super) fn shift_for(frequency: f64) -> f64 {
    (TAU * SHIFT * frequency).powi(2)
}

impl CoupledModel {
    /// All modes of the machine in its fixed basis with the springs that `coupled` was made with.
    ///
    /// # Errors
    /// [`LinalgError::Eigen`] if the dense eigenproblem fails.
    ///
    /// # Accuracy
    /// Modes from a thousandth of the frequency that the basis was made for to a thousand times as high keep
    /// eight digits of omega^2, whatever the joints' stiffness (up to some 1e22 N/m).
    pub fn eigen(&self, at: &AtPosition, coupled: &Coupled, stiffness: &[f64]) -> Result<CoupledEigen, LinalgError> {
        let free = free_motions(&at.springs, &self.eigenvalues, stiffness);
        let raised: Vec<f64> = self.eigenvalues.iter().map(|l| l + self.shift()).collect();
        let flexibility = flexibility_with_springs(&raised, &coupled.roots)?;
        let eigen = eigen_of_flexibility(&flexibility, self.shift())?;
        let mut out = CoupledEigen { values: eigen.values, vectors: eigen.vectors, free: free.ncols() };
        out.settle(&free);
        let small = out.free..out.values.iter().take_while(|l| **l < SMALL * self.shift()).count().max(out.free);
        for r in small {
            let shape = out.vectors.columns(r, 1).into_owned();
            let parts: f64 = self.eigenvalues.iter().zip(shape.iter()).map(|(l, z)| l * z * z).sum();
            out.values[r] = parts + multiply(&coupled.roots, &shape).norm_squared();
        }
        Ok(out)
    }
}

impl CoupledEigen {
    /// Puts the free motions first, at exactly zero, and makes the next few shapes orthogonal to them.
    pub(super) fn settle(&mut self, free: &DMatrix<f64>) {
        let n = free.ncols();
        if n == 0 {
            return;
        }
        self.values.rows_mut(0, n).fill(0.0);
        self.vectors.columns_mut(0, n).copy_from(free);
        let rest = self.vectors.columns_range(n..).into_owned();
        let rest = &rest - multiply(free, &multiply_transposed(free, &rest));
        for (k, column) in rest.column_iter().enumerate() {
            let length = column.norm();
            self.vectors.column_mut(n + k).copy_from(&(column / length));
        }
    }
}
