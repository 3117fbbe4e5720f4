//! MAT and VTS files, read back by SciPy and VTK to the last bit.

use std::path::Path;
use std::process::Command;

use nalgebra::DMatrix;
use serde_json::{Value, json};
use stiffmap::export::mat5::{self, Value as Mat};
use stiffmap::export::{ExportError, mat, response, vts};
use stiffmap::frf::ComplianceMap;
use stiffmap::state_space::StateSpace;

mod numbered;
use numbered::{map, names};

/// Runs `tests/readers.py`; `None` where the Python tests are switched off by name.
fn read_back(kind: &str, file: &Path, expected: &Value) -> Option<Result<(), String>> {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return None;
    }
    let python = std::env::var("STIFFMAP_PYTHON").unwrap_or_else(|_| {
        panic!(
            "STIFFMAP_PYTHON names no Python; set it to one that has scipy and pyvista, or set \
             STIFFMAP_PYTHON_TESTS=skip"
        )
    });
    let json = file.with_extension("expected.json");
    std::fs::write(&json, expected.to_string()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/readers.py");
    let run = Command::new(&python).arg(script).arg(kind).arg(file).arg(&json).output().unwrap();
    let message = String::from_utf8_lossy(&run.stderr).trim().to_owned();
    match run.status.code() {
        Some(0) => Some(Ok(())),
        Some(1) if !message.contains("Traceback") => Some(Err(message)),
        other => panic!("{python} readers.py {kind} ended with {other:?}: {message}"),
    }
}

fn column(values: &[f64]) -> Value {
    json!({ "shape": [values.len(), 1], "re": values })
}

fn cells(names: &[String]) -> Value {
    json!({ "cells": names })
}

fn matrix(m: &DMatrix<f64>) -> Value {
    json!({ "shape": [m.nrows(), m.ncols()], "re": m.transpose().as_slice() })
}

fn expected_compliance(m: &ComplianceMap) -> Value {
    json!({
        "position_m": column(&m.positions),
        "frequency_hz": column(&m.frequencies),
        "output": cells(&m.outputs),
        "input": cells(&m.inputs),
        "quantity": "receptance",
        "unit": "m/N",
        "receptance": {
            "shape": [m.positions.len(), m.frequencies.len(), m.outputs.len(), m.inputs.len()],
            "re": m.values.iter().map(|v| v.re).collect::<Vec<_>>(),
            "im": m.values.iter().map(|v| v.im).collect::<Vec<_>>(),
        },
    })
}

#[test]
fn scipy_reads_the_compliance_map_in_every_shape() {
    let folder = tempfile::tempdir().unwrap();
    // More than one block of frequencies, a block with a rest, and each extent alone at one.
    for (p, f, o, i) in [(7, 35, 3, 2), (1, 35, 3, 3), (7, 1, 2, 3), (3, 17, 1, 1), (1, 1, 1, 1)] {
        let map = map(p, f, o, i);
        let file = folder.path().join("compliance.mat");
        mat::write_compliance(&file, &map).unwrap();
        if let Some(read) = read_back("mat", &file, &expected_compliance(&map)) {
            read.unwrap_or_else(|e| panic!("{p} x {f} x {o} x {i}: {e}"));
        }
    }
}

#[test]
fn negative_control_one_perturbed_compliance_fails() {
    let folder = tempfile::tempdir().unwrap();
    let mut map = map(4, 20, 3, 3);
    let file = folder.path().join("compliance.mat");
    mat::write_compliance(&file, &map).unwrap();
    map.values[((2 * 20 + 5) * 3 + 1) * 3 + 2].im *= 1.0 + 1e-15;
    if let Some(read) = read_back("mat", &file, &expected_compliance(&map)) {
        let message = read.unwrap_err();
        assert!(message.starts_with("receptance[2, 5, 1, 2]"), "{message}");
    }
}

fn state(position: f64, n: usize, n_out: usize, n_in: usize, rows: usize) -> StateSpace {
    let fill =
        |r: usize, c: usize, seed: f64| DMatrix::from_fn(r, c, |i, j| position + seed + i as f64 + 0.01 * j as f64);
    StateSpace {
        position,
        a: fill(2 * n, 2 * n, 0.5),
        b: fill(2 * n, n_in, 1.5),
        c: fill(rows * n_out, 2 * n, 2.5),
        d: fill(rows * n_out, n_in, 3.5),
        eigenvalues: (0..n).map(|r| 1e4 * (r + 1) as f64).collect(),
        eigenvectors: fill(n, n_out, 4.5),
        damping: vec![0.02; n],
        dampers: nalgebra::DMatrix::zeros(0, n),
    }
}

