//! Footprints shorter than the elements of their rail, and values that no machine has.

use super::*;
use std::time::Instant;

/// Frequencies of the modes at one position, Hz.
fn frequencies(footprint: &str) -> (Vec<f64>, String, f64) {
    let folder = tempfile::tempdir().unwrap();
    let machine = edited(folder.path(), &[("footprint = \"120 mm\"", &format!("footprint = \"{footprint}\""))]);
    let out = folder.path().join("out");
    let started = Instant::now();
    let output = run(&machine, &out).args(["--position", "0.1"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let mut rows = csv::Reader::from_path(out.join("eigenfrequencies.csv")).unwrap();
    let found = rows.records().map(|row| row.unwrap()[3].parse().unwrap()).collect();
    (found, said(&output), started.elapsed().as_secs_f64())
}

#[test]
fn a_footprint_below_the_mesh_costs_no_more_than_the_mesh_and_is_said() {
    // Trained every 1.4 mm, as the length of the footprint asked for before, in a minute: 429 footprints.
    let dense = [412.866_709_536_513_95, 739.712_274_849_691_1, 922.078_267_553_426];
    let (found, said, _) = frequencies("5 mm");
    for (found, dense) in found.iter().zip(dense) {
        // The fixed basis of the whole machine has fewer directions too, and is checked to 1e-5.
        assert!((found / dense - 1.0).abs() < 5e-8, "{found} Hz, {dense} Hz");
    }
    assert!(said.contains("5 mm on a rail whose elements are 83.33 mm long"), "{said}");
    // It need not be fast, but 3,000 times the elements' length took hours and gigabytes.
    let (shorter, _, seconds) = frequencies("0.02 mm");
    assert!(seconds < 20.0, "{seconds} s");
    for (short, dense) in shorter.iter().zip(dense) {
        // A point in place of 5 mm in the middle of a linear brick.
        assert!((short / dense - 1.0).abs() < 1e-5, "{short} Hz, {dense} Hz");
    }
    // Control: a footprint that the mesh does tell apart differs, and nothing is said.
    let (longer, said, _) = frequencies("120 mm");
    assert!((longer[0] / dense[0] - 1.0).abs() > 1e-4 && !said.contains("elements are"), "{said}");
}

#[test]
fn values_beyond_any_machine_are_refused_with_file_key_and_value() {
    let changes = [
        ("footprint = \"120 mm\"", "footprint = \"1e-12 m\"", "footprint"),
        ("at = [\"50 mm\", \"165 mm\", \"500 mm\"]", "at = [0, 0, 1e27]", "at"),
        ("diameter = \"20 mm\"", "diameter = 1e305", "diameter"),
        ("density = \"7200 kg/m3\"", "density = 1e-300", "density"),
        ("young = \"115 GPa\"", "young = 1e300", "young"),
        ("stiffness = \"1 N/um\"", "stiffness = 1e30", "stiffness"),
    ];
    for (from, to, key) in changes {
        let folder = tempfile::tempdir().unwrap();
        let output = run(&edited(folder.path(), &[(from, to)]), &folder.path().join("out")).output().unwrap();
        let said = said(&output);
        let value = to.rsplit(['=', ',', ' ']).next().unwrap().trim_matches(['"', ']']);
        assert_eq!(output.status.code(), Some(2), "{to}: {said}");
        let number = value.trim_end_matches(" m");
        assert!(said.contains("machine.toml:") && said.contains(key) && said.contains("allowed:"), "{said}");
        assert!(said.contains(number) || key == "footprint", "{number}: {said}");
    }
}

#[test]
fn a_line_of_a_hundred_megabytes_is_quoted_by_its_ends() {
    let folder = tempfile::tempdir().unwrap();
    let long = format!("*NODE\n1, 0., 0., {}\n", "9x".repeat(25_000_000));
    let machine = edited(folder.path(), &[]);
    std::fs::write(folder.path().join("tool.inp"), long).unwrap();
    let output = run(&machine, &folder.path().join("out")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stderr.len() < 20_000, "{} bytes", output.stderr.len());
    assert!(said(&output).contains("tool.inp"), "{}", said(&output));

    std::fs::write(&machine, format!("name = \"{}", "a".repeat(17 << 20))).unwrap();
    let output = run(&machine, &folder.path().join("out")).output().unwrap();
    assert!(output.status.code() == Some(2) && said(&output).contains("larger than 16 MiB"), "{}", said(&output));
}
