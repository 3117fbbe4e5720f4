//! Output files, read back by their formats' own readers.

use std::io::Write;
use std::path::Path;
use std::process::Command;

use nalgebra::{Complex, DMatrix};
use serde_json::{Value, json};
use stiffmap::export::manifest::{Check, Manifest};
use stiffmap::export::mat5::{self, Value as Mat};
use stiffmap::export::{ExportError, atomic, eigenfrequencies, mat, response, surface, vts};
use stiffmap::frf::{ComplianceMap, Quantity};
use stiffmap::modal::{ModeFamilies, ModeTableRow, TrackedMode};
use stiffmap::state_space::StateSpace;

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
    let run = Command::new(&python)
        .arg(script)
        .arg(kind)
        .arg(file)
        .arg(&json)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&run.stderr).trim().to_owned();
    match run.status.code() {
        Some(0) => Some(Ok(())),
        Some(1) if !message.contains("Traceback") => Some(Err(message)),
        other => panic!("{python} readers.py {kind} ended with {other:?}: {message}"),
    }
}

fn names(n: usize) -> Vec<String> {
    ["tool.x", "tool.y", "tool.z", "sensor.x"][..n]
        .iter()
        .map(|s| (*s).to_owned())
        .collect()
}

/// A map whose every value is different and tells its place.
fn map(n_position: usize, n_frequency: usize, n_out: usize, n_in: usize) -> ComplianceMap {
    let count = n_position * n_frequency * n_out * n_in;
    ComplianceMap {
        positions: (0..n_position).map(|p| -0.1 * p as f64).collect(),
        frequencies: (0..n_frequency).map(|f| 0.5 * f as f64).collect(),
        outputs: names(n_out),
        inputs: names(n_in),
        quantity: Quantity::Receptance,
        values: (0..count)
            .map(|k| Complex::new(1e-8 * (k as f64 + 0.1).sqrt(), -1e-9 * (k as f64 + 1.0)))
            .collect(),
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
    for (p, f, o, i) in [
        (7, 35, 3, 2),
        (1, 35, 3, 3),
        (7, 1, 2, 3),
        (3, 17, 1, 1),
        (1, 1, 1, 1),
    ] {
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
    let fill = |r: usize, c: usize, seed: f64| {
        DMatrix::from_fn(r, c, |i, j| position + seed + i as f64 + 0.01 * j as f64)
    };
    StateSpace {
        position,
        a: fill(2 * n, 2 * n, 0.5),
        b: fill(2 * n, n_in, 1.5),
        c: fill(rows * n_out, 2 * n, 2.5),
        d: fill(rows * n_out, n_in, 3.5),
        eigenvalues: (0..n).map(|r| 1e4 * (r + 1) as f64).collect(),
        eigenvectors: fill(n, n_out, 4.5),
        damping: vec![0.02; n],
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
        let states: Vec<_> = (0..positions)
            .map(|p| state(-0.005 * p as f64, n, o, i, rows))
            .collect();
        mat::write_state_space(&file, &states, &names(o), &names(i)).unwrap();
        if let Some(read) = read_back(
            "mat",
            &file,
            &expected_states(&states, &names(o), &names(i)),
        ) {
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
    if let Some(read) = read_back(
        "mat",
        &file,
        &expected_states(&states, &names(2), &names(2)),
    ) {
        let message = read.unwrap_err();
        assert!(message.starts_with("states(1).B[4, 1]"), "{message}");
    }
}

#[test]
fn state_matrices_that_do_not_fit_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state_space.mat");
    let write = |s: StateSpace| {
        mat::write_state_space(&file, &[s], &names(2), &names(2))
            .unwrap_err()
            .to_string()
    };
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
    let blocks = Mat::Cell {
        dims: vec![17, 1],
        values,
    };
    let error = mat5::write(&file, &[("blocks", blocks)]).unwrap_err();
    assert!(
        matches!(&error, ExportError::TooLarge { variable, bytes, .. }
            if variable == "blocks" && *bytes > 17 << 27),
        "{error}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_value_that_is_not_finite_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let mut map = map(3, 4, 2, 2);
    map.values[((4 + 3) * 2 + 1) * 2].im = f64::NAN;
    let error = mat::write_compliance(&folder.path().join("c.mat"), &map).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("from tool.x to tool.y at -0.1 m and 1.5 Hz is NaN"),
        "{message}"
    );
    let response = response::Response {
        output: 1,
        input: 0,
        label: "yx".into(),
    };
    let csv = surface::write_surface(&folder.path().join("s.csv"), &map, &response).unwrap_err();
    assert!(csv.to_string().contains("-0.1 m and 1.5 Hz"), "{csv}");
    assert!(vts::write_surface(&folder.path().join("s.vts"), &map, &response).is_err());
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing may be left"
    );
}

#[test]
fn a_surface_holds_the_response_to_nine_digits() {
    let folder = tempfile::tempdir().unwrap();
    let map = map(4, 9, 3, 3);
    let files = surface::write_direct_surfaces(folder.path(), &map).unwrap();
    let found: Vec<_> = files
        .iter()
        .map(|f| f.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        found,
        ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv"]
    );
    for (direction, file) in files.iter().enumerate() {
        let mut lines = csv::Reader::from_path(file).unwrap();
        assert_eq!(
            lines.headers().unwrap(),
            vec![
                "position_m",
                "frequency_hz",
                "magnitude_m_per_N",
                "phase_deg"
            ]
        );
        let rows: Vec<[f64; 4]> = lines.deserialize().map(|r| r.unwrap()).collect();
        assert_eq!(rows.len(), 4 * 9);
        for (k, row) in rows.iter().enumerate() {
            let value = map.values[k * 9 + 4 * direction];
            assert_eq!(
                [row[0], row[1]],
                [map.positions[k / 9], map.frequencies[k % 9]]
            );
            assert!(
                (row[2] / value.norm() - 1.0).abs() < 6e-9,
                "{row:?} for {value}"
            );
            assert!(
                (row[3] - value.arg().to_degrees()).abs() < 6e-7,
                "{row:?} for {value}"
            );
            let other = map.values[k * 9 + 4 * ((direction + 1) % 3)];
            assert!(
                (row[2] / other.norm() - 1.0).abs() > 1e-6,
                "control: another response"
            );
        }
    }
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

fn families() -> ModeFamilies {
    let mode = |family, rank, frequency| TrackedMode {
        family,
        rank,
        frequency,
        damping_ratio: 0.02,
    };
    ModeFamilies {
        positions: vec![0.0, -0.3],
        modes: vec![
            vec![
                mode(1, 1, 0.0),
                mode(2, 2, 14.25),
                mode(3, 3, 1.0 / 3.0 + 20.0),
            ],
            vec![mode(1, 1, 0.0), mode(3, 2, 13.0), mode(2, 3, 15.5)],
        ],
        veerings: Vec::new(),
    }
}

#[test]
fn eigenfrequencies_are_listed_by_position_and_rank() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("eigenfrequencies.csv");
    let mut families = families();
    eigenfrequencies::write_families(&file, &families).unwrap();
    let mut lines = csv::Reader::from_path(&file).unwrap();
    let rows: Vec<(f64, usize, usize, f64, f64)> =
        lines.deserialize().map(|r| r.unwrap()).collect();
    assert_eq!(rows.len(), 6);
    assert_eq!(rows[2], (0.0, 3, 3, 1.0 / 3.0 + 20.0, 0.02));
    assert_eq!(rows[4], (-0.3, 3, 2, 13.0, 0.02));
    families.modes[1][0].frequency = f64::INFINITY;
    let error = eigenfrequencies::write_families(&file, &families).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("frequency of rank 1 at -0.3 m is inf"),
        "{error}"
    );
}

#[test]
fn the_mode_table_leaves_a_free_familys_difference_empty() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mode_table.csv");
    let row = |family, min, max, difference_percent| ModeTableRow {
        family,
        min,
        max,
        difference_percent,
        position_of_min: 0.0,
        position_of_max: -0.6,
        interior_extremum: false,
    };
    let rows = [row(1, 0.0, 0.0, f64::NAN), row(2, 14.0, 17.5, 25.0)];
    eigenfrequencies::write_mode_table(&file, &rows).unwrap();
    assert_eq!(
        std::fs::read_to_string(&file).unwrap(),
        "family,min_hz,max_hz,difference_percent,position_of_min_m,position_of_max_m,\
         interior_extremum\n1,0,0,,0,-0.6,false\n2,14,17.5,25,0,-0.6,false\n"
    );
    let bad = [row(2, 14.0, 17.5, f64::INFINITY)];
    assert!(
        eigenfrequencies::write_mode_table(&file, &bad).is_err(),
        "only a free family's"
    );
}