fn expected_states(states: &[StateSpace], outputs: &[String], inputs: &[String]) -> Value {
    let structs: Vec<_> = states
        .iter()
        .map(|s| {
            json!({
                "position": { "shape": [1, 1], "re": [s.position] },
                "A": matrix(&s.a), "B": matrix(&s.b), "C": matrix(&s.c), "D": matrix(&s.d),
                "eigenvalues": column(&s.eigenvalues),
                "eigenvectors": matrix(&s.eigenvectors),
                "damping": column(&s.damping),
            })
        })
        .collect();
    json!({
        "states": { "structs": structs },
        "inputs": cells(inputs),
        "outputs": cells(outputs),
        "units": { "structs": [{
            "position": "m", "input": "N", "displacement": "m", "velocity": "m/s",
            "acceleration": "m/s^2", "eigenvalues": "(rad/s)^2",
        }] },
    })
}

#[test]
fn scipy_reads_the_state_space_database() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state_space.mat");
    // (positions, modes, outputs, inputs, row blocks in C)
    for (positions, n, o, i, rows) in [(5, 30, 4, 3, 1), (3, 4, 2, 3, 3), (1, 1, 1, 1, 1)] {
        let states: Vec<_> = (0..positions).map(|p| state(-0.005 * p as f64, n, o, i, rows)).collect();
        mat::write_state_space(&file, &states, &names(o), &names(i)).unwrap();
        if let Some(read) = read_back("mat", &file, &expected_states(&states, &names(o), &names(i))) {
            read.unwrap_or_else(|e| panic!("{positions} positions, {n} modes: {e}"));
        }
    }
}

#[test]
fn negative_control_one_perturbed_state_matrix_fails() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state_space.mat");
    let mut states = vec![state(0.0, 3, 2, 2, 1), state(-0.3, 3, 2, 2, 1)];
    mat::write_state_space(&file, &states, &names(2), &names(2)).unwrap();
    states[1].b[(4, 1)] += 1e-12;
    if let Some(read) = read_back("mat", &file, &expected_states(&states, &names(2), &names(2))) {
        let message = read.unwrap_err();
        assert!(message.starts_with("states(1).B[4, 1]"), "{message}");
    }
}

#[test]
fn state_matrices_that_do_not_fit_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state_space.mat");
    let write = |s: StateSpace| mat::write_state_space(&file, &[s], &names(2), &names(2)).unwrap_err().to_string();
    let mut short = state(-0.3, 3, 2, 2, 1);
    short.damping.pop();
    assert!(write(short).contains("the damping at -0.3 m has 2 entries, expected 3"));
    let mut narrow = state(-0.3, 3, 2, 2, 1);
    narrow.b = DMatrix::zeros(6, 1);
    assert!(write(narrow).contains("columns of B at -0.3 m has 1 entries, expected 2"));
    let mut nan = state(-0.3, 3, 2, 2, 1);
    nan.a[(1, 2)] = f64::NAN;
    assert!(write(nan).contains("A (column by column) at -0.3 m 13 is NaN"));
}

#[test]
fn a_variable_past_two_gibibytes_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("large.mat");
    // Seventeen cells that borrow one block of 128 MiB.
    let block = vec![0.0; 1 << 24];
    let values = (0..17).map(|_| Mat::column(&block)).collect();
    let blocks = Mat::Cell { dims: vec![17, 1], values };
    let error = mat5::write(&file, &[("blocks", blocks)]).unwrap_err();
    assert!(
        matches!(&error, ExportError::TooLarge { variable, bytes, .. }
            if variable == "blocks" && *bytes > 17 << 27),
        "{error}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn vtk_reads_the_surface_and_a_perturbed_value_fails() {
    let folder = tempfile::tempdir().unwrap();
    let map = map(3, 5, 2, 2);
    let file = folder.path().join("surface_yy.vts");
    let response = response::direct_responses(&map).remove(1);
    vts::write_surface(&file, &map, &response).unwrap();
    let values: Vec<_> = (0..15).map(|k| map.values[k * 4 + 3]).collect();
    let flat = |data: Vec<f64>| json!({ "shape": [data.len()], "re": data });
    let magnitudes: Vec<f64> = values.iter().map(|v| v.re.hypot(v.im)).collect();
    let mut expected = json!({
        "unit": "m/N",
        "dimensions": flat(vec![5.0, 3.0, 1.0]),
        "bounds": flat(vec![0.0, 1.0, 0.0, 1.6, 0.0, 0.6]),
        "position_m": flat((0..15).map(|k| map.positions[k / 5]).collect()),
        "frequency_hz": flat((0..15).map(|k| map.frequencies[k % 5]).collect()),
        "magnitude": flat(magnitudes.clone()),
        "log10_magnitude": flat(magnitudes.iter().map(|m| m.log10()).collect()),
        "phase_deg": flat(values.iter().map(|v| v.im.atan2(v.re).to_degrees()).collect()),
    });
    if let Some(read) = read_back("vts", &file, &expected) {
        read.unwrap();
        expected["magnitude"]["re"][7] = json!(magnitudes[7] * (1.0 + 1e-15));
        let message = read_back("vts", &file, &expected).unwrap().unwrap_err();
        assert!(message.starts_with("magnitude[7]"), "{message}");
    }
}
