//! Element matrices entry by entry against CalculiX's (`*FREQUENCY, SOLVER=MATRIXSTORAGE`).

use crate::bench::{ccx, elastic, modes, nafems_steel, stiffmap};
use crate::support::grids::{grid, one};
use nalgebra::DMatrix;
use std::fmt::Write as _;
use std::path::Path;
use stiffmap::element::{matrices, reference_nodes};
use stiffmap::mesh::{CellKind, Mesh};

const MATERIAL: [f64; 3] = [1000.0, 0.3, 7.0];

/// A deck of a mesh with a frequency step.
fn deck(mesh: &Mesh, [young, poisson, density]: [f64; 3], boundary: &str, step: &str) -> String {
    let mut text = String::from("*NODE, NSET=NALL\n");
    for (label, [x, y, z]) in mesh.node_labels.iter().zip(&mesh.nodes) {
        writeln!(text, "{label}, {x:?}, {y:?}, {z:?}").expect("written");
    }
    writeln!(text, "*ELEMENT, TYPE={}, ELSET=EALL", mesh.cells[0].kind.name()).expect("written");
    for cell in &mesh.cells {
        let labels: Vec<String> = std::iter::once(cell.label)
            .chain(cell.nodes.iter().map(|&n| mesh.node_labels[n]))
            .map(|l| l.to_string())
            .collect();
        let lines: Vec<String> = labels.chunks(10).map(|c| c.join(", ")).collect();
        writeln!(text, "{}", lines.join(",\n")).expect("written");
    }
    for (name, nodes) in &mesh.node_sets {
        writeln!(text, "*NSET, NSET={name}").expect("written");
        nodes.iter().for_each(|&n| writeln!(text, "{},", mesh.node_labels[n]).expect("written"));
    }
    write!(
        text,
        "*MATERIAL, NAME=M\n*ELASTIC\n{young:?}, {poisson}\n*DENSITY\n{density:?}\n*SOLID SECTION, ELSET=EALL, MATERIAL=M\n\
         {boundary}*STEP\n{step}\n*END STEP\n"
    )
    .expect("written");
    text
}

/// A matrix of a `.sti` or `.mas` file.
fn stored(file: &Path, n: usize) -> DMatrix<f64> {
    let text = std::fs::read_to_string(file).expect("CalculiX wrote it");
    let mut matrix = DMatrix::zeros(n, n);
    for line in text.lines() {
        let words: Vec<f64> = line.split_whitespace().map(|w| w.parse().expect("a number")).collect();
        let (i, j) = (words[0] as usize - 1, words[1] as usize - 1);
        matrix[(i, j)] = words[2];
        matrix[(j, i)] = words[2];
    }
    matrix
}

/// CalculiX's stiffness and mass of one element, the incompatible modes' own coordinates last.
fn calculix(kind: CellKind, x: &[[f64; 3]]) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let mut mesh = grid(kind, [1.0; 3], [1; 3]);
    mesh.cells.truncate(1);
    mesh.cells[0].nodes = (0..x.len()).collect();
    mesh.nodes = x.to_vec();
    mesh.node_labels = (1..=x.len() as u64).collect();
    mesh.node_sets.clear();
    let folder = tempfile::tempdir().expect("a folder");
    let text = deck(&mesh, MATERIAL, "", "*FREQUENCY, SOLVER=MATRIXSTORAGE\n1");
    std::fs::write(folder.path().join("e.inp"), text).expect("written");
    ccx()?.arg("e").current_dir(folder.path()).output().expect("runs");
    let n = 3 * x.len() + if kind == CellKind::Hex8Incompatible { 9 } else { 0 };
    Some((stored(&folder.path().join("e.sti"), n), stored(&folder.path().join("e.mas"), n)))
}

/// CalculiX's C3D8I over the nodes and the mean of its three incompatible modes: the two other combinations, which must
/// have no mass, are eliminated. `nodal` rows belong to the nodes.
fn without_massless_combinations(k: &DMatrix<f64>, m: &DMatrix<f64>, nodal: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut combine = DMatrix::identity(nodal + 9, nodal + 9);
    for c in 0..3 {
        for (row, shares) in [[1.0, 1.0, 1.0].map(|s| s / 3.0), [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]].iter().enumerate() {
            for (column, share) in shares.iter().enumerate() {
                combine[(nodal + 3 * row + c, nodal + 3 * column + c)] = *share;
            }
        }
    }
    let (k, m) = (&combine * k * combine.transpose(), &combine * m * combine.transpose());
    let kept = nodal + 3;
    assert!(m.rows(kept, 6).amax() < 1e-14 * m.amax(), "mass of the differences: {:.1e}", m.rows(kept, 6).amax());
    assert!(m.rows(nodal, 3).amax() > 0.1 * m.amax(), "control: the mean has mass");
    let own = k.view((kept, kept), (6, 6)).into_owned().cholesky().expect("regular");
    let coupling = k.view((kept, 0), (6, kept)).into_owned();
    let condensed = k.view((0, 0), (kept, kept)) - coupling.transpose() * own.solve(&coupling);
    (condensed, m.view((0, 0), (kept, kept)).into_owned())
}

