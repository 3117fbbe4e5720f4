//! The element types and what the mesh must know of them.

/// One finite element.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Element type.
    pub kind: CellKind,
    /// Label in its file, for messages.
    pub label: u64,
    /// Node indices in the element's own order (Abaqus convention).
    pub nodes: Vec<usize>,
    /// Index into [`super::Mesh::materials`], if the file gives one.
    pub material: Option<usize>,
}

/// Element types that can be assembled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CellKind {
    /// Four-node tetrahedron, C3D4.
    Tet4,
    /// Ten-node tetrahedron, C3D10: corners 1-4, then 12 23 31 14 24 34.
    Tet10,
    /// Eight-node brick, C3D8: the face 1-4, then 5-8 above it.
    Hex8,
    /// Eight-node brick with incompatible modes, C3D8I.
    Hex8Incompatible,
    /// Twenty-node brick, C3D20: corners, then 12 23 34 41, 56 67 78 85, 15 26 37 48.
    Hex20,
    /// Twenty-node brick with reduced integration, C3D20R.
    Hex20Reduced,
    /// Six-node wedge, C3D6: the triangle 1-3, then 4-6 above it.
    Wedge6,
    /// Fifteen-node wedge, C3D15: corners, then 12 23 31, 45 56 64, 14 25 36.
    Wedge15,
}

impl CellKind {
    /// Every kind.
    pub const ALL: [Self; 8] = [
        Self::Tet4,
        Self::Tet10,
        Self::Hex8,
        Self::Hex8Incompatible,
        Self::Hex20,
        Self::Hex20Reduced,
        Self::Wedge6,
        Self::Wedge15,
    ];

    /// Nodes of the element.
    pub fn node_count(self) -> usize {
        match self {
            Self::Tet4 => 4,
            Self::Wedge6 => 6,
            Self::Hex8 | Self::Hex8Incompatible => 8,
            Self::Tet10 => 10,
            Self::Wedge15 => 15,
            Self::Hex20 | Self::Hex20Reduced => 20,
        }
    }

    /// Corners, which are the first nodes.
    pub fn corner_count(self) -> usize {
        match self {
            Self::Tet4 | Self::Tet10 => 4,
            Self::Wedge6 | Self::Wedge15 => 6,
            Self::Hex8 | Self::Hex8Incompatible | Self::Hex20 | Self::Hex20Reduced => 8,
        }
    }

    /// Faces.
    pub fn face_count(self) -> usize {
        match self.corner_count() {
            4 => 4,
            6 => 5,
            _ => 6,
        }
    }

    /// Name in Abaqus and CalculiX.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "C3D4",
            Self::Tet10 => "C3D10",
            Self::Hex8 => "C3D8",
            Self::Hex8Incompatible => "C3D8I",
            Self::Hex20 => "C3D20",
            Self::Hex20Reduced => "C3D20R",
            Self::Wedge6 => "C3D6",
            Self::Wedge15 => "C3D15",
        }
    }
}

/// A face of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellFace {
    /// Index into [`super::Mesh::cells`].
    pub cell: usize,
    /// Face, counted from 0 in the order of Abaqus (S1 is 0).
    pub face: usize,
}
