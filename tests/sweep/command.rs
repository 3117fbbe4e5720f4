//! `stiffmap sweep` from the study to its files.

use super::*;
use serde_json::Value;

fn manifest(folder: &Path, out: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(out).join("manifest.json")).unwrap()).unwrap()
}

#[test]
fn a_sweep_leaves_table_front_maps_pictures_and_manifest() {
    let folder = folder_with(STUDY);
    let mut command = stiffmap();
    command.current_dir(folder.path()).args([
        "sweep",
        "study.toml",
        "--out",
        "out",
        "--maps",
        "0,23",
        "--sensitivities",
    ]);
    done(&command.output().unwrap());
    assert_eq!(table(folder.path(), "out"), reference(), "maps and pictures change nothing");
    let files = [
        "pareto.csv",
        "sensitivities.csv",
        "maps/0000/compliance.mat",
        "maps/0023/compliance.mat",
        "figures/metrics_over_variables.png",
        "figures/front.png",
        "figures/best_over_position.png",
    ];
    let manifest = manifest(folder.path(), "out");
    let listed: Vec<&str> = manifest["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    for file in files {
        assert!(out_of(&folder).join(file).is_file() && listed.contains(&file), "{file}: {listed:?}");
    }
    assert_eq!(manifest["settings"]["route"], "modes");
    assert!(manifest["settings"]["route_why"].as_str().is_some_and(|why| !why.is_empty()));
    assert!(manifest["settings"]["pairs_per_second"].as_f64().is_some_and(|rate| rate > 0.0));
    assert_eq!((&manifest["counts"]["rows"], &manifest["counts"]["pairs_done_now"]), (&24.into(), &120.into()));
    assert!(manifest["seconds"]["designs"].as_f64().is_some());
}

#[test]
fn the_table_has_every_variable_and_metric_with_its_unit() {
    let header = reference().lines().next().unwrap();
    assert_eq!(
        header,
        "design,guide_x [N/m],diameter [m],cost [EUR],stiffness_x [N/m],stiffness_z [N/m],bounds_met,error"
    );
    assert_eq!(numbers(reference(), "design"), (0..24).map(f64::from).collect::<Vec<_>>());
    // A thicker screw is stiffer along z, and the cost is what the study says.
    let (d, z) = (numbers(reference(), "diameter [m]"), numbers(reference(), "stiffness_z [N/m]"));
    let by =
        |largest: bool| (0..24).max_by(|&a, &b| if largest { d[a].total_cmp(&d[b]) } else { d[b].total_cmp(&d[a]) });
    assert!(z[by(true).unwrap()] > 1.5 * z[by(false).unwrap()]);
    for (k, cost) in numbers(reference(), "guide_x [N/m]").iter().zip(numbers(reference(), "cost [EUR]")) {
        assert!((cost - (10.0 + 2.0 * k * 1e-6)).abs() < 1e-9);
    }
}

#[test]
fn a_design_that_cannot_be_has_a_row_with_its_error() {
    let text = changed(
        "[sampling]",
        "[variables.length]\npath = \"joints.screw.free_length\"\nvalues = [\"200 mm\", \"500 mm\"]\n[sampling]",
    );
    let folder = folder_with(&text.replace("designs = 24", "designs = 4"));
    done(&sweep(folder.path(), "out", &[]));
    let table = table(folder.path(), "out");
    let rows = numbers(&table, "length [m]").into_iter().zip(column(&table, "stiffness_z [N/m]"));
    for ((length, stiffness), error) in rows.zip(column(&table, "error")) {
        // The carriage comes 300 mm closer to the mount.
        assert_eq!(length == 0.2, stiffness.is_empty());
        assert_eq!(length == 0.2, error.contains("free length of the screw is -0.1"), "{error}");
    }
    let manifest = manifest(folder.path(), "out");
    assert_eq!(manifest["counts"]["rows_with_errors"], 2);
    assert!(manifest["warnings"].to_string().contains("2 rows lack values"));
}

