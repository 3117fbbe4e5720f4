//! What stands in an input file, before labels and names are resolved.

use crate::mesh::{CellKind, Warning};

/// Everything of a file that the mesh is made from.
#[derive(Default)]
pub struct Raw {
    pub nodes: Vec<RawNode>,
    pub cells: Vec<RawCell>,
    /// Node labels of all cells, one after the other.
    pub cell_nodes: Vec<u64>,
    pub node_sets: Vec<RawSet>,
    pub element_sets: Vec<RawSet>,
    pub materials: Vec<RawMaterial>,
    pub sections: Vec<RawSection>,
    pub warnings: Vec<Warning>,
}

pub struct RawNode {
    pub label: u64,
    pub at: [f64; 3],
    pub line: u32,
}

pub struct RawCell {
    pub kind: CellKind,
    pub label: u64,
    pub line: u32,
}

/// A piece of a set; pieces of the same name make one set.
pub struct RawSet {
    pub name: String,
    pub members: Members,
}

pub enum Members {
    /// Nodes or cells by index, from `first` up to but without `end`.
    Section { first: usize, end: usize, line: usize },
    /// Labels with their lines.
    Labels(Vec<(u64, u32)>),
    /// All labels from `first` to `last` by `step`.
    Range { first: u64, last: u64, step: u64, line: usize },
    /// Another set.
    Set { name: String, line: usize },
}

pub struct RawMaterial {
    pub name: String,
    /// Young's modulus and Poisson's ratio, in the file's units.
    pub elastic: Option<(f64, f64)>,
    /// In the file's units.
    pub density: Option<f64>,
}

/// A `*SOLID SECTION`.
pub struct RawSection {
    pub element_set: String,
    pub material: String,
    pub line: usize,
}
