//! Parts given by matrices, and machines exported to other programs.

#[path = "../support/mod.rs"]
mod support;

mod any_bytes;
mod band;
mod deck;
mod faces;
mod full;
mod nastran;
mod parts;
mod readers;
mod refusals;
mod superelement;

use std::path::{Path, PathBuf};
use std::process::Command;
use stiffmap::export::matrix_market::{DofRow, write_dofs, write_sets, write_sparse};
use stiffmap::machine::{InterfaceNodes, InterfaceWeights, MatrixFiles, Part, Region};
use stiffmap::mesh::Mesh;
use stiffmap::solid::{SecondOrder, assemble, interface_motions};

/// A folder of this binary's tests.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Writes a part's own matrices, degrees of freedom and interfaces into a folder.
fn write_part(folder: &Path, part: &Part, mesh: &Mesh) -> SecondOrder {
    let system = assemble(part, mesh).expect("the part");
    write_sparse(&folder.join("k.mtx"), &system.stiffness).expect("writes");
    write_sparse(&folder.join("m.mtx"), &system.mass).expect("writes");
    let label = |(node, direction): (usize, usize)| (mesh.node_labels[node], direction, mesh.nodes[node]);
    let rows: Vec<DofRow> = system.node_of_unknown().into_iter().map(|n| n.map(label)).collect();
    write_dofs(&folder.join("dofs.csv"), &rows).expect("writes");
    let everywhere = Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    let surfaces = interface_motions(part, mesh).expect("surfaces");
    let sets: Vec<_> = part
        .interfaces
        .iter()
        .zip(&surfaces)
        .map(|(interface, (surface, _))| {
            let weights = surface.weights_within(interface.within.as_ref().unwrap_or(&everywhere));
            (interface.nodes.clone(), weights.iter().map(|(n, w)| (mesh.node_labels[*n], *w)).collect())
        })
        .collect();
    write_sets(&folder.join("sets.csv"), &sets).expect("writes");
    system
}

/// The files that [`write_part`] writes.
fn files(folder: &Path, part: &Part) -> MatrixFiles {
    MatrixFiles {
        stiffness: folder.join("k.mtx"),
        mass: folder.join("m.mtx"),
        stiffness_name: None,
        mass_name: None,
        dofs: Some(folder.join("dofs.csv")),
        nodes: None,
        sets: Some(folder.join("sets.csv")),
        free: None,
        with_mesh: false,
        interfaces: vec![InterfaceNodes { labels: None, weights: InterfaceWeights::Unsaid }; part.interfaces.len()],
    }
}

/// A part by the matrices of a folder.
fn by_matrices(part: &Part, files: MatrixFiles) -> Part {
    Part { mesh: files.stiffness.clone(), matrices: Some(files), clamped: Vec::new(), ..part.clone() }
}

/// Debian's CalculiX, or what STIFFMAP_CCX_BINARY names; `None` where its tests are switched off by name.
fn calculix(deck: &Path) -> Option<()> {
    if std::env::var("STIFFMAP_CCX").as_deref() == Ok("skip") {
        eprintln!("skipped: STIFFMAP_CCX=skip");
        return None;
    }
    let program = std::env::var("STIFFMAP_CCX_BINARY").unwrap_or_else(|_| "ccx".into());
    let mut command = Command::new(&program);
    let job = deck.with_extension("");
    command.current_dir(deck.parent().expect("a folder")).arg(job.file_name().expect("a name"));
    let output = command.output().unwrap_or_else(|e| {
        panic!("{program}: {e}; install calculix-ccx, name it by STIFFMAP_CCX_BINARY, or set STIFFMAP_CCX=skip")
    });
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("Job finished"), "{program} {}: {said}", deck.display());
    Some(())
}

/// The frequencies (Hz) of CalculiX's .dat file.
fn calculix_frequencies(deck: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(deck.with_extension("dat")).expect("a .dat file");
    let table = text.split("P A R T I C I P A T I O N").next().unwrap_or_default();
    let rows = table.lines().filter_map(|line| {
        let fields: Vec<f64> = line.split_whitespace().map_while(|f| f.parse().ok()).collect();
        (fields.len() == 5).then(|| fields[3])
    });
    rows.collect()
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/matrices").join(name)
}
