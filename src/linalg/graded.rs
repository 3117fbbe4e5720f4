//! Matrices whose rows differ by many powers of ten: a mount of 400 N/m beside a bolt of 1e20 N/m.
//!
//! A stiffness that is added up in one matrix keeps only the digits that the largest entry leaves: beside
//! 1e20 N/m nothing is left of 400 N/m. The routines here never add such numbers up. They work on the rows
//! of a factor, K = Lambda + W^T W, and on the flexibility (K + s)^-1, in which a stiff spring is a small
//! number and a rigid one is zero.
//!
//! # Source
//! A. J. Cox, N. J. Higham, Stability of Householder QR factorization for weighted least squares problems,
//! Numerical Analysis 1997, Pitman Research Notes 380 (1998): with rows sorted by size and columns pivoted,
//! each row keeps an error relative to itself.

use super::dense::{evd, one_thread, view};
use super::{LinalgError, SymmetricEigen, multiply};
use faer::Mat;
use nalgebra::{DMatrix, DVector};

/// A = Q R with rows of very different size; `a` has at least as many rows as columns and full column rank.
#[derive(Clone, Debug)]
pub struct GradedFactor {
    /// Q, m x n: orthonormal columns.
    pub span: DMatrix<f64>,
    /// The orthonormal complement of Q, m x (m - n).
    pub rest: DMatrix<f64>,
    /// R^-1, n x n, so that (A^T A)^-1 = R^-1 R^-T.
    pub inverse: DMatrix<f64>,
}

/// Factors a matrix by Householder reflections, its rows sorted by size and its columns pivoted.
///
/// # Errors
/// [`LinalgError::Eigen`] if an entry is not finite or the columns depend on each other.
pub fn graded_factor(a: &DMatrix<f64>) -> Result<GradedFactor, LinalgError> {
    let (m, n) = a.shape();
    assert!(m >= n, "{m} rows for {n} columns");
    let failed = || LinalgError::Eigen { n };
    if a.iter().any(|v| !v.is_finite()) {
        return Err(failed());
    }
    if n == 0 {
        return Ok(GradedFactor {
            span: DMatrix::zeros(m, 0),
            rest: DMatrix::identity(m, m),
            inverse: DMatrix::zeros(0, 0),
        });
    }
    let (order, factor) = sorted_factor(a);
    let (q, r) = (factor.compute_Q(), factor.thin_R());
    let triangle = DMatrix::from_fn(n, n, |i, j| if i <= j { r[(i, j)] } else { 0.0 });
    let inverse = triangle.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or_else(failed)?;
    // Column k of the sorted matrix that was factored is column forward[k] of A.
    let (forward, _) = factor.P().arrays();
    let mut unpivoted = DMatrix::zeros(n, n);
    for (k, &column) in forward.iter().enumerate() {
        unpivoted.row_mut(column).copy_from(&inverse.row(k));
    }
    Ok(GradedFactor { span: unsorted(&q, &order, 0, n), rest: unsorted(&q, &order, n, m - n), inverse: unpivoted })
}

/// The factor of the rows in the order of their size, and that order.
fn sorted_factor(a: &DMatrix<f64>) -> (Vec<usize>, faer::linalg::solvers::ColPivQr<f64>) {
    let size: Vec<f64> = a.row_iter().map(|row| row.amax()).collect();
    let mut order: Vec<usize> = (0..a.nrows()).collect();
    order.sort_by(|&i, &j| size[j].total_cmp(&size[i]));
    let sorted = a.select_rows(&order);
    one_thread();
    let factor = view(&sorted).col_piv_qr();
    (order, factor)
}

/// Some columns of Q with the rows in their own order again.
fn unsorted(q: &Mat<f64>, order: &[usize], first: usize, columns: usize) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(order.len(), columns);
    for j in 0..columns {
        for (i, &row) in order.iter().enumerate() {
            out[(row, j)] = q[(i, first + j)];
        }
    }
    out
}

/// Below this share of its size before, a row that earlier rows were taken out of is rounding.
const DEPENDENT: f64 = 1e-12;

