//! What the program promises at its limits: streams that nobody reads, any number of threads, memory, a folder served
//! to slow clients, machine files that no machine has, and how soon it ends when asked to.
//!
//! `input` holds a machine of 78 unknowns, a slide on a bed with a tool on it, made for a trial of faults.

mod footprints;
mod fuzz;
mod memory;
mod serving;
mod streams;
mod threads;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn input(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/limits/input").join(name)
}

/// The program.
fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command.env_remove("STIFFMAP_ADAPTER").env_remove("RAYON_NUM_THREADS");
    command
}

/// A cold run of the small machine into a folder.
fn run(machine: &Path, out: &Path) -> Command {
    let mut command = program();
    command.arg("run").arg(machine).args(["--no-cache", "--no-figures", "--out"]).arg(out);
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Files of a folder whose numbers are results, in order, with their bytes; the manifest holds seconds.
fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.filter(|path| path.extension().is_none_or(|e| e != "json")).collect();
    files.sort();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    files.iter().map(|path| (name(path), std::fs::read(path).unwrap())).collect()
}

/// The small machine with parts of its text replaced, beside copies of its meshes.
fn edited(folder: &Path, edits: &[(&str, &str)]) -> PathBuf {
    for part in ["bed.inp", "carriage.inp", "tool.inp"] {
        std::fs::copy(input(part), folder.join(part)).unwrap();
    }
    let mut text = std::fs::read_to_string(input("machine.toml")).unwrap();
    for (from, to) in edits {
        assert!(text.contains(from), "{from:?} stands in the machine file");
        text = text.replace(from, to);
    }
    let file = folder.join("machine.toml");
    std::fs::write(&file, text).unwrap();
    file
}
