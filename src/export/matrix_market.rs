//! Matrices as Matrix Market files, with tables of what their rows are.
//!
//! A table of degrees of freedom and one of node sets beside them are what a machine file's `matrices`
//! reads: a part that is written so can be used again.

use super::{ExportError, atomic, finite};
use crate::linalg::SparseSymmetric;
use crate::matrix::DIRECTIONS;
use nalgebra::DMatrix;
use std::io::Write;
use std::path::Path;

/// Writes the lower triangle of a symmetric matrix, `coordinate real symmetric`.
///
/// # Errors
/// [`ExportError::NotFinite`] or [`ExportError::Io`].
pub fn write_sparse(path: &Path, matrix: &SparseSymmetric) -> Result<(), ExportError> {
    let lower = |i: usize| matrix.row(i).filter(move |(j, v)| *j <= i && (*v != 0.0 || *j == i));
    let entries: usize = (0..matrix.n()).map(|i| lower(i).count()).sum();
    let failed = atomic::io(path, "write");
    atomic::write_atomic(path, |file| {
        writeln!(file, "%%MatrixMarket matrix coordinate real symmetric").map_err(&failed)?;
        writeln!(file, "{} {} {entries}", matrix.n(), matrix.n()).map_err(&failed)?;
        for i in 0..matrix.n() {
            for (j, value) in lower(i) {
                let value = finite(path, value, || format!("entry {}, {}", i + 1, j + 1))?;
                writeln!(file, "{} {} {value:e}", i + 1, j + 1).map_err(&failed)?;
            }
        }
        Ok(())
    })
}

/// Writes a dense matrix, `array real general`, by columns.
///
/// # Errors
/// [`ExportError::NotFinite`] or [`ExportError::Io`].
pub fn write_dense(path: &Path, matrix: &DMatrix<f64>) -> Result<(), ExportError> {
    let failed = atomic::io(path, "write");
    atomic::write_atomic(path, |file| {
        writeln!(file, "%%MatrixMarket matrix array real general").map_err(&failed)?;
        writeln!(file, "{} {}", matrix.nrows(), matrix.ncols()).map_err(&failed)?;
        for (k, value) in matrix.iter().enumerate() {
            let value = finite(path, *value, || format!("value {}", k + 1))?;
            writeln!(file, "{value:e}").map_err(&failed)?;
        }
        Ok(())
    })
}

/// A row of a matrix: node label, direction (0 to 5) and place (m); `None` for a modal coordinate.
pub type DofRow = Option<(u64, usize, [f64; 3])>;

/// Writes the table `node,direction,x,y,z`, one line a row of the matrices.
///
/// # Errors
/// [`ExportError::NotFinite`] or [`ExportError::Io`].
pub fn write_dofs(path: &Path, rows: &[DofRow]) -> Result<(), ExportError> {
    let mut text = String::from("node,direction,x,y,z\n");
    for (k, row) in rows.iter().enumerate() {
        match row {
            Some((node, direction, at)) => {
                let [x, y, z] =
                    [0, 1, 2].map(|c| finite(path, at[c], || format!("coordinate {} of node {node}", c + 1)));
                text += &format!("{node},{},{:e},{:e},{:e}\n", DIRECTIONS[*direction], x?, y?, z?);
            }
            None => text += &format!("{},modal,,,\n", k + 1),
        }
    }
    atomic::write_bytes(path, text.as_bytes())
}

/// Writes the table `set,node,weight`.
///
/// # Errors
/// [`ExportError::NotFinite`] or [`ExportError::Io`].
pub fn write_sets(path: &Path, sets: &[(String, Vec<(u64, f64)>)]) -> Result<(), ExportError> {
    let mut text = String::from("set,node,weight\n");
    for (name, nodes) in sets {
        for (node, weight) in nodes {
            let weight = finite(path, *weight, || format!("weight of node {node} in {name}"))?;
            text += &format!("{name},{node},{weight:e}\n");
        }
    }
    atomic::write_bytes(path, text.as_bytes())
}
