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
    /// `*SURFACE, TYPE=NODE`.
    pub node_surfaces: Vec<RawSet>,
    pub element_sets: Vec<RawSet>,
    pub materials: Vec<RawMaterial>,
    pub sections: Vec<RawSection>,
    pub surfaces: Vec<RawSurface>,
    /// Names of surfaces that are passed over, and why.
    pub passed_over: Vec<(String, String)>,
    pub boundaries: Vec<RawBoundary>,
    /// Whether the first step has let go what was held before it.
    pub let_go: bool,
    /// The frequency step of a deck.
    pub frequency: Option<FrequencyStep>,
    pub warnings: Vec<Warning>,
    /// Whether bricks with too many nodes have been warned of.
    pub surplus_said: bool,
}

pub struct RawNode {
    pub label: u64,
    pub at: [f64; 3],
    pub line: u32,
}

/// An element: a solid, or something that only sets are made of.
pub struct RawCell {
    pub kind: RawKind,
    pub label: u64,
    pub line: u32,
}

/// What an element is.
#[derive(Clone, Copy)]
pub enum RawKind {
    Solid(CellKind),
    /// A two-dimensional element without a section, which marks a face of a solid: its name and nodes.
    Face(&'static str, usize),
    /// A line element without a section, which only sets are made of: its name and nodes.
    Line(&'static str, usize),
}

impl RawKind {
    pub fn node_count(self) -> usize {
        match self {
            RawKind::Solid(kind) => kind.node_count(),
            RawKind::Face(_, nodes) | RawKind::Line(_, nodes) => nodes,
        }
    }

    /// Name in Abaqus and CalculiX.
    pub fn name(self) -> &'static str {
        match self {
            RawKind::Solid(kind) => kind.name(),
            RawKind::Face(name, _) | RawKind::Line(name, _) => name,
        }
    }

    /// Corners of a two-dimensional element, which are its first nodes.
    pub fn face_corners(self) -> Option<usize> {
        match self {
            RawKind::Face(_, 3 | 6) => Some(3),
            RawKind::Face(..) => Some(4),
            _ => None,
        }
    }
}

/// A piece of a surface: a face of an element or of every element of a set.
pub struct RawSurface {
    pub name: String,
    pub of: Target,
    /// Counted from 0.
    pub face: usize,
    pub line: usize,
}

/// One label or one set.
pub enum Target {
    Label(u64),
    Set(String),
}

/// Displacements held.
pub struct RawBoundary {
    pub of: Target,
    pub directions: [bool; 3],
    pub line: usize,
}

/// A piece of a set; pieces of the same name make one set. Names keep their quotes.
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
    /// The nodes of an element set.
    OfElements { name: String, line: usize },
}

impl Members {
    /// Where they stand.
    pub fn line(&self) -> usize {
        match self {
            Members::Section { line, .. }
            | Members::Range { line, .. }
            | Members::Set { line, .. }
            | Members::OfElements { line, .. } => *line,
            Members::Labels(list) => list.last().map_or(0, |(_, line)| *line as usize),
        }
    }
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

/// What a deck's frequency step asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyStep {
    /// Modes wanted.
    pub modes: usize,
    /// Lowest frequency wanted, cycles a time unit.
    pub from: f64,
    /// Highest frequency wanted.
    pub to: f64,
}
