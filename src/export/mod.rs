//! Results as files, one file a format.
//!
//! Every exporter takes a result and a path and returns once the file stands under that path,
//! whole: it is written aside and renamed ([`atomic`]). Nothing here computes physics. Numbers
//! that are not finite are refused with their place, since a reader downstream would take them
//! for results.
//!
//! | file | from | by |
//! |---|---|---|
//! | `eigenfrequencies.csv` | [`ModeFamilies`](crate::modal::ModeFamilies) | [`eigenfrequencies::write_families`] |
//! | `mode_table.csv` | [`ModeTableRow`](crate::modal::ModeTableRow) | [`eigenfrequencies::write_mode_table`] |
//! | `compliance.mat` | [`ComplianceMap`](crate::frf::ComplianceMap) | [`mat::write_compliance`] |
//! | `compliance.npy` | the tiles of a map | [`stream::MapStream`] |
//! | `state_space.mat` | [`Database`](crate::state_space::Database) | [`mat::write_database`] |
//! | `time_history.csv`, `.mat` | [`History`](crate::response::History) | [`history::write_csv`], [`history::write_mat`] |
//! | `surface_<out><in>.csv` | one response of a map | [`surface::write_surface`], [`stream::MapStream`] |
//! | `surface_<out><in>.vts` | one response of a map | [`vts::write_surface`] |
//! | `mode_shapes_<axis>_<mm>_mm.vtu` | shapes at a position | [`vtu::write_mode_shapes`] |
//! | `designs.parquet` | [`Row`](crate::sweep::table::Row)s | `parquet::write_designs` (feature `parquet`) |
//! | `manifest.json` | [`manifest::Manifest`] | [`manifest::Manifest::write`] |

pub mod atomic;
pub(crate) mod base64;
pub mod deck;
mod digits;
pub mod eigenfrequencies;
pub mod history;
pub mod manifest;
pub mod mat;
pub mod mat5;
pub mod matrix_market;
pub mod npy;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod response;
pub mod stream;
pub mod surface;
pub mod vts;
pub mod vtu;

use std::path::{Path, PathBuf};

/// Why a file was not written. Under its name there is then what was there before.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// What was tried, as a verb.
        action: &'static str,
        /// The reason given.
        source: std::io::Error,
    },
    /// A number is NaN or infinite.
    #[error("{}: {what} is {value}; only finite numbers are written", path.display())]
    NotFinite {
        /// The file that was to be written.
        path: PathBuf,
        /// Which number, with its place.
        what: String,
        /// The value seen.
        value: f64,
    },
    /// Parts of the input do not fit together.
    #[error("{}: {what} has {seen} entries, expected {expected}", path.display())]
    Shape {
        /// The file that was to be written.
        path: PathBuf,
        /// Which array.
        what: String,
        /// Entries seen.
        seen: usize,
        /// Entries that the rest of the input asks for.
        expected: usize,
    },
    /// A variable is larger than a level 5 MAT-file can hold.
    #[error(
        "{}: variable `{variable}` takes {bytes} bytes, a level 5 MAT-file holds at most {limit} \
         a variable; ask for fewer positions or frequencies",
        path.display()
    )]
    TooLarge {
        /// The file that was to be written.
        path: PathBuf,
        /// Name of the variable.
        variable: String,
        /// Its size, bytes.
        bytes: u64,
        /// The largest size allowed, bytes.
        limit: u64,
    },
    /// A value has no form in the file's format.
    #[error("{}: {reason}", path.display())]
    Format {
        /// The file that was to be written.
        path: PathBuf,
        /// What could not be expressed.
        reason: String,
    },
}

/// Refuses a number that is not finite; `what` is called only then.
fn finite(path: &Path, value: f64, what: impl FnOnce() -> String) -> Result<f64, ExportError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(ExportError::NotFinite { path: path.into(), what: what(), value })
}

/// Refuses an array whose length is not what the rest of the input asks for.
fn length(path: &Path, what: &str, seen: usize, expected: usize) -> Result<(), ExportError> {
    if seen == expected {
        return Ok(());
    }
    Err(ExportError::Shape { path: path.into(), what: what.into(), seen, expected })
}
