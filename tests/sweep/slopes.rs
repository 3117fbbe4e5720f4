//! Sensitivities of every metric to every variable that a study may name, in every damping, against central
//! differences of the table's own values.

use super::agreement::{KINDS, Kind, machine_of_environment, study_of_positions, with_damping};
use super::*;
use stiffmap::interrupt::Interrupt;
use stiffmap::pipeline::{read_meshes, reduce_parts};
use stiffmap::reduction::Superelement;
use stiffmap::sweep::table::Row;
use stiffmap::sweep::{Evaluator, Kept, ModesRoute, Request};
use toml::{Table, Value as Toml};

/// Difference of a slope from that of central differences, as a share of it.
const AGREES: f64 = 1e-3;
/// Slopes below this share of metric / variable are compared with that share: rounding is all they are.
const FELT: f64 = 1e-3;

/// A study in which every spring, damper, loss factor, ratio, screw and material is a variable, at their values.
fn study_of_everything(machine: &Table, positions: [f64; 2], band: [f64; 2]) -> String {
    let mut paths: Vec<String> = Vec::new();
    for joint in machine["joints"].as_array().expect("[[joints]]") {
        let name = joint["name"].as_str().expect("a name");
        for kind in ["stiffness", "damping"] {
            match joint.get(kind) {
                Some(Toml::Table(springs)) => paths.extend(springs.keys().map(|k| format!("joints.{name}.{kind}.{k}"))),
                Some(_) => paths.push(format!("joints.{name}.{kind}")),
                None => {}
            }
        }
        let others = ["diameter", "young", "loss_factor", "free_length", "span"];
        paths.extend(others.iter().filter(|k| joint.get(**k).is_some()).map(|k| format!("joints.{name}.{k}")));
    }
    let damping = machine["analysis"]["damping"].as_table().expect("damping");
    let overall = ["ratio", "loss_factor"].iter().filter(|k| damping.contains_key(**k));
    paths.extend(overall.map(|k| format!("analysis.damping.{k}")));
    for (name, _) in machine["parts"].as_table().expect("[parts]") {
        paths.extend(["young", "density"].map(|k| format!("parts.{name}.material.{k}")));
    }
    let mut text = study_of_positions(machine, 1, positions, band)
        .replace("\"latin-hypercube\"\ndesigns = 1\nseed = 11\n", "\"grid\"\n");
    for (k, path) in paths.iter().enumerate() {
        write!(text, "[variables.v{k}]\npath = \"{path}\"\nfactor = true\nvalues = [1.0]\n").expect("text");
    }
    text += "[metrics.f]\nkind = \"eigenfrequency\"\nfamilies = [2, 3, 4]\n[metrics.m]\nkind = \"dynamic-stiffness\"\n\
             over = \"mean\"\n";
    let directions = text.lines().find(|l| l.starts_with("directions")).expect("directions").to_owned();
    text + &directions + "\n"
}

