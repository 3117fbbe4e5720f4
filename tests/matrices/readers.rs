//! Each format's reader against matrices that are known.

use super::support::dense::full;
use super::support::{box_mesh, part};
use super::{calculix, data, folder};
use nalgebra::DMatrix;
use std::fmt::Write as _;
use std::path::Path;
use stiffmap::matrix::op4::parse_op4;
use stiffmap::matrix::*;
use stiffmap::solid::assemble;

const NOWHERE: &str = "matrix";

fn dense(matrix: Coordinates) -> DMatrix<f64> {
    let name = |row: usize| (row + 1).to_string();
    full(&symmetric(matrix, "stiffness", &name).unwrap_or_else(|e| panic!("{e}")))
}

fn market(text: &str) -> DMatrix<f64> {
    dense(parse_market(text.as_bytes(), Path::new(NOWHERE)).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn matrix_market_in_all_its_forms_is_one_matrix() {
    let expected = DMatrix::from_row_slice(3, 3, &[4.0, -1.0, 0.0, -1.0, 5.0, 2.5, 0.0, 2.5, 6.0]);
    let head = "%%MatrixMarket matrix";
    let forms = [
        format!("{head} coordinate real symmetric\n% lower\n3 3 5\n1 1 4\n2 1 -1\n2 2 5\n3 2 2.5\n3 3 6\n"),
        format!("{head} coordinate real symmetric\n3 3 5\n1 1 4\n1 2 -1\n2 2 5\n2 3 2.5\n3 3 6\n"),
        format!("{head} coordinate real general\n3 3 5\n1 1 4\n1 2 -1\n2 2 5\n2 3 2.5\n3 3 6\n"),
        format!("{head} coordinate real general\n3 3 7\n3 3 6.\n1 1 4E0\n1 2 -1\n2 1 -1\n2 2 5\n2 3 2.5\n3 2 2.5D0\n"),
        format!("{head} array real general\n3 3\n4\n-1\n0\n-1\n5\n2.5\n0\n2.5\n6\n"),
        format!("{} array real symmetric\r\n3 3\r\n4\r\n-1\r\n0\r\n5\r\n2.5\r\n6\r\n", head.to_uppercase()),
    ];
    for form in &forms {
        assert_eq!(market(form), expected, "{form}");
    }
    assert_ne!(market(&forms[0].replace("2.5", "2.6")), expected);
}

fn chain(order: usize) -> [DMatrix<f64>; 2] {
    let stiffness = DMatrix::from_fn(order, order, |i, j| match i.abs_diff(j) {
        0 => 2e9,
        1 => -1e9,
        _ => 0.0,
    });
    [stiffness, DMatrix::from_fn(order, order, |i, j| if i == j { (i + 1) as f64 / 7.0 } else { 0.0 })]
}

/// Files by tests/matrices/op4/make.py, each confirmed by pyNastran's reader.
#[test]
fn output4_in_all_its_forms_is_one_pair_of_matrices() {
    let [stiffness, mass] = chain(9);
    let mut read = 0;
    for entry in std::fs::read_dir(data("op4")).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_none_or(|e| e != "op4") {
            continue;
        }
        let bytes = std::fs::read(&file).unwrap();
        let (matrices, unusable) = parse_op4(&bytes, &file).unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = matrices.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["KAA", "MAA"], "{}", file.display());
        assert!(unusable.len() == 1 && unusable[0].contains("PHI (2 x 3"), "{unusable:?}");
        let single = file.to_string_lossy().contains("single");
        for (seen, expected) in matrices.into_iter().zip([&stiffness, &mass]) {
            let difference = (dense(seen.matrix) - expected).amax() / expected.amax();
            // Seven digits and 24 bits; sixteen digits and 53 bits.
            assert!(difference <= if single { 6e-8 } else { 2e-16 }, "{}: {difference:.1e}", file.display());
        }
        read += 1;
    }
    assert_eq!(read, 14);
}

