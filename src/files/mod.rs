//! Files of the user and of the program: read once and recorded, written whole, one job a folder.
//!
//! | what | by |
//! |---|---|
//! | every byte that a result depends on is read once, hashed as it is parsed, and recorded | [`Inputs`] |
//! | a file that is written stands aside until it is complete | [`aside`] |
//! | a result folder belongs to one job at a time, and says whether its result is whole | [`ResultFolder`] |
//!
//! `docs/reliability.md` says what is promised and what is not.

pub mod aside;
mod folder;
mod holder;
mod inputs;

pub use folder::{FolderError, MANIFEST, ResultFolder, SWEEP_RECORD};
pub use inputs::{InputError, InputFile, Inputs};
