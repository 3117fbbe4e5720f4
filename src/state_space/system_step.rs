//! The exact step of a linear system whose modes are coupled.

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

impl SystemStep {
    /// The step of a system over a time, s.
    ///
    /// # Accuracy
    /// Some 1e-14 of the largest entry of each block in states that are scaled alike.
    ///
    /// # Panics
    /// If an entry or the step is not finite.
    pub fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, step: f64) -> Self {
        let (n, i) = (a.nrows(), b.ncols());
        let mut all = DMatrix::zeros(n + 2 * i, n + 2 * i);
        all.view_mut((0, 0), (n, n)).copy_from(&(a * step));
        all.view_mut((0, n), (n, i)).copy_from(&(b * step));
        all.view_mut((n, n + i), (i, i)).fill_with_identity();
        assert!(all.iter().all(|x| x.is_finite()), "a system of finite numbers");
        let over = all.exp();
        let constant = over.view((0, n), (n, i)).into_owned();
        let to = over.view((0, n + i), (n, i)).into_owned();
        Self { phi: over.view((0, 0), (n, n)).into_owned(), from: &constant - &to, constant, to }
    }
}