#[test]
fn stiffness_and_mass_are_those_of_calculix_entry_by_entry() {
    for kind in CellKind::ALL {
        let mut x = one(kind);
        if kind == CellKind::Hex8Incompatible {
            // The same as CalculiX's on parallelepipeds; elsewhere CalculiX's fails the patch test.
            let skew = |[x, y, z]: [f64; 3]| [x + 0.3 * y - 0.1 * z, 1.2 * y + 0.2 * z, 0.1 * x + 0.7 * z];
            x = reference_nodes(kind).into_iter().map(skew).collect();
        }
        let Some((mut k, mut m)) = calculix(kind, &x) else { return };
        if kind == CellKind::Hex8Incompatible {
            (k, m) = without_massless_combinations(&k, &m, 3 * x.len());
        }
        let n = k.nrows();
        let [young, poisson, density] = MATERIAL;
        let ours = matrices(kind, &x, young, poisson, density).expect("not inverted");
        assert_eq!(n, 3 * ours.functions());
        let difference = |young: f64| {
            let e = matrices(kind, &x, young, poisson, density).expect("not inverted");
            let block = DMatrix::from_fn(n, n, |i, j| e.stiffness(i / 3, j / 3)[i % 3][j % 3]);
            (block - &k).amax() / k.amax()
        };
        assert!(difference(young) < 1e-11, "{kind:?}: stiffness differs by {:.1e}", difference(young));
        assert!(difference(1.0001 * young) > 1e-5, "control: a stiffer material is seen");
        // CalculiX integrates the masses of these three with their stiffness points, too few for the inertia.
        let other_mass = matches!(kind, CellKind::Tet4 | CellKind::Tet10 | CellKind::Wedge6);
        let functions = ours.functions();
        let off = DMatrix::from_fn(functions, functions, |a, b| ours.mass(a, b) - m[(3 * a, 3 * b)]);
        let mass = off.amax() / m.amax();
        assert_eq!(mass < 1e-11, !other_mass, "{kind:?}: mass differs by {mass:.1e}");
        let total = |f: &dyn Fn(usize, usize) -> f64| -> f64 {
            (0..x.len() * x.len()).map(|i| f(i / x.len(), i % x.len())).sum()
        };
        let (a, b) = (total(&|a, b| ours.mass(a, b)), total(&|a, b| m[(3 * a, 3 * b)]));
        // On curved tetrahedra the volume itself is beyond four points.
        assert!((a / b - 1.0).abs() < if kind == CellKind::Tet10 { 1e-2 } else { 1e-11 }, "{kind:?}: {a} {b}");
    }
}

/// The NAFEMS plate FV52 as it is written, w = 0 along the four bottom edges, in both programs.
#[test]
fn the_plate_on_its_bottom_edges_has_calculixs_frequencies() {
    let Some(mut ccx) = ccx() else { return };
    for kind in [CellKind::Hex20Reduced, CellKind::Tet10] {
        let mut mesh = grid(kind, [10.0, 10.0, 1.0], [6, 6, 1]);
        let edge = crate::nafems::bottom_edges(&mesh);
        mesh.node_sets.clear();
        mesh.node_sets.insert("EDGE".into(), edge);
        mesh.materials = vec![nafems_steel()];
        let steel = nafems_steel();
        let text = deck(
            &mesh,
            [steel.young, steel.poisson, steel.density],
            "*BOUNDARY\nEDGE, 3, 3\n",
            "*FREQUENCY\n10\n*NODE FILE\nU",
        );
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("plate.inp");
        std::fs::write(&file, text).expect("written");
        ccx.arg("plate").current_dir(folder.path()).output().expect("runs");
        let table = std::fs::read_to_string(folder.path().join("plate.dat")).expect("CalculiX wrote it");
        let theirs: Vec<f64> = table
            .lines()
            .filter_map(|line| {
                let words: Vec<&str> = line.split_whitespace().collect();
                (words.len() == 5).then(|| words[3].parse().ok())?
            })
            .take(10)
            .collect();
        let run = stiffmap().args(["modes", "--json"]).arg(&file).output().expect("runs");
        let json: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
        let ours: Vec<f64> =
            json["frequencies"].as_array().expect("a list").iter().filter_map(serde_json::Value::as_f64).collect();
        assert_eq!(json["rigid"], 3);
        let direct = elastic(&modes(&mesh, &[("EDGE", [false, false, true])], 10));
        assert!(direct.iter().zip(&ours[3..]).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{direct:?} {ours:?}");
        // CalculiX's four mass points show on so coarse a mesh.
        let bound = if kind == CellKind::Tet10 { 3e-3 } else { 1e-5 };
        println!("{}: {ours:?}\n        {theirs:?}", kind.name());
        for (a, b) in ours.iter().zip(&theirs).skip(3) {
            assert!((a / b - 1.0).abs() < bound, "{kind:?}: {ours:?} against {theirs:?}");
        }
    }
}
