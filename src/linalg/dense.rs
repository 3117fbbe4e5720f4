//! Dense products, symmetric eigenproblem and rank-revealing orthonormalisation.

use super::LinalgError;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::diag::DiagMut;
use faer::{Accum, MatMut, MatRef, Par, Spec};
use nalgebra::{DMatrix, DVector};

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix.
#[derive(Clone, Debug)]
pub struct SymmetricEigen {
    /// Eigenvalues, ascending.
    pub values: DVector<f64>,
    /// Eigenvectors, one a column.
    pub vectors: DMatrix<f64>,
}

/// Eigenvalues and eigenvectors of a symmetric matrix, of which the lower triangle is read; all threads.
///
/// # Errors
/// [`LinalgError::Eigen`] if the iteration does not converge or an entry is not finite.
pub fn symmetric_eigen(a: &DMatrix<f64>) -> Result<SymmetricEigen, LinalgError> {
    eigen(a, Par::rayon(0))
}

/// The same on the calling thread alone, for loops that are parallel already.
///
/// # Errors
/// As [`symmetric_eigen`].
pub fn symmetric_eigen_sequential(a: &DMatrix<f64>) -> Result<SymmetricEigen, LinalgError> {
    eigen(a, Par::Seq)
}

fn eigen(a: &DMatrix<f64>, par: Par) -> Result<SymmetricEigen, LinalgError> {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a symmetric matrix is square");
    if a.iter().any(|v| !v.is_finite()) {
        return Err(LinalgError::Eigen { n });
    }
    let (mut values, mut vectors) = (DVector::zeros(n), DMatrix::zeros(n, n));
    let mut memory = MemBuffer::new(self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, par, Spec::default()));
    self_adjoint_evd(
        view(a),
        DiagMut::from_slice_mut(values.as_mut_slice()),
        Some(MatMut::from_column_major_slice_mut(vectors.as_mut_slice(), n, n)),
        par,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| LinalgError::Eigen { n })?;
    Ok(SymmetricEigen { values, vectors })
}

/// A B.
pub fn multiply(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(a.ncols(), b.nrows(), "inner dimensions of A B");
    product(view(a), view(b))
}

/// A^T B.
pub fn multiply_transposed(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(a.nrows(), b.nrows(), "inner dimensions of A^T B");
    product(view(a).transpose(), view(b))
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> DMatrix<f64> {
    let mut c = DMatrix::zeros(a.nrows(), b.ncols());
    let (rows, columns) = c.shape();
    let out = MatMut::from_column_major_slice_mut(c.as_mut_slice(), rows, columns);
    matmul(out, Accum::Replace, a, b, 1.0, Par::rayon(0));
    c
}

fn view(a: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

/// Number of negative eigenvalues of a small symmetric matrix, of which the lower triangle is read.
///
/// # Errors
/// [`LinalgError::Eigen`] as for [`symmetric_eigen`].
pub fn count_negative(a: &DMatrix<f64>) -> Result<usize, LinalgError> {
    Ok(symmetric_eigen_sequential(a)?.values.iter().filter(|v| **v < 0.0).count())
}

/// Combinations T that make the columns of V orthonormal, from their Gram matrix G = V^T V (in any
/// inner product): T^T G T = I. Directions below `tolerance` of the largest, after each column has
/// been scaled to unit length, are left out; zero columns too.
///
/// # Errors
/// [`LinalgError::Eigen`] as for [`symmetric_eigen`].
pub fn independent_directions(gram: &DMatrix<f64>, tolerance: f64) -> Result<DMatrix<f64>, LinalgError> {
    let n = gram.nrows();
    let scale: Vec<f64> = (0..n).map(|i| if gram[(i, i)] > 0.0 { gram[(i, i)].sqrt().recip() } else { 0.0 }).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| gram[(i, j)] * scale[i] * scale[j]);
    let eigen = symmetric_eigen(&unit)?;
    let largest = eigen.values.iter().copied().fold(0.0, f64::max);
    // Strongest first, so that a reader of the basis meets the important directions first.
    let kept: Vec<usize> = (0..n).rev().filter(|&k| eigen.values[k] > tolerance * largest && eigen.values[k] > 0.0).collect();
    Ok(DMatrix::from_fn(n, kept.len(), |i, k| {
        let k = kept[k];
        scale[i] * eigen.vectors[(i, k)] / eigen.values[k].sqrt()
    }))
}

/// An orthonormal basis of the columns of V, without the directions whose singular value is below
/// `tolerance` of the largest.
///
/// # Errors
/// [`LinalgError::Eigen`] if V is not finite.
pub fn orthonormal_span(v: &DMatrix<f64>, tolerance: f64) -> Result<DMatrix<f64>, LinalgError> {
    let n = v.ncols().min(v.nrows());
    let failed = || LinalgError::Eigen { n };
    if v.iter().any(|v| !v.is_finite()) {
        return Err(failed());
    }
    if n == 0 {
        return Ok(DMatrix::zeros(v.nrows(), 0));
    }
    let svd = view(v).thin_svd().map_err(|_| failed())?;
    let values = svd.S().column_vector();
    let kept = (0..n).take_while(|&k| values[k] > tolerance * values[0]).count();
    Ok(DMatrix::from_fn(v.nrows(), kept, |i, k| svd.U()[(i, k)]))
}
