//! Eigenvalues and eigenvectors of a general complex matrix.

use super::LinalgError;
use super::dense::one_thread;
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::{Complex, DMatrix};

/// A = V diag(values) V^-1.
#[derive(Clone, Debug)]
pub struct ComplexEigen {
    /// Eigenvalues, in no order.
    pub values: Vec<Complex<f64>>,
    /// V, one eigenvector a column.
    pub vectors: DMatrix<Complex<f64>>,
    /// V^-1.
    pub inverse: DMatrix<Complex<f64>>,
}

/// Eigenvalues and eigenvectors of a complex matrix (faer's QR iteration).
///
/// # Errors
/// [`LinalgError::Eigen`] if the iteration does not converge or an entry is not finite.
pub fn complex_eigen(a: &DMatrix<Complex<f64>>) -> Result<ComplexEigen, LinalgError> {
    let n = a.nrows();
    let failed = || LinalgError::Eigen { n };
    if a.ncols() != n || a.iter().any(|x| !x.re.is_finite() || !x.im.is_finite()) {
        return Err(failed());
    }
    if n == 0 {
        let none = DMatrix::zeros(0, 0);
        return Ok(ComplexEigen { values: Vec::new(), vectors: none.clone(), inverse: none });
    }
    one_thread();
    let matrix = Mat::from_fn(n, n, |i, j| faer::c64::new(a[(i, j)].re, a[(i, j)].im));
    let eigen = matrix.eigen().map_err(|_| failed())?;
    let vectors = eigen.U();
    let inverse = vectors.partial_piv_lu().solve(Mat::<faer::c64>::identity(n, n));
    let plain = |x: &faer::c64| Complex::new(x.re, x.im);
    let out = ComplexEigen {
        values: eigen.S().column_vector().iter().map(plain).collect(),
        vectors: DMatrix::from_fn(n, n, |i, j| plain(&vectors[(i, j)])),
        inverse: DMatrix::from_fn(n, n, |i, j| plain(&inverse[(i, j)])),
    };
    if out.inverse.iter().any(|x| !x.re.is_finite() || !x.im.is_finite()) {
        return Err(failed());
    }
    Ok(out)
}
