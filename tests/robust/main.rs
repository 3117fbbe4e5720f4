//! Machines beside the road of the bundled mill: soft mounts under stiff bolts, coordinates without mass, few modes
//! of stiff parts, plates one brick thick.
//!
//! The inputs were made for trials of the program; `input/k.mtx`, `m.mtx` and `dofs.csv` are a beam of eight nodes
//! whose rotations have no inertia.

#[path = "../support/dense.rs"]
#[allow(dead_code, reason = "this test uses some of it")]
mod dense;

mod massless;
mod mode_count;
mod reduction_error;
mod soft_mounts;

use std::path::PathBuf;
use stiffmap::coupling::{CoupledModel, assembled};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::mesh::MeshFile;
use stiffmap::pipeline::{self, PipelineError, Solved};
use stiffmap::reduction::Superelement;
use stiffmap::solid::assemble;

/// A machine of the folder `input` with parts of its text replaced.
fn machine(file: &str, edits: &[(&str, &str)]) -> Machine {
    let source = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/robust/input").join(file);
    let mut text = std::fs::read_to_string(&source).expect("an input of the test");
    for (from, to) in edits {
        assert!(text.contains(from), "{from:?} stands in {file}");
        text = text.replace(from, to);
    }
    // Beside its meshes, under a name of its own for each thread.
    let name = format!(".{}-{:?}.toml", std::process::id(), std::thread::current().id());
    let edited = source.with_file_name(name);
    std::fs::write(&edited, text).expect("the folder can be written");
    let read = read_machine(&edited);
    std::fs::remove_file(&edited).expect("it was written");
    read.unwrap_or_else(|error| panic!("{error}"))
}

fn reduced(machine: &Machine) -> (Vec<MeshFile>, Vec<Superelement>) {
    let meshes = pipeline::read_meshes(machine).unwrap_or_else(|error| panic!("{error}"));
    let parts = pipeline::reduce_parts(machine, &meshes, None, &Interrupt::default(), &|| ());
    let parts = parts.unwrap_or_else(|error| panic!("{error}"));
    (meshes, parts.into_iter().map(|part| part.superelement).collect())
}

/// The job of `run` up to the counted modes at the first position.
fn solved(machine: &Machine, parts: &[Superelement]) -> Result<(CoupledModel, Solved), PipelineError> {
    let wanted = machine.analysis.modes;
    let highest = machine.analysis.frequencies.iter().copied().fold(0.0, f64::max);
    let model = pipeline::build_model(machine, parts, wanted, highest)?.model;
    let positions = [machine.axis.travel[0]];
    let solved = pipeline::solve_positions(machine, &model, &positions, wanted, &Interrupt::default(), &|| ())?;
    Ok((model, solved))
}

/// All eigenvalues of the machine before any reduction at its first position, by nalgebra, (rad/s)^2.
fn unreduced(machine: &Machine, meshes: &[MeshFile], shift: f64) -> Vec<f64> {
    let systems: Vec<_> =
        machine.parts.iter().zip(meshes).map(|(p, m)| assemble(p, &m.mesh).expect("assembles")).collect();
    let springs = pipeline::unreduced_springs(machine, meshes, machine.axis.travel[0]).expect("springs");
    let whole = assembled(&systems, &springs);
    let mut values = dense::eigenvalues(&dense::full(&whole.stiffness), &dense::full(&whole.mass), shift);
    // Motions without inertia come out as infinite, of either sign.
    values.retain(|l| *l > -0.5 * shift);
    values
}
