//! Exports of a small machine: CalculiX solves its deck; its matrices give its frequencies back.

use super::support::dense::{full, symmetric_values};
use super::support::grids::{distort, grid};
use super::support::{box_mesh, craig_bampton, on, part, superelement};
use super::{by_matrices, calculix, calculix_frequencies, files, folder};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::OnceLock;
use stiffmap::machine::{InterfaceNodes, InterfaceWeights, MatrixFiles};
use stiffmap::matrix::{parse_market, symmetric};
use stiffmap::mesh::{CellKind, Mesh, read_part_mesh};

/// Positions: both ends and one between, where no node of the rail meets the footprint's ends.
const POSITIONS: [f64; 3] = [0.3, -0.0371, -0.3];
/// Elastic frequencies that are compared.
const MODES: usize = 20;

const MACHINE: &str = r#"
name = "slide"

[axes.z]
direction = [0, 0, 1]
travel = [0.3, -0.3]
step = 0.05
moves = ["carriage", "arm"]

[parts.bed]
mesh = "bed.inp"
clamped = ["YMIN"]
interfaces = { rail = { nodes = "YMAX" }, end = { nodes = "ZMAX" } }

[parts.carriage]
mesh = "carriage.inp"
interfaces = { seat = { nodes = "YMIN" }, nut = { nodes = "ZMAX" }, top = { nodes = "YMAX" } }

[parts.arm]
mesh = "arm.inp"
interfaces = { foot = { nodes = "YMIN", coupling = "COUPLING" }, tip = { nodes = "YMAX" } }

[[joints]]
name = "guide"
type = "linear-guide"
rail = "bed.rail"
carriage = "carriage.seat"
footprint = "120 mm"
stiffness = { x = "50 N/um", y = "90 N/um", rx = 2e5, ry = 3e5, rz = 1e5 }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["bed.end", "carriage.nut"]
axis = "z"
young = "210 GPa"
diameter = "16 mm"

[[joints]]
name = "spindle"
type = "bearing"
between = ["carriage.top", "arm.foot"]
axis = "y"
at = [0.05, 0.16, 0.5]
stiffness = { radial = "120 N/um", axial = "60 N/um" }

[[joints]]
name = "hinge"
type = "spring-damper"
between = ["carriage.top", "arm.foot"]
stiffness = { rx = 2e6, rz = 1e6 }

[ports.tool]
interface = "arm.tip"
directions = ["x", "y", "z"]

[analysis]
component = { modes = 40 }
modes = 20
frequencies = { from = 0, to = 4000, step = 100 }
damping = { ratio = 0.02 }
"#;

/// A mesh as an Abaqus deck.
pub fn write_mesh(file: &Path, mesh: &Mesh) {
    let mut text = String::from("*NODE\n");
    for (label, [x, y, z]) in mesh.node_labels.iter().zip(&mesh.nodes) {
        writeln!(text, "{label}, {x:e}, {y:e}, {z:e}").unwrap();
    }
    writeln!(text, "*ELEMENT, TYPE={}, ELSET=ALL", mesh.cells[0].kind.name()).unwrap();
    for cell in &mesh.cells {
        let nodes: Vec<String> = cell.nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect();
        writeln!(text, "{}, {}", cell.label, nodes.join(", ")).unwrap();
    }
    for (name, nodes) in &mesh.node_sets {
        writeln!(text, "*NSET, NSET={name}").unwrap();
        nodes.iter().for_each(|n| writeln!(text, "{},", mesh.node_labels[*n]).unwrap());
    }
    text += "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n";
    std::fs::write(file, text).unwrap();
}

/// The slide with an arm on its carriage that only its bearing's rotation leaves free, in a folder.
fn machine(coupling: &str) -> tempfile::TempDir {
    // Fine enough that CalculiX's coarser integration of the mass does not show.
    let bed = box_mesh([0.0; 3], [0.1, 0.1, 1.0], [2, 2, 20]);
    let carriage = box_mesh([0.0, 0.11, 0.45], [0.1, 0.05, 0.1], [4, 2, 4]);
    let arm = box_mesh([0.02, 0.17, 0.47], [0.06, 0.2, 0.06], [2, 6, 2]);
    machine_of([bed, carriage, arm], coupling)
}

