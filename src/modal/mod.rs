//! Modes at a position: found, counted, tracked into families.

mod convergence;
mod dissipation;
mod estimate;
mod free_motion;
mod solve;
mod tracking;

pub use convergence::{ConvergenceError, Extrapolation, extrapolate};
pub(crate) use dissipation::damper_rows;
pub use dissipation::{Dissipation, PartLosses, ViscousDamping};
pub use estimate::{MissingMotion, ReductionEstimate, SAFETY, reduction_estimate};
pub use solve::{FreeMotion, ModeCount, Modes, base_modes, check_count, modes_around, modes_at};
pub use tracking::{Tracker, mode_table, track};

use crate::coupling::CouplingError;
use crate::linalg::LinalgError;

/// Why the modes at a position could not be had.
#[derive(Debug, thiserror::Error)]
pub enum ModalError {
    /// Position or joint is out of range.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// The dense eigensolver failed.
    #[error("at position {position} m: {source}")]
    Eigen {
        /// Position, m.
        position: f64,
        /// What failed.
        source: LinalgError,
    },
    /// A mode that is held and has no positive frequency.
    #[error(
        "at position {position} m: a mode that joints hold has omega^2 = {eigenvalue:.3e} (rad/s)^2, which is not positive; its stiffness is lost in rounding: make the softest joint stiffer, or leave it out"
    )]
    Negative {
        /// Position, m.
        position: f64,
        /// Eigenvalue, (rad/s)^2.
        eigenvalue: f64,
    },
    /// The inertia count differs.
    #[error(
        "at position {position} m: {found} modes were found below {frequency:.3} Hz, but the machine has {counted}"
    )]
    Missed {
        /// Position, m.
        position: f64,
        /// Frequency, Hz.
        frequency: f64,
        /// Modes found.
        found: usize,
        /// Modes counted.
        counted: usize,
    },
}

/// One mode at one position, with the family that tracking gave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedMode {
    /// Family over the positions, 1-based; the families are numbered by rank at the first position.
    pub family: usize,
    /// Rank at this position by frequency, 1-based, free modes at 0 Hz included.
    pub rank: usize,
    /// Natural frequency, Hz.
    pub frequency: f64,
    /// Viscous-equivalent damping ratio (zeta + eta / 2).
    pub damping_ratio: f64,
}

/// The modes of every position, in families.
#[derive(Clone, Debug, Default)]
pub struct ModeFamilies {
    /// Positions, m.
    pub positions: Vec<f64>,
    /// Per position, modes by rank.
    pub modes: Vec<Vec<TrackedMode>>,
    /// Pairs of families that veer, with the position: both labellings are conventions there.
    pub veerings: Vec<Veering>,
}

/// A place where two families exchange their shapes and the labels are a convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veering {
    /// Between this position, m,
    pub from: f64,
    /// and this one, m.
    pub to: f64,
    /// The families.
    pub families: [usize; 2],
    /// The best MAC that either kept.
    pub mac: f64,
}

/// One line of the paper's table 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeTableRow {
    /// Family.
    pub family: usize,
    /// Smallest frequency over the travel, Hz.
    pub min: f64,
    /// Largest frequency over the travel, Hz.
    pub max: f64,
    /// (max - min) / min, percent.
    pub difference_percent: f64,
    /// Position of the smallest, m.
    pub position_of_min: f64,
    /// Position of the largest, m.
    pub position_of_max: f64,
    /// Whether either extremum lies between the ends of the travel.
    pub interior_extremum: bool,
    /// Largest estimate of how much too high the reduction of the parts puts the frequency, relative; `None` for a
    /// free motion, and until it is estimated.
    pub reduction_error: Option<f64>,
}
