//! Modal state space at a position (the paper's equations (4) to (11)).

mod assemble;

pub use assemble::{StateSpaceOptions, state_space};

use nalgebra::DMatrix;

/// A modal state-space system x' = A x + B u, y = C x + D u at one position.
#[derive(Clone, Debug)]
pub struct StateSpace {
    /// Position, m.
    pub position: f64,
    /// 2n x 2n.
    pub a: DMatrix<f64>,
    /// 2n x n_input.
    pub b: DMatrix<f64>,
    /// n_row x 2n; n_row = n_output, or 2 or 3 times that with velocity and acceleration rows.
    pub c: DMatrix<f64>,
    /// n_row x n_input.
    pub d: DMatrix<f64>,
    /// omega_r^2, (rad/s)^2.
    pub eigenvalues: Vec<f64>,
    /// Shapes at the outputs, n x n_output, kg^(-1/2).
    pub eigenvectors: DMatrix<f64>,
    /// Damping ratio of each mode.
    pub damping: Vec<f64>,
}
