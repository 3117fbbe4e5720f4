//! The report page: one HTML file that shows a run and answers "what if".
//!
//! The page holds the run's modal database and evaluates maps itself: by WebGPU with the text of
//! `shaders/`, in f64 JavaScript where there is no WebGPU. When a joint changes it solves the machine
//! anew in few coordinates ([`Around`](crate::coupling::Around)). `docs/report.md` says how, and how accurately. Pictures and
//! surfaces are drawn by three.js, curves by uPlot, both embedded (`assets/web`).

mod accuracy;
pub mod arrays;
mod database;
mod header;
mod local;
mod memory;
mod pack;
mod page;
mod shapes;
mod what_if;

pub use accuracy::Accuracy;
pub use database::{Database, DatabaseInput};
pub use header::{CoupledEntry, Group, Header, SpringEntry, TableEntry, VeeringEntry};
pub use local::PAGE;
pub use memory::admit_page;
pub use page::{DATABASE_FILE, PAGE_FILE, page, write_page};
pub use shapes::PartSkin;

use crate::coupling::CouplingError;
use crate::export::ExportError;
use crate::linalg::LinalgError;
use crate::modal::ModalError;
use std::path::PathBuf;

/// Why a report was not made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The modes of a position could not be had again.
    #[error(transparent)]
    Modal(#[from] ModalError),
    /// A position could not be coupled.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// The space of the mode shapes could not be formed.
    #[error("the space of the mode shapes: {0}")]
    Shapes(LinalgError),
    /// A file of the result is not there.
    #[error("{}: {source}; `stiffmap run` writes it", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The reason given.
        source: std::io::Error,
    },
    /// A file is no modal database.
    #[error("{}: no modal database: {reason}", path.display())]
    NoDatabase {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// The file could not be written.
    #[error(transparent)]
    Export(#[from] ExportError),
}
