//! What is wrong with a study file.

use crate::files::InputError;
use crate::machine::{MachineError, Place};
use std::path::PathBuf;

/// Why a study is refused.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A key, value or name of the study or its machine file is wrong.
    #[error(transparent)]
    File(#[from] MachineError),
    /// A file was edited between two readings.
    #[error(transparent)]
    Inputs(#[from] InputError),
    /// The study file is missing, is not text, or may not be read.
    #[error("{}: cannot read the study file: {source}; name a study file in UTF-8 (`stiffmap init DIR` writes two)", file.display())]
    Unreadable {
        /// The study file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A path that names nothing in the machine.
    #[error("{place}: the path {path:?} names nothing in the machine{}; allowed here: {}", meant(nearest), existing.join(", "))]
    UnknownPath {
        /// Where.
        place: Box<Place>,
        /// The path.
        path: String,
        /// The path that was probably meant.
        nearest: Option<String>,
        /// What exists in place of its first wrong step.
        existing: Vec<String>,
    },
    /// A place that two variables change, or one twice.
    #[error(
        "{place}: {path:?} is varied twice, already by the variable {by:?}; allowed: each place by one variable; remove it here or there"
    )]
    VariedTwice {
        /// Where.
        place: Box<Place>,
        /// The path.
        path: String,
        /// The variable that has it already.
        by: String,
    },
}

fn meant(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |path| format!(" (did you mean {path:?}?)"))
}
