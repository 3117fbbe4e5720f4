//! CalculiX's `.sti` and `.mas` (`*FREQUENCY, SOLVER=MATRIXSTORAGE`): `row column value`, one triangle.

use super::MatrixError;
use super::coordinates::{Coordinates, MOST_ROWS};
use super::text::{Lines, fields, number};
use std::path::Path;

/// The matrix of a `.sti` or `.mas` file.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_calculix(bytes: &[u8], file: &Path) -> Result<Coordinates, MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let mut matrix = Coordinates { file: file.to_path_buf(), symmetric: true, ..Coordinates::default() };
    while let Some(line) = lines.next()? {
        let mut parts = fields(line);
        let mut index = || parts.next()?.parse::<usize>().ok().filter(|i| (1..=MOST_ROWS).contains(i));
        let place = index().zip(index());
        let value = parts.next().and_then(number);
        let (Some((i, j)), Some(value), None) = (place, value, parts.next()) else {
            return Err(lines.refuse(line, "row, column and a finite number"));
        };
        matrix.n = matrix.n.max(i).max(j);
        matrix.entries.push((i as u32 - 1, j as u32 - 1, value));
    }
    if matrix.entries.is_empty() {
        return Err(lines.refuse("no entry", "at least one"));
    }
    Ok(matrix)
}
