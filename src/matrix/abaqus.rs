//! Abaqus matrix text: `*MATRIX OUTPUT, FORMAT=MATRIX INPUT | LABELS | COORDINATE`.
//!
//! The first two give `row node, direction, column node, direction, value`, the third `row, column,
//! value`. A node label that is not positive is one of Abaqus's internal nodes and becomes a modal
//! coordinate. Abaqus holds a fixed direction by a diagonal of 1e36: such rows are taken out.

use super::MatrixError;
use super::coordinates::{Coordinates, MOST_ROWS};
use super::labels::DofLabel;
use super::text::{Lines, fields, number};
use std::collections::HashMap;
use std::path::Path;

/// A stiffness on the diagonal from which on a row is fixed to ground.
const FIXED: f64 = 1e35;

/// The matrix of an Abaqus text file; its labels too, unless the file is in coordinate format.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_abaqus(bytes: &[u8], file: &Path) -> Result<(Coordinates, Option<Vec<DofLabel>>), MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let mut matrix = Coordinates { file: file.to_path_buf(), ..Coordinates::default() };
    let (mut labels, mut index): (Vec<DofLabel>, HashMap<DofLabel, u32>) = Default::default();
    let (mut factor, mut keywords) = (1.0, 0);
    let mut labelled = None;
    while let Some(line) = lines.next()? {
        if line.starts_with("**") {
            continue;
        }
        if line.starts_with('*') {
            keywords += 1;
            if keywords > 1 {
                return Err(lines.refuse(line, "one *MATRIX INPUT a file, with its data in the same file"));
            }
            factor = keyword(&lines, line)?;
            continue;
        }
        let parts: Vec<&str> = fields(line).collect();
        let with_labels = *labelled.get_or_insert(parts.len() == 5);
        let entry = if with_labels { &[0, 2][..] } else { &[][..] };
        let wanted = if with_labels { "node, direction, node, direction, value" } else { "row, column, value" };
        let value = parts.last().and_then(|v| number(v)).filter(|_| parts.len() == if with_labels { 5 } else { 3 });
        let value = value.ok_or_else(|| lines.refuse(line, wanted))?;
        let mut place = [0; 2];
        for (slot, &at) in place.iter_mut().zip(entry) {
            let label = label(parts[at], parts[at + 1]).ok_or_else(|| {
                lines.refuse(
                    line,
                    "a node label and a direction from 1 to 6 (other degrees of freedom are not mechanical)",
                )
            })?;
            *slot = *index.entry(label).or_insert_with(|| {
                labels.push(label);
                labels.len() as u32 - 1
            });
        }
        if !with_labels {
            for (slot, part) in place.iter_mut().zip(&parts) {
                let row = part.parse::<usize>().ok().filter(|i| (1..=MOST_ROWS).contains(i));
                *slot = row.ok_or_else(|| lines.refuse(line, wanted))? as u32 - 1;
            }
        }
        matrix.n = matrix.n.max(place[0].max(place[1]) as usize + 1);
        matrix.entries.push((place[0], place[1], factor * value));
    }
    if matrix.entries.is_empty() {
        return Err(lines.refuse("no entry", "at least one"));
    }
    Ok((matrix, labelled.unwrap_or(false).then_some(labels)))
}

/// Whether a row of a stiffness is fixed to ground by its diagonal.
pub(super) fn is_fixed(diagonal: f64) -> bool {
    diagonal >= FIXED
}

/// The scale factor of `*MATRIX INPUT`.
fn keyword(lines: &Lines<'_>, line: &str) -> Result<f64, MatrixError> {
    const ALLOWED: &str = "*MATRIX INPUT with NAME, TYPE=SYMMETRIC or SCALE FACTOR";
    let mut parts = line.split(',').map(str::trim);
    if !parts.next().is_some_and(|k| k.eq_ignore_ascii_case("*MATRIX INPUT")) {
        return Err(lines.refuse(line, ALLOWED));
    }
    let mut factor = 1.0;
    for part in parts.filter(|p| !p.is_empty()) {
        let (key, value) = part.split_once('=').ok_or_else(|| lines.refuse(line, ALLOWED))?;
        match key.trim().to_ascii_uppercase().as_str() {
            "NAME" => {}
            "TYPE" if value.trim().eq_ignore_ascii_case("SYMMETRIC") => {}
            "SCALE FACTOR" | "SCALEFACTOR" => factor = number(value).ok_or_else(|| lines.refuse(line, ALLOWED))?,
            _ => return Err(lines.refuse(line, ALLOWED)),
        }
    }
    Ok(factor)
}

fn label(node: &str, direction: &str) -> Option<DofLabel> {
    let node: i64 = node.parse().ok()?;
    let direction = direction.parse::<usize>().ok()?;
    if node <= 0 {
        return Some(DofLabel::Modal(node.unsigned_abs().checked_mul(1000)?.checked_add(direction as u64)?));
    }
    (1..=6).contains(&direction).then(|| DofLabel::Node { node: node as u64, direction: direction - 1 })
}
