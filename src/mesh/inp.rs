//! Abaqus/CalculiX `.inp`: nodes, ten-node tetrahedra, sets, isotropic materials, solid sections.
//!
//! Keywords and set names are read without regard to case, data in free format. What would not change
//! the mesh (output requests, steps) is passed over with a warning; everything else that is not
//! understood is refused with its line.
//!
//! The file is read in two passes: `sections` collects what stands in it, `assemble` resolves labels and
//! names, so sections may come in any order.

mod assemble;
mod keywords;
mod labels;
mod lines;
mod properties;
mod raw;
mod sections;
mod sets;
mod topology;

use super::{Mesh, MeshError, MeshFile, Spot, Warning};
use crate::machine::MeshUnits;
use std::path::Path;

/// The mesh of an Abaqus/CalculiX input file; its warnings go to the log.
///
/// `units` are those of the file; the mesh is in m, Pa and kg/m^3. Nodes that no element uses are
/// dropped. An element without a `*SOLID SECTION` has no material.
///
/// # Errors
/// [`MeshError`] with the line: a keyword or parameter that would change the result and is not
/// supported, an element type other than C3D10, unreadable or infinite numbers, labels given twice,
/// labels or names that do not exist, an element that is cut off, a material without modulus or density,
/// no elements.
pub fn read_inp(path: &Path, units: MeshUnits) -> Result<Mesh, MeshError> {
    let MeshFile { mesh, warnings } = read_inp_file(path, units)?;
    for Warning { line, text } in warnings {
        tracing::warn!("{}:{line}: {text}", path.display());
    }
    Ok(mesh)
}

/// The mesh of an Abaqus/CalculiX input file and its warnings.
///
/// # Errors
/// As [`read_inp`].
pub fn read_inp_file(path: &Path, units: MeshUnits) -> Result<MeshFile, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| MeshError::Unreadable { file: path.to_path_buf(), source })?;
    parse_inp(&bytes, path, units)
}

/// The mesh of the bytes of an input file; `file` serves the messages.
///
/// # Errors
/// As [`read_inp`].
pub fn parse_inp(bytes: &[u8], file: &Path, units: MeshUnits) -> Result<MeshFile, MeshError> {
    let text = std::str::from_utf8(bytes).ok().filter(|text| !text.contains('\0')).ok_or_else(|| {
        let valid = match std::str::from_utf8(bytes) {
            Ok(text) => text.find('\0').unwrap_or(0),
            Err(error) => error.valid_up_to(),
        };
        let line = 1 + bytes[..valid].iter().filter(|&&b| b == b'\n').count();
        MeshError::NotText { spot: Spot { file: file.to_path_buf(), line } }
    })?;
    let raw = sections::collect(text, file)?;
    assemble::assemble(raw, file, units)
}
