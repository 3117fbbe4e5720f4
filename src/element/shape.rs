//! Shape functions of every kind, and their physical gradients.

use super::{brick, tet, wedge};
use crate::mesh::CellKind;

/// Nodes of the largest element.
pub const MAX_NODES: usize = 20;

/// Shape functions and their derivatives at one point; entries past the element's nodes are zero.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Value of each shape function.
    pub values: [f64; MAX_NODES],
    /// Its derivatives by r, s, t.
    pub derivatives: [[f64; 3]; MAX_NODES],
}

impl Shape {
    pub(super) fn zero() -> Self {
        Self { values: [0.0; MAX_NODES], derivatives: [[0.0; 3]; MAX_NODES] }
    }
}

/// Shape functions of an element at (r, s, t) of its reference domain.
///
/// Tetrahedra: barycentric coordinates 1 - r - s - t, r, s, t. Bricks: r, s, t from -1 to 1. Wedges:
/// barycentric coordinates 1 - r - s, r, s, and t from -1 to 1.
///
/// # Source
/// Zienkiewicz and Taylor, The Finite Element Method, vol. 1, ch. 4 (serendipity family for 15 and 20 nodes).
pub fn shape(kind: CellKind, at: [f64; 3]) -> Shape {
    match kind {
        CellKind::Tet4 => tet::shape_4(at),
        CellKind::Tet10 => tet::shape_10(at),
        CellKind::Hex8 | CellKind::Hex8Incompatible => brick::shape_8(at),
        CellKind::Hex20 | CellKind::Hex20Reduced => brick::shape_20(at),
        CellKind::Wedge6 => wedge::shape_6(at),
        CellKind::Wedge15 => wedge::shape_15(at),
    }
}

/// Places of the nodes in the reference domain.
pub fn reference_nodes(kind: CellKind) -> Vec<[f64; 3]> {
    let corners: Vec<[f64; 3]> = match kind.corner_count() {
        4 => tet::CORNERS.to_vec(),
        6 => wedge::CORNERS.to_vec(),
        _ => brick::CORNERS.to_vec(),
    };
    let sides: &[[usize; 2]] = match kind {
        CellKind::Tet10 => &tet::SIDES,
        CellKind::Hex20 | CellKind::Hex20Reduced => &brick::SIDES,
        CellKind::Wedge15 => &wedge::SIDES,
        _ => &[],
    };
    let middle = |&[a, b]: &[usize; 2]| std::array::from_fn(|c| 0.5 * (corners[a][c] + corners[b][c]));
    corners.iter().copied().chain(sides.iter().map(middle)).collect()
}

/// The Jacobian's inverse, d r_a / d x_c at `[a][c]`, and its determinant.
pub(super) fn inverse_jacobian(nodes: &[[f64; 3]], derivatives: &[[f64; 3]]) -> ([[f64; 3]; 3], f64) {
    let mut j = [[0.0; 3]; 3]; // j[a][c] = d x_c / d r_a
    for (x, d) in nodes.iter().zip(derivatives) {
        for a in 0..3 {
            for c in 0..3 {
                j[a][c] += d[a] * x[c];
            }
        }
    }
    let cofactor = |a: usize, c: usize| {
        let (a1, a2, c1, c2) = ((a + 1) % 3, (a + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        j[a1][c1] * j[a2][c2] - j[a1][c2] * j[a2][c1]
    };
    let det = (0..3).map(|c| j[0][c] * cofactor(0, c)).sum::<f64>();
    (std::array::from_fn(|a| std::array::from_fn(|c| cofactor(a, c) / det)), det)
}

/// Gradients of the shape functions in physical coordinates (1/m), and det J (m^3).
///
/// The gradients are meaningless where the determinant is not positive; callers look at it first.
pub fn gradients(kind: CellKind, nodes: &[[f64; 3]], at: [f64; 3]) -> ([[f64; 3]; MAX_NODES], f64) {
    assert_eq!(nodes.len(), kind.node_count(), "nodes of a {}", kind.name());
    physical(nodes, &shape(kind, at))
}

/// The same where the shape functions are known.
pub(super) fn physical(nodes: &[[f64; 3]], shape: &Shape) -> ([[f64; 3]; MAX_NODES], f64) {
    let (inverse, det) = inverse_jacobian(nodes, &shape.derivatives);
    let mut gradient = [[0.0; 3]; MAX_NODES];
    for (g, d) in gradient.iter_mut().zip(&shape.derivatives).take(nodes.len()) {
        *g = std::array::from_fn(|c| d[0] * inverse[0][c] + d[1] * inverse[1][c] + d[2] * inverse[2][c]);
    }
    (gradient, det)
}
