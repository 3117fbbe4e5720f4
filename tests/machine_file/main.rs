//! The machine file: what is read from it, and what is refused with which words.

use stiffmap::machine::*;
use tempfile::TempDir;

mod contact;
mod full;
mod hints;
mod limits;
mod names;
mod placement;
mod quantities;
mod reading;
mod refusals;

/// A small machine that is in order; the tests change a line of it.
const MACHINE: &str = r#"
name = "small mill"

[axes.z]
direction = [0, 0, 2]
travel = ["0 mm", "-100 mm"]
step = "5 mm"
moves = ["head"]

[parts.column]
mesh = "column.inp"
clamped = ["BASE"]
[parts.column.interfaces]
rail = { nodes = "RAIL" }
mount = { nodes = "MOUNT" }

[parts.head]
mesh = "head.inp"
[parts.head.interfaces]
carriage = { nodes = "CARRIAGE" }
nut = { nodes = "NUT" }
tip = { nodes = "TIP", within = { axis = "z", from = "10 mm", to = "30 mm" } }

[[joints]]
name = "guide"
type = "linear-guide"
rail = "column.rail"
carriage = "head.carriage"
footprint = "90 mm"
stiffness = { x = "77 N/um", y = 77e6 }
damping = { x = "100 N s/m" }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["column.mount", "head.nut"]
axis = "z"
young = "210 GPa"
diameter = "40 mm"

[ports.tool]
interface = "head.tip"
directions = ["x", "z"]

[analysis]
component = { modes = 50 }
modes = 30
frequencies = { from = "0 Hz", to = "10 Hz", step = "1 Hz" }
damping = { ratio = 0.02 }
"#;

fn folder_with(text: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in [("machine.toml", text), ("column.inp", ""), ("head.inp", "")] {
        std::fs::write(folder.path().join(name), content).expect("a file in it");
    }
    folder
}

fn read(text: &str) -> Result<Machine, MachineError> {
    read_machine(folder_with(text).path())
}

/// The small machine with one text replaced.
fn changed(from: &str, to: &str) -> String {
    assert!(MACHINE.contains(from), "{from:?} is not in the small machine");
    MACHINE.replacen(from, to, 1)
}

/// Checks that a machine file is refused, and that the message holds every fragment.
#[track_caller]
fn refused(text: &str, fragments: &[&str]) {
    let message = match read(text) {
        Ok(_) => panic!("accepted; expected a refusal with {fragments:?}"),
        Err(error) => error.to_string(),
    };
    for fragment in ["machine.toml:"].iter().chain(fragments) {
        assert!(message.contains(fragment), "{fragment:?} is not in: {message}");
    }
}

#[track_caller]
fn refused_change(from: &str, to: &str, fragments: &[&str]) {
    refused(&changed(from, to), fragments);
}

#[track_caller]
fn accepted(from: &str, to: &str) -> Machine {
    read(&changed(from, to)).unwrap_or_else(|error| panic!("{error}"))
}
