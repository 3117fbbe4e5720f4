//! Dense references by nalgebra, which share no code with the crate's solvers.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use std::f64::consts::TAU;
use stiffmap::linalg::SparseSymmetric;

/// A sparse matrix in full.
pub fn full(a: &SparseSymmetric) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.n(), a.n());
    for i in 0..a.n() {
        for (j, v) in a.row(i) {
            out[(i, j)] = v;
        }
    }
    out
}

/// Eigenvalues of K x = lambda M x, ascending, as those of (K + s M)^-1 M: the low ones are accurate
/// relative to lambda + s, however large the others are.
pub fn eigenvalues(stiffness: &DMatrix<f64>, mass: &DMatrix<f64>, shift: f64) -> Vec<f64> {
    let shifted = stiffness + mass * shift;
    let root = Cholesky::new(0.5 * (&shifted + shifted.transpose())).expect("K + s M is positive definite").l();
    let half = root.solve_lower_triangular(mass).expect("regular");
    let inverse = root.solve_lower_triangular(&half.transpose()).expect("regular");
    let theta = (0.5 * (&inverse + inverse.transpose())).symmetric_eigenvalues();
    let mut values: Vec<f64> = theta.iter().map(|t| 1.0 / t - shift).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The lowest frequencies (Hz) of K x = omega^2 M x; rigid motions are reported as about zero.
pub fn frequencies(stiffness: &DMatrix<f64>, mass: &DMatrix<f64>, shift: f64) -> Vec<f64> {
    let values = eigenvalues(stiffness, mass, shift);
    values.iter().map(|l| l.max(0.0).sqrt() / TAU).collect()
}

/// Eigenvalues, ascending, of a symmetric matrix.
pub fn symmetric_values(a: &DMatrix<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = SymmetricEigen::new(a.clone()).eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// diag(a, b).
pub fn side_by_side(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = (a.nrows(), b.nrows());
    let mut out = DMatrix::zeros(n + m, n + m);
    out.view_mut((0, 0), (n, n)).copy_from(a);
    out.view_mut((n, n), (m, m)).copy_from(b);
    out
}

/// Displacements of points by the motion t + theta x (x - about), stacked.
pub fn rigid_field(points: &[[f64; 3]], about: [f64; 3], motion: [f64; 6]) -> DVector<f64> {
    let [tx, ty, tz, rx, ry, rz] = motion;
    let field = points.iter().flat_map(|p| {
        let [x, y, z] = [p[0] - about[0], p[1] - about[1], p[2] - about[2]];
        [tx + ry * z - rz * y, ty + rz * x - rx * z, tz + rx * y - ry * x]
    });
    DVector::from_iterator(3 * points.len(), field)
}
