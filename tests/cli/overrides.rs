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
fn quantities_reach_the_files_under_their_own_names() {
    let frequencies = "10,40.5,300";
    let columns = [
        ("receptance", "magnitude_m_per_N", "m/N", "smallest_dynamic_stiffness"),
        ("mobility", "magnitude_m_per_s_N", "m/(s N)", "largest_mobility"),
        ("accelerance", "magnitude_m_per_s2_N", "m/(s^2 N)", "largest_accelerance"),
    ];
    let mut before: Option<Vec<f64>> = None;
    for (quantity, header, unit, extreme) in columns {
        let out = tempfile::tempdir().unwrap();
        let record = quick(out.path(), &["--position", "0", "--frequencies", frequencies, "--quantity", quantity]);
        assert_eq!((&record["settings"]["quantity"], &record["settings"]["unit"]), (&quantity.into(), &unit.into()));
        assert_eq!(record["settings"][extreme].as_array().unwrap().len(), 3);
        assert_eq!(record["settings"]["most_negative_real_part"].as_array().unwrap().len(), 3);
        let magnitudes = column(&out.path().join("surface_xx.csv"), header);
        if let Some(before) = before {
            for ((now, before), f) in magnitudes.iter().zip(before).zip([10.0, 40.5, 300.0]) {
                assert!((now / (before * std::f64::consts::TAU * f) - 1.0).abs() < 1e-8, "{quantity} at {f} Hz");
            }
        }
        before = Some(magnitudes);
        // The variable of the MAT-file has the quantity's name.
        let mat = std::fs::read(out.path().join("compliance.mat")).unwrap();
        assert!(mat.windows(quantity.len()).any(|w| w == quantity.as_bytes()), "{quantity}");
    }
}

#[test]
fn grids_are_laid_as_their_names_say() {
    let out = tempfile::tempdir().unwrap();
    let grid = |text: &str| {
        let record = quick(out.path(), &["--position", "0", "--frequencies", text]);
        let frequencies = column(&out.path().join("surface_xx.csv"), "frequency_hz");
        assert_eq!(record["counts"]["frequencies"], frequencies.len());
        (record["settings"]["frequency_grid"].as_str().unwrap().to_owned(), frequencies)
    };
    let (name, found) = grid("logarithmic:1:100:3");
    assert_eq!((name.as_str(), found[0], found[2], found.len()), ("logarithmic", 1.0, 100.0, 3));
    assert!((found[1] - 10.0).abs() < 1e-12);
    assert_eq!(grid("uniform:5:10:5"), ("uniform".into(), vec![5.0, 10.0]));
    assert_eq!(grid("5,7").0, "listed");
    // Modes at 40.6 and 42.5 Hz, and background at 30, 35, .. 60 Hz.
    let (name, found) = grid("clustered:30:60:13:7");
    assert_eq!((name.as_str(), found[0], *found.last().unwrap()), ("clustered", 30.0, 60.0));
    assert!((20..60).contains(&found.len()), "{found:?}");
    let near = found.iter().filter(|f| (39.8..43.4).contains(*f)).count();
    assert!(near > 13, "{near} of {}", found.len());
}

#[test]
fn the_machine_file_names_grid_and_quantity() {
    let (mill, out) = (Mill::new(), tempfile::tempdir().unwrap());
    mill.replace(
        "machine.toml",
        "frequencies = { from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }",
        "frequencies = { grid = \"clustered\", from = \"20 Hz\", to = \"60 Hz\", background = 5 }",
    );
    mill.replace("machine.toml", "quantity = \"receptance\"", "quantity = \"mobility\"");
    let mut run = stiffmap(warm_cache());
    run.arg("run").arg(mill.0.path()).args(["--no-figures", "--positions", "0,-0.6", "--out"]).arg(out.path());
    let run = run.output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    assert!(stderr(&run).contains("largest mobility |H|"), "{}", stderr(&run));
    let settings = &manifest(out.path())["settings"];
    assert_eq!((&settings["frequency_grid"], &settings["quantity"]), (&"clustered".into(), &"mobility".into()));
    let frequencies = column(&out.path().join("surface_yy.csv"), "frequency_hz");
    assert_eq!((frequencies[0], frequencies[frequencies.len() - 1]), (20.0, 60.0));
    assert!(column(&out.path().join("surface_yy.csv"), "magnitude_m_per_s_N").iter().all(|h| *h > 0.0));
    let check = stiffmap(warm_cache()).arg("check").arg(mill.0.path()).output().unwrap();
    assert!(stdout(&check).contains("mobility from 20 to 60 Hz (clustered grid, 13 frequencies a mode on 5)"));
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