/// The same with given meshes of bed, carriage and arm.
fn machine_of(meshes: [Mesh; 3], coupling: &str) -> tempfile::TempDir {
    let folder = folder();
    for (name, mesh) in ["bed", "carriage", "arm"].into_iter().zip(meshes) {
        write_mesh(&folder.path().join(format!("{name}.inp")), &mesh);
    }
    std::fs::write(folder.path().join("machine.toml"), MACHINE.replace("COUPLING", coupling)).unwrap();
    folder
}

fn stiffmap(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command.env("STIFFMAP_CACHE", folder.join("cache")).args(arguments).current_dir(folder);
    command.output().unwrap()
}

fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = stiffmap(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Elastic frequencies of a run at each position, without the free rotation of the arm.
fn run(folder: &Path) -> Vec<Vec<f64>> {
    let list = POSITIONS.map(|p| p.to_string()).join(",");
    succeed(folder, &["run", ".", "--no-figures", "--positions", &list, "--out", "out"]);
    let table = std::fs::read_to_string(folder.join("out/eigenfrequencies.csv")).unwrap();
    let mut found = vec![Vec::new(); POSITIONS.len()];
    for line in table.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        let position = POSITIONS.iter().position(|p| *p == fields[0]).unwrap();
        if fields[3] > 1.0 {
            found[position].push(fields[3]);
        }
    }
    found
}

/// The distributing machine and its frequencies, once for all tests.
fn distributing() -> &'static (tempfile::TempDir, Vec<Vec<f64>>) {
    static MACHINE: OnceLock<(tempfile::TempDir, Vec<Vec<f64>>)> = OnceLock::new();
    MACHINE.get_or_init(|| {
        let folder = machine("distributing");
        let found = run(folder.path());
        (folder, found)
    })
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    assert!(a.len() >= MODES && b.len() >= MODES, "{} and {} frequencies", a.len(), b.len());
    super::support::worst_ratio(&a[..MODES], &b[..MODES])
}

fn against_calculix(folder: &Path, expected: &[Vec<f64>]) {
    for (position, expected) in POSITIONS.iter().zip(expected) {
        let deck = folder.join(format!("at{position}.inp"));
        let (position, modes) = (position.to_string(), (MODES + 1).to_string());
        let out = deck.to_str().unwrap();
        succeed(folder, &["export", ".", "--format", "inp", "--position", &position, "--modes", &modes, "--out", out]);
        let text = std::fs::read_to_string(&deck).unwrap();
        assert!(text.contains("integrates the mass of C3D10 with 4 points"), "{}", &text[..600]);
        if calculix(&deck).is_none() {
            return;
        }
        let found: Vec<f64> = calculix_frequencies(&deck).into_iter().filter(|f| *f > 1.0).collect();
        let difference = worst(expected, &found);
        eprintln!("{position} m: {MODES} elastic frequencies, largest difference {difference:.1e}");
        assert!(difference < 1e-3, "{position} m: {difference:.1e}\n{expected:?}\n{found:?}");
        let low = super::support::worst_ratio(&expected[..8], &found[..8]);
        assert!(low < 1e-5, "{position} m: {low:.1e}");
    }
}

#[test]
fn calculix_finds_the_frequencies_of_the_exported_machine() {
    let (folder, expected) = distributing();
    against_calculix(folder.path(), expected);
    // Negative control: the positions do differ.
    assert!(worst(&expected[0], &expected[2]) > 1e-2);
}

#[test]
fn calculix_finds_the_frequencies_with_a_rigid_interface_too() {
    let folder = machine("rigid");
    let expected = run(folder.path());
    against_calculix(folder.path(), &expected);
    assert!(worst(&expected[1], &distributing().1[1]) > 1e-3);
}