#[test]
fn a_sweep_and_a_search_in_which_no_design_is_answered_fail() {
    let with = |lengths: &str| {
        let variable =
            format!("[variables.length]\npath = \"joints.screw.free_length\"\nvalues = {lengths}\n[sampling]");
        let text = changed("[sampling]", &variable).replace("designs = 24", "designs = 4");
        folder_with(&(text + "\n[optimise]\nobjective = \"stiffness_x\"\nevaluations = 10\n"))
    };
    // Both lengths are shorter than the carriage's way to the mount.
    let folder = with("[\"100 mm\", \"200 mm\"]");
    let failed = sweep(folder.path(), "out", &[]);
    assert_eq!(failed.status.code(), Some(1), "{}", stderr(&failed));
    let said = stderr(&failed);
    assert!(said.contains("no design was answered; the first, design 0: ") && said.contains("free length"), "{said}");
    assert!(column(&table(folder.path(), "out"), "error").iter().all(|error| !error.is_empty()));
    let search = |folder: &TempDir| {
        let mut command = stiffmap();
        let arguments = ["optimise", "study.toml", "--no-figures", "--out", "search"];
        command.current_dir(folder.path()).args(arguments).output().unwrap()
    };
    let failed = search(&folder);
    assert_eq!(failed.status.code(), Some(1), "{}", stderr(&failed));
    assert!(stderr(&failed).contains("no design was answered"), "{}", stderr(&failed));
    assert!(!folder.path().join("search/best.toml").exists());
    // One length that can be is enough, and evaluations are counted to the last: a generation has more.
    let folder = with("[\"200 mm\", \"500 mm\"]");
    done(&sweep(folder.path(), "out", &[]));
    done(&search(&folder));
    let log = std::fs::read_to_string(folder.path().join("search/evaluations.csv")).unwrap();
    assert_eq!(log.lines().count(), 1 + 10);
}

#[test]
fn usage_that_makes_no_sense_is_refused() {
    let folder = folder_with(STUDY);
    for (arguments, fragment) in [
        (&["--shard", "4/3"][..], "I from 1 to N"),
        (&["--maps", "24"], "there is no design 24; allowed: 0 to 23"),
        (&["--resume", "--overwrite"], "cannot be used with"),
        (&["--route", "guess"], "possible values"),
    ] {
        let output = sweep(folder.path(), "out", arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(fragment), "{}", stderr(&output));
    }
    let missing = stiffmap().current_dir(folder.path()).args(["sweep", "nothing.toml"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("nothing.toml: cannot read the study file"), "{}", stderr(&missing));
    assert!(!out_of(&folder).exists());
}

#[test]
fn a_device_gives_the_processors_table() {
    let folder = folder_with(STUDY);
    for (out, backend) in [("cpu", "cpu"), ("gpu", "gpu")] {
        let run = sweep(folder.path(), out, &["--route", "coupling", "--backend", backend]);
        let none = run.status.code() != Some(0) && stderr(&run).contains("no adapter");
        if backend == "gpu" && none && std::env::var("STIFFMAP_GPU").is_ok_and(|v| v != "require") {
            eprintln!("skipped: no adapter");
            return;
        }
        done(&run);
        assert_eq!(manifest(folder.path(), out)["settings"]["route"], "coupling");
    }
    let of = |out: &str| manifest(folder.path(), out)["backend"]["backend"].as_str().unwrap().to_owned();
    assert_eq!((of("cpu").as_str(), of("gpu").as_str()), ("cpu", "gpu"));
    for name in ["stiffness_x [N/m]", "stiffness_z [N/m]"] {
        let (a, b) = (numbers(&table(folder.path(), "cpu"), name), numbers(&table(folder.path(), "gpu"), name));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / a).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{name}: {apart:.1e}");
    }
}

#[test]
fn sensitivities_of_a_design_that_is_not_there_are_refused() {
    let folder = folder_with(STUDY);
    let refused = sweep(folder.path(), "out", &["--sensitivities=24"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr(&refused).contains("--sensitivities: there is no design 24; allowed: 0 to 23"),
        "{}",
        stderr(&refused)
    );
}
