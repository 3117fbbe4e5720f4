//! Eigenfrequencies over positions and the mode table (the paper's table 2), as CSV.

use std::io::Write;
use std::path::Path;

use super::{ExportError, atomic, finite, length};
use crate::modal::{ModeFamilies, ModeTableRow};

/// Writes `eigenfrequencies.csv`: one line a mode and position, by position and rank.
///
/// Columns: `position_m, family, rank, frequency_hz, damping_ratio, reduction_error`, the last of them by how much
/// the reduction of the parts puts the frequency too high, relative to it, as estimated: `errors[position][rank]`,
/// 0 for free motions, empty where there is none. Numbers are written with the fewest digits that give back the same f64.
///
/// # Errors
/// [`ExportError::Shape`] if the modes are not one list a position, [`ExportError::NotFinite`] for
/// NaN and infinities, [`ExportError::Io`] if the file cannot be written.
pub fn write_families(path: &Path, families: &ModeFamilies, errors: &[Vec<Option<f64>>]) -> Result<(), ExportError> {
    length(path, "the modes per position", families.modes.len(), families.positions.len())?;
    let mut text = String::from("position_m,family,rank,frequency_hz,damping_ratio,reduction_error\n");
    for (i, (position, modes)) in families.positions.iter().zip(&families.modes).enumerate() {
        let position = finite(path, *position, || format!("position {i}"))?;
        for (k, mode) in modes.iter().enumerate() {
            let place = |what| move || format!("the {what} of rank {} at {position} m", mode.rank);
            let frequency = finite(path, mode.frequency, place("frequency"))?;
            let damping = finite(path, mode.damping_ratio, place("damping ratio"))?;
            let (family, rank) = (mode.family, mode.rank);
            let error = errors.get(i).and_then(|e| *e.get(k)?).map_or_else(String::new, |e| format!("{e:.2e}"));
            text += &format!("{position},{family},{rank},{frequency},{damping},{error}\n");
        }
    }
    atomic::write_bytes(path, text.as_bytes())
}

/// Writes `mode_table.csv`: one line a family.
///
/// Columns: `family, min_hz, max_hz, difference_percent, position_of_min_m, position_of_max_m,
/// interior_extremum, reduction_error`. A family that is free (0 Hz) has no relative difference: its field is empty.
///
/// # Errors
/// [`ExportError::NotFinite`] for NaN and infinities other than a free family's difference,
/// [`ExportError::Io`] if the file cannot be written.
pub fn write_mode_table(path: &Path, rows: &[ModeTableRow]) -> Result<(), ExportError> {
    atomic::write_atomic(path, |file| {
        writeln!(
            file,
            "family,min_hz,max_hz,difference_percent,position_of_min_m,position_of_max_m,\
             interior_extremum,reduction_error"
        )
        .map_err(atomic::io(path, "write"))?;
        for row in rows {
            let number = |value, what| finite(path, value, || format!("the {what} of family {}", row.family));
            let difference =
                if row.min == 0.0 { String::new() } else { number(row.difference_percent, "difference")?.to_string() };
            writeln!(
                file,
                "{},{},{},{difference},{},{},{},{}",
                row.family,
                number(row.min, "smallest frequency")?,
                number(row.max, "largest frequency")?,
                number(row.position_of_min, "position of the smallest frequency")?,
                number(row.position_of_max, "position of the largest frequency")?,
                row.interior_extremum,
                row.reduction_error.map_or_else(String::new, |e| e.to_string()),
            )
            .map_err(atomic::io(path, "write"))?;
        }
        Ok(())
    })
}
