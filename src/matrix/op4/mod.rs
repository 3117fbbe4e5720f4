//! Nastran OUTPUT4: text and binary, dense and sparse, small and large (BIGMAT) row numbers.
//!
//! A matrix is a header (columns, rows, form, type, name) and its columns; a column names its first
//! row and its values, or, where that row is 0, strings of values each with its own first row. Rows
//! are negative in the header where string headers are two words instead of one. A column number past
//! the last ends the matrix; the next may follow.
//!
//! Lengths count words of 4 bytes, two of which make a number in double precision. In dense text Nastran counts
//! numbers instead, and some writers count words there too; the lines that follow show which.
//!
//! # Source
//! NX Nastran DMAP Programmer's Guide, module OUTPUT4.

mod binary;
mod text;

use super::MatrixError;
use super::coordinates::{Coordinates, MOST_ROWS};
use std::path::Path;

/// One matrix of an OUTPUT4 file.
#[derive(Clone, Debug)]
pub struct Op4Matrix {
    /// Name, without its padding.
    pub name: String,
    /// Its entries.
    pub matrix: Coordinates,
}

/// The square real matrices of an OUTPUT4 file; others are passed over and named with the reason.
///
/// # Errors
/// [`MatrixError::Content`] with the line or byte of what is not OUTPUT4.
pub fn parse_op4(bytes: &[u8], file: &Path) -> Result<(Vec<Op4Matrix>, Vec<String>), MatrixError> {
    let mut found = (Vec::new(), Vec::new());
    let binary = bytes.iter().take(8).any(|&b| b == 0);
    if binary {
        binary::parse(bytes, file, &mut found)?
    } else {
        text::parse(bytes, file, &mut found)?
    }
    Ok(found)
}

type Found = (Vec<Op4Matrix>, Vec<String>);

/// A matrix's header.
struct Header {
    name: String,
    columns: usize,
    rows: usize,
    /// Whether a string's header is two words.
    big: bool,
    /// Words of 4 bytes a number: 1 single, 2 double. A complex value is two numbers.
    words: usize,
    /// Numbers a value: 2 if complex.
    numbers: usize,
    /// Why the matrix is passed over.
    unusable: Option<String>,
}

impl Header {
    fn new(columns: i64, rows: i64, form: i64, kind: i64, name: &str) -> Option<Self> {
        let (words, numbers) = match kind {
            1 => (1, 1),
            2 => (2, 1),
            3 => (1, 2),
            4 => (2, 2),
            _ => return None,
        };
        let size = |n: i64| usize::try_from(n).ok().filter(|n| (1..=MOST_ROWS).contains(n));
        let (columns, count) = (size(columns)?, size(rows.checked_abs()?)?);
        let name = name.trim().to_string();
        let unusable = if numbers > 1 {
            Some(format!("{name} (complex)"))
        } else if columns != count {
            Some(format!("{name} ({count} x {columns}, form {form})"))
        } else {
            None
        };
        // The rows of a string's header of one word end at 65535.
        let big = rows < 0 || count > 65535;
        Some(Self { name, columns, rows: count, big, words, numbers, unusable })
    }

    fn start(&self, file: &Path) -> Coordinates {
        Coordinates { file: file.to_path_buf(), n: self.columns, entries: Vec::new(), symmetric: false }
    }

    fn finish(self, matrix: Coordinates, found: &mut Found) {
        match self.unusable {
            Some(reason) => found.1.push(reason),
            None => found.0.push(Op4Matrix { name: self.name, matrix }),
        }
    }

    /// Puts values of a column from a row (from 1) on; `None` if they run out of the matrix. Of a matrix that is
    /// passed over only the number of values counts.
    fn put(
        &self,
        matrix: &mut Coordinates,
        column: usize,
        row: usize,
        values: impl Iterator<Item = f64>,
    ) -> Option<()> {
        for (k, value) in values.enumerate() {
            let row = row.checked_add(k / self.numbers).filter(|r| (1..=self.rows).contains(r))?;
            if value != 0.0 && self.unusable.is_none() {
                value.is_finite().then_some(())?;
                matrix.entries.push((row as u32 - 1, column as u32 - 1, value));
            }
        }
        Some(())
    }

    /// Row and words of a string from its header of one word.
    fn string(word: i64) -> Option<(usize, usize)> {
        let (words, row) = (word / 65536 - 1, word % 65536);
        (word > 0 && words > 0).then_some((row as usize, words as usize))
    }
}
