//! A part's finite-element mesh: nodes, cells, named sets; one file a format.

use crate::machine::Material;
use std::collections::BTreeMap;

/// A mesh in metres, with its named sets and materials in SI.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Node coordinates, m.
    pub nodes: Vec<[f64; 3]>,
    /// Label of each node in its file, for messages.
    pub node_labels: Vec<u64>,
    /// Cells.
    pub cells: Vec<Cell>,
    /// Node sets: indices into `nodes`, ascending, no duplicates.
    pub node_sets: BTreeMap<String, Vec<usize>>,
    /// Element sets: indices into `cells`, ascending, no duplicates.
    pub element_sets: BTreeMap<String, Vec<usize>>,
    /// Materials of the file.
    pub materials: Vec<Material>,
}

/// One finite element.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Element type.
    pub kind: CellKind,
    /// Label in its file, for messages.
    pub label: u64,
    /// Node indices in the element's own order (Abaqus convention).
    pub nodes: Vec<usize>,
    /// Index into [`Mesh::materials`], if the file gives one.
    pub material: Option<usize>,
}

/// Element types that can be assembled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// Ten-node tetrahedron, C3D10: corners 1-4, then 12 23 31 14 24 34.
    Tet10,
}

impl CellKind {
    /// Nodes of the element.
    pub fn node_count(self) -> usize {
        match self {
            CellKind::Tet10 => 10,
        }
    }
}
