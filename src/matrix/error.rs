//! What is wrong with a part's matrices.

use std::path::PathBuf;

/// Why matrices are refused.
#[derive(Debug, thiserror::Error)]
pub enum MatrixError {
    /// A file is missing or may not be read.
    #[error("{}: cannot read the file: {source}; correct the name or the permissions", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No reader for this extension.
    #[error(
        "{}: unknown matrix format {extension:?}; allowed: mtx (Matrix Market, Abaqus matrix text), sti and mas (CalculiX), op4 (Nastran), full (Ansys)",
        file.display()
    )]
    UnknownFormat {
        /// The file.
        file: PathBuf,
        /// Its extension in lower case.
        extension: String,
    },
    /// A place in a file that cannot be read or is not allowed.
    #[error("{}, {place}: found {seen}; allowed: {allowed}; {advice}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// Line, byte or row.
        place: String,
        /// What was seen, shortened.
        seen: String,
        /// What is allowed.
        allowed: String,
        /// What to do.
        advice: &'static str,
    },
    /// A matrix that is not in the file.
    #[error("{}: no {what} in this file; it has {found}; {advice}", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// What was looked for.
        what: String,
        /// What there is instead.
        found: String,
        /// What to do.
        advice: &'static str,
    },
    /// Rows, labels or nodes that do not fit together.
    #[error("{}: the table of degrees of freedom does not fit: {reason}", file.display())]
    Dofs {
        /// The file.
        file: PathBuf,
        /// What was found and what was expected.
        reason: String,
    },
    /// A matrix that differs from its transpose.
    #[error(
        "{}: the {what} matrix is not symmetric: {value:.9e} at {place}, but {mirrored:.9e} at the mirrored place; they may differ by {tolerance:.1e} (1e-8 of the diagonal); gyroscopic and follower terms cannot be used",
        file.display()
    )]
    Unsymmetric {
        /// The file.
        file: PathBuf,
        /// Stiffness or mass.
        what: &'static str,
        /// Row and column.
        place: String,
        /// The value there.
        value: f64,
        /// The value at the mirrored place.
        mirrored: f64,
        /// The largest difference allowed.
        tolerance: f64,
    },
    /// An interface that cannot be formed.
    #[error("part \"{part}\", interface \"{interface}\": {reason}")]
    Interface {
        /// Part.
        part: String,
        /// Interface.
        interface: String,
        /// What was found and what to do.
        reason: String,
    },
}