/// W^T W = V G V^T with orthonormal columns V (n x r) and G^-1 (r x r), both kept for rows of very different
/// size; rows that are combinations of larger ones bring no column of their own.
///
/// # Errors
/// [`LinalgError::Eigen`] if an entry is not finite.
pub fn independent_rows(w: &DMatrix<f64>) -> Result<(DMatrix<f64>, DMatrix<f64>), LinalgError> {
    let (s, n) = w.shape();
    if w.iter().any(|v| !v.is_finite()) {
        return Err(LinalgError::Eigen { n });
    }
    let mut rest: DMatrix<f64> = w.transpose();
    let whole: Vec<f64> = (0..s).map(|k| rest.column(k).norm()).collect();
    let mut open: Vec<usize> = (0..s).filter(|&k| whole[k] > 0.0).collect();
    let (mut span, mut coefficients): (Vec<DVector<f64>>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
    while let Some(at) = (0..open.len())
        .filter(|&at| rest.column(open[at]).norm() > DEPENDENT * whole[open[at]])
        .max_by(|&a, &b| rest.column(open[a]).norm().total_cmp(&rest.column(open[b]).norm()))
    {
        let mut v: DVector<f64> = rest.column(open[at]).normalize();
        for known in &span {
            v -= known * known.dot(&v);
        }
        v.normalize_mut();
        let mut along = DVector::zeros(s);
        for &k in &open {
            along[k] = v.dot(&rest.column(k));
            let part = &v * along[k];
            rest.column_mut(k).zip_apply(&part, |x, p| *x -= p);
        }
        open.remove(at);
        span.push(v);
        coefficients.push(along);
        if span.len() == n {
            break;
        }
    }
    if span.is_empty() {
        return Ok((DMatrix::zeros(n, 0), DMatrix::zeros(0, 0)));
    }
    // W^T = V C, G = C C^T: its inverse from the factor of C^T, whose rows are those of W.
    let inverse = graded_factor(&DMatrix::from_columns(&coefficients))?.inverse;
    Ok((DMatrix::from_columns(&span), multiply(&inverse, &inverse.transpose())))
}

/// The flexibility (Lambda + s + W^T W)^-1, n x n: `diagonal` holds the n values of Lambda + s, all positive.
///
/// With Q the factor of [I; (Lambda + s)^-1/2 W^T] and Q_n its lower rows,
/// (Lambda + s + W^T W)^-1 = (Lambda + s)^-1/2 (I - Q_n Q_n^T) (Lambda + s)^-1/2.
///
/// # Errors
/// [`LinalgError::Eigen`] if an entry is not finite.
pub fn flexibility_with_springs(diagonal: &[f64], w: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let (s, n) = w.shape();
    assert_eq!(diagonal.len(), n, "one diagonal entry a coordinate");
    let root: Vec<f64> = diagonal.iter().map(|d| d.sqrt().recip()).collect();
    let lower = lower_rows(&root, w)?;
    debug_assert_eq!(lower.shape(), (n, s));
    let mut out = multiply(&lower, &lower.transpose());
    for j in 0..n {
        for i in 0..n {
            let unit = f64::from(u8::from(i == j));
            out[(i, j)] = (unit - out[(i, j)]) * root[i] * root[j];
        }
    }
    Ok(out)
}

/// Q_n of [`flexibility_with_springs`], n x s, for the roots of 1 / (Lambda + s).
///
/// # Errors
/// [`LinalgError::Eigen`] if an entry is not finite.
pub fn lower_rows(root: &[f64], w: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let (s, n) = w.shape();
    let stacked =
        DMatrix::from_fn(
            s + n,
            s,
            |i, j| {
                if i < s { f64::from(u8::from(i == j)) } else { root[i - s] * w[(j, i - s)] }
            },
        );
    if stacked.iter().any(|v| !v.is_finite()) {
        return Err(LinalgError::Eigen { n });
    }
    if s == 0 {
        return Ok(DMatrix::zeros(n, 0));
    }
    let (order, factor) = sorted_factor(&stacked);
    Ok(unsorted(&factor.compute_thin_Q(), &order, 0, s).rows(s, n).into_owned())
}

/// A flexibility below this share of the largest is rounding: the direction is rigid.
const RIGID: f64 = 1e-15;

/// Eigenvalues and vectors of A from its flexibility H = (A + shift)^-1, ascending.
///
/// # Accuracy
/// An eigenvalue lambda keeps some 5e-15 (lambda + shift)^2 / (shift lambda) of itself; rigid directions come
/// last, at 1e15 times the shift.
///
/// # Errors
/// [`LinalgError::Eigen`] if the iteration fails or an entry is not finite.
pub fn eigen_of_flexibility(h: &DMatrix<f64>, shift: f64) -> Result<SymmetricEigen, LinalgError> {
    let n = h.nrows();
    if h.iter().any(|v| !v.is_finite()) {
        return Err(LinalgError::Eigen { n });
    }
    let (mut values, mut vectors) = (DVector::zeros(n), DMatrix::zeros(n, n));
    evd(&(-0.5 * (h + h.transpose())), &mut values, &mut vectors)?;
    // Eigenvalues of the negative flexibility ascend as those of A do.
    let least = RIGID * values.iter().fold(0.0, |m: f64, v| m.max(-v));
    values.apply(|v| *v = (-*v).max(least).recip() - shift);
    Ok(SymmetricEigen { values, vectors })
}
