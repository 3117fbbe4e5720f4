//! Linear algebra: sparse factor, block Lanczos, shift-invert modes, dense symmetric eigenproblem.
//!
//! The only folder that names faer and METIS. Dense matrices in its interfaces are nalgebra's
//! `DMatrix`, column-major; sparse symmetric matrices are [`SparseSymmetric`].

mod cholesky;
mod complex;
mod dense;
mod graded;
mod lanczos;
mod ordering;
mod shift_invert;
mod sparse;

pub use cholesky::{Cholesky, Indefinite, factor_entries};
pub use complex::{ComplexEigen, complex_eigen};
pub use dense::{
    SymmetricEigen, count_negative, independent_directions, multiply, multiply_transposed, orthonormal,
    orthonormal_span, symmetric_eigen, symmetric_eigen_fast, triangle,
};
pub use graded::{
    GradedFactor, eigen_of_flexibility, flexibility_with_springs, graded_factor, independent_rows, lower_rows,
};
pub use lanczos::{LanczosOptions, Spectrum, lowest_modes};
pub use ordering::Ordering;
pub use shift_invert::{FreeSpectrum, shift_invert_modes};
pub use sparse::{SparseBuilder, SparseSymmetric};

use crate::interrupt::Interrupt;

/// Ends a computation between two steps where the user has asked to stop.
///
/// # Errors
/// [`LinalgError::Interrupted`].
pub fn go_on(interrupt: Option<&Interrupt>) -> Result<(), LinalgError> {
    if interrupt.is_some_and(Interrupt::requested) { Err(LinalgError::Interrupted) } else { Ok(()) }
}

/// What a linear-algebra routine could not do.
#[derive(Debug, thiserror::Error)]
pub enum LinalgError {
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// A matrix that should be positive definite is not.
    #[error("the matrix is not positive definite: the pivot of unknown {unknown} of {n} is not positive")]
    NotPositiveDefinite {
        /// Row of the matrix.
        unknown: usize,
        /// Order of the matrix.
        n: usize,
    },
    /// The factor does not fit into memory, or the pattern is not one.
    #[error("sparse factorisation of order {n} failed: {reason}")]
    Factorisation {
        /// Order of the matrix.
        n: usize,
        /// What the library said.
        reason: String,
    },
    /// METIS refused the graph.
    #[error("METIS could not order a graph of {nodes} nodes (status {status})")]
    Ordering {
        /// Nodes of the graph.
        nodes: usize,
        /// METIS's return value; 1 is success.
        status: i32,
    },
    /// The dense eigenvalue iteration did not converge, or its input is not finite.
    #[error("the dense eigenproblem of order {n} did not converge")]
    Eigen {
        /// Order of the matrix.
        n: usize,
    },
    /// Block Lanczos used up its steps.
    #[error(
        "block Lanczos found {converged} of {wanted} modes in a subspace of {dimension} vectors; \
         the largest residual is {residual:.1e} where {tolerance:.0e} is asked"
    )]
    NotConverged {
        /// Modes asked for.
        wanted: usize,
        /// Modes whose explicit residual is small enough.
        converged: usize,
        /// Vectors in the subspace.
        dimension: usize,
        /// Largest relative residual among the modes asked for.
        residual: f64,
        /// Residual asked for.
        tolerance: f64,
    },
    /// The inertia count and the modes found disagree.
    #[error("{found} modes were found below {frequency_hz:.3} Hz, but the inertia of K - omega^2 M counts {counted}")]
    ModesMissed {
        /// Modes found below the shift.
        found: usize,
        /// Modes counted below the shift.
        counted: usize,
        /// The shift, Hz.
        frequency_hz: f64,
    },
}
