//! A part's finite-element mesh: nodes, cells, named sets; one file a format.
//!
//! [`read_part_mesh`] chooses the format by the file's extension: Abaqus/CalculiX `.inp` by [`inp`], Gmsh
//! `.msh` by [`msh`].

mod cell;
mod error;
pub mod inp;
mod labels;
pub mod msh;

pub use cell::{Cell, CellFace, CellKind};
pub use error::{MeshError, Spot};
pub use inp::{included_files, read_inp};

use crate::machine::{Material, MeshUnits, Part, Placement, nearest};
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
/// [`MeshError::UnknownFormat`] for an extension that no reader knows, otherwise as [`inp::read_inp`] and
/// [`msh::read_msh_file`].
pub fn read_mesh_file(path: &Path, units: MeshUnits) -> Result<MeshFile, MeshError> {
    read_format(path, units, false)
}

fn read_format(path: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile, MeshError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "inp" => inp::read_inp_file(path, units, plain_bricks),
        "msh" => msh::read_msh_file(path, units, plain_bricks),
        _ => Err(MeshError::UnknownFormat { file: path.to_path_buf(), extension }),
    }
}

/// The mesh of a part: in its units, with its bricks, where it stands in the machine; or its matrices
/// with its nodes.
///
/// # Errors
/// As [`read_mesh_file`]; [`MeshError::TurnedSupport`] where the file holds single displacements along axes
/// that the machine's are not parallel to; [`MeshError::Matrix`] for a part given by matrices.
pub fn read_part_mesh(part: &Part) -> Result<MeshFile, MeshError> {
    let with_mesh = part.matrices.as_ref().is_none_or(|files| files.with_mesh);
    let mut file = if with_mesh {
        read_format(&part.mesh, part.mesh_units, part.plain_bricks)?
    } else {
        MeshFile { mesh: Mesh::default(), warnings: Vec::new() }
    };
    if !file.mesh.supports.is_empty() {
        let text = format!("*BOUNDARY of the file holds {} nodes", file.mesh.supports.len());
        file.warnings.insert(0, Warning { line: 0, text });
    }
    if let Some(files) = &part.matrices {
        let mesh = &mut file.mesh;
        let geometry = with_mesh.then(|| Geometry {
            nodes: std::mem::take(&mut mesh.nodes),
            labels: std::mem::take(&mut mesh.node_labels),
            sets: std::mem::take(&mut mesh.node_sets),
        });
        let MatrixPart { geometry, matrices, warnings } = read_part_matrices(part, files, geometry)?;
        (mesh.nodes, mesh.node_labels, mesh.node_sets) = (geometry.nodes, geometry.labels, geometry.sets);
        mesh.matrices = Some(Box::new(matrices));
        file.warnings.extend(warnings.into_iter().map(|text| Warning { line: 0, text }));
    }
    place(&mut file.mesh, &part.placement, &part.mesh)?;
    Ok(file)
}

/// Moves a mesh from its own coordinates to the machine's.
fn place(mesh: &mut Mesh, placement: &Placement, file: &Path) -> Result<(), MeshError> {
    if *placement == Placement::IDENTITY {
        return Ok(());
    }
    mesh.nodes.iter_mut().for_each(|x| *x = placement.apply(*x));
    for (&node, held) in &mut mesh.supports {
        if held.iter().all(|h| *h) {
            continue;
        }
        let parallel = |row: [f64; 3]| row.iter().position(|c| c.abs() > 1.0 - 1e-9);
        let axes = placement.rotation.map(parallel);
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(MeshError::TurnedSupport { file: file.to_path_buf(), node: mesh.node_labels[node] });
        };
        *held = [held[x], held[y], held[z]];
    }
    Ok(())
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
    /// Surfaces given by element faces.
    pub surfaces: BTreeMap<String, Vec<CellFace>>,
    /// Single displacements that the file itself holds, one entry a node.
    pub supports: BTreeMap<usize, [bool; 3]>,
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

    /// The faces of a surface; the name's case does not matter.
    pub fn surface(&self, name: &str) -> Option<&[CellFace]> {
        find_set(&self.surfaces, name)
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

fn find_set<'a, T>(sets: &'a BTreeMap<String, Vec<T>>, name: &str) -> Option<&'a [T]> {
    let exact = sets.get(name);
    exact.or_else(|| sets.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, set)| set)).map(Vec::as_slice)
}
