//! Studies that are refused, with which words.

use super::*;
use stiffmap::sweep::TableError;
use stiffmap::sweep::room::{fits, table_bytes};

#[track_caller]
fn refused(text: &str, fragments: &[&str]) {
    let message = match read(text) {
        Ok(_) => panic!("accepted; expected a refusal with {fragments:?}"),
        Err(error) => error.to_string(),
    };
    for fragment in ["study.toml:"].iter().chain(fragments) {
        assert!(message.contains(fragment), "{fragment:?} is not in: {message}");
    }
}

#[track_caller]
fn refused_change(from: &str, to: &str, fragments: &[&str]) {
    refused(&changed(from, to), fragments);
}

#[test]
fn a_path_that_names_nothing_is_refused_with_the_nearest_one() {
    refused_change(
        "joints.screw.diameter",
        "joints.screw.diametre",
        &["variables.diameter.path", "names nothing", "did you mean \"joints.screw.diameter\"?", "free_length"],
    );
    refused_change("guide *.stiffness.x", "rail *.stiffness.x", &["names nothing", "allowed here: guide A, screw"]);
    refused_change(
        "guide *.stiffness.x",
        "guide *.stiffness.z",
        &["did you mean \"joints.guide A.stiffness.", "x, y, rx, ry, rz"],
    );
    refused_change("joints.screw.diameter", "joints.screw.stiffness", &["names nothing", "diameter"]);
}

#[test]
fn ranges_that_are_none_are_refused() {
    refused_change(
        "[\"10 mm\", \"25 mm\"]",
        "[\"25 mm\", \"10 mm\"]",
        &["range[1]: found \"25 mm\"", "at most the second value, \"10 mm\"", "exchange"],
    );
    refused_change("[\"10 mm\", \"25 mm\"]", "[\"10 mm\", \"10 mm\"]", &["two different values"]);
    refused_change("[\"10 mm\", \"25 mm\"]", "[\"10 N\", \"25 mm\"]", &["range[1]", "a length in m, mm, um"]);
    refused_change("[\"10 mm\", \"25 mm\"]", "[0, \"25 mm\"]", &["range[1]: found 0", "positive"]);
    refused_change("[\"10 mm\", \"25 mm\"]", "[nan, \"25 mm\"]", &["not finite"]);
    let beyond = &["range[2]: found 1e305", "a length from 1e-12 to 1e5 m", "unit"];
    refused_change("[\"10 mm\", \"25 mm\"]", "[\"10 mm\", 1e305]", beyond);
    refused_change("scale = \"log\"", "scale = \"cubic\"", &["\"linear\" or \"log\""]);
    refused_change("scale = \"log\"", "values = [1]", &["no `range` beside `values`"]);
}

#[test]
fn numbers_out_of_reach_are_refused_before_anything_is_computed() {
    refused_change("designs = 24", "designs = 100000000000", &["designs: found 100000000000", "at most 1000000000"]);
    refused_change("designs = 24", "designs = 0", &["designs: found 0", "at least 1"]);
    let families = |list: &str| {
        changed("[cost]", &format!("[metrics.mode]\nkind = \"eigenfrequency\"\nfamilies = {list}\n[cost]"))
    };
    refused(&families("[2, 500]"), &["metrics.mode.families[2]: found 500", "from 1 to 6", "raise `modes`"]);
    assert!(read(&families("[2, 6]")).is_ok(), "control: as many families as the machine has modes");
}

#[test]
fn what_is_varied_twice_is_refused() {
    let twice = "[variables.again]\npath = \"joints.guide A.stiffness.x\"\nrange = [1, 2]\n[sampling]";
    refused_change(
        "[sampling]",
        twice,
        &["\"joints.guide A.stiffness.x\" is varied twice", "the variable \"guide_x\""],
    );
    refused_change("[variables.diameter]", "[variables.guide_x]", &["study.toml:", "duplicate key"]);
    refused_change(
        "path = \"joints.guide *.stiffness.x\"",
        "paths = [\"joints.guide *.stiffness.x\", \"joints.guide A.stiffness.x\"]",
        &["paths[2]", "varied twice", "\"guide_x\""],
    );
}

