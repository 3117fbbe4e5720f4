//! A part as a second-order system: element matrices assembled into sparse stiffness and mass, and
//! the rigid motions of its interfaces as rows over the nodes.

mod assembly;
mod interface;
mod numbering;
mod surface;

pub use assembly::{SecondOrder, assemble};
pub use interface::{InterfaceMotion, NodeRows, rotation_arm};
pub use numbering::{interface_motions, rigid_nodes};
pub use surface::{Face, Surface};

/// Why a part could not be assembled.
#[derive(Debug, thiserror::Error)]
pub enum SolidError {
    /// An element's Jacobian determinant is not positive.
    #[error(
        "part \"{part}\": element {element} is inverted or folded (Jacobian determinant {determinant:.3e} m^3); remesh it, or check the order of its nodes"
    )]
    InvertedElement {
        /// Part.
        part: String,
        /// Label in the mesh file.
        element: u64,
        /// Smallest determinant at its quadrature points, m^3.
        determinant: f64,
    },
    /// An element has no material.
    #[error(
        "part \"{part}\": element {element} has no material; give the mesh file a *SOLID SECTION that covers it, or the part a `material`"
    )]
    NoMaterial {
        /// Part.
        part: String,
        /// Label in the mesh file.
        element: u64,
    },
    /// A node set that the machine file names does not exist.
    #[error("part \"{part}\", {user}: no node set \"{set}\" in {mesh}; it has {known}")]
    UnknownSet {
        /// Part.
        part: String,
        /// What names the set.
        user: String,
        /// The name.
        set: String,
        /// Mesh file.
        mesh: String,
        /// The sets there are.
        known: String,
    },
    /// A node set does not cover a single element face, or its region leaves nothing of it.
    #[error("part \"{part}\", interface \"{interface}\": {reason}")]
    NoSurface {
        /// Part.
        part: String,
        /// Interface.
        interface: String,
        /// What was found and what to do.
        reason: String,
    },
    /// The mesh falls into pieces.
    #[error(
        "part \"{part}\": the mesh falls into {pieces} pieces that share no node; a part is one body (element {element} is not connected to the first)"
    )]
    Pieces {
        /// Part.
        part: String,
        /// Number of pieces.
        pieces: usize,
        /// Label of an element outside the first piece.
        element: u64,
    },
    /// The clamped nodes leave the part free to turn.
    #[error("part \"{part}\": its clamped nodes lie on one line, so it can still turn; clamp a surface")]
    ClampOnLine {
        /// Part.
        part: String,
    },
    /// Two rigid interfaces claim one node, or a clamp does.
    #[error(
        "part \"{part}\", rigid interface \"{interface}\": node {node} also belongs to {other}; a node follows one rigid surface only"
    )]
    RigidOverlap {
        /// Part.
        part: String,
        /// Interface.
        interface: String,
        /// Label in the mesh file.
        node: u64,
        /// What else holds the node.
        other: String,
    },
}
