//! What the program promises at its limits: streams that nobody reads, any number of threads, memory, a folder served
//! to slow clients, machine files that no machine has, and how soon it ends when asked to.
//!
//! `input` holds a machine of 78 unknowns, a slide on a bed with a tool on it, made for a trial of faults.

mod estimates;
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

/// Files of a folder, and of those in it but a cache, whose numbers are results, in order, with their bytes; the
/// manifest holds seconds.
fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut folders = vec![folder.to_path_buf()];
    let mut found = Vec::new();
    while let Some(here) = folders.pop() {
        for path in std::fs::read_dir(&here).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
            if path.is_dir() && name != "cache" {
                folders.push(path);
            } else if path.is_file() && path.extension().is_none_or(|e| e != "json") {
                found.push((name, std::fs::read(path).unwrap()));
            }
        }
    }
    found.sort();
    found
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

/// The small machine beside a study of its guide, in a folder of their own; returns the study.
fn study(folder: &Path, positions: &str, families: bool) -> PathBuf {
    edited(folder, &[]);
    let file = folder.join("study.toml");
    let frequency = if families { "[metrics.first]\nkind = \"eigenfrequency\"\nfamilies = [1]\n" } else { "" };
    let text = format!(
        "name = \"guides\"\nmachine = \"machine.toml\"\npositions = {positions}\n\
         [variables.guide]\npath = \"joints.guide.stiffness.y\"\nrange = [\"60 N/um\", \"120 N/um\"]\n\
         [sampling]\nmethod = \"latin-hypercube\"\ndesigns = 9\nseed = 3\n\
         [metrics.dyn]\nkind = \"dynamic-stiffness\"\ndirections = [\"tool.x\"]\n{frequency}\
         [objectives]\n\"dyn_tool.x\" = \"maximise\"\n[optimise]\nobjective = \"dyn_tool.x\"\nevaluations = 12\n"
    );
    std::fs::write(&file, text).unwrap();
    file
}
