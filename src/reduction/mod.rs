//! Component mode synthesis: a part of many thousand unknowns becomes a superelement of some hundred.
//!
//! Both methods span a subspace of the part's displacements and carry out Rayleigh-Ritz in it, so
//! that the superelement has M = I and K = diag(lambda):
//!
//! - Craig-Bampton: constraint modes (unit motions of the interfaces, inside in static equilibrium)
//!   and modes with fixed interfaces;
//! - free interface: rigid modes, free modes and attachment modes (responses to unit forces on the
//!   interfaces, in inertia relief where the part is free).
//!
//! Either is completed by second-moment vectors (the response to the inertia of the static ones),
//! which bring the error of the coupled frequencies from 1e-4 to 1e-7 at the same number of modes.
//! What differs from the textbooks: a rail is not one interface but a continuum of footprints; the
//! basis contains the responses to footprints at training positions and is kept at the rail's nodes.
//!
//! Sources: R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968); R. H. MacNeal, Comput. Struct. 1 (1971);
//! S. Rubin, AIAA J. 13 (1975); for second moments Z. Bai, Appl. Numer. Math. 43 (2002).

mod basis;
mod beyond;
mod cache;
mod component_modes;
mod constraint;
mod craig_bampton;
mod flexibility;
mod free_interface;
mod memory;
mod skin;
mod superelement;

pub use beyond::Beyond;
pub use cache::{Cache, CacheError, Cached};
pub use memory::{REDUCTION_ADVICE, admit_assemblies, admit_assembly, admit_modes, foreseen};
pub use skin::{MOST_SKIN_NODES, ReducedSkin, Skin, skin};
pub use superelement::{
    LEAST_SHARE, RailSpring, RailTraining, ReducedInterface, ReducedRail, ReductionRequest, Superelement, reduce,
};

use crate::linalg::LinalgError;
use crate::solid::SolidError;

/// Why a part could not be reduced.
#[derive(Debug, thiserror::Error)]
pub enum ReductionError {
    /// The part could not be assembled.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// There is not enough memory for it.
    #[error(transparent)]
    Memory(#[from] crate::resources::NoMemory),
    /// A solver failed.
    #[error("part \"{part}\": {source}")]
    Linalg {
        /// Part.
        part: String,
        /// What failed.
        source: LinalgError,
    },
    /// The interfaces of a free part do not hold it.
    #[error(
        "part \"{part}\": its interfaces leave {free} of its rigid motions free, so it has no constraint modes; use the free-interface method or add an interface"
    )]
    NotHeld {
        /// Part.
        part: String,
        /// Rigid motions left.
        free: usize,
    },
    /// A reduced stiffness came out indefinite.
    #[error(
        "part \"{part}\": the reduced stiffness has the eigenvalue {eigenvalue:.3e} (rad/s)^2, which should be positive; the mesh is broken or the part is not held together"
    )]
    Indefinite {
        /// Part.
        part: String,
        /// The eigenvalue.
        eigenvalue: f64,
    },
}
