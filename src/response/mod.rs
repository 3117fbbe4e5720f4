//! Time histories: forces in, motions out.
//!
//! | case | how | exact |
//! |---|---|---|
//! | fixed position | two-by-two recursions a mode ([`simulate`]) | for forces that are straight between samples |
//! | along a path | K(p(t)) about the modes of stations ([`moving`]) | second order in the step; frozen it is the row above |
//! | friction, backlash | forces fed back between the joints' reduced coordinates ([`contact`]) | Coulomb's law without regularisation |
//!
//! Forces are sampled ([`Forces`]) so that straight lines between the samples keep their momentum (`sampling.rs`).
//! [`spectrum`] divides the response's spectrum by that of such a force, so that the map comes out again by way of time.
//! Formulas, sources and accuracy: `docs/time_response.md`.

pub mod contact;
mod coupled;
mod csv;
mod cutter;
mod force;
mod force_check;
mod force_text;
mod frozen;
mod kernel;
mod milling;
pub mod moving;
mod noise;
mod path;
mod sampling;
mod share;
pub mod spectrum;

pub use csv::{ForceFile, read_force_file, read_path_file};
pub use cutter::CutterPort;
pub use force::{Forces, Pulse, PulseShape, Shape};
pub use force_check::mirrored_share;
pub use force_text::{parse_force, parse_milling};
pub use frozen::{History, Plant, Recording, simulate, simulate_all};
pub use milling::Milling;
pub use path::Path;
pub use share::acceleration_share_above;

use crate::coupling::CouplingError;
use crate::modal::ModalError;

/// Why there is no time history.
#[derive(Debug, thiserror::Error)]
pub enum ResponseError {
    /// A setting on the command line or of a caller is not allowed.
    #[error("{what}: found {seen}; allowed: {allowed}")]
    NotAllowed {
        /// Which setting.
        what: String,
        /// The value seen.
        seen: String,
        /// What is allowed, and what to do.
        allowed: String,
    },
    /// A CSV file of forces or positions cannot be used.
    #[error("{file}{}: {problem}", line.map_or_else(String::new, |l| format!(":{l}")))]
    File {
        /// The file.
        file: String,
        /// Line, counted from 1.
        line: Option<usize>,
        /// What is wrong and what is allowed.
        problem: String,
    },
    /// The force has no spectrum to divide by, or does not end.
    #[error("no spectrum: {0}")]
    Spectrum(String),
    /// A friction or backlash law has no well-posed step.
    #[error(
        "joint \"{joint}\": {problem} at a step of {step:e} s; raise the sampling rate with --rate or keep fewer modes"
    )]
    Contact {
        /// Joint.
        joint: String,
        /// What is wrong.
        problem: String,
        /// Step, s.
        step: f64,
    },
    /// A position or joint is out of range.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// The modes of a position could not be had.
    #[error(transparent)]
    Modal(#[from] ModalError),
    /// The step along a path has no solution.
    #[error(
        "along the path, at {position} m: the step of {step:e} s has no solution; the stiffness there is not positive"
    )]
    Step {
        /// Position, m.
        position: f64,
        /// Step, s.
        step: f64,
    },
    /// The user asked to stop.
    #[error("interrupted; nothing half-written is left")]
    Interrupted,
}

impl ResponseError {
    /// Whether the input is to blame (exit code 2) and not the computation.
    pub fn is_input(&self) -> bool {
        match self {
            Self::NotAllowed { .. } | Self::File { .. } | Self::Spectrum(_) => true,
            Self::Coupling(error) | Self::Modal(ModalError::Coupling(error)) => {
                !matches!(error, CouplingError::Basis(_))
            }
            _ => false,
        }
    }

    pub(crate) fn not_allowed(
        what: impl Into<String>,
        seen: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> Self {
        Self::NotAllowed { what: what.into(), seen: seen.to_string(), allowed: allowed.into() }
    }
}