#[test]
fn a_failed_write_keeps_the_old_file_and_leaves_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("deep/down/file.txt");
    atomic::write_bytes(&file, b"old").unwrap();
    let failed = atomic::write_atomic(&file, |w| {
        w.write_all(&[b'x'; 1 << 20])
            .map_err(atomic::io(&file, "write"))?;
        Err(ExportError::Format {
            path: file.clone(),
            reason: "stopped half-way".into(),
        })
    });
    assert!(
        failed
            .unwrap_err()
            .to_string()
            .ends_with("file.txt: stopped half-way")
    );
    let panicked = std::panic::catch_unwind(|| {
        atomic::write_atomic(&file, |_| panic!("a defect in an exporter"))
    });
    assert!(panicked.is_err());
    assert_eq!(std::fs::read(&file).unwrap(), b"old");
    assert_eq!(
        std::fs::read_dir(file.parent().unwrap()).unwrap().count(),
        1
    );
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("taken"), "a file").unwrap();
    let error = atomic::write_bytes(&folder.path().join("taken/file.txt"), b"x").unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("taken/file.txt: ") && message.starts_with("cannot"),
        "{message}"
    );
}

#[test]
fn the_manifest_keeps_its_order_and_refuses_what_json_cannot_hold() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("manifest.json");
    let mut manifest = Manifest {
        name: "mill".into(),
        ..Manifest::default()
    };
    manifest.backend = json!({ "kind": "cpu", "precision": "f64" });
    manifest.seconds.push("reduce", 3.25);
    manifest.seconds.push("modes", 0.5);
    manifest.seconds.push("again", 0.125);
    manifest.counts.push("nodes", 30_632);
    manifest.checks.push(Check {
        name: "reciprocity".into(),
        figure: 1e-15,
        bound: 1e-12,
        passed: true,
    });
    manifest.write(&file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let at = |name: &str| text.find(name).unwrap();
    assert!(at("\"reduce\"") < at("\"modes\"") && at("\"modes\"") < at("\"again\""));
    let read: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(read["counts"]["nodes"], 30_632);
    assert_eq!(read["checks"][0]["figure"], 1e-15);

    let mut bad = manifest.clone();
    bad.seconds.push("export", f64::NAN);
    assert!(
        bad.write(&file)
            .unwrap_err()
            .to_string()
            .contains("stage `export` is NaN")
    );
    let mut bad = manifest.clone();
    bad.backend = json!({ "difference": f64::INFINITY });
    assert!(
        bad.write(&file)
            .unwrap_err()
            .to_string()
            .contains("`backend.difference` is null")
    );
    let mut bad = manifest.clone();
    bad.seconds.push("modes", 1.0);
    assert!(
        bad.write(&file)
            .unwrap_err()
            .to_string()
            .contains("`modes` is given twice")
    );
    assert_eq!(
        std::fs::read_to_string(&file).unwrap(),
        text,
        "the old file stays"
    );
}

#[test]
fn responses_that_share_a_short_name_get_their_whole_names() {
    let mut map = map(1, 1, 4, 4);
    let labels = |m: &ComplianceMap| -> Vec<String> {
        response::direct_responses(m)
            .into_iter()
            .map(|r| r.label)
            .collect()
    };
    assert_eq!(
        labels(&map),
        ["tool_x_tool_x", "yy", "zz", "sensor_x_sensor_x"]
    );
    map.inputs.truncate(3);
    assert_eq!(labels(&map), ["xx", "yy", "zz"]);
}
