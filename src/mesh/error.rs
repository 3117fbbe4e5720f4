//! What is wrong with a mesh file.

use std::fmt;
use std::path::PathBuf;

/// A line of a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spot {
    /// The mesh file.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: usize,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)
    }
}

/// Why a mesh file is refused.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// A file was edited between two readings.
    #[error(transparent)]
    Inputs(#[from] crate::files::InputError),
    /// A part's matrices are not usable.
    #[error(transparent)]
    Matrix(#[from] crate::matrix::MatrixError),
    /// There is not enough memory for the text.
    #[error(transparent)]
    Memory(#[from] crate::resources::NoMemory),
    /// The file is missing or may not be read.
    #[error("{}: cannot read the mesh file: {source}; correct the name or the permissions", file.display())]
    Unreadable {
        /// The mesh file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No reader for this extension.
    #[error("{}: unknown mesh format {extension:?}; allowed: \"inp\" (Abaqus, CalculiX), \"msh\" (Gmsh); export the mesh in that format", file.display())]
    UnknownFormat {
        /// The mesh file.
        file: PathBuf,
        /// Its extension in lower case.
        extension: String,
    },
    /// Bytes that are no text.
    #[error("{spot}: found bytes that are not text; allowed: UTF-8; save the file as text in UTF-8")]
    NotText {
        /// Where.
        spot: Spot,
    },
    /// A keyword that would change the result and is not supported.
    #[error("{spot}: the keyword *{keyword} is not supported and would change the result; {advice}")]
    Keyword {
        /// Where.
        spot: Spot,
        /// The keyword as the file writes it.
        keyword: String,
        /// What to do.
        advice: &'static str,
    },
    /// A parameter of a keyword that is missing, unknown, or of a value that is not supported.
    #[error("{spot}: *{keyword}: {seen}; allowed: {allowed}; {advice}")]
    Parameter {
        /// Where.
        spot: Spot,
        /// The keyword.
        keyword: &'static str,
        /// What was seen.
        seen: String,
        /// What is allowed.
        allowed: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// A value on a data line that cannot be read or is not allowed.
    #[error("{spot}: *{keyword}: found {seen:?}; allowed: {allowed}; correct the line")]
    Value {
        /// Where.
        spot: Spot,
        /// The keyword of the section.
        keyword: &'static str,
        /// The text seen, shortened.
        seen: String,
        /// What is allowed.
        allowed: String,
    },
    /// A file whose name says another format than its text.
    #[error("{spot}: found {seen}; allowed: an Abaqus or CalculiX input file; rename the file to end in .{extension}")]
    OtherFormat {
        /// Where.
        spot: Spot,
        /// What it is.
        seen: &'static str,
        /// The extension of that format.
        extension: &'static str,
    },
    /// A data line that belongs to no keyword.
    #[error(
        "{spot}: found {seen:?} where a keyword is expected; allowed: a line that begins with *; remove the line or add its keyword"
    )]
    StrayData {
        /// Where.
        spot: Spot,
        /// The text seen, shortened.
        seen: String,
    },
    /// A section or the file ends too early.
    #[error("{spot}: {what} ends too early: {detail}; the file may be cut off, write it again")]
    Truncated {
        /// Where the file or section ends.
        spot: Spot,
        /// What ends.
        what: &'static str,
        /// What is missing.
        detail: String,
    },
    /// A label given twice.
    #[error("{spot}: {kind} {label} is given twice; allowed: each {kind} label once; renumber the mesh")]
    Duplicate {
        /// Where the second one stands.
        spot: Spot,
        /// `node`, `element`, or `material`.
        kind: &'static str,
        /// The label or name.
        label: String,
    },
    /// A reference to a node or element that does not exist.
    #[error(
        "{spot}: {by} refers to {kind} {label}, which does not exist; allowed: labels of the file; the file may be cut off, write it again"
    )]
    MissingLabel {
        /// Where.
        spot: Spot,
        /// What refers to it.
        by: String,
        /// `node` or `element`.
        kind: &'static str,
        /// The label.
        label: u64,
    },
    /// A reference to a set or material that does not exist.
    #[error("{spot}: no {kind} is called {name:?}{}; define it in the file or correct the name", did_you_mean(nearest))]
    UnknownName {
        /// Where.
        spot: Spot,
        /// `node set`, `element set`, or `material`.
        kind: &'static str,
        /// The name seen.
        name: String,
        /// The existing name that was probably meant.
        nearest: Option<String>,
    },
    /// A material that elements use and that lacks a property.
    #[error(
        "{spot}: the material {name:?} has no {property}; add {keyword} to it, or give the part a material in the machine file and remove *SOLID SECTION"
    )]
    IncompleteMaterial {
        /// Where the section that uses it stands.
        spot: Spot,
        /// The material.
        name: String,
        /// What it lacks.
        property: &'static str,
        /// The keyword that gives it.
        keyword: &'static str,
    },
    /// An element with two materials.
    #[error(
        "{spot}: element {element} already has the material {first:?}; allowed: one *SOLID SECTION an element; correct the element sets"
    )]
    TwoMaterials {
        /// Where the second section stands.
        spot: Spot,
        /// The element's label.
        element: u64,
        /// The material it has.
        first: String,
    },
    /// Two elements in one place that cannot count as one.
    #[error(
        "{spot}: element {second} has the corners of element {first}, but other {difference}; allowed: each place filled once; remove one of the two"
    )]
    Coincident {
        /// Where the second stands.
        spot: Spot,
        /// Label of the first.
        first: u64,
        /// Label of the second.
        second: u64,
        /// What they differ in.
        difference: &'static str,
    },
    /// Two names of one kind that programs read as one or as two.
    #[error(
        "{spot}: the name {second} differs from {first} in quotes, or in case or blanks within quotes, alone; Abaqus reads two names there and others read one; rename one of them"
    )]
    AlmostEqualNames {
        /// Where the second stands.
        spot: Spot,
        /// The first, as the file writes it.
        first: String,
        /// The second, as the file writes it.
        second: String,
    },
    /// More set members than any mesh needs.
    #[error("{spot}: the sets up to here have more than {limit} members; remove sets that are not needed")]
    TooManyMembers {
        /// Where.
        spot: Spot,
        /// The limit.
        limit: usize,
    },
    /// A file that `*INCLUDE` names and that cannot be taken in.
    #[error("{spot}: *INCLUDE of {}: {reason}", include.display())]
    Include {
        /// Where.
        spot: Spot,
        /// The file named.
        include: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// A section that gives a material to elements that are no solids.
    #[error(
        "{spot}: the section covers element {element}, a {kind}, which is not supported; allowed: solid elements; mesh the body with solids, or remove the section if the element does not matter"
    )]
    NoSolid {
        /// Where the section stands.
        spot: Spot,
        /// The element's label.
        element: u64,
        /// Its type.
        kind: String,
    },
    /// A deck whose modes cannot be computed.
    #[error("{spot}: {reason}")]
    Deck {
        /// Where.
        spot: Spot,
        /// What was found, what is allowed, what to do.
        reason: String,
    },
    /// Something in a section of a Gmsh file that cannot be read or is not allowed.
    #[error("{spot}: ${section}: found {seen:?}; allowed: {allowed}")]
    Gmsh {
        /// Where.
        spot: Spot,
        /// The section.
        section: &'static str,
        /// The text seen, shortened.
        seen: String,
        /// What is allowed, and what to do.
        allowed: String,
    },
    /// Displacements that the file holds along axes which the machine file turns.
    #[error(
        "{}: the file holds single displacements of node {node} (*BOUNDARY) along its own axes, which `orientation` turns away from the machine's; hold them with `supported` in the machine file instead",
        file.display()
    )]
    TurnedSupport {
        /// The mesh file.
        file: PathBuf,
        /// Label of the node.
        node: u64,
    },
    /// No element to assemble.
    #[error("{}: the mesh has no elements; allowed: at least one solid element (C3D4, C3D6, C3D8, C3D8I, C3D10, C3D15, C3D20, C3D20R); the file may be cut off", file.display())]
    NoElements {
        /// The mesh file.
        file: PathBuf,
    },
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(" (did you mean {name:?}?)"))
}
