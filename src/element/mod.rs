//! Shape functions, quadrature and matrices of the solid elements and their faces.
//!
//! An element answers the same questions at a point of its reference domain, whatever its kind:
//! [`shape`] gives its shape functions with their derivatives, [`gradients`] the physical gradients and
//! the Jacobian's determinant, [`matrices`] its stiffness and mass. Node orders, face orders and
//! stiffness rules are those of Abaqus and CalculiX; `docs/elements.md` lists formulation, rules and
//! accuracy of each.
//!
//! One file a family: `tet`, `brick`, `wedge`; `incompatible` holds the modes of C3D8I, `face` the
//! triangles and quadrilaterals.

mod brick;
pub mod face;
mod incompatible;
mod matrices;
pub mod quadrature;
mod shape;
mod tet;
mod wedge;

pub use incompatible::det_variation;
pub use matrices::{ElementMatrices, matrices};
pub use shape::{MAX_NODES, Shape, gradients, reference_nodes, shape};

use crate::mesh::CellKind;

/// Displacement functions of an element beside those of its nodes, each with three unknowns of the element's own:
/// one for C3D8I, the mean of its incompatible modes.
pub fn own_functions(kind: CellKind) -> usize {
    matrices::own_functions(kind)
}

/// The faces of an element as local node indices, outward (corners first, then midsides in order), in
/// the order S1, S2, .. of Abaqus.
pub fn faces(kind: CellKind) -> &'static [&'static [usize]] {
    match kind {
        CellKind::Tet4 => &tet::FACES_4,
        CellKind::Tet10 => &tet::FACES_10,
        CellKind::Hex8 | CellKind::Hex8Incompatible => &brick::FACES_8,
        CellKind::Hex20 | CellKind::Hex20Reduced => &brick::FACES_20,
        CellKind::Wedge6 => &wedge::FACES_6,
        CellKind::Wedge15 => &wedge::FACES_15,
    }
}
