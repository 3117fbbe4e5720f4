//! What is wrong with a machine file.

use super::quantity::QuantityError;
use std::fmt;
use std::path::PathBuf;

/// A place in the machine file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The machine file.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: usize,
    /// Key path, such as `joints[2] "guide B".stiffness.x` (joints are counted from 1); empty for the
    /// file as a whole.
    pub key: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)?;
        if self.key.is_empty() { Ok(()) } else { write!(f, ": {}", self.key) }
    }
}

/// Why a machine file is refused.
#[derive(Debug, thiserror::Error)]
pub enum MachineError {
    /// The file is missing, is not text, or may not be read.
    #[error("{}: cannot read the machine file: {source}; {advice}", file.display())]
    Unreadable {
        /// The machine file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
        /// What to do.
        advice: &'static str,
    },
    /// The file is not TOML.
    #[error("{}:{line}:{column}: not valid TOML: {message}", file.display())]
    Syntax {
        /// The machine file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Column in characters, counted from 1.
        column: usize,
        /// What the parser said.
        message: String,
    },
    /// A key that means nothing here.
    #[error("{place}: unknown key `{key}`{}; allowed here: {}", did_you_mean(nearest), allowed.join(", "))]
    UnknownKey {
        /// Where.
        place: Box<Place>,
        /// The key seen.
        key: String,
        /// The allowed key that was probably meant.
        nearest: Option<String>,
        /// Every key allowed here.
        allowed: Vec<&'static str>,
    },
    /// A key that must be there is not.
    #[error("{place}: the key `{key}` is missing{}; add {expected}", found_instead(found))]
    MissingKey {
        /// The table that lacks it.
        place: Box<Place>,
        /// The key.
        key: &'static str,
        /// An unknown key that may be a misspelling of it.
        found: Option<String>,
        /// What to write.
        expected: &'static str,
    },
    /// A value that is not allowed.
    #[error("{place}: found {seen}; allowed: {allowed}; {advice}")]
    NotAllowed {
        /// Where.
        place: Box<Place>,
        /// The value seen.
        seen: String,
        /// What is allowed.
        allowed: String,
        /// What to do.
        advice: String,
    },
    /// A number with a unit that cannot be read, or of the wrong dimension.
    #[error("{place}: {source}")]
    Quantity {
        /// Where.
        place: Box<Place>,
        /// What is wrong with it.
        source: QuantityError,
    },
    /// A reference to something that does not exist.
    #[error("{place}: no {kind} is called {name:?}{}; existing: {}", did_you_mean(nearest), listed(existing))]
    UnknownName {
        /// Where.
        place: Box<Place>,
        /// What was looked for, such as `part`.
        kind: String,
        /// The name seen.
        name: String,
        /// The existing name that was probably meant.
        nearest: Option<String>,
        /// Every existing name.
        existing: Vec<String>,
    },
    /// A name given twice.
    #[error("{place}: {name:?} is given twice; allowed: each {kind} once; rename or remove one of them")]
    Duplicate {
        /// Where the second one stands.
        place: Box<Place>,
        /// What it is, such as `joint`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A mesh file that does not exist.
    #[error("{place}: the mesh file {} does not exist{}; allowed: a file named relative to the machine file's folder; correct the name or put the file there", path.display(), did_you_mean(nearest))]
    MissingMesh {
        /// Where.
        place: Box<Place>,
        /// The path looked for.
        path: PathBuf,
        /// A file of that folder with a similar name.
        nearest: Option<String>,
    },
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!(" (did you mean `{name}`?)"))
}

fn found_instead(found: &Option<String>) -> String {
    found.as_ref().map_or_else(String::new, |key| format!(" (is `{key}` a misspelling of it?)"))
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
