//! Machines with several ports: every name that tables and messages print can be written in a study.

use super::*;
use stiffmap::sweep::metrics::directions;

/// The slide's study with `[metrics]` of the port called tool.
fn study_of_tool() -> String {
    changed("directions = [\"x\", \"z\"]", "directions = [\"tool.x\", \"tool.z\"]")
        .replace("stiffness_x = { min", "\"stiffness_tool.x\" = { min")
        .replace("stiffness_x = \"maximise\"", "\"stiffness_tool.x\" = \"maximise\"")
}

/// The slide with other ports.
fn folder_of(ports: &str, study: &str) -> TempDir {
    let folder = folder_with(study);
    let start = MACHINE.find("[ports.tool]").unwrap();
    let end = MACHINE.find("[analysis]").unwrap();
    let machine = format!("{}{ports}\n{}", &MACHINE[..start], &MACHINE[end..]);
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    folder
}

const TOOL: &str = "[ports.tool]\ninterface = \"carriage.top\"\ndirections = [\"x\", \"y\", \"z\"]\n";
const SENSOR: &str = "[ports.sensor]\ninterface = \"bed.mount\"\ndirections = [\"x\", \"z\"]\ninput = false\n";

fn read_with(ports: &str, study: &str) -> Result<Study, StudyError> {
    read_study(&folder_of(ports, study).path().join("study.toml"))
}

#[test]
fn a_name_with_a_point_is_read_in_quotes_as_tables_and_with_underscores() {
    let quoted = "\"stiffness_tool.x\" = { min = \"0.1 N/um\" }";
    for written in [
        quoted.to_owned(),
        "stiffness_tool.x = { min = \"0.1 N/um\" }".to_owned(),
        "stiffness_tool.x.min = \"0.1 N/um\"".to_owned(),
        "stiffness_tool_x = { min = \"0.1 N/um\" }".to_owned(),
        "[bounds.stiffness_tool.x]\nmin = \"0.1 N/um\"".to_owned(),
        "stiffness_tool = { x = { min = \"0.1 N/um\" } }".to_owned(),
    ] {
        let study = read_with(&format!("{TOOL}{SENSOR}"), &study_of_tool().replace(quoted, &written));
        let study = study.unwrap_or_else(|e| panic!("{written}: {e}"));
        assert_eq!((study.bounds[0].name.as_str(), study.bounds[0].min), ("stiffness_tool.x", Some(1e5)), "{written}");
        assert_eq!(study.bounds.len(), 1);
        assert_eq!(study.objectives[0].name, "stiffness_tool.x");
    }
    for written in ["stiffness_tool.x = \"maximise\"", "stiffness_tool_x = \"maximise\""] {
        let text = study_of_tool().replace("\"stiffness_tool.x\" = \"maximise\"", written);
        let study = read_with(&format!("{TOOL}{SENSOR}"), &text).unwrap_or_else(|e| panic!("{written}: {e}"));
        assert_eq!((study.objectives[0].name.as_str(), study.objectives[0].maximise), ("stiffness_tool.x", true));
    }
}

#[test]
fn a_name_that_is_none_is_refused_with_all_that_are() {
    let refused = |from: &str, to: &str, fragments: &[&str]| {
        let text = study_of_tool();
        assert!(text.contains(from), "{from}");
        let error =
            read_with(&format!("{TOOL}{SENSOR}"), &text.replacen(from, to, 1)).expect_err("refused").to_string();
        fragments.iter().for_each(|fragment| assert!(error.contains(fragment), "{fragment:?} is not in {error}"));
    };
    let bound = "\"stiffness_tool.x\" = { min";
    let all = ["stiffness_tool.x", "stiffness_tool.z", "cost"];
    refused(bound, "stiffness_tool.w = { min", &[&["bounds.stiffness_tool.w"][..], &all].concat());
    refused(
        bound,
        "\"stiffness_sensor.x\" = { min",
        &[&["no metric is called \"stiffness_sensor.x\""][..], &all].concat(),
    );
    refused(
        bound,
        "stiffness_tool_x = { max = 1 }\n\"stiffness_tool.x\" = { min",
        &["stiffness_tool.x\" is given twice", "each bound once"],
    );
    refused("[objectives]", "[optimise]\nobjective = \"stiffness_tool.w\"\n[objectives]", &all);
    refused("\"tool.x\", ", "\"x\", ", &["no direction is called \"x\"", "tool.x"]);
    refused("\"tool.x\", ", "\"sensor.x\", ", &["no direction is called \"sensor.x\"", "tool.x"]);
}

