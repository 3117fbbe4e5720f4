//! Studies, samples, tables: what a sweep is made of, and the command as its user meets it.

mod agreement;
mod command;
mod dask;
mod free_machine;
mod goals;
mod interrupted;
mod optimum;
mod parquet;
mod ports;
mod refusals;
mod routes;
mod samples;
mod shards;
mod slopes;
#[path = "../support/mod.rs"]
mod support;
mod values;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use stiffmap::sweep::{Study, StudyError, read_study};
use tempfile::TempDir;

/// A bed with a rail and a carriage on it, quick to reduce and couple.
const MACHINE: &str = r#"
name = "slide"

[axes.z]
direction = [0, 0, 1]
travel = ["300 mm", "-300 mm"]
step = "150 mm"
moves = ["carriage"]

[parts.bed]
mesh = "bed.inp"
clamped = ["YMIN"]
interfaces = { rail = { nodes = "YMAX" }, mount = { nodes = "ZMAX" } }

[parts.carriage]
mesh = "carriage.inp"
material = { young = "210 GPa", poisson = 0.3, density = "7850 kg/m3" }
interfaces = { shoe = { nodes = "YMIN" }, nut = { nodes = "ZMAX" }, top = { nodes = "YMAX" } }

[[joints]]
name = "guide A"
type = "linear-guide"
rail = "bed.rail"
carriage = "carriage.shoe"
footprint = "120 mm"
stiffness = { x = "50 N/um", y = "90 N/um", rx = "2e5 N m/rad", ry = "3e5 N m/rad", rz = "1e5 N m/rad" }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["bed.mount", "carriage.nut"]
axis = "z"
young = "210 GPa"
diameter = "16 mm"

[ports.tool]
interface = "carriage.top"
directions = ["x", "y", "z"]

[analysis]
component = { modes = 12 }
modes = 6
frequencies = { from = "0 Hz", to = "1500 Hz", step = "10 Hz" }
damping = { ratio = 0.02 }
"#;

/// A study of it; the tests change a line.
const STUDY: &str = r#"
name = "slide study"
machine = "machine.toml"

[variables.guide_x]
path = "joints.guide *.stiffness.x"
range = ["25 N/um", "100 N/um"]
scale = "log"

[variables.diameter]
path = "joints.screw.diameter"
range = ["10 mm", "25 mm"]

[sampling]
method = "latin-hypercube"
designs = 24
seed = 7

[metrics.stiffness]
kind = "dynamic-stiffness"
directions = ["x", "z"]

[cost]
unit = "EUR"
constant = 10
[cost.terms]
guide_x = { per = "1 N/um", costs = 2 }

[bounds]
stiffness_x = { min = "0.1 N/um" }

[objectives]
stiffness_x = "maximise"
cost = "minimise"
"#;

/// What the mesh files say of their material.
const STEEL: &str =
    "*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, 0.3\n*DENSITY\n7850\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n";

/// The slide and a study in a folder of their own.
fn folder_with(study: &str) -> TempDir {
    static MESHES: OnceLock<[String; 2]> = OnceLock::new();
    let [bed, carriage] = MESHES.get_or_init(|| {
        let (_, meshes) = support::slide::machine(true);
        [0, 1].map(|part| support::inp(&meshes[part], STEEL))
    });
    let folder = tempfile::tempdir().unwrap();
    let files = [("machine.toml", MACHINE), ("study.toml", study), ("bed.inp", bed), ("carriage.inp", carriage)];
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

/// The study with one text replaced.
fn changed(from: &str, to: &str) -> String {
    assert!(STUDY.contains(from), "{from:?} is not in the study");
    STUDY.replacen(from, to, 1)
}

fn read(text: &str) -> Result<Study, StudyError> {
    read_study(&folder_with(text).path().join("study.toml"))
}

/// The built binary, its cache shared by all tests of this binary.
fn stiffmap() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep-cache");
    command.env("STIFFMAP_CACHE", cache).env_remove("STIFFMAP_ADAPTER");
    command
}

/// `stiffmap sweep` of the folder's study into one of its folders.
fn sweep(folder: &Path, out: &str, arguments: &[&str]) -> Output {
    let mut command = stiffmap();
    command.current_dir(folder).args(["sweep", "study.toml", "--no-figures", "--out", out]).args(arguments);
    command.output().unwrap()
}

#[track_caller]
fn done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn table(folder: &Path, out: &str) -> String {
    std::fs::read_to_string(folder.join(out).join("designs.csv")).unwrap()
}

/// The table of one whole run of the study, computed once.
fn reference() -> &'static str {
    static TABLE: OnceLock<String> = OnceLock::new();
    TABLE.get_or_init(|| {
        let folder = folder_with(STUDY);
        done(&sweep(folder.path(), "out", &[]));
        table(folder.path(), "out")
    })
}

/// A column of a table as text.
fn column(table: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let at = reader.headers().unwrap().iter().position(|h| h == name);
    let at = at.unwrap_or_else(|| panic!("no column {name}: {table}"));
    reader.records().map(|record| record.unwrap()[at].to_owned()).collect()
}

/// The same as numbers.
fn numbers(table: &str, name: &str) -> Vec<f64> {
    column(table, name).iter().map(|cell| cell.parse().unwrap()).collect()
}

fn out_of(folder: &TempDir) -> PathBuf {
    folder.path().join("out")
}
