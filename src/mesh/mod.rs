//! A part's finite-element mesh: nodes, cells, named sets; one file a format.
//!
//! [`read_part_mesh`] chooses the format by the file's extension: Abaqus/CalculiX `.inp` by [`inp`], Gmsh
//! `.msh` by [`msh`].

mod cell;
mod doubled;
mod error;
pub mod inp;
mod labels;
pub mod msh;
mod named;

pub use cell::{Cell, CellFace, CellKind};
pub use error::{MeshError, Spot};
pub use inp::read_inp;
pub use named::{FaceElement, Namesake, loosely_equal, spelling};

use crate::files::{InputError, Inputs};
use crate::machine::{Material, MeshUnits, Part, Placement, nearest};
use crate::matrix::{Geometry, GivenMatrices, MatrixPart, read_part_matrices};
use inp::Reading;
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
    read_format(path, units, Reading::default())
}

fn read_format(path: &Path, units: MeshUnits, how: Reading) -> Result<MeshFile, MeshError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "inp" => inp::read_inp_as(path, units, how),
        "msh" => msh::read_msh_file(path, units, how.plain_bricks),
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
        // Materials of the file do not matter where the machine file or matrices say what the part is made of.
        let other_material = part.material.is_some() || part.matrices.is_some();
        read_format(&part.mesh, part.mesh_units, Reading { plain_bricks: part.plain_bricks, other_material })?
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
            faces: mesh.surfaces.keys().chain(mesh.face_sets.keys()).cloned().collect(),
            clashes: BTreeMap::new(),
        });
        let MatrixPart { geometry, matrices, warnings, inputs } = read_part_matrices(part, files, geometry)?;
        (mesh.nodes, mesh.node_labels, mesh.node_sets) = (geometry.nodes, geometry.labels, geometry.sets);
        for (name, nodes) in geometry.clashes {
            let what = ["the set of the mesh".to_owned(), "the set of the table `sets`".to_owned()];
            let both = what.into_iter().zip(nodes).map(|(what, nodes)| Namesake { what, nodes });
            mesh.namesakes.insert(name, both.collect());
        }
        mesh.matrices = Some(Box::new(matrices));
        mesh.inputs.extend(&inputs)?;
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

/// The files of all parts as they were read.
///
/// # Errors
/// [`InputError`] if two parts read one file and saw different contents.
pub fn inputs_of(meshes: &[MeshFile]) -> Result<Inputs, InputError> {
    let mut inputs = Inputs::default();
    meshes.iter().try_for_each(|file| inputs.extend(&file.mesh.inputs))?;
    Ok(inputs)
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
    /// Surfaces given by two-dimensional elements: physical surfaces of Gmsh, element sets of shells and the like.
    pub face_sets: BTreeMap<String, Vec<FaceElement>>,
    /// Where several things of the file have one name: those of them that are not made of faces.
    pub namesakes: BTreeMap<String, Vec<Namesake>>,
    /// Names that the file gives to something that is passed over, and why: for the message if one is used.
    pub passed_over: BTreeMap<String, String>,
    /// Single displacements that the file itself holds, one entry a node.
    pub supports: BTreeMap<usize, [bool; 3]>,
    /// Materials of the file.
    pub materials: Vec<Material>,
    /// Stiffness and mass in place of what the cells would give.
    pub matrices: Option<Box<GivenMatrices>>,
    /// Every file that it was made from, as it was read, with all that they include; none for a mesh made in memory.
    pub inputs: Inputs,
}

impl Mesh {
    /// The nodes of a set, as indices into [`Mesh::nodes`]; case and blanks of the name do not matter.
    pub fn node_set(&self, name: &str) -> Option<&[usize]> {
        find_set(&self.node_sets, name)
    }

    /// The faces of a surface; case and blanks of the name do not matter.
    pub fn surface(&self, name: &str) -> Option<&[CellFace]> {
        find_set(&self.surfaces, name)
    }

    /// The cells of a set, as indices into [`Mesh::cells`]; case and blanks of the name do not matter.
    pub fn element_set(&self, name: &str) -> Option<&[usize]> {
        find_set(&self.element_sets, name)
    }

    /// The node set that `name` is probably a misspelling of.
    pub fn nearest_node_set(&self, name: &str) -> Option<&str> {
        nearest(name, self.node_sets.keys().map(String::as_str))
    }
}

fn find_set<'a, T>(sets: &'a BTreeMap<String, Vec<T>>, name: &str) -> Option<&'a [T]> {
    let known = spelling(sets.keys().map(String::as_str), name).ok()??;
    sets.get(known).map(Vec::as_slice)
}
