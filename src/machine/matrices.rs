//! The matrices of a part: `matrices = { stiffness = "k.mtx", mass = "m.mtx", dofs = "dofs.csv" }`.

use super::error::MachineError;
use super::model::{InterfaceNodes, MatrixFiles};
use super::parts::read_mesh_path;
use super::table::Item;
use std::path::Path;

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
        mass: read_mesh_path(&table.need("mass", "mass = \"FILE.mtx\"; a part without mass has no modes")?, folder)?,
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
