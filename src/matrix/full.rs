//! Ansys `.full`, as `/AUX2` or a modal analysis leaves it (symbolic assembly, symmetric, consistent mass).
//!
//! A record is its length in 4-byte words, a word of flags, the data, and the length again. The
//! second record is the header with 64-bit word offsets of the parts. Each row of a matrix is a
//! record of column numbers from 1, its own last, and a record of values.
//!
//! # Source
//! Ansys, Guide to Interfacing with ANSYS, 1.9 (fdfull.inc); its standard header of binary files.

use super::MatrixError;
use super::coordinates::Coordinates;
use super::labels::DofLabel;
use std::path::Path;

/// What a `.full` file holds, without its fixed rows.
#[derive(Clone, Debug)]
pub struct FullFile {
    /// Stiffness.
    pub stiffness: Coordinates,
    /// Mass; `None` where the file has none.
    pub mass: Option<Coordinates>,
    /// One a row.
    pub labels: Vec<DofLabel>,
    /// Directions that the file fixes to ground.
    pub fixed: Vec<DofLabel>,
}

/// Words of the header that are used, from 0.
mod header {
    pub const ASSEMBLY: usize = 0;
    pub const EQUATIONS: usize = 1;
    pub const NODES: usize = 6;
    pub const LUMPED: usize = 10;
    pub const UNSYMMETRIC: usize = 13;
    pub const STIFFNESS: usize = 18;
    pub const CONSTRAINTS: usize = 20;
    pub const MASS: usize = 26;
    pub const DOFS: usize = 35;
    pub const DISTRIBUTED: usize = 62;
}

/// Reads a `.full` file.
///
/// # Errors
/// [`MatrixError::Content`] with the word of the file: not a full file, a kind that is not supported
/// (frontal assembly, lumped mass, unsymmetric, constraint equations, a file of one domain of many),
/// compressed or broken records.
pub fn parse_full(bytes: &[u8], file: &Path) -> Result<FullFile, MatrixError> {
    let mut words = Words { bytes, file, at: 0 };
    let standard = words.integers()?;
    if standard.len() != 100 || standard[0] != 4 {
        return Err(words.refuse(format!("file number {:?}", standard.first()), "4, an Ansys full file"));
    }
    let head = words.integers()?;
    let item = |k: usize| head.get(k).copied().unwrap_or(0);
    let pointer = |k: usize| (item(k) as u32 as u64 | (item(k + 1) as u32 as u64) << 32) as usize;
    let kinds = [
        (header::ASSEMBLY, item(header::ASSEMBLY) < 0, "a file of symbolic assembly (fun04 below 0)"),
        (header::LUMPED, item(header::LUMPED) == 0, "a consistent mass (lumpm 0); run with LUMPM,OFF"),
        (header::UNSYMMETRIC, item(header::UNSYMMETRIC) == 0, "a symmetric matrix (keyuns 0)"),
        (header::CONSTRAINTS, item(header::CONSTRAINTS) == 0, "no constraint equations (ncefull 0)"),
        (
            header::DISTRIBUTED,
            item(header::DISTRIBUTED) == 0,
            "a file of the whole model (distKey 0); combine it first",
        ),
    ];
    for (k, fits, allowed) in kinds {
        if !fits {
            return Err(words.refuse(format!("header item {} = {}", k + 1, item(k)), allowed));
        }
    }
    let directions = words.integers()?;
    let nodes = words.integers()?;
    let n = usize::try_from(item(header::EQUATIONS)).unwrap_or(0);
    if n == 0 || nodes.len() != usize::try_from(item(header::NODES)).unwrap_or(0) {
        return Err(words.refuse(format!("{n} equations, {} nodes", nodes.len()), "as many as the header says"));
    }
    words.at = pointer(header::DOFS);
    let of_node = words.integers()?;
    let signed = words.integers()?;
    if of_node.len() != nodes.len() || signed.len() != n {
        return Err(
            words.refuse(format!("{} nodes, {} rows", of_node.len(), signed.len()), "as many as the header says")
        );
    }
    // A row's direction is an index into the list of directions, negative where it is fixed.
    let mut rows = Vec::with_capacity(n);
    let mut next = signed.iter();
    for (&node, &count) in nodes.iter().zip(&of_node) {
        for _ in 0..count {
            let Some(&sign) = next.next() else { break };
            let code = directions.get((sign.unsigned_abs() as usize).wrapping_sub(1)).copied();
            let direction = code.and_then(|c| usize::try_from(c).ok()).filter(|c| (1..=6).contains(c));
            let (Some(direction), Ok(node)) = (direction, u64::try_from(node)) else {
                return Err(words.refuse(
                    format!("degree of freedom {code:?} of node {node}"),
                    "UX, UY, UZ, ROTX, ROTY, ROTZ (1 to 6)",
                ));
            };
            rows.push((DofLabel::Node { node, direction: direction - 1 }, sign > 0));
        }
    }
    if rows.len() != n {
        return Err(words.refuse(format!("{} degrees of freedom for {n} equations", rows.len()), "one each"));
    }
    let mut place = vec![None; n];
    let (mut labels, mut fixed) = (Vec::new(), Vec::new());
    for (row, (label, free)) in rows.into_iter().enumerate() {
        if free {
            place[row] = Some(labels.len() as u32);
            labels.push(label);
        } else {
            fixed.push(label);
        }
    }
    let mut matrix = |at: usize| -> Result<Option<Coordinates>, MatrixError> {
        if at == 0 {
            return Ok(None);
        }
        words.at = at;
        words.matrix(&place, labels.len()).map(Some)
    };
    let stiffness = matrix(pointer(header::STIFFNESS))?;
    let mass = matrix(pointer(header::MASS))?;
    let stiffness = stiffness.ok_or_else(|| words.refuse("no stiffness", "a stiffness matrix (ptrSTF above 0)"))?;
    Ok(FullFile { stiffness, mass, labels, fixed })
}

