//! Command-line values that take the place of the machine file's.

use super::*;

fn positions(out: &Path) -> Vec<f64> {
    let mut found = column(&out.join("surface_xx.csv"), "position_m");
    found.dedup();
    found
}

#[test]
fn a_position_may_be_negative_and_off_the_stations() {
    let out = tempfile::tempdir().unwrap();
    let record = quick(out.path(), &["--position", "-0.4512", "--frequencies", "5,25,55"]);
    assert_eq!(record["counts"]["positions"], 1);
    assert_eq!(positions(out.path()), [-0.4512]);
    assert_eq!(column(&out.path().join("surface_zz.csv"), "frequency_hz"), [5.0, 25.0, 55.0]);
}

#[test]
fn a_range_includes_its_end() {
    let out = tempfile::tempdir().unwrap();
    quick(out.path(), &["--positions", "0:-0.6:0.1", "--frequencies", "10:30:10"]);
    assert_eq!(positions(out.path()), [0.0, -0.1, -0.2, -0.3, -0.4, -0.5, -0.6]);
    let frequencies = column(&out.path().join("surface_xx.csv"), "frequency_hz");
    assert_eq!(frequencies[..3], [10.0, 20.0, 30.0]);
}

#[test]
fn damping_takes_the_place_of_the_files() {
    let (little, usual) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    quick(little.path(), &["--position", "0", "--damping", "0.01", "--frequencies", "30:50:0.05"]);
    quick(usual.path(), &["--position", "0", "--frequencies", "30:50:0.05"]);
    let ratios = |out: &TempDir| column(&out.path().join("eigenfrequencies.csv"), "damping_ratio");
    assert!(ratios(&little)[1..].iter().all(|zeta| *zeta == 0.01));
    assert!(ratios(&usual)[1..].iter().all(|zeta| *zeta == 0.02));
    let peak = |out: &TempDir| {
        let magnitudes = column(&out.path().join("surface_xx.csv"), "magnitude_m_per_N");
        magnitudes.into_iter().fold(0.0, f64::max)
    };
    // Half the damping: nearly twice the peak.
    let ratio = peak(&little) / peak(&usual);
    assert!((1.8..2.2).contains(&ratio), "{ratio}");
}

#[test]
fn exactly_n_modes_reach_map_and_tables() {
    let (with, without) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let grid = ["--position", "0", "--frequencies", "0,20", "--modes", "20"];
    let record = quick(without.path(), &[&grid[..], &["--no-residual"]].concat());
    assert_eq!(record["counts"]["elastic_modes_reported"], 20);
    assert_eq!(record["counts"]["modes_in_map_most"], 20);
    assert_eq!(record["settings"]["exactly_n_modes"], true);
    assert!(record["settings"].get("residual_degree").is_none());
    assert_eq!(column(&without.path().join("eigenfrequencies.csv"), "rank").len(), 21);

    let record = quick(with.path(), &grid);
    assert_eq!(record["settings"]["residual_degree"], 0);
    // What is left out of 20 modes makes the machine look stiffer at 0 Hz.
    for surface in ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv"] {
        let at_rest = |out: &TempDir| column(&out.path().join(surface), "magnitude_m_per_N")[0];
        assert!(at_rest(&with) > 1.001 * at_rest(&without), "{surface}");
    }
}

#[test]
fn json_prints_the_manifest_and_nothing_else() {
    let out = tempfile::tempdir().unwrap();
    let arguments = ["--json", "--no-figures", "--position", "-0.3", "--frequencies", "10"];
    let run = run_into(warm_cache(), out.path(), &arguments);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let printed: Value = serde_json::from_str(&stdout(&run)).unwrap();
    assert_eq!(printed, manifest(out.path()));
    assert_eq!(stderr(&run), "");
}

/// Whether there is a device; without one, STIFFMAP_GPU=require is a failure.
fn has_adapter() -> bool {
    let listed = stiffmap(warm_cache()).args(["devices", "--json"]).output().unwrap();
    let found: Value = serde_json::from_str(&stdout(&listed)).unwrap();
    let any = !found.as_array().unwrap().is_empty();
    let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
    assert!(any || !required, "STIFFMAP_GPU=require and no adapter");
    any
}

#[test]
fn the_device_computes_the_same_map() {
    if !has_adapter() {
        println!("skipped: no adapter");
        return;
    }
    let (cpu, gpu) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let grid = ["--positions", "0,-0.3,-0.6", "--frequencies", "0:200:1"];
    quick(cpu.path(), &[&grid[..], &["--backend", "cpu"]].concat());
    let record = quick(gpu.path(), &[&grid[..], &["--backend", "gpu"]].concat());
    assert_eq!(record["backend"]["backend"], "gpu");
    println!("adapter: {}", record["backend"]["adapter"]);
    for surface in ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv"] {
        let read = |out: &TempDir| column(&out.path().join(surface), "magnitude_m_per_N");
        let (expected, found) = (read(&cpu), read(&gpu));
        assert_eq!(found.len(), 3 * 201);
        let largest = expected.iter().copied().fold(0.0, f64::max);
        let pairs = || expected.iter().zip(&found);
        assert!(pairs().all(|(e, f)| (e - f).abs() <= 2e-6 * largest), "{surface}");
        assert!(pairs().any(|(e, f)| (1.0 + 1e-4) * e - f > 2e-6 * largest), "the bound notices 1e-4");
    }
}

#[test]
fn without_a_driver_gpu_is_an_error_and_auto_falls_back() {
    let out = tempfile::tempdir().unwrap();
    let run = |backend: &str| {
        let mut command = stiffmap(warm_cache());
        command.args(["run", "--no-figures", "--position", "0", "--frequencies", "10", "--backend", backend]);
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        command.arg("--out").arg(out.path()).output().unwrap()
    };
    let refused = run("gpu");
    let said = stderr(&refused);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("error: ") && said.contains("adapter"), "{said}");
    assert!(!out.path().join("manifest.json").exists());

    let fallen_back = run("auto");
    assert_eq!(fallen_back.status.code(), Some(0), "{}", stderr(&fallen_back));
    assert_eq!(manifest(out.path())["backend"]["backend"], "cpu");
}
