//! A part as a second-order system: element matrices assembled into sparse stiffness and mass, and
//! the rigid motions of its interfaces as rows over the nodes.

mod assembly;
mod definite;
mod given;
mod held;
mod hourglass;
mod interface;
mod numbering;
mod places;
mod surface;

pub use assembly::{SecondOrder, assemble};
pub use held::held_displacements;
pub use interface::{InterfaceMotion, NodeRows, axis_name, rotation_arm};
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
    /// A name stands for different places of the mesh.
    #[error(
        "part \"{part}\", {user}: the name \"{name}\" stands for different places in {mesh}: {places}; rename all but the one that is meant"
    )]
    TwoPlaces {
        /// Part.
        part: String,
        /// What names the place.
        user: String,
        /// The name.
        name: String,
        /// Mesh file.
        mesh: String,
        /// What stands under the name.
        places: String,
    },
    /// A two-dimensional element that marks no face.
    #[error(
        "part \"{part}\", {user}: element {element} of \"{name}\" is no face of a solid element; allowed: triangles and quadrilaterals whose corners are those of a face; mesh surface and body together, or take the element out of \"{name}\""
    )]
    NoFace {
        /// Part.
        part: String,
        /// What names the place.
        user: String,
        /// The name.
        name: String,
        /// Label of the element.
        element: u64,
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
    /// Reduced elements that stand in a single row.
    #[error(
        "part \"{part}\": in {count} elements of type C3D20R (element {element} first) midside nodes can move without any stiffness: reduced integration does not see such hourglass motions, and in a single row of elements no neighbour restrains them; write the elements as C3D20, or mesh at least two of them side by side"
    )]
    Hourglass {
        /// Part.
        part: String,
        /// Number of such elements.
        count: usize,
        /// Label of the first.
        element: u64,
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
    /// A node set that holds displacements names no node of the mesh.
    #[error(
        "part \"{part}\": the set \"{set}\" under `supported` holds no node of an element; correct the name or remove it"
    )]
    EmptySupport {
        /// Part.
        part: String,
        /// Set.
        set: String,
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
    /// Given matrices fall into pieces.
    #[error(
        "part \"{part}\": its matrices fall into {pieces} pieces that share no entry; a part is one body ({place} is not connected to the first)"
    )]
    MatrixPieces {
        /// Part.
        part: String,
        /// Number of pieces.
        pieces: usize,
        /// A row outside the first piece.
        place: String,
    },
    /// A given matrix is not positive semidefinite.
    #[error(
        "part \"{part}\": the {what} matrix is indefinite at {place}: {reason}; allowed: no eigenvalue below -{tolerance:.0e} of the diagonal; check the file, its units and its table of degrees of freedom"
    )]
    NotSemidefinite {
        /// Part.
        part: String,
        /// Stiffness or mass.
        what: &'static str,
        /// Row and its label.
        place: String,
        /// What was found.
        reason: String,
        /// Share of the diagonal that is taken for rounding.
        tolerance: f64,
    },
    /// Given matrices hold the part in some directions only.
    #[error(
        "part \"{part}\": {file} leaves {free} of the six rigid motions free and holds the others; clamp the part, or give matrices of the free part"
    )]
    PartlyFree {
        /// Part.
        part: String,
        /// Stiffness file.
        file: String,
        /// Motions left free.
        free: usize,
    },
    /// Given matrices are neither free nor held.
    #[error(
        "part \"{part}\": in {file} a rigid motion leaves forces of {residual:.1e} of their rows, where a free part leaves less than {free:.0e} and a held one more than {held:.0e}; write more digits, or say free = true or free = false in `matrices`"
    )]
    DoubtfullyFree {
        /// Part.
        part: String,
        /// Stiffness file.
        file: String,
        /// Largest relative force.
        residual: f64,
        /// Largest of a free part.
        free: f64,
        /// Smallest of a held part.
        held: f64,
    },
    /// Given matrices cannot be factored.
    #[error("part \"{part}\": {source}")]
    Ordering {
        /// Part.
        part: String,
        /// What failed.
        source: crate::linalg::LinalgError,
    },
}
