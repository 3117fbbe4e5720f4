//! CSV files, the manifest, and files that are there whole or not at all.

use std::io::Write;

use serde_json::{Value, json};
use stiffmap::export::manifest::{Check, Manifest};
use stiffmap::export::{ExportError, atomic, eigenfrequencies, mat, response, surface, vts};
use stiffmap::frf::ComplianceMap;
use stiffmap::modal::{ModeFamilies, ModeTableRow, TrackedMode};

mod numbered;
use numbered::map;

#[test]
fn a_value_that_is_not_finite_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let mut map = map(3, 4, 2, 2);
    map.values[((4 + 3) * 2 + 1) * 2].im = f64::NAN;
    let error = mat::write_compliance(&folder.path().join("c.mat"), &map).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("from tool.x to tool.y at -0.1 m and 1.5 Hz is NaN"), "{message}");
    let response = response::Response { output: 1, input: 0, label: "yx".into() };
    let csv = surface::write_surface(&folder.path().join("s.csv"), &map, &response).unwrap_err();
    assert!(csv.to_string().contains("-0.1 m and 1.5 Hz"), "{csv}");
    assert!(vts::write_surface(&folder.path().join("s.vts"), &map, &response).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing may be left");
}

#[test]
fn a_surface_holds_the_response_to_nine_digits() {
    let folder = tempfile::tempdir().unwrap();
    let map = map(4, 9, 3, 3);
    let files = surface::write_direct_surfaces(folder.path(), &map).unwrap();
    let found: Vec<_> = files.iter().map(|f| f.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(found, ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv"]);
    for (direction, file) in files.iter().enumerate() {
        let mut lines = csv::Reader::from_path(file).unwrap();
        assert_eq!(lines.headers().unwrap(), vec!["position_m", "frequency_hz", "magnitude_m_per_N", "phase_deg"]);
        let rows: Vec<[f64; 4]> = lines.deserialize().map(|r| r.unwrap()).collect();
        assert_eq!(rows.len(), 4 * 9);
        for (k, row) in rows.iter().enumerate() {
            let value = map.values[k * 9 + 4 * direction];
            assert_eq!([row[0], row[1]], [map.positions[k / 9], map.frequencies[k % 9]]);
            assert!((row[2] / value.norm() - 1.0).abs() < 6e-9, "{row:?} for {value}");
            assert!((row[3] - value.arg().to_degrees()).abs() < 6e-7, "{row:?} for {value}");
            let other = map.values[k * 9 + 4 * ((direction + 1) % 3)];
            assert!((row[2] / other.norm() - 1.0).abs() > 1e-6, "control: another response");
        }
    }
}

fn families() -> ModeFamilies {
    let mode = |family, rank, frequency| TrackedMode { family, rank, frequency, damping_ratio: 0.02 };
    ModeFamilies {
        positions: vec![0.0, -0.3],
        modes: vec![
            vec![mode(1, 1, 0.0), mode(2, 2, 14.25), mode(3, 3, 1.0 / 3.0 + 20.0)],
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
    let errors = vec![vec![None, Some(2.5e-6), Some(0.0)], vec![None, None, None]];
    eigenfrequencies::write_families(&file, &families, &errors).unwrap();
    let mut lines = csv::Reader::from_path(&file).unwrap();
    let rows: Vec<(f64, usize, usize, f64, f64, Option<f64>)> = lines.deserialize().map(|r| r.unwrap()).collect();
    assert_eq!(rows.len(), 6);
    assert_eq!(rows[2], (0.0, 3, 3, 1.0 / 3.0 + 20.0, 0.02, Some(0.0)));
    assert_eq!((rows[0].5, rows[1].5), (None, Some(2.5e-6)));
    assert_eq!(rows[4], (-0.3, 3, 2, 13.0, 0.02, None));
    families.modes[1][0].frequency = f64::INFINITY;
    let error = eigenfrequencies::write_families(&file, &families, &errors).unwrap_err();
    assert!(error.to_string().contains("frequency of rank 1 at -0.3 m is inf"), "{error}");
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
        reduction_error: (min > 0.0).then_some(2e-6),
    };
    let rows = [row(1, 0.0, 0.0, f64::NAN), row(2, 14.0, 17.5, 25.0)];
    eigenfrequencies::write_mode_table(&file, &rows).unwrap();
    assert_eq!(
        std::fs::read_to_string(&file).unwrap(),
        "family,min_hz,max_hz,difference_percent,position_of_min_m,position_of_max_m,\
         interior_extremum,reduction_error\n1,0,0,,0,-0.6,false,\n2,14,17.5,25,0,-0.6,false,0.000002\n"
    );
    let bad = [row(2, 14.0, 17.5, f64::INFINITY)];
    assert!(eigenfrequencies::write_mode_table(&file, &bad).is_err(), "only a free family's");
}

#[test]
fn a_failed_write_keeps_the_old_file_and_leaves_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("deep/down/file.txt");
    atomic::write_bytes(&file, b"old").unwrap();
    let failed = atomic::write_atomic(&file, |w| {
        w.write_all(&[b'x'; 1 << 20]).map_err(atomic::io(&file, "write"))?;
        Err(ExportError::Format { path: file.clone(), reason: "stopped half-way".into() })
    });
    assert!(failed.unwrap_err().to_string().ends_with("file.txt: stopped half-way"));
    let panicked = std::panic::catch_unwind(|| atomic::write_atomic(&file, |_| panic!("a defect in an exporter")));
    assert!(panicked.is_err());
    assert_eq!(std::fs::read(&file).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(file.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("taken"), "a file").unwrap();
    let error = atomic::write_bytes(&folder.path().join("taken/file.txt"), b"x").unwrap_err();
    let message = error.to_string();
    assert!(message.contains("taken/file.txt: ") && message.starts_with("cannot"), "{message}");
}

#[test]
fn the_manifest_keeps_its_order_and_refuses_what_json_cannot_hold() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("manifest.json");
    let mut manifest = Manifest { name: "mill".into(), ..Manifest::default() };
    manifest.backend = json!({ "kind": "cpu", "precision": "f64" });
    manifest.seconds.push("reduce", 3.25);
    manifest.seconds.push("modes", 0.5);
    manifest.seconds.push("again", 0.125);
    manifest.counts.push("nodes", 30_632);
    manifest.checks.push(Check { name: "reciprocity".into(), figure: 1e-15, bound: 1e-12, passed: true });
    manifest.write(&file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let at = |name: &str| text.find(name).unwrap();
    assert!(at("\"reduce\"") < at("\"modes\"") && at("\"modes\"") < at("\"again\""));
    let read: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(read["counts"]["nodes"], 30_632);
    assert_eq!(read["checks"][0]["figure"], 1e-15);

    let mut bad = manifest.clone();
    bad.seconds.push("export", f64::NAN);
    assert!(bad.write(&file).unwrap_err().to_string().contains("stage `export` is NaN"));
    let mut bad = manifest.clone();
    bad.backend = json!({ "difference": f64::INFINITY });
    assert!(bad.write(&file).unwrap_err().to_string().contains("`backend.difference` is null"));
    let mut bad = manifest.clone();
    bad.seconds.push("modes", 1.0);
    assert!(bad.write(&file).unwrap_err().to_string().contains("`modes` is given twice"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text, "the old file stays");
}

#[test]
fn responses_that_share_a_short_name_get_their_whole_names() {
    let mut map = map(1, 1, 4, 4);
    let labels =
        |m: &ComplianceMap| -> Vec<String> { response::direct_responses(m).into_iter().map(|r| r.label).collect() };
    assert_eq!(labels(&map), ["tool_x_tool_x", "yy", "zz", "sensor_x_sensor_x"]);
    map.inputs.truncate(3);
    assert_eq!(labels(&map), ["xx", "yy", "zz"]);
}