/// What is wrong with the sensitivities of a machine in one damping, in words. `shift` takes those of another variable
/// in the place of each.
fn wrong_slopes(
    (text, folder): (&str, &Path),
    kind: &Kind,
    (positions, band): ([f64; 2], [f64; 2]),
    shift: usize,
) -> Vec<String> {
    let machine = with_damping(text, folder, kind);
    let here = tempfile::tempdir().unwrap();
    std::fs::write(here.path().join("machine.toml"), machine.to_string()).unwrap();
    std::fs::write(here.path().join("study.toml"), study_of_everything(&machine, positions, band)).unwrap();
    let study = read_study(&here.path().join("study.toml")).unwrap_or_else(|e| panic!("{e}"));
    let meshes = read_meshes(&study.machine).expect("meshes");
    let interrupt = Interrupt::default();
    let parts = reduce_parts(&study.machine, &meshes, None, &interrupt, &|| {}).expect("reduces");
    let parts: Vec<Superelement> = parts.into_iter().map(|p| p.superelement).collect();
    let request = Request::of(&study);
    let n = study.variables.len();
    let at = vec![1.0; n];
    let beside = |variable: usize, step: f64| {
        let mut values = at.clone();
        values[variable] += step;
        values
    };
    // The bases hold what is tried: all variables a little to either side.
    let probes = [0.95, 1.05].map(|factor| study.design(&vec![factor; n]));
    let route = ModesRoute::new(&study.machine, &parts, request.clone(), &probes, &interrupt).expect("prepared");
    // What a part's material changes is differenced by all coordinates: how many are kept would change with it in steps.
    let untruncated = Request { kept: Kept::All, ..request };
    let whole = ModesRoute::new(&study.machine, &parts, untruncated, &probes, &interrupt).expect("prepared");
    let evaluation = route.evaluate(&[study.design(&at)]).swap_remove(0).expect("answered");
    let mut found = route.sensitivities(&at, &|values| Ok(study.design(values))).expect("answered");
    found.rotate_left(shift);
    let results = |values: &[f64]| {
        let design = study.design(values);
        let route = if design.parts == study.design(&at).parts { &route } else { &whole };
        let outcome = route.evaluate(&[study.design(values)]).swap_remove(0);
        Row::new(&study, 0, values.to_vec(), &outcome).results
    };
    let columns = study.result_columns();
    let (mut wrong, mut compared, mut worst) = (Vec::new(), 0, 0.0_f64);
    for (v, own) in found.iter().enumerate() {
        // Central differences of two steps, extrapolated; small, so that no other peak or position becomes the worst.
        // A part's material turns all coordinates, which leaves more rounding: a longer step.
        let of_parts = study.design(&beside(v, 1e-3)).parts != study.design(&at).parts;
        let (step, felt) = if of_parts { (1e-3, 5.0 * FELT) } else { (2e-4, FELT) };
        let rows: Vec<_> = [-2.0, -1.0, 1.0, 2.0].map(|k| results(&beside(v, k * step))).into();
        for metric in &study.metrics {
            let place = columns.iter().position(|c| c.name == metric.name).expect("a column");
            let value = |k: usize| rows[k][place].expect("a value");
            let near = (value(2) - value(1)) / (2.0 * step);
            let far = (value(3) - value(0)) / (4.0 * step);
            let expected = (4.0 * near - far) / 3.0;
            let slope = metric.rate(&evaluation, own).expect("a slope");
            let size = 0.5 * (value(2) + value(1)).abs();
            let off = (slope - expected).abs() / expected.abs().max(felt * size);
            compared += 1;
            worst = worst.max(off);
            if off.is_nan() || off > AGREES {
                let path = &study.variables[v].name;
                wrong.push(format!(
                    "{}: {} by {path}: {slope:e}, differences {expected:e}, of {size:e}",
                    kind.name, metric.name
                ));
            }
        }
    }
    println!("{}: {compared} slopes of {n} variables, largest difference {worst:.1e}", kind.name);
    wrong
}

#[test]
fn every_slope_is_that_of_differences_in_every_damping() {
    let folder = folder_with(STUDY);
    let of = |kind, shift| wrong_slopes((MACHINE, folder.path()), kind, ([0.15, -0.15], [20.0, 1500.0]), shift);
    let wrong: Vec<String> = KINDS.iter().flat_map(|kind| of(kind, 0)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let control = of(&KINDS[3], 1);
    assert!(control.len() > 50, "slopes of other variables are no slopes of these: {}", control.len());
}

/// Another machine, by the variables of [`machine_of_environment`].
#[test]
#[ignore = "a benchmark of some minutes: cargo test --release --test sweep -- --ignored --nocapture slopes_of_a_machine"]
fn slopes_of_a_machine() {
    let (text, folder, at, band) = machine_of_environment();
    let of = |kind| wrong_slopes((&text, &folder), kind, (at, band), 0);
    let wrong: Vec<String> = KINDS.iter().flat_map(of).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
