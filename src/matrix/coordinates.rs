//! Entries of a square matrix as a file gives them, made symmetric.

use super::MatrixError;
use crate::linalg::{SparseBuilder, SparseSymmetric};
use std::path::PathBuf;

/// Entries of a file's matrix, in any order, each place at most once.
#[derive(Clone, Debug, Default)]
pub struct Coordinates {
    /// The file.
    pub file: PathBuf,
    /// Order of the matrix.
    pub n: usize,
    /// Row, column (from 0), value.
    pub entries: Vec<(u32, u32, f64)>,
    /// Whether the file says that one triangle stands for both.
    pub symmetric: bool,
}

/// Largest difference between mirrored entries, relative to the square root of their diagonals' product.
pub const SYMMETRY: f64 = 1e-8;
/// Rows that a matrix may have.
pub(super) const MOST_ROWS: usize = 50_000_000;

/// The symmetric matrix of a file's entries; a single triangle stands for both, whatever the header says.
///
/// # Errors
/// [`MatrixError::Unsymmetric`] with the worst pair; [`MatrixError::Content`] for an entry given twice
/// or a triangle mirrored in a file that says it gives one only.
pub fn symmetric(
    mut matrix: Coordinates,
    what: &'static str,
    place: &dyn Fn(usize) -> String,
) -> Result<SparseSymmetric, MatrixError> {
    let refused = |row: u32, column: u32, seen: &str, allowed: &str| MatrixError::Content {
        file: matrix.file.clone(),
        place: format!("row {}, column {}", row + 1, column + 1),
        seen: seen.into(),
        allowed: allowed.into(),
        advice: "write the matrix again",
    };
    matrix.entries.sort_unstable_by_key(|&(i, j, _)| (i, j));
    if let Some(pair) = matrix.entries.windows(2).find(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)) {
        return Err(refused(pair[0].0, pair[0].1, "an entry given twice", "each entry once"));
    }
    if let Some(&(i, j, _)) = matrix.entries.iter().find(|e| e.0.max(e.1) as usize >= matrix.n) {
        let allowed = format!("rows and columns from 1 to {}", matrix.n);
        return Err(refused(i, j, "an entry outside the matrix", &allowed));
    }
    let upper = matrix.entries.iter().any(|(i, j, _)| i < j);
    let lower = matrix.entries.iter().any(|(i, j, _)| i > j);
    let both = upper && lower;
    let find = |i: u32, j: u32| matrix.entries.binary_search_by_key(&(i, j), |&(i, j, _)| (i, j)).ok();
    let value = |i: u32, j: u32| find(i, j).map_or(0.0, |k| matrix.entries[k].2);
    if both {
        let off_diagonal = || matrix.entries.iter().filter(|(i, j, _)| i != j);
        if matrix.symmetric
            && let Some(&(i, j, _)) = off_diagonal().find(|(i, j, _)| find(*j, *i).is_some())
        {
            return Err(refused(i, j, "an entry of both triangles", "one triangle, since the file says symmetric"));
        }
        let mut worst: Option<(f64, MatrixError)> = None;
        for &(i, j, a) in off_diagonal().filter(|_| !matrix.symmetric) {
            let b = value(j, i);
            let scale = (value(i, i) * value(j, j)).abs().sqrt();
            let tolerance = SYMMETRY * if scale > 0.0 { scale } else { a.abs().max(b.abs()) };
            let excess = (a - b).abs() / tolerance;
            if (a - b).abs() > tolerance && worst.as_ref().is_none_or(|(seen, _)| excess > *seen) {
                let error = MatrixError::Unsymmetric {
                    file: matrix.file.clone(),
                    what,
                    place: format!("row {}, column {}", place(i as usize), place(j as usize)),
                    value: a,
                    mirrored: b,
                    tolerance,
                };
                worst = Some((excess, error));
            }
        }
        if let Some((_, error)) = worst {
            return Err(error);
        }
    }
    let mirrored = both && !matrix.symmetric;
    let mut pattern: Vec<Vec<usize>> = (0..matrix.n).map(|i| vec![i]).collect();
    for &(i, j, _) in &matrix.entries {
        pattern[i as usize].push(j as usize);
        pattern[j as usize].push(i as usize);
    }
    for row in &mut pattern {
        row.sort_unstable();
        row.dedup();
    }
    let mut builder = SparseBuilder::new(&pattern);
    for &(i, j, v) in &matrix.entries {
        let (i, j) = (i as usize, j as usize);
        if i == j {
            builder.add(i, i, v);
        } else {
            let share = if mirrored { 0.5 * v } else { v };
            builder.add(i, j, share);
            builder.add(j, i, share);
        }
    }
    Ok(builder.finish())
}
