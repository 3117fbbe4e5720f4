//! One matrix or table from a file, by its extension.

use super::coordinates::Coordinates;
use super::labels::{DofLabel, DofTable, parse_calculix_dofs, parse_dof_table};
use super::op4::parse_op4;
use super::{MatrixError, abaqus, calculix, full, market};
use crate::files::Inputs;
use std::path::Path;

/// A matrix as its file has it.
pub(super) struct Raw {
    pub matrix: Coordinates,
    pub labels: Option<Vec<DofLabel>>,
    pub fixed: Vec<DofLabel>,
    /// Whether the file says how many rows there are.
    pub sized: bool,
}

/// Reads a file whole and records it.
pub(super) fn bytes(file: &Path, inputs: &mut Inputs) -> Result<Vec<u8>, MatrixError> {
    inputs.read(file).map_err(|source| MatrixError::Unreadable { file: file.to_path_buf(), source })
}

pub(super) fn read_dofs(file: &Path, inputs: &mut Inputs) -> Result<DofTable, MatrixError> {
    let calculix = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("dof"));
    let bytes = bytes(file, inputs)?;
    if calculix { parse_calculix_dofs(&bytes, file) } else { parse_dof_table(&bytes, file) }
}

pub(super) fn read_matrix(
    file: &Path,
    name: Option<&str>,
    what: &'static str,
    warnings: &mut Vec<String>,
    inputs: &mut Inputs,
) -> Result<Raw, MatrixError> {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let plain = |matrix, sized| Raw { matrix, labels: None, fixed: Vec::new(), sized };
    let bytes = bytes(file, inputs)?;
    let missing =
        |what: String, found: String, advice| MatrixError::Missing { file: file.to_path_buf(), what, found, advice };
    match extension.as_str() {
        "mtx"
            if bytes.len() >= market::BANNER.len()
                && bytes[..market::BANNER.len()].eq_ignore_ascii_case(market::BANNER.as_bytes()) =>
        {
            let mut matrix = market::parse_market(&bytes, file)?;
            let triangle = |over: fn(&(u32, u32, f64)) -> bool| !matrix.entries.iter().any(over);
            let one = triangle(|(i, j, _)| i < j) != triangle(|(i, j, _)| i > j);
            if one && !matrix.symmetric {
                warnings
                    .push(format!("{}: one triangle under the header `general` is read as symmetric", file.display()));
            }
            matrix.symmetric |= one;
            Ok(plain(matrix, true))
        }
        "mtx" => {
            let (matrix, labels) = abaqus::parse_abaqus(&bytes, file)?;
            Ok(Raw { matrix, labels, fixed: Vec::new(), sized: false })
        }
        "sti" | "mas" => Ok(plain(calculix::parse_calculix(&bytes, file)?, false)),
        "op4" => {
            let (mut matrices, unusable) = parse_op4(&bytes, file)?;
            let names = || {
                let usable = matrices.iter().map(|m| m.name.clone());
                let all: Vec<String> = usable.chain(unusable.iter().cloned()).collect();
                if all.is_empty() { "none".into() } else { all.join(", ") }
            };
            let wanted = name.map_or_else(|| format!("single {what} matrix"), |n| format!("real square matrix {n}"));
            let same: Vec<String> = matrices
                .iter()
                .filter(|m| name.is_some_and(|name| m.name.eq_ignore_ascii_case(name)))
                .map(|m| format!("{} of order {}", m.name, m.matrix.n))
                .collect();
            if same.len() > 1 {
                let wanted = format!("single matrix {}", name.unwrap_or_default());
                let advice = "write each matrix once, or under different names";
                return Err(missing(wanted, same.join(", "), advice));
            }
            let at = match name {
                Some(name) => matrices.iter().position(|m| m.name.eq_ignore_ascii_case(name)),
                None => (matrices.len() == 1).then_some(0),
            };
            let advice = "name one by stiffness_name or mass_name";
            let at = at.ok_or_else(|| missing(wanted, names(), advice))?;
            Ok(plain(matrices.swap_remove(at).matrix, true))
        }
        "full" => {
            let full = full::parse_full(&bytes, file)?;
            let matrix = if what == "mass" { full.mass } else { Some(full.stiffness) };
            let advice = "write it by a modal analysis, or name another file";
            let matrix = matrix.ok_or_else(|| missing("mass matrix".into(), "a stiffness matrix".into(), advice))?;
            Ok(Raw { matrix, labels: Some(full.labels), fixed: full.fixed, sized: true })
        }
        _ => Err(MatrixError::UnknownFormat { file: file.to_path_buf(), extension }),
    }
}
