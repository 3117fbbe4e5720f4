//! What the benchmarks share: frequencies of a body, and whether CalculiX is there.

use crate::support::part;
use std::path::{Path, PathBuf};
use std::process::Command;
use stiffmap::linalg::{FreeSpectrum, shift_invert_modes};
use stiffmap::machine::{Material, Support};
use stiffmap::mesh::Mesh;
use stiffmap::solid::assemble;

/// The material of the NAFEMS plates.
pub fn nafems_steel() -> Material {
    Material { name: "steel".into(), young: 200e9, poisson: 0.3, density: 8000.0 }
}

/// The lowest modes of a body held at some sets.
pub fn modes(mesh: &Mesh, supports: &[(&str, [bool; 3])], count: usize) -> FreeSpectrum {
    let mut body = part("body", &[], vec![]);
    body.supported = supports.iter().map(|(set, d)| Support { nodes: set.to_string(), directions: *d }).collect();
    let system = assemble(&body, mesh).expect("assembles");
    let ordering = system.ordering().expect("METIS orders it");
    shift_invert_modes(&system.stiffness, &system.mass, &ordering, system.rigid.ncols(), count, None)
        .expect("converges and counts")
}

/// Frequencies (Hz) of the elastic modes.
pub fn elastic(found: &FreeSpectrum) -> Vec<f64> {
    found.eigenvalues[found.rigid..].iter().map(|l| l.sqrt() / std::f64::consts::TAU).collect()
}

/// The frequency nearest to `f`, relative to it, minus one.
pub fn nearest(frequencies: &[f64], f: f64) -> f64 {
    frequencies.iter().map(|g| g / f - 1.0).min_by(|a, b| a.abs().total_cmp(&b.abs())).expect("a frequency")
}

/// Whether something of CalculiX that is missing is a failure.
fn missing(what: &str) {
    assert_ne!(std::env::var("STIFFMAP_CCX").as_deref(), Ok("require"), "{what} is missing");
    eprintln!("skipped: {what} is missing");
}

/// CalculiX's solver, if it is installed.
pub fn ccx() -> Option<Command> {
    let name = std::env::var("STIFFMAP_CCX_BINARY").unwrap_or_else(|_| "ccx".into());
    match Command::new(&name).arg("-v").output() {
        Ok(_) => Some(Command::new(name)),
        Err(_) => {
            missing("CalculiX (package calculix-ccx)");
            None
        }
    }
}

/// CalculiX's test decks, if they are installed.
pub fn test_decks() -> Option<PathBuf> {
    let folder = Path::new("/usr/share/doc/calculix-ccx-test/examples/test");
    if folder.is_dir() {
        return Some(folder.to_path_buf());
    }
    missing("the folder of CalculiX's test decks (package calculix-ccx-test)");
    None
}

/// The program.
pub fn stiffmap() -> Command {
    Command::new(env!("CARGO_BIN_EXE_stiffmap"))
}
