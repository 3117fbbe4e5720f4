//! Why a sweep's table could not be begun, continued or joined.

use std::path::{Path, PathBuf};

/// Why a table could not be begun, continued or joined.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried, as a verb.
        action: &'static str,
        /// The reason given.
        source: std::io::Error,
    },
    /// Another process writes the same table.
    #[error("{}: another process writes this table; wait for it, or choose another folder with --out", path.display())]
    InUse {
        /// The table.
        path: PathBuf,
    },
    /// A table that is not finished is in the way.
    #[error("{}: an unfinished sweep is there; continue it with --resume, begin anew with --overwrite, or choose another folder with --out", path.display())]
    Unfinished {
        /// The table.
        path: PathBuf,
    },
    /// All rows are there, but no manifest.
    #[error("{}: no manifest.json is there, so the sweep that wrote the folder did not finish; continue it with --resume", path.display())]
    NoEnd {
        /// The folder.
        path: PathBuf,
    },
    /// A complete table of something else is in the way.
    #[error("{}: a complete table of other inputs is there: {difference}; replace it with --overwrite, or choose another folder with --out", path.display())]
    Other {
        /// The table.
        path: PathBuf,
        /// What is not as it is here.
        difference: String,
    },
    /// A table without the record that says what it belongs to.
    #[error("{}: there is no sweep.json beside it, so nobody knows what it belongs to; begin anew with --overwrite, or choose another folder with --out", path.display())]
    NoRecord {
        /// The table.
        path: PathBuf,
    },
    /// The table belongs to other inputs.
    #[error("{}: {what} is {seen} there and {expected} here; nothing of it can be used: restore what was changed, or choose another folder with --out", path.display())]
    Differs {
        /// The record beside the table.
        path: PathBuf,
        /// What differs, such as the hash of an input.
        what: String,
        /// The value in the record.
        seen: String,
        /// The value of this sweep.
        expected: String,
    },
    /// A row before the last is not what this sweep writes.
    #[error("{}:{line}: the row is damaged: {reason}; allowed: rows as the sweep wrote them; begin anew with --overwrite", path.display())]
    Damaged {
        /// The table.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A record that cannot be read.
    #[error("{}: not the record of a sweep: {reason}; name the output folders of sweeps", path.display())]
    Record {
        /// The record.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Designs that no shard holds.
    #[error("designs {from} to {to} are in none of the folders: {why}")]
    Gap {
        /// First design missing.
        from: u64,
        /// Last design missing.
        to: u64,
        /// Which shard lacks them, and what to do.
        why: String,
    },
    /// Designs that two shards hold.
    #[error("designs {from} to {to} are in {} and in {}; name each shard once", first.display(), second.display())]
    Overlap {
        /// First design held twice.
        from: u64,
        /// Last design held twice.
        to: u64,
        /// One folder.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// The disk has too little room.
    #[error("{}: the sweep needs {}, of which {} for the table of {rows} designs and {} for {maps} maps, but {} are free; take fewer designs or maps, fewer metrics over \"each\" position, or another disk with --out", path.display(), bytes(*table + *of_maps), bytes(*table), bytes(*of_maps), bytes(*free))]
    NoRoom {
        /// The output folder.
        path: PathBuf,
        /// Bytes of the table.
        table: f64,
        /// Rows of the table.
        rows: u64,
        /// Bytes of the maps.
        of_maps: f64,
        /// Number of maps.
        maps: usize,
        /// Bytes that are free.
        free: f64,
    },
}

impl TableError {
    /// Whether the input is to blame and not the machine that runs the sweep.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}

/// Turns an I/O error into one that names the file and what was tried.
pub(super) fn io(path: &Path, action: &'static str) -> impl Fn(std::io::Error) -> TableError {
    move |source| TableError::Io { path: path.to_path_buf(), action, source }
}

/// A number of bytes in words.
fn bytes(count: f64) -> String {
    let units = ["bytes", "kB", "MB", "GB", "TB", "PB", "EB"];
    let power = if count < 1.0 { 0 } else { ((count.log10() / 3.0).floor() as usize).min(units.len() - 1) };
    let value = count / 1000_f64.powi(power as i32);
    let decimals = usize::from(power > 0);
    format!("{value:.decimals$} {}", units[power])
}