#[test]
fn abaqus_text_with_labels_and_in_coordinates() {
    let [stiffness, _] = chain(6);
    let (mut labelled, mut coordinates) = (String::from("**\n*MATRIX INPUT, NAME=K, TYPE=SYMMETRIC\n"), String::new());
    for i in 0..6 {
        for j in 0..=i {
            if stiffness[(i, j)] != 0.0 {
                let label = |k: usize| (7 - k / 3, 1 + k % 3);
                let ((a, p), (b, q)) = (label(i), label(j));
                writeln!(labelled, "{a},{p}, {b},{q},  {:.16e}", stiffness[(i, j)]).unwrap();
                writeln!(coordinates, "{} {} {:.16e}", i + 1, j + 1, stiffness[(i, j)]).unwrap();
            }
        }
    }
    let (matrix, labels) = parse_abaqus(labelled.as_bytes(), Path::new(NOWHERE)).unwrap();
    let expected: Vec<DofLabel> =
        (0..6).map(|k| DofLabel::Node { node: 7 - k / 3, direction: (k % 3) as usize }).collect();
    assert_eq!(labels.unwrap(), expected);
    assert_eq!(dense(matrix), stiffness);
    let spaced: String = labelled.lines().filter(|l| !l.starts_with('*')).map(|l| l.replace(',', " ") + "\n").collect();
    assert_eq!(dense(parse_abaqus(spaced.as_bytes(), Path::new(NOWHERE)).unwrap().0), stiffness);
    let (matrix, labels) = parse_abaqus(coordinates.as_bytes(), Path::new(NOWHERE)).unwrap();
    assert!(labels.is_none());
    assert_eq!(dense(matrix), stiffness);
    let doubled = labelled.replace("TYPE=SYMMETRIC", "SCALE FACTOR=2.");
    assert_eq!(dense(parse_abaqus(doubled.as_bytes(), Path::new(NOWHERE)).unwrap().0), 2.0 * &stiffness);
}

/// The elements of a mesh as a deck that makes CalculiX store its matrices.
fn storage_deck(mesh: &stiffmap::mesh::Mesh) -> String {
    let mut deck = String::from("*NODE\n");
    for (label, [x, y, z]) in mesh.node_labels.iter().zip(&mesh.nodes) {
        writeln!(deck, "{label},{x:.14e},{y:.14e},{z:.14e}").unwrap();
    }
    deck += "*ELEMENT,TYPE=C3D10,ELSET=E\n";
    for cell in &mesh.cells {
        let nodes: Vec<String> = cell.nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect();
        writeln!(deck, "{},{}", cell.label, nodes.join(",")).unwrap();
    }
    deck += "*MATERIAL,NAME=S\n*ELASTIC\n2.1E11,0.3\n*DENSITY\n7850\n*SOLID SECTION,ELSET=E,MATERIAL=S\n";
    deck + "*STEP\n*FREQUENCY,SOLVER=MATRIXSTORAGE\n2\n*END STEP\n"
}

#[test]
fn calculix_stores_the_matrices_that_are_assembled_here() {
    let (folder, mesh) = (folder(), box_mesh([0.0; 3], [0.3, 0.1, 0.2], [2, 1, 2]));
    let deck = folder.path().join("box.inp");
    std::fs::write(&deck, storage_deck(&mesh)).unwrap();
    if calculix(&deck).is_none() {
        return;
    }
    let read = |extension: &str| {
        let file = deck.with_extension(extension);
        (std::fs::read(&file).unwrap(), file)
    };
    let own = assemble(&part("box", &[], Vec::new()), &mesh).unwrap();
    let (bytes, file) = read("dof");
    let labels = parse_calculix_dofs(&bytes, &file).unwrap().labels;
    let place = |label: &DofLabel| {
        let DofLabel::Node { node, direction } = *label else { panic!("{label}") };
        own.unknowns_of(mesh.node_labels.iter().position(|l| *l == node).unwrap(), direction)[0].0
    };
    let order: Vec<usize> = labels.iter().map(place).collect();
    let stored = |extension: &str| {
        let (bytes, file) = read(extension);
        dense(parse_calculix(&bytes, &file).unwrap())
    };
    let ordered = |a: DMatrix<f64>| a.select_rows(&order).select_columns(&order);
    let (stiffness, expected) = (stored("sti"), ordered(full(&own.stiffness)));
    let difference = (&stiffness - &expected).amax() / expected.amax();
    assert!(difference < 1e-10, "{difference:.1e}");
    let reversed = expected.select_rows(&(0..order.len()).rev().collect::<Vec<_>>());
    assert!((&stiffness - reversed).amax() / expected.amax() > 0.1);
    // CalculiX integrates the mass by fewer points, which leaves its sums over translations.
    let (mass, expected) = (stored("mas"), ordered(full(&own.mass)));
    let along = |a: &DMatrix<f64>, axis: usize| {
        let unit = DMatrix::from_fn(order.len(), 1, |row, _| f64::from(u8::from(order[row] % 3 == axis)));
        a * unit
    };
    for axis in 0..3 {
        let (a, b) = (along(&mass, axis), along(&expected, axis));
        assert!((&a - &b).amax() < 1e-10 * b.amax(), "axis {axis}");
    }
}
