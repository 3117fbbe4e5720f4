//! A part's finite-element mesh: nodes, cells, named sets; one file a format.
//!
//! [`read_mesh`] chooses the format by the file's extension. Abaqus/CalculiX `.inp` is read by
//! [`inp::read_inp`].

mod error;
pub mod inp;

pub use error::{MeshError, Spot};
pub use inp::read_inp;

use crate::machine::{Material, MeshUnits, Part, nearest};
use crate::matrix::{Geometry, GivenMatrices, MatrixPart, read_part_matrices};
use std::collections::BTreeMap;
use std::path::Path;

/// A mesh and what its file said that was passed over.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// The mesh.
    pub mesh: Mesh,
    /// What was passed over without changing the result, by line.
    pub warnings: Vec<Warning>,
}

/// Something in a mesh file that was passed over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Line of the file, counted from 1; 0 for the file as a whole.
    pub line: usize,
    /// What, and what became of it.
    pub text: String,
}

/// The mesh of a file with its warnings; the format follows from the extension.
///
/// # Errors
/// [`MeshError::UnknownFormat`] for an extension that no reader knows, otherwise as [`inp::read_inp`].
pub fn read_mesh_file(path: &Path, units: MeshUnits) -> Result<MeshFile, MeshError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "inp" => inp::read_inp_file(path, units),
        _ => Err(MeshError::UnknownFormat { file: path.to_path_buf(), extension }),
    }
}

/// The mesh of a part, or its matrices with its nodes.
///
/// # Errors
/// As [`read_mesh_file`]; [`MeshError::Matrix`] for a part given by matrices.
pub fn read_part(part: &Part) -> Result<MeshFile, MeshError> {
    let Some(files) = &part.matrices else { return read_mesh_file(&part.mesh, part.mesh_units) };
    let MeshFile { mut mesh, mut warnings } = if files.with_mesh {
        read_mesh_file(&part.mesh, part.mesh_units)?
    } else {
        MeshFile { mesh: Mesh::default(), warnings: Vec::new() }
    };
    let geometry = files.with_mesh.then(|| Geometry {
        nodes: std::mem::take(&mut mesh.nodes),
        labels: std::mem::take(&mut mesh.node_labels),
        sets: std::mem::take(&mut mesh.node_sets),
    });
    let MatrixPart { geometry, matrices, warnings: own } = read_part_matrices(part, files, geometry)?;
    (mesh.nodes, mesh.node_labels, mesh.node_sets) = (geometry.nodes, geometry.labels, geometry.sets);
    mesh.matrices = Some(Box::new(matrices));
    warnings.extend(own.into_iter().map(|text| Warning { line: 0, text }));
    Ok(MeshFile { mesh, warnings })
}

/// The mesh of a file; its warnings go to the log.
///
/// # Errors
/// As [`read_mesh_file`].
pub fn read_mesh(path: &Path, units: MeshUnits) -> Result<Mesh, MeshError> {
    let MeshFile { mesh, warnings } = read_mesh_file(path, units)?;
    for Warning { line, text } in warnings {
        tracing::warn!("{}:{line}: {text}", path.display());
    }
    Ok(mesh)
}

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
    /// Stiffness and mass in place of what the cells would give.
    pub matrices: Option<Box<GivenMatrices>>,
}

impl Mesh {
    /// The nodes of a set, as indices into [`Mesh::nodes`]; the name's case does not matter.
    pub fn node_set(&self, name: &str) -> Option<&[usize]> {
        find_set(&self.node_sets, name)
    }

    /// The cells of a set, as indices into [`Mesh::cells`]; the name's case does not matter.
    pub fn element_set(&self, name: &str) -> Option<&[usize]> {
        find_set(&self.element_sets, name)
    }

    /// The node set that `name` is probably a misspelling of.
    pub fn nearest_node_set(&self, name: &str) -> Option<&str> {
        nearest(name, self.node_sets.keys().map(String::as_str))
    }
}

fn find_set<'a>(sets: &'a BTreeMap<String, Vec<usize>>, name: &str) -> Option<&'a [usize]> {
    let exact = sets.get(name);
    exact.or_else(|| sets.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, set)| set)).map(Vec::as_slice)
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
