//! Superelements coupled by joints: the only place where position and joint stiffness enter.
//!
//! Side by side the superelements have K = diag(lambda), M = I. A spring of stiffness k between two
//! sides adds k b b^T, where b(p) reads the relative motion of the sides at the joint's point:
//!
//! ```text
//! K(p) = Lambda + B(p)^T diag(k(p)) B(p)
//! ```
//!
//! On a rail b(p) is formed from the area weights of the footprint under the carriage, so it is
//! continuous and exact at every p. A fixed basis for all positions and all joint stiffnesses brings
//! the side-by-side coordinates (some 800) to some 200: the component modes of the band's
//! neighbourhood, the inertia of the joints' static responses over the whole travel, and, in series
//! with the joints, the static flexibility of all the rest, exact at every position.

mod around;
mod assembled;
mod basis;
mod eigen;
mod fixed_position;
mod joint;
mod mechanism;
mod model;
mod series;
mod side_by_side;
mod training;
mod unreduced;

pub use around::{Around, AroundCoupled, AroundOptions};
pub use assembled::{Assembled, AssembledRow, assembled, assembled_bytes};
pub use basis::{BasisOptions, ResidualEnergy};
pub use eigen::CoupledEigen;
pub use fixed_position::at_fixed_position;
pub use joint::{CoupledJoint, CoupledSpring};
pub(crate) use joint::{check_screw, free_length, overhang};
pub use mechanism::{null_space, separated};
pub use model::{AtPosition, Coupled, CoupledModel, PartShare, SpringValues, couple};
pub use side_by_side::{PortRow, SideBySide};
pub use training::reduction_requests;
pub use unreduced::{PlacedInterface, PlacedSpring, Unreduced, unreduced};

use crate::linalg::LinalgError;

/// Why the machine could not be coupled.
#[derive(Debug, thiserror::Error)]
pub enum CouplingError {
    /// A carriage's footprint leaves its rail.
    #[error(
        "joint \"{joint}\": at position {position} m the footprint from {from:.4} to {to:.4} m leaves the rail, which \
         spans {rail_from:.4} to {rail_to:.4} m along the travel; shorten the travel or the footprint"
    )]
    FootprintLeavesRail {
        /// Joint.
        joint: String,
        /// Position, m.
        position: f64,
        /// Start of the footprint along the travel, m.
        from: f64,
        /// End of the footprint, m.
        to: f64,
        /// Start of the rail, m.
        rail_from: f64,
        /// End of the rail, m.
        rail_to: f64,
    },
    /// A ball screw's free length is not positive.
    #[error(
        "joint \"{joint}\": at position {position} m the free length of the screw is {length:.4} m; mount and nut must not meet within the travel"
    )]
    ScrewLength {
        /// Joint.
        joint: String,
        /// Position, m.
        position: f64,
        /// Length, m.
        length: f64,
    },
    /// A ball screw's nut is beyond its second support.
    #[error(
        "joint \"{joint}\": at position {position} m the free length of the screw is {length:.4} m, and its supports are {span:.4} m apart; make `span` longer than the free length within the travel"
    )]
    ScrewSpan {
        /// Joint.
        joint: String,
        /// Position, m.
        position: f64,
        /// Length from mount to nut, m.
        length: f64,
        /// Distance between the supports, m.
        span: f64,
    },
    /// A rail on a part without surfaces.
    #[error(
        "joint \"{joint}\": the rail \"{rail}\" is a node set without faces, so no footprint can travel on it; give the part's `mesh` beside its matrices"
    )]
    RailWithoutSurface {
        /// Joint.
        joint: String,
        /// Interface.
        rail: String,
    },
    /// A joint turns an interface that is a single node without rotations.
    #[error(
        "joint \"{joint}\": the interface \"{interface}\" is one node without rotations, {arm:.3e} m from the joint's point at position {position} m, or under a rotational spring; use a set of nodes, or put the joint's `at` on the node"
    )]
    NoRotation {
        /// Joint.
        joint: String,
        /// Interface.
        interface: String,
        /// Distance of the node from the joint's point, m.
        arm: f64,
        /// Position, m.
        position: f64,
    },
    /// A guide along no global axis cannot be cut to its footprint.
    #[error("joint \"{joint}\": the travel is along none of the axes x, y, z, so its footprint cannot be made rigid")]
    TravelAcross {
        /// Joint.
        joint: String,
    },
    /// A position outside the travel.
    #[error("position {position} m lies outside the travel of axis \"{axis}\", {from} to {to} m")]
    OutsideTravel {
        /// Position, m.
        position: f64,
        /// Axis.
        axis: String,
        /// One end, m.
        from: f64,
        /// The other end, m.
        to: f64,
    },
    /// The fixed basis could not be formed.
    #[error("the machine's fixed basis: {0}")]
    Basis(#[from] LinalgError),
}
