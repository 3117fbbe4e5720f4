//! The exact step of a linear system whose modes are coupled.

use crate::linalg::multiply_transposed;
use nalgebra::DMatrix;

/// The exact step of x' = A x + B u over a time.
///
/// ```text
/// x(h) = phi x(0) + constant u                 u constant
/// x(h) = phi x(0) + from u(0) + to u(h)        u straight in between
/// ```
///
/// All four are blocks of one matrix exponential (Van Loan, IEEE Trans. Automat. Contr. 23, 1978), here of the states
/// and the inputs' values and slopes.
#[derive(Clone, Debug)]
pub struct SystemStep {
    /// n x n.
    pub phi: DMatrix<f64>,
    /// n x n_input, for inputs that stay constant.
    pub constant: DMatrix<f64>,
    /// n x n_input, for the inputs at the beginning.
    pub from: DMatrix<f64>,
    /// n x n_input, for the inputs at the end.
    pub to: DMatrix<f64>,
}

/// A of modes with dampers between them, [0 I; -diag(omega^2), -(diag(2 zeta omega) + G^T G)], 2n x 2n.
///
/// `eigenvalues` are omega^2, (rad/s)^2, `zeta` the ratios without the dampers, `dampers` the rows G, n_damper x n.
pub fn state_matrix(eigenvalues: &[f64], zeta: &[f64], dampers: &DMatrix<f64>) -> DMatrix<f64> {
    let n = eigenvalues.len();
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    if dampers.nrows() > 0 {
        a.view_mut((n, n), (n, n)).copy_from(&-multiply_transposed(dampers, dampers));
    }
    for r in 0..n {
        a[(r, n + r)] = 1.0;
        a[(n + r, r)] = -eigenvalues[r];
        a[(n + r, n + r)] -= 2.0 * zeta[r] * eigenvalues[r].sqrt();
    }
    a
}

/// Slow and free motions are scaled as if they turned by this much a second, rad/s.
const SLOWEST: f64 = 1.0;

impl SystemStep {
    /// The step over a time (s) of modes with the eigenvalues omega^2, whose states are displacements and then rates.
    ///
    /// The exponential is formed with the displacements times their frequencies, so that all states are rates.
    ///
    /// # Accuracy
    /// Some 1e-14 of the largest entry of each block in these states.
    ///
    /// # Panics
    /// If an entry or the step is not finite, or A is not twice as large as the number of modes.
    pub fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, eigenvalues: &[f64], step: f64) -> Self {
        let (n, i) = (a.nrows(), b.ncols());
        assert_eq!(n, 2 * eigenvalues.len(), "two states a mode");
        let scale: Vec<f64> = eigenvalues.iter().map(|l| l.sqrt().max(SLOWEST)).collect();
        let mut all = DMatrix::zeros(n + 2 * i, n + 2 * i);
        all.view_mut((0, 0), (n, n)).copy_from(&(a * step));
        all.view_mut((0, n), (n, i)).copy_from(&(b * step));
        all.view_mut((n, n + i), (i, i)).fill_with_identity();
        assert!(all.iter().all(|x| x.is_finite()), "a system of finite numbers");
        for (r, factor) in scale.iter().enumerate() {
            all.row_mut(r).scale_mut(*factor);
            all.column_mut(r).unscale_mut(*factor);
        }
        let mut over = all.exp();
        for (r, factor) in scale.iter().enumerate() {
            over.row_mut(r).unscale_mut(*factor);
            over.column_mut(r).scale_mut(*factor);
        }
        let constant = over.view((0, n), (n, i)).into_owned();
        let to = over.view((0, n + i), (n, i)).into_owned();
        Self { phi: over.view((0, 0), (n, n)).into_owned(), from: &constant - &to, constant, to }
    }
}
