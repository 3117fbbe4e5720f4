//! Gmsh `.msh`, versions 2.2 and 4.1, as text.
//!
//! Physical groups become sets: of surfaces the faces that their triangles and quadrilaterals mark, of volumes an
//! element set; of each a node set. A group without a name is called after its dimension and number, such as
//! `PhysicalSurface7`. The file has no materials; the machine file gives them. What is not understood is
//! refused with its line.
//!
//! # Source
//! C. Geuzaine, J.-F. Remacle, Gmsh reference manual, chapter "Gmsh file formats".

mod elements;
mod groups;
mod lines;
mod raw;
mod version_2;
mod version_4;

use super::{MeshError, MeshFile};
use crate::files::Inputs;
use crate::machine::MeshUnits;
use lines::Lines;
use std::path::Path;

/// The mesh of a Gmsh file and its warnings; `units.length` is that of the file. Eight-node bricks get
/// incompatible modes (C3D8I) unless `plain_bricks`.
///
/// # Errors
/// [`MeshError`] with the line: a binary file or another version, an element type that is no supported
/// solid, unreadable or infinite numbers, labels given twice or missing, a section that is cut off, no
/// solid elements.
pub fn read_msh_file(path: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile, MeshError> {
    let mut inputs = Inputs::default();
    let bytes = inputs.read(path).map_err(|source| MeshError::Unreadable { file: path.to_path_buf(), source })?;
    let mut file = parse(&bytes, path, units, plain_bricks)?;
    file.mesh.inputs = inputs;
    Ok(file)
}

/// The same of the bytes of a file; `file` serves the messages.
///
/// # Errors
/// As [`read_msh_file`].
pub fn parse_msh(bytes: &[u8], file: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile, MeshError> {
    let mut read = parse(bytes, file, units, plain_bricks)?;
    read.mesh.inputs.add(file, bytes)?;
    Ok(read)
}

fn parse(bytes: &[u8], file: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile, MeshError> {
    let mut lines = Lines::new(bytes, file)?;
    let mut raw = raw::Raw::default();
    let four = lines.format()?;
    while let Some(section) = lines.next_section()? {
        match section {
            "PhysicalNames" => groups::read_names(&mut lines, &mut raw)?,
            "Entities" if four => version_4::read_entities(&mut lines, &mut raw)?,
            "PartitionedEntities" if four => version_4::read_partitioned_entities(&mut lines, &mut raw)?,
            "Nodes" if four => version_4::read_nodes(&mut lines, &mut raw)?,
            "Elements" if four => version_4::read_elements(&mut lines, &mut raw)?,
            "Nodes" => version_2::read_nodes("Nodes", &mut lines, &mut raw)?,
            "ParametricNodes" => version_2::read_nodes("ParametricNodes", &mut lines, &mut raw)?,
            "Elements" => version_2::read_elements(&mut lines, &mut raw)?,
            other => lines.skip_section(other)?,
        }
    }
    raw.assemble(file, units, plain_bricks)
}
