//! `stiffmap init`: the bundled mill as a start.

use super::{UsageError, streams};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use stiffmap::export::atomic::write_bytes;
use stiffmap::machine::bundled_vertical_mill;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder to write into; it is made if it does not exist
    dir: PathBuf,
}

/// Writes the bundled mill; a file that is there already is never overwritten.
pub fn init(arguments: &Arguments) -> Result<()> {
    let dir = &arguments.dir;
    for (name, _) in bundled_vertical_mill() {
        if dir.join(name).exists() {
            return Err(UsageError(format!("{} exists; choose an empty folder", dir.join(name).display())).into());
        }
    }
    std::fs::create_dir_all(dir).map_err(|error| UsageError(format!("{}: {error}", dir.display())))?;
    // The machine file last: a folder without it is no machine.
    for (name, content) in bundled_vertical_mill().iter().rev() {
        write_bytes(&dir.join(name), content.as_bytes())?;
    }
    streams::say(&format!(
        "wrote the vertical mill to {}; run it with `stiffmap run {}`",
        dir.display(),
        dir.display()
    ));
    Ok(())
}
