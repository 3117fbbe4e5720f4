//! Matrix Market: `%%MatrixMarket matrix coordinate|array real|integer general|symmetric`.
//!
//! # Source
//! R. F. Boisvert, R. Pozo, K. A. Remington, The Matrix Market Exchange Formats, NISTIR 5935 (1996).

use super::MatrixError;
use super::coordinates::{Coordinates, MOST_ROWS};
use super::text::{Lines, fields, number};
use std::path::Path;

/// What the first line of a Matrix Market file begins with.
pub(super) const BANNER: &str = "%%MatrixMarket";

/// The square matrix of a Matrix Market file.
///
/// `coordinate` and `array`, `real` and `integer`, `general` and `symmetric`. A symmetric file may
/// hold either triangle, and an entry of a triangle stands for both.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_market(bytes: &[u8], file: &Path) -> Result<Coordinates, MatrixError> {
    const HEADER: &str = "%%MatrixMarket matrix coordinate|array real|integer general|symmetric";
    let mut lines = Lines::new(bytes, file);
    let header = lines.next()?.unwrap_or_default();
    let words: Vec<String> = header.split_whitespace().map(str::to_ascii_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let [banner, "matrix", layout @ ("coordinate" | "array"), "real" | "integer", symmetry @ ("general" | "symmetric")] =
        words[..]
    else {
        return Err(lines.refuse(header, HEADER));
    };
    if !banner.eq_ignore_ascii_case(BANNER) {
        return Err(lines.refuse(header, HEADER));
    }
    let symmetric = symmetry == "symmetric";
    let dense = layout == "array";
    let size = next_data(&mut lines)?.ok_or_else(|| lines.refuse("the end of the file", "a line of sizes"))?;
    let sizes: Vec<usize> = fields(size).map_while(|f| f.parse().ok()).collect();
    let (rows, columns, entries) = match (dense, &sizes[..]) {
        (false, &[rows, columns, entries]) => (rows, columns, entries),
        (true, &[rows, columns]) => (rows, columns, 0),
        _ => return Err(lines.refuse(size, "rows, columns and, for coordinate, the number of entries")),
    };
    if rows != columns || rows == 0 || rows > MOST_ROWS {
        return Err(lines.refuse(size, format!("a square matrix of 1 to {MOST_ROWS} rows")));
    }
    let mut matrix = Coordinates { file: file.to_path_buf(), n: rows, entries: Vec::new(), symmetric };
    if dense {
        array(&mut lines, &mut matrix)?
    } else {
        coordinate(&mut lines, &mut matrix, entries)?
    }
    if let Some(line) = next_data(&mut lines)? {
        return Err(lines.refuse(line, "the end of the file after the last entry"));
    }
    Ok(matrix)
}

fn next_data<'a>(lines: &mut Lines<'a>) -> Result<Option<&'a str>, MatrixError> {
    while let Some(line) = lines.next()? {
        if !line.starts_with('%') {
            return Ok(Some(line));
        }
    }
    Ok(None)
}

fn coordinate(lines: &mut Lines<'_>, matrix: &mut Coordinates, entries: usize) -> Result<(), MatrixError> {
    for k in 0..entries {
        let missing = || format!("{entries} entries, as the line of sizes says, not {k}");
        let line = next_data(lines)?.ok_or_else(|| lines.refuse("the end of the file", missing()))?;
        let mut parts = fields(line);
        let mut index = || parts.next()?.parse::<usize>().ok().filter(|i| (1..=matrix.n).contains(i));
        let place = index().zip(index());
        let value = parts.next().and_then(number);
        let (Some((i, j)), Some(value), None) = (place, value, parts.next()) else {
            return Err(lines.refuse(line, format!("row and column from 1 to {}, and a finite number", matrix.n)));
        };
        matrix.entries.push((i as u32 - 1, j as u32 - 1, value));
    }
    Ok(())
}

/// Values by columns; the lower triangle only where the file is symmetric.
fn array(lines: &mut Lines<'_>, matrix: &mut Coordinates) -> Result<(), MatrixError> {
    for j in 0..matrix.n {
        for i in if matrix.symmetric { j } else { 0 }..matrix.n {
            let place = format!("a finite number for row {}, column {}", i + 1, j + 1);
            let line = next_data(lines)?.ok_or_else(|| lines.refuse("the end of the file", place.as_str()))?;
            let value = number(line).ok_or_else(|| lines.refuse(line, place.as_str()))?;
            if value != 0.0 {
                matrix.entries.push((i as u32, j as u32, value));
            }
        }
    }
    Ok(())
}
