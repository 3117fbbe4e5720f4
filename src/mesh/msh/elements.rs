//! Gmsh's element types, and the order of their nodes.

use crate::mesh::CellKind;

/// A supported element type.
pub enum Kind {
    /// A solid: Abaqus's node k is Gmsh's node `order[k]`.
    Solid(CellKind, &'static [usize]),
    /// A triangle or quadrilateral of so many nodes, which marks a face of a solid.
    Face(usize),
    /// A point of so many nodes, which only sets are made of.
    Point(usize),
    /// A line of so many nodes, which only sets are made of.
    Line(usize),
}

impl Kind {
    /// Nodes of the element.
    pub fn node_count(&self) -> usize {
        match self {
            Kind::Solid(kind, _) => kind.node_count(),
            Kind::Face(count) | Kind::Point(count) | Kind::Line(count) => *count,
        }
    }

    /// Dimension of the element, which is that of its physical groups.
    pub fn dimension(&self) -> u8 {
        match self {
            Kind::Solid(..) => 3,
            Kind::Face(_) => 2,
            Kind::Line(_) => 1,
            Kind::Point(_) => 0,
        }
    }

    /// Corners of a triangle or quadrilateral, which are its first nodes.
    pub fn face_corners(&self) -> Option<usize> {
        match self {
            Kind::Face(3 | 6) => Some(3),
            Kind::Face(_) => Some(4),
            _ => None,
        }
    }
}

const FIRST: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
const TET_10: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
const HEX_20: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15];
const WEDGE_15: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11];

/// The type of a number, or what to do about one that is not supported.
pub fn find(number: u64) -> Result<Kind, &'static str> {
    Ok(match number {
        4 => Kind::Solid(CellKind::Tet4, &FIRST[..4]),
        5 => Kind::Solid(CellKind::Hex8, &FIRST),
        6 => Kind::Solid(CellKind::Wedge6, &FIRST[..6]),
        11 => Kind::Solid(CellKind::Tet10, &TET_10),
        17 => Kind::Solid(CellKind::Hex20, &HEX_20),
        18 => Kind::Solid(CellKind::Wedge15, &WEDGE_15),
        15 => Kind::Point(1),
        1 => Kind::Line(2),
        8 => Kind::Line(3),
        26 => Kind::Line(4),
        2 => Kind::Face(3),
        3 => Kind::Face(4),
        9 => Kind::Face(6),
        16 => Kind::Face(8),
        10 => Kind::Face(9),
        7 | 14 | 19 => {
            return Err("tetrahedra, bricks and wedges; this is a pyramid, mesh without transitions to bricks");
        }
        12 | 13 => {
            return Err("bricks of 8 or 20 nodes and wedges of 6 or 15; set Mesh.SecondOrderIncomplete = 1");
        }
        _ => return Err("elements of first or second order; set Mesh.ElementOrder to 1 or 2"),
    })
}
