//! The matrices of a part: `matrices = { stiffness = "k.mtx", mass = "m.mtx", dofs = "dofs.csv" }`.

use super::error::MachineError;
use super::parts::read_mesh_path;
use super::table::Item;
use std::path::{Path, PathBuf};

/// A part's matrices, by file.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixFiles {
    /// Stiffness.
    pub stiffness: PathBuf,
    /// Mass.
    pub mass: PathBuf,
    /// Name of the stiffness in a file of several matrices.
    pub stiffness_name: Option<String>,
    /// Name of the mass in a file of several matrices.
    pub mass_name: Option<String>,
    /// Table of degrees of freedom.
    pub dofs: Option<PathBuf>,
    /// Coordinates of the nodes.
    pub nodes: Option<PathBuf>,
    /// Node sets.
    pub sets: Option<PathBuf>,
    /// Whether the part is free, where the matrices leave doubt.
    pub free: Option<bool>,
    /// Whether the part names a mesh too.
    pub with_mesh: bool,
    /// One an interface of the part.
    pub interfaces: Vec<InterfaceNodes>,
}

impl MatrixFiles {
    /// The file that labels the rows.
    pub fn label_file(&self) -> &Path {
        self.dofs.as_deref().unwrap_or(&self.stiffness)
    }
}

/// What the machine file says of the nodes of an interface of a part given by matrices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceNodes {
    /// Labels in place of a set's name.
    pub labels: Option<Vec<u64>>,
    /// Weights.
    pub weights: InterfaceWeights,
}

/// Weights of an interface's nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum InterfaceWeights {
    /// Nothing said: the table's, or areas where there is a mesh.
    #[default]
    Unsaid,
    /// Areas of the mesh's faces.
    Area,
    /// The same for all.
    Equal,
    /// One a node, in the order of the labels or ascending labels of a set.
    Given(Vec<f64>),
}

type Result<T> = std::result::Result<T, MachineError>;

pub(super) fn read_matrix_files(
    item: &Item<'_>,
    folder: &Path,
    with_mesh: bool,
    interfaces: Vec<InterfaceNodes>,
) -> Result<MatrixFiles> {
    let table = item.table()?;
    let optional = |key| table.get(key).map(|item| read_mesh_path(&item, folder)).transpose();
    let name = |key| table.get(key).map(|item| item.text().map(str::to_owned)).transpose();
    let files = MatrixFiles {
        stiffness: read_mesh_path(&table.need("stiffness", "stiffness = \"FILE.mtx\"")?, folder)?,
        mass: read_mesh_path(&table.need("mass", "mass = \"FILE.mtx\"")?, folder)?,
        stiffness_name: name("stiffness_name")?,
        mass_name: name("mass_name")?,
        dofs: optional("dofs")?,
        nodes: optional("nodes")?,
        sets: optional("sets")?,
        free: table.get("free").map(|item| item.boolean()).transpose()?,
        with_mesh,
        interfaces,
    };
    table.finish()?;
    Ok(files)
}