struct Words<'a> {
    bytes: &'a [u8],
    file: &'a Path,
    /// Word of the next record.
    at: usize,
}

impl<'a> Words<'a> {
    fn refuse(&self, seen: impl Into<String>, allowed: impl Into<String>) -> MatrixError {
        MatrixError::Content {
            file: self.file.to_path_buf(),
            place: format!("word {}", self.at),
            seen: seen.into(),
            allowed: allowed.into(),
            advice: "export the matrices by *EXPORT as Matrix Market instead, or write the file again",
        }
    }

    fn word(&self, at: usize) -> Option<u32> {
        let from = at.checked_mul(4)?;
        Some(u32::from_le_bytes(self.bytes.get(from..from.checked_add(4)?)?.try_into().ok()?))
    }

    /// Data of the next record, which must be of integers or of doubles.
    fn record(&mut self, integers: bool) -> Result<&'a [u8], MatrixError> {
        let broken = |this: &Self, seen: String| this.refuse(seen, "a record: length, flags, data, length");
        let (length, flags) = (self.word(self.at), self.word(self.at.saturating_add(1)));
        let Some((length, flags)) = length.zip(flags) else {
            return Err(broken(self, "the end of the file".into()));
        };
        if flags != if integers { 1 << 31 } else { 0 } {
            let what = if integers { "integers" } else { "doubles" };
            return Err(self.refuse(
                format!("flags {flags:#x}"),
                format!("a plain record of {what} (no compression, single precision or short form)"),
            ));
        }
        let (from, length) = (4 * (self.at + 2), length as usize);
        let data = self.bytes.get(from..from.saturating_add(4 * length));
        let end = self.word(self.at + 2 + length);
        let (Some(data), true) = (data, end == Some(length as u32)) else {
            return Err(broken(self, format!("a record of {length} words that ends with {end:?}")));
        };
        self.at += length + 3;
        Ok(data)
    }

    fn integers(&mut self) -> Result<Vec<i32>, MatrixError> {
        let data = self.record(true)?;
        Ok(data.chunks_exact(4).map(|w| i32::from_le_bytes(w.try_into().unwrap_or_default())).collect())
    }

    /// One record of column numbers and one of values for each equation.
    fn matrix(&mut self, place: &[Option<u32>], n: usize) -> Result<Coordinates, MatrixError> {
        let mut matrix = Coordinates { file: self.file.to_path_buf(), n, entries: Vec::new(), symmetric: true };
        for row in 0..place.len() {
            let columns = self.integers()?;
            let values = self.record(false)?;
            if values.len() != 8 * columns.len() {
                return Err(self.refuse(
                    format!("{} columns and {} bytes of values", columns.len(), values.len()),
                    "8 bytes a column",
                ));
            }
            for (&column, value) in columns.iter().zip(values.chunks_exact(8)) {
                let value = f64::from_le_bytes(value.try_into().unwrap_or_default());
                let column = usize::try_from(column).ok().and_then(|c| c.checked_sub(1)).filter(|c| *c < place.len());
                let (Some(column), true) = (column, value.is_finite()) else {
                    return Err(self.refuse(
                        format!("value {value} in row {}", row + 1),
                        "a finite number and a column of the matrix",
                    ));
                };
                if let (Some(i), Some(j), true) = (place[row], place[column], value != 0.0) {
                    matrix.entries.push((i, j, value));
                }
            }
        }
        Ok(matrix)
    }
}
