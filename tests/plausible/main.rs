//! Slips of a machine file that compute, and give wrong numbers: each is warned of, or refused, with the likely slip.

mod accepted;
mod commands;
mod meshes;
mod slips;
mod slips_of_joints;

use std::path::Path;
use stiffmap::machine::read_machine;
use stiffmap::pipeline;
use tempfile::TempDir;

const MACHINE: &str = include_str!("machine.toml");

/// A folder with the small mill, its file passed through some replacements: each text must be there.
#[track_caller]
fn mill(edits: &[(&str, &str)]) -> TempDir {
    let mut text = MACHINE.to_owned();
    for (from, to) in edits {
        assert!(text.contains(from), "{from:?} is not in the machine file");
        text = text.replace(from, to);
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.toml"), text).unwrap();
    for (name, mesh) in meshes::files() {
        std::fs::write(folder.path().join(name), mesh).unwrap();
    }
    folder
}

/// The warnings of a machine, or the one line with which it is refused.
fn told(path: &Path) -> Result<Vec<String>, String> {
    let machine = read_machine(path).map_err(|error| error.to_string())?;
    let meshes = pipeline::read_meshes(&machine).map_err(|error| error.to_string())?;
    Ok(pipeline::plausibility(&machine, &meshes))
}
