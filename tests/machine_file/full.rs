//! A machine file that uses every table, for the tests of hints, limits and documents.

use stiffmap::machine::{Machine, MachineError, read_machine};
use tempfile::TempDir;

/// A machine that uses every table; the keys stand in lines or in inline tables.
pub const FULL: &str = r#"name = "full"
units = "mm-t-s"

[axes.z]
direction = [0, 0, 1]
travel = ["0 mm", "-100 mm"]
step = "5 mm"
moves = ["head", "tool"]

[parts.column]
mesh = "column.inp"
units = "mm-t-s"
orientation = { x = [0, 1, 0], z = [0, 0, 1] }
origin = [0, 0, 0]
material = { young = "115 GPa", poisson = 0.26, density = "7200 kg/m3" }
clamped = ["BASE"]
supported = [{ nodes = "EDGE", directions = ["z"] }]
plain_bricks = true
loss_factor = 0.01
[parts.column.interfaces]
rail = { nodes = "RAIL", within = { axis = "z", from = "10 mm", to = "30 mm" }, coupling = "distributing" }
mount = { nodes = "MOUNT" }
box = { nodes = "BOX", within = { x = ["10 mm", "30 mm"] } }

[parts.head]
mesh = "head.inp"
[parts.head.interfaces]
carriage = { nodes = "CARRIAGE" }
nut = { nodes = "NUT" }
seat = { nodes = "SEAT" }

[parts.tool.matrices]
stiffness = "k.mtx"
mass = "m.mtx"
dofs = "dofs.csv"
[parts.tool.interfaces]
journal = { nodes = [1, 2, 3], weights = "equal" }

[[joints]]
name = "guide"
type = "linear-guide"
rail = "column.rail"
carriage = "head.carriage"
footprint = "90 mm"
stiffness = { x = "77 N/um", y = 77e6 }
damping = { x = "100 N s/m" }
friction = { coulomb = "50 N", breakaway = "80 N", stribeck = "1 mm/s" }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["column.mount", "head.nut"]
axis = "z"
young = "210 GPa"
diameter = "40 mm"
free_length = "300 mm"
support = "both-ends"
span = "1300 mm"
damping = "10 N s/m"
backlash = "10 um"

[[joints]]
name = "bearing"
type = "bearing"
between = ["head.seat", "tool.journal"]
axis = "y"
at = ["0 mm", "0 mm", "1 mm"]
stiffness = { radial = "120 N/um", axial = "60 N/um" }
damping = { radial = "10 N s/m" }
loss_factor = 0.02

[[joints]]
name = "bolts"
type = "bolted"
between = ["head.seat", "tool.journal"]
at = ["0 mm", "0 mm", "1 mm"]
stiffness = { x = 1e9, y = 1e9, z = 1e9, rx = 1e7, ry = 1e7, rz = 1e7 }
damping = { x = 1 }

[[joints]]
name = "strut"
type = "spring-damper"
between = ["head.seat", "column.box"]
at = ["0 mm", "0 mm", "1 mm"]
direction = "x"
stiffness = "1 N/um"
damping = "10 N s/m"

[ports.tip]
interface = "tool.journal"
directions = ["x"]
input = true
output = true

[analysis]
component = { modes = 10, band = "5 kHz", method = "craig-bampton", second_moment = true }
modes = 12
frequencies = { grid = "uniform", from = "0 Hz", to = "900 Hz", step = "1 Hz" }
quantity = "receptance"
damping = { ratio = 0.02, rayleigh = { alpha = 1, beta = 1e-6 }, loss_factor = 0.01 }
"#;

/// Reads a text beside all the files that [`FULL`] names.
pub fn read_full(text: &str) -> Result<Machine, MachineError> {
    read_machine(folder_with_all(text).path())
}

/// A folder with a machine file and every file that [`FULL`] names.
pub fn folder_with_all(text: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["column.inp", "head.inp", "k.mtx", "m.mtx", "dofs.csv"] {
        std::fs::write(folder.path().join(name), "").expect("a file in it");
    }
    std::fs::write(folder.path().join("machine.toml"), text).expect("a machine file in it");
    folder
}