#[test]
fn values_that_need_what_the_machine_does_not_give_are_refused() {
    let variable = |text: &str| changed("[sampling]", &format!("[variables.v]\n{text}\n[sampling]"));
    refused(&variable("path = \"parts.bed.material.young\"\nrange = [1, 2]"), &["factor = true"]);
    refused(&variable("path = \"joints.screw.free_length\"\nfactor = true\nrange = [1, 2]"), &["absolute values"]);
    refused(&variable("path = \"joints.screw.support\"\nvalues = [\"both-ends\"]"), &["the key `span` is missing"]);
    refused(&variable("path = \"joints.screw.support\"\nvalues = [\"both\"]"), &["\"one-end\" or \"both-ends\""]);
    refused(&variable("path = \"analysis.damping.ratio\"\nrange = [0.1, 1]"), &["range[2]", "less than 1"]);
    refused(
        &variable("paths = [\"joints.guide A.stiffness.y\", \"joints.guide A.stiffness.r*\"]\nrange = [1, 2]"),
        &["whose values measure the same"],
    );
}

#[test]
fn metrics_goals_and_samples_that_name_nothing_are_refused() {
    refused_change(
        "\"x\", \"z\"]",
        "\"x\", \"w\"]",
        &["metrics.stiffness.directions[2]", "no direction is called \"w\""],
    );
    refused_change("dynamic-stiffness", "dynamic-stifness", &["did you mean `dynamic-stiffness`?"]);
    refused_change("stiffness_x = { min", "stifness_x = { min", &["bounds.stifness_x", "did you mean `stiffness_x`?"]);
    refused_change("cost = \"minimise\"", "cost = \"less\"", &["\"maximise\" or \"minimise\""]);
    refused_change("latin-hypercube", "latin", &["sampling.method", "did you mean `latin-hypercube`?"]);
    refused_change("method = \"latin-hypercube\"", "method = \"grid\"", &["sampling", "on a grid"]);
    refused_change(
        "machine = \"machine.toml\"",
        "machine = \"mill.toml\"",
        &["machine: found \"mill.toml\"", "existing machine file"],
    );
    refused_change("[objectives]", "[objective]", &["unknown key `objective`", "did you mean `objectives`?"]);
    refused_change(
        "[objectives]",
        "[band]\nfrom = \"9 Hz\"\nto = \"3 Hz\"\n[objectives]",
        &["band.to", "more than `from`, 9 Hz"],
    );
    refused_change("machine = ", "positions = [\"-301 mm\"]\nmachine = ", &["positions[1]", "within the travel"]);
}

#[test]
fn a_sample_too_large_for_the_disk_is_refused_with_figures() {
    let study = read(STUDY).unwrap();
    let rows = 1_000_000_000_000;
    let Err(TableError::NoRoom { table, free, .. }) = fits(&study, rows, 0, Path::new("out"), 1e9) else {
        panic!("accepted")
    };
    assert!(table > 1e13 && free == 1e9);
    assert!(fits(&study, 24, 0, Path::new("out"), 1e9).is_ok());
    // The estimate is an upper bound that is not absurd.
    let bytes = reference().len() as f64;
    let estimate = table_bytes(&study, 24);
    assert!(estimate > bytes - 200.0 && estimate < 4.0 * bytes, "{estimate} {bytes}");

    let grid = changed("method = \"latin-hypercube\"\ndesigns = 24\nseed = 7", "method = \"grid\"");
    let grid = grid.replace("range", "points = 10000000\nrange");
    let folder = folder_with(&grid);
    let output = sweep(folder.path(), "out", &[]);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(said.contains("100000000000000 designs") && said.contains("are free") && said.contains("PB"), "{said}");
    assert!(!out_of(&folder).exists(), "nothing is begun");
}
