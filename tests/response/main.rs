//! Time histories and state-space databases: against closed forms, the matrix exponential, SciPy and python-control.

mod command;
mod contact;
mod database;
mod forces;
mod frozen;
mod milling;
mod momentum;
mod moving;
mod recursion;
mod spectra;

use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use stiffmap::coupling::CoupledModel;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::modal::{Modes, modes_at};
use stiffmap::pipeline;
use stiffmap::reduction::Cache;

/// The bundled mill, coupled as `simulate` does it for 900 Hz.
struct Mill {
    machine: Machine,
    model: CoupledModel,
}

fn mill() -> &'static Mill {
    static MILL: OnceLock<Mill> = OnceLock::new();
    MILL.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
        let machine = read_machine(&folder).unwrap();
        let meshes = pipeline::read_meshes(&machine).unwrap();
        // tests/run.sh names a cache that is empty at the start and shared by the test binaries.
        let cache = std::env::var_os("STIFFMAP_CACHE").map(|c| Cache::in_folder(PathBuf::from(c)));
        let parts = pipeline::reduce_parts(&machine, &meshes, cache.as_ref(), &Interrupt::default(), &|| ()).unwrap();
        let parts: Vec<_> = parts.into_iter().map(|p| p.superelement).collect();
        let model = pipeline::build_model(&machine, &parts, 30, 1.5 * 900.0).unwrap().model;
        Mill { machine, model }
    })
}

fn modes(position: f64) -> Modes {
    modes_at(&mill().model, &mill().machine.analysis.damping, position).unwrap()
}

/// The modes at the stations of the travel, 5 mm apart.
fn all_stations() -> &'static [Modes] {
    static STATIONS: OnceLock<Vec<Modes>> = OnceLock::new();
    // Made before the parallel loop: a task that waits for it could hold the thread that makes it.
    mill();
    STATIONS.get_or_init(|| mill().machine.axis.stations().into_par_iter().map(modes).collect())
}

fn names() -> Vec<String> {
    ["x", "y", "z"].map(String::from).to_vec()
}

/// Largest |a - b| over the largest |b|.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let peak = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
}

/// Runs a check of `tests/response/check.py`; `None` where the Python tests are switched off by name.
fn python(check: &str, files: &[&Path]) -> Option<f64> {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return None;
    }
    let python = std::env::var("STIFFMAP_PYTHON").unwrap_or_else(|_| {
        panic!(
            "STIFFMAP_PYTHON names no Python; set it to one that has scipy and control, or set STIFFMAP_PYTHON_TESTS=skip"
        )
    });
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/response/check.py");
    let run = Command::new(&python).arg(script).arg(check).args(files).output().unwrap();
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{python} check.py {check}: {message}");
    let text = String::from_utf8(run.stdout).unwrap();
    Some(text.trim().parse().unwrap_or_else(|_| panic!("{check}: {text:?}")))
}