/// The machine of C3D8I, moved inside by up to `amplitude` (m).
fn machine_of_bricks(amplitude: f64) -> tempfile::TempDir {
    let pieces = [
        ([0.0; 3], [0.1, 0.1, 1.0], [2, 2, 20]),
        ([0.0, 0.11, 0.45], [0.1, 0.05, 0.1], [4, 2, 4]),
        ([0.02, 0.17, 0.47], [0.06, 0.2, 0.06], [2, 6, 2]),
    ];
    let meshes = pieces.map(|(from, size, cells)| {
        let mut mesh = grid(CellKind::Hex8Incompatible, size, cells);
        distort(&mut mesh, amplitude);
        mesh.nodes.iter_mut().for_each(|x| *x = [0, 1, 2].map(|c| x[c] + from[c]));
        mesh
    });
    machine_of(meshes, "distributing")
}

#[test]
fn calculix_has_the_same_incompatible_bricks_where_they_are_parallelepipeds_and_else_the_export_says_so() {
    for amplitude in [0.0, 0.004, 0.01] {
        let folder = machine_of_bricks(amplitude);
        let expected = &run(folder.path())[1];
        let deck = folder.path().join("bricks.inp");
        let arguments = ["export", ".", "--format", "inp", "--position", "-0.0371", "--modes", "21", "--out"];
        let output = stiffmap(folder.path(), &[&arguments[..], &[deck.to_str().unwrap()]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        let text = std::fs::read_to_string(&deck).unwrap();
        let told = [&said, &text].map(|text| text.contains("are no parallelepipeds"));
        assert_eq!(told, [amplitude > 0.0; 2], "{said}");
        if calculix(&deck).is_none() {
            return;
        }
        let found: Vec<f64> = calculix_frequencies(&deck).into_iter().filter(|f| *f > 1.0).collect();
        let difference = worst(expected, &found);
        eprintln!("bricks moved by {amplitude} m: largest difference {difference:.1e} of {MODES} frequencies");
        // What the reduction to 40 component modes leaves, and beyond it what the export has told.
        let told = said
            .split_once("differ by up to about ")
            .map_or(0.0, |(_, rest)| rest.split_whitespace().next().unwrap().parse::<f64>().unwrap());
        assert!(difference < 2e-5 + told, "{amplitude} m: {difference:.1e}, told {told:.0e}\n{expected:?}\n{found:?}");
        assert!((amplitude > 0.0) == (difference > 2e-5), "control: {amplitude} m, {difference:.1e}");
    }
}

#[test]
fn the_reduced_matrices_have_the_frequencies_of_the_run() {
    let (folder, expected) = distributing();
    let position = POSITIONS[1].to_string();
    succeed(folder.path(), &["export", ".", "--format", "mtx", "--position", &position, "--out", "reduced"]);
    let read = |name: &str| {
        let file = folder.path().join("reduced").join(name);
        full(
            &symmetric(parse_market(&std::fs::read(&file).unwrap(), &file).unwrap(), "stiffness", &|i| i.to_string())
                .unwrap(),
        )
    };
    let stiffness = read("stiffness.mtx");
    assert_eq!(read("mass.mtx"), DMatrix::identity(stiffness.nrows(), stiffness.nrows()));
    let found: Vec<f64> =
        symmetric_values(&stiffness).iter().map(|l| l.max(0.0).sqrt() / TAU).filter(|f| *f > 1.0).collect();
    assert!(worst(&expected[1], &found) < 1e-6);
}

/// The unreduced machine as one part by matrices, without any joint, has the machine's frequencies.
#[test]
fn the_full_matrices_are_a_part_with_the_frequencies_of_the_machine() {
    let (source, expected) = distributing();
    let position = POSITIONS[1].to_string();
    let folder = folder();
    let out = folder.path().to_str().unwrap();
    succeed(source.path(), &["export", ".", "--format", "mtx", "--full", "--position", &position, "--out", out]);
    // The arm turns freely about its bearing: a spring that is soft beside all others holds it.
    hold(&folder.path().join("stiffness.mtx"));
    let mut whole = part("whole", &[], vec![on("some")]);
    let files = MatrixFiles {
        stiffness: folder.path().join("stiffness.mtx"),
        mass: folder.path().join("mass.mtx"),
        sets: None,
        free: Some(false),
        interfaces: vec![InterfaceNodes {
            labels: Some(vec![1500, 1580, 1650, 1740]),
            weights: InterfaceWeights::Equal,
        }],
        ..files(folder.path(), &whole)
    };
    whole = by_matrices(&whole, files);
    let mesh = read_part_mesh(&whole).unwrap_or_else(|e| panic!("{e}")).mesh;
    let reduced = superelement(&whole, &mesh, craig_bampton(60));
    let found: Vec<f64> = reduced.eigenvalues.iter().map(|l| l.sqrt() / TAU).collect();
    assert!(found[0] < 5.0, "{:?}", &found[..8]);
    let difference = worst(&expected[1], &found[1..]);
    // The soft spring itself is worth 1.6e-5.
    assert!(difference < 3e-5, "{difference:.1e}\n{:?}\n{:?}", expected[1], &found[..MODES]);
}

/// Adds 100 N/m to the last diagonal entry.
fn hold(file: &Path) {
    let text = std::fs::read_to_string(file).unwrap();
    let (head, last) = text.trim_end().rsplit_once('\n').unwrap();
    let fields: Vec<&str> = last.split(' ').collect();
    assert_eq!(fields[0], fields[1]);
    let value: f64 = fields[2].parse().unwrap();
    std::fs::write(file, format!("{head}\n{} {} {:e}\n", fields[0], fields[1], value + 100.0)).unwrap();
}

#[test]
fn an_exported_part_is_read_again_as_a_part_by_matrices() {
    let (source, expected) = distributing();
    let copy = folder();
    for name in ["bed.inp", "carriage.inp"] {
        std::fs::copy(source.path().join(name), copy.path().join(name)).unwrap();
    }
    let out = copy.path().join("arm");
    succeed(source.path(), &["export", ".", "--format", "mtx", "--part", "arm", "--out", out.to_str().unwrap()]);
    let given = "matrices = { stiffness = \"arm/stiffness.mtx\", mass = \"arm/mass.mtx\", dofs = \"arm/dofs.csv\", sets = \"arm/sets.csv\" }\n\
                 interfaces = { foot = { nodes = \"foot\" }, tip = { nodes = \"tip\" } }";
    let start = MACHINE.find("mesh = \"arm.inp\"").unwrap();
    let end = MACHINE[start..].find("\n\n").unwrap() + start;
    std::fs::write(copy.path().join("machine.toml"), format!("{}{given}{}", &MACHINE[..start], &MACHINE[end..]))
        .unwrap();
    for (seen, expected) in run(copy.path()).iter().zip(expected) {
        assert!(worst(expected, seen) < 1e-8);
    }
    // A deck cannot hold it, and nothing is written.
    let refused = stiffmap(copy.path(), &["export", ".", "--format", "inp", "--out", "deck.inp"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("part \"arm\" is given by matrices"), "{said}");
    assert!(!copy.path().join("deck.inp").exists());
}

#[test]
fn an_export_that_makes_no_sense_is_bad_usage() {
    let (folder, _) = distributing();
    for (arguments, fragment) in [
        (&["--format", "inp", "--full", "--out", "x"][..], "--format mtx"),
        (&["--format", "inp", "--position", "0.7", "--out", "x"], "outside the travel"),
        (&["--format", "mtx", "--part", "leg", "--out", "x"], "bed, carriage, arm"),
        (&["--format", "inp", "--modes", "0", "--out", "x"], "at least 1"),
    ] {
        let output = stiffmap(folder.path(), &[&["export", "."], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(fragment), "{arguments:?}: {said}");
        assert!(!folder.path().join("x").exists());
    }
}
