//! Sweeps over designs: joint stiffness, ball screw, damping and the moduli of homogeneous parts.
//!
//! A [`Design`] is a machine that differs from the nominal one in its springs, dampers and loss
//! factors, and in factors on the Young's modulus and density of homogeneous parts. Parts are reduced
//! once and position data are prepared once; an [`Evaluator`] answers designs in batches.

mod bases;
mod coupling_route;
mod design;
mod device;
pub mod goals;
pub mod machine_values;
mod memory;
pub mod metrics;
mod modes_route;
pub mod optimise;
pub mod pareto;
pub mod paths;
mod prepared;
mod random;
pub mod room;
pub mod runner;
pub mod sampling;
mod sensitivity;
pub mod shards;
pub mod sobol;
mod study;
mod study_error;
pub mod table;
mod table_error;
mod variable_reading;
pub mod variables;

pub use coupling_route::CouplingRoute;
pub use design::{Design, PartScale};
pub use device::{BackendUse, SpringBackend};
pub use modes_route::ModesRoute;
pub use prepared::{Kept, Prepared, Request, varied_springs};
pub use sensitivity::Sensitivity;
pub use study::{Study, read_study};
pub use study_error::StudyError;
pub use table_error::TableError;

use crate::frf::metrics::PairMetrics;

/// Metrics of one design at one position.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionMetrics {
    /// Refined extrema of the direct pairs, in the order of [`crate::frf::metrics::direct_pairs_of`].
    pub pairs: Vec<PairMetrics>,
    /// Static compliance H_ii(0) of the direct pairs, m/N; infinite where a free motion is felt.
    pub static_compliance: Vec<f64>,
    /// Eigenfrequency of each family that was asked for, Hz; `None` where tracking lost the family.
    pub families: Vec<Option<f64>>,
}

/// Metrics of one design at every position of the sweep, in the order of [`Evaluator::positions`].
pub type Evaluation = Vec<PositionMetrics>;

/// Answers designs.
pub trait Evaluator {
    /// The route's name, `modes` or `coupling`, for the manifest.
    fn route(&self) -> &'static str;

    /// Positions, m.
    fn positions(&self) -> &[f64];

    /// Designs that are best answered together.
    fn batch(&self) -> usize;

    /// What has computed the designs so far.
    fn backend(&self) -> BackendUse {
        BackendUse::cpu("eigenproblems are solved on the processor")
    }

    /// Metrics of each design, in order, on all threads; a design that cannot be answered has its own error.
    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>>;
}

impl From<crate::gpu::GpuError> for SweepError {
    fn from(error: crate::gpu::GpuError) -> Self {
        Self::Device { message: error.to_string() }
    }
}

/// Why a design or a sweep could not be answered.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The prepared positions do not fit into the memory.
    #[error(transparent)]
    Memory(#[from] crate::resources::NoMemory),
    /// The design cannot be coupled, such as a screw without length.
    #[error(transparent)]
    Coupling(#[from] crate::coupling::CouplingError),
    /// Its modes could not be had.
    #[error(transparent)]
    Modal(#[from] crate::modal::ModalError),
    /// Its responses could not be had.
    #[error(transparent)]
    Frf(#[from] crate::frf::FrfError),
    /// A value is not finite or out of range.
    #[error("{what}: {seen}; allowed: {allowed}")]
    Value {
        /// What.
        what: String,
        /// Value seen.
        seen: f64,
        /// Values allowed.
        allowed: &'static str,
    },
    /// A machine with scaled parts could not be prepared.
    #[error("with scaled parts: {message}")]
    Parts {
        /// Why.
        message: String,
    },
    /// The coupling route has no eigenfrequencies.
    #[error("eigenfrequencies of families need the modes route; leave the families out or write route = \"modes\"")]
    NeedsModes,
    /// The device that was asked for failed.
    #[error("{message}")]
    Device {
        /// Why.
        message: String,
    },
    /// The work was interrupted.
    #[error("interrupted")]
    Interrupted,
}
