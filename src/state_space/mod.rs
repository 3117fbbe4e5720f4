//! Modal state space at a position (the paper's equations (4) to (11)), continuous or exactly
//! discretised, and databases of them over the travel.

mod assemble;
mod damped_sum;
mod database;
mod discrete;
mod mode_step;
mod system_step;

pub use assemble::{StateSpaceOptions, state_space};
pub use damped_sum::DampedSum;
pub use database::{Aligned, Database, receptance, receptance_difference};
pub use discrete::{Hold, discretise};
pub use mode_step::ModeStep;
pub use system_step::{SystemStep, state_matrix};

use crate::linalg::LinalgError;
use nalgebra::DMatrix;

/// Why a database of state spaces could not be made or read at a position.
#[derive(Debug, thiserror::Error)]
pub enum StateSpaceError {
    /// There is nothing to hold.
    #[error("a database needs at least one position")]
    NoPositions,
    /// The positions do not ascend or descend throughout.
    #[error(
        "position {position} m follows {previous} m; the positions of a database must all ascend or all descend: \
         sort them"
    )]
    Order {
        /// Position, m.
        position: f64,
        /// The one before, m.
        previous: f64,
    },
    /// A position that the database does not cover.
    #[error("position {position} m lies outside the database, which covers {first} to {last} m")]
    Outside {
        /// Position, m.
        position: f64,
        /// First position, m.
        first: f64,
        /// Last position, m.
        last: f64,
    },
    /// The subspaces of two neighbours could not be aligned.
    #[error("the modes at position {position} m could not be aligned with those before it: a shape is not finite")]
    Alignment {
        /// Position, m.
        position: f64,
    },
    /// The interpolated stiffness is not positive.
    #[error(
        "between positions, at {position} m, the interpolated stiffness has the eigenvalue {eigenvalue:.3e} (rad/s)^2; \
         the stations are too far apart: make the axis's step smaller"
    )]
    Negative {
        /// Position, m.
        position: f64,
        /// Eigenvalue, (rad/s)^2.
        eigenvalue: f64,
    },
    /// The interpolated stiffness has no modes.
    #[error("between positions, at {position} m: {source}")]
    Eigen {
        /// Position, m.
        position: f64,
        /// What failed.
        source: LinalgError,
    },
}

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
    /// Damping ratio of each mode, its own term of dampers between modes included.
    pub damping: Vec<f64>,
    /// Rows G of the dampers between the modes, n_damper x n; none where the modes are damped one by one. The lower right
    /// of A is -(diag(2 zeta_r omega_r) + G^T G without its diagonal).
    pub dampers: DMatrix<f64>,
}

impl StateSpace {
    /// Damping ratio of each mode without the dampers between modes.
    pub fn own_damping(&self) -> Vec<f64> {
        own_ratios(&self.eigenvalues, &self.damping, &self.dampers)
    }
}

/// Ratios less the own terms of dampers between the modes.
fn own_ratios(eigenvalues: &[f64], ratios: &[f64], dampers: &DMatrix<f64>) -> Vec<f64> {
    let own = |(r, zeta): (usize, &f64)| {
        let dampers = dampers.column(r).norm_squared();
        if dampers == 0.0 { *zeta } else { (zeta - dampers / (2.0 * eigenvalues[r].sqrt())).max(0.0) }
    };
    ratios.iter().enumerate().map(own).collect()
}