#[test]
fn names_of_three_ports_with_spaces_and_of_inputs_and_outputs_alone_can_be_written() {
    let spaced = TOOL.replace("[ports.tool]", "[ports.\"left tool\"]");
    let third = "[ports.rail]\ninterface = \"bed.rail\"\ndirections = [\"z\", \"x\"]\noutput = false\n";
    let study = study_of_tool().replace("tool.", "left tool.").replace("stiffness_left tool", "stiffness_left_tool");
    let read = read_with(&format!("{SENSOR}{spaced}{third}"), &study).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(directions(&read.machine), ["left tool.x", "left tool.y", "left tool.z"]);
    assert_eq!(read.bounds[0].name, "stiffness_left_tool.x");
    let with_space = study.replace("\"stiffness_left_tool.x\" = { min", "\"stiffness_left tool.x\" = { min");
    assert_eq!(read_with(&format!("{SENSOR}{spaced}"), &with_space).unwrap().bounds[0].name, "stiffness_left_tool.x");

    // Force at the rail, motion at the sensor: no output is an input, so they are paired in their order.
    let text = study_of_tool()
        .replace("\"tool.x\", \"tool.z\"", "\"sensor.x from rail.z\"")
        .replace("stiffness_tool.x", "stiffness_sensor.x_from_rail.z");
    for text in
        [text.clone(), text.replace("\"stiffness_sensor.x_from_rail.z\" = {", "stiffness_sensor.x_from_rail.z = {")]
    {
        let read = read_with(&format!("{SENSOR}{third}"), &text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(directions(&read.machine), ["sensor.x from rail.z", "sensor.z from rail.x"]);
        assert_eq!(read.bounds[0].name, "stiffness_sensor.x_from_rail.z");
    }
}

#[test]
fn a_sensor_beside_the_tool_wherever_it_stands_changes_no_value_and_a_search_may_name_the_tool() {
    for ports in [format!("{SENSOR}{TOOL}"), format!("{TOOL}{SENSOR}")] {
        let folder = folder_of(&ports, &study_of_tool());
        done(&sweep(folder.path(), "out", &["--sensitivities=3"]));
        let table = table(folder.path(), "out");
        for direction in ["x", "z"] {
            let found = numbers(&table, &format!("stiffness_tool.{direction} [N/m]"));
            let alone = numbers(reference(), &format!("stiffness_{direction} [N/m]"));
            let worst = found.iter().zip(&alone).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-5, "{direction}: {worst:.1e} of {found:?} {alone:?}");
        }
        let (x, z) = (numbers(&table, "stiffness_tool.x [N/m]"), numbers(reference(), "stiffness_z [N/m]"));
        assert!(x.iter().zip(&z).any(|(x, z)| (x / z - 1.0).abs() > 0.1), "control: directions differ");
        let rates = std::fs::read_to_string(out_of(&folder).join("sensitivities.csv")).unwrap();
        assert!(rates.contains("stiffness_tool.x") && rates.contains("stiffness_tool.z"), "{rates}");
    }
    // The search improves a metric that is no objective, in its own sense.
    let text = study_of_tool().replace("\"stiffness_tool.x\" = \"maximise\"\n", "")
        + "\n[optimise]\nobjective = \"stiffness_tool.z\"\nevaluations = 16\n";
    let folder = folder_of(&format!("{SENSOR}{TOOL}"), &text);
    let mut command = stiffmap();
    command.current_dir(folder.path()).args(["optimise", "study.toml", "--out", "best"]);
    done(&command.output().unwrap());
    let manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("best/manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["settings"]["objective"], "stiffness_tool.z");
    let log = std::fs::read_to_string(folder.path().join("best/evaluations.csv")).unwrap();
    let z = numbers(&log, "stiffness_tool.z [N/m]");
    let best = manifest["settings"]["best_evaluation"].as_u64().unwrap() as usize;
    assert!(z.iter().all(|other| *other <= z[best]), "the largest of {z:?}, not number {best}");
}

#[test]
fn a_run_reports_the_direct_responses_of_the_tool_wherever_the_sensor_stands() {
    let weakest = |ports: &str| {
        let folder = folder_of(ports, STUDY);
        let mut command = stiffmap();
        command.current_dir(folder.path()).args(["run", ".", "--no-figures", "--positions", "0", "--out", "out"]);
        done(&command.output().unwrap());
        let manifest: serde_json::Value =
            serde_json::from_slice(&std::fs::read(out_of(&folder).join("manifest.json")).unwrap()).unwrap();
        let list = manifest["settings"]["smallest_dynamic_stiffness"].as_array().unwrap().clone();
        let entry = |e: &serde_json::Value| {
            (e["direction"].as_str().unwrap().to_owned(), e["stiffness_n_per_m"].as_f64().unwrap())
        };
        list.iter().map(entry).collect::<Vec<_>>()
    };
    let alone = weakest(TOOL);
    for ports in [format!("{SENSOR}{TOOL}"), format!("{TOOL}{SENSOR}")] {
        let beside = weakest(&ports);
        let names: Vec<&str> = beside.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["tool.x", "tool.y", "tool.z"]);
        for ((_, a), (_, b)) in beside.iter().zip(&alone) {
            assert!((a / b - 1.0).abs() < 1e-5, "{beside:?} {alone:?}");
        }
    }
    assert!(alone.windows(2).all(|w| (w[0].1 / w[1].1 - 1.0).abs() > 1e-3), "control: the directions differ");
}
