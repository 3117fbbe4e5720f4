//! How much disk a sweep takes, told before it starts.

use super::study::Study;
use super::table_error::{TableError, io};
use std::path::Path;

/// Bytes of a number with its comma: 17 digits, sign, point, exponent.
const NUMBER: f64 = 22.0;
/// Bytes for record, pictures and manifest.
const REST: f64 = 16e6;

/// Bytes of the table of `rows` designs, at most but for long error texts.
pub fn table_bytes(study: &Study, rows: u64) -> f64 {
    let numbers = study.variables.len() + study.result_columns().len() + 1;
    rows as f64 * (numbers as f64 * NUMBER + 8.0)
}

/// Bytes of one design's whole map and its files.
pub fn map_bytes(study: &Study) -> f64 {
    let machine = &study.machine;
    let rows = |wanted: fn(&crate::machine::Port) -> bool| {
        machine.ports.iter().filter(|p| wanted(p)).map(|p| p.directions.len()).sum::<usize>() as f64
    };
    let pairs = study.positions.len() as f64 * machine.analysis.frequencies.len() as f64;
    // Two doubles a value, and a line of text for each direct response.
    pairs * (16.0 * rows(|p| p.output) * rows(|p| p.input))
}

/// Refuses a sweep that the disk of a folder, which need not exist yet, cannot hold.
///
/// # Errors
/// [`TableError::NoRoom`] with the figures, [`TableError::Io`] if the free room cannot be asked for.
pub fn check_room(study: &Study, rows: u64, maps: usize, folder: &Path) -> Result<(), TableError> {
    let exists = folder.ancestors().find(|f| f.exists()).unwrap_or(Path::new("."));
    let free = fs4::available_space(exists).map_err(io(exists, "ask for the free room of"))? as f64;
    fits(study, rows, maps, folder, free)
}

/// As [`check_room`] with the free bytes given.
///
/// # Errors
/// [`TableError::NoRoom`].
pub fn fits(study: &Study, rows: u64, maps: usize, folder: &Path, free: f64) -> Result<(), TableError> {
    let (table, of_maps) = (table_bytes(study, rows), maps as f64 * map_bytes(study));
    if table + of_maps + REST <= free {
        return Ok(());
    }
    Err(TableError::NoRoom { path: folder.to_path_buf(), table, rows, of_maps, maps, free })
}
