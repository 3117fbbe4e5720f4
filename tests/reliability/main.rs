//! What docs/reliability.md promises: a result is of one machine, a folder of one job, a file whole or known as not.
//!
//! The machine is a block of steel on a soft guide, whose lowest frequency is sqrt(k / m) / 2 pi: so each result shows by
//! itself which mass it was made from. 200 kills and edits at random moments are in `benches/reliability`.

mod folders;
mod identity;
#[cfg(unix)]
mod integrity;
#[cfg(unix)]
mod outputs;
#[path = "../support/mod.rs"]
mod support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Two parts whose mesh files have one name, a guide and a screw.
const MACHINE: &str = r#"
name = "block"

[axes.z]
direction = [0, 0, 1]
travel = ["0 mm", "200 mm"]
step = "200 mm"
moves = ["block"]

[parts.bed]
mesh = "bed/part.inp"
clamped = ["YMIN"]
interfaces = { rail = { nodes = "YMAX" }, mount = { nodes = "ZMAX" } }

[parts.block]
mesh = "block/part.inp"
interfaces = { shoe = { nodes = "YMIN" }, nut = { nodes = "ZMAX" }, top = { nodes = "YMAX" } }

[[joints]]
name = "guide"
type = "linear-guide"
rail = "bed.rail"
carriage = "block.shoe"
footprint = "120 mm"
stiffness = { x = "1 N/um", y = "1000 N/um", rx = "1e9 N m/rad", ry = "1e9 N m/rad", rz = "1e9 N m/rad" }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["bed.mount", "block.nut"]
axis = "z"
young = "210 GPa"
diameter = "16 mm"

[ports.tool]
interface = "block.top"
directions = ["x", "y", "z"]

[analysis]
component = { modes = 6 }
modes = 2
frequencies = { from = "0 Hz", to = "300 Hz", step = "5 Hz" }
damping = { ratio = 0.02 }
"#;

/// A study of it.
const STUDY: &str = r#"
name = "block study"
machine = "machine.toml"

[variables.guide]
path = "joints.guide.stiffness.y"
range = ["500 N/um", "2000 N/um"]

[sampling]
method = "latin-hypercube"
designs = 12
seed = 3

[metrics.stiffness]
kind = "dynamic-stiffness"
directions = ["x", "z"]

[objectives]
stiffness_x = "maximise"

[optimise]
evaluations = 12
"#;

/// Density of steel, kg/m^3, and volume of the block, m^3.
const DENSITY: f64 = 7850.0;
const VOLUME: f64 = 0.12 * 0.1 * 0.12;

/// The lowest frequency of the block of a density, Hz.
fn truth(density: f64) -> f64 {
    (1e6 / (density * VOLUME)).sqrt() / std::f64::consts::TAU
}

/// What a mesh file says of its material, which stands in another file.
const STEEL: &str = "*INCLUDE, INPUT=more/steel.inp\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n";

fn material(density: f64) -> String {
    format!("*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, 0.3\n*DENSITY\n{density}\n")
}

/// The machine, its study and a cache in a folder of their own.
struct Room(TempDir);

impl Room {
    fn new() -> Room {
        let room = Room(tempfile::tempdir().unwrap());
        let bed = support::box_mesh([-0.1, -0.1, -0.2], [0.2, 0.1, 0.6], [1, 1, 3]);
        let block = support::box_mesh([-0.06, 0.0, -0.06], [0.12, 0.1, 0.12], [1, 1, 1]);
        room.write("machine.toml", MACHINE);
        room.write("study.toml", STUDY);
        for (part, mesh) in [("bed", bed), ("block", block)] {
            room.write(&format!("{part}/part.inp"), &support::inp(&mesh, STEEL));
            room.write(&format!("{part}/more/steel.inp"), &material(DENSITY));
        }
        room
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
        command.env("STIFFMAP_CACHE", self.path("cache")).env_remove("STIFFMAP_ADAPTER");
        command.current_dir(self.0.path()).args(words);
        command
    }

    fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    /// Runs a command that must succeed.
    #[track_caller]
    fn done(&self, words: &[&str]) {
        let output = self.run(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", said(&output));
    }

    /// Runs a command that must be refused as bad input with all these words.
    #[track_caller]
    fn refused(&self, words: &[&str], fragments: &[&str]) {
        let output = self.run(words);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(fragments.iter().all(|f| said.contains(f)), "{words:?}: {fragments:?} are not in: {said}");
    }

    fn manifest(&self, out: &str) -> Value {
        serde_json::from_slice(&self.read(&format!("{out}/manifest.json"))).unwrap()
    }

    /// The lowest frequency of a result, Hz.
    fn frequency(&self, out: &str) -> f64 {
        let text = String::from_utf8(self.read(&format!("{out}/eigenfrequencies.csv"))).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let at = reader.headers().unwrap().iter().position(|h| h == "frequency_hz").unwrap();
        reader.records().next().unwrap().unwrap()[at].parse().unwrap()
    }

    fn hash(&self, name: &str) -> String {
        blake3::hash(&self.read(name)).to_hex().to_string()
    }

    /// All files below a folder, relative to it, in order.
    fn files(&self, folder: &str) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, found: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    walk(&path, root, found);
                } else {
                    found.push(path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/"));
                }
            }
        }
        let mut found = Vec::new();
        walk(&self.path(folder), &self.path(folder), &mut found);
        found.sort();
        found
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Whether a frequency is that of a density; the block is so stiff that its elasticity changes less than this.
fn is(frequency: f64, density: f64) -> bool {
    (frequency / truth(density) - 1.0).abs() < 2e-3
}

/// Words for a quick run.
const QUICK: [&str; 5] = ["run", ".", "--no-figures", "--frequencies", "0:60:5"];

#[test]
fn the_block_has_the_frequency_of_its_mass() {
    let room = Room::new();
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    let frequency = room.frequency("out");
    assert!(is(frequency, DENSITY), "{frequency} Hz, closed form {} Hz", truth(DENSITY));
    assert!(!is(frequency, 1.01 * DENSITY), "control: one per cent more mass would be noticed");
}
