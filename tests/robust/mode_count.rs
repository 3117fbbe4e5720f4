//! Modes are counted where the basis reaches: valid machines are solved, and their frequencies are right.

use crate::{machine, reduced, solved, unreduced};
use std::f64::consts::TAU;
use stiffmap::machine::Machine;
use stiffmap::reduction::Superelement;

/// The wanted modes, each within the estimate of the reduction's error of the exact ones.
fn assert_right(machine: &Machine, parts: &[Superelement], exact: &[f64], what: &str) {
    let (model, found) = solved(machine, parts).unwrap_or_else(|error| panic!("{what}: {error}"));
    let modes = &found.modes[0];
    let wanted = machine.analysis.modes.min(modes.eigenvalues.len() - modes.free);
    let estimate = stiffmap::modal::reduction_estimate(&model, parts, modes, wanted).expect("estimates");
    for r in 0..wanted {
        let f = exact[modes.free + r].max(0.0).sqrt() / TAU;
        let error = modes.frequency(modes.free + r) / f - 1.0;
        let allowed = 3.0 * estimate.frequencies[r] + 2e-5;
        assert!(error.abs() < allowed, "{what}, mode {}: {error:.1e} where {allowed:.1e} is allowed", r + 1);
    }
    assert!(found.counts.iter().all(|c| c.found == c.counted));
}

#[test]
fn two_parts_are_solved_for_any_number_of_modes() {
    let mut combinations = 0;
    for (method, components) in
        [("craig-bampton", 30), ("craig-bampton", 6), ("free-interface", 30), ("free-interface", 8)]
    {
        for stiffness in ["1e6", "1e8", "1e11"] {
            let edits = |modes: usize| {
                let component =
                    format!("component = {{ modes = {components}, method = \"{method}\" }}\nmodes = {modes}");
                machine(
                    "two_parts.toml",
                    &[("component = { modes = 30 }\nmodes = 12", &component), ("1e8 N/m", &format!("{stiffness} N/m"))],
                )
            };
            let first = edits(1);
            let (meshes, parts) = reduced(&first);
            let exact = unreduced(&first, &meshes, 1e6);
            for modes in 1..=20 {
                let what = format!("{method}, {components} component modes, {stiffness} N/m, {modes} modes");
                assert_right(&edits(modes), &parts, &exact, &what);
                combinations += 1;
            }
        }
    }
    assert!(combinations >= 150);
}

#[test]
fn a_small_slide_is_solved_for_any_modulus_thickness_and_stiffness() {
    for tool in ["tool.inp", "one_brick.inp"] {
        let mesh = format!("mesh = \"{tool}\"");
        for step in 0..25 {
            let share = f64::from(step) / 24.0;
            let young = format!("{:.4} GPa", 0.4 * 10f64.powf(3.0 * share));
            let k = format!("{:.3e} N/m", 1e5 * 10f64.powf(8.0 * share));
            let bolts = format!("x = \"{k}\", y = \"{k}\", z = \"{k}\"");
            let nominal = "x = \"1e8 N/m\", y = \"1e8 N/m\", z = \"1e8 N/m\"";
            for edit in [("0.55 GPa", young.as_str()), (nominal, bolts.as_str())] {
                let edits = [edit, ("mesh = \"tool.inp\"", mesh.as_str())];
                let machine = machine("slide/machine.toml", &edits);
                let (meshes, parts) = reduced(&machine);
                let exact = unreduced(&machine, &meshes, 1e4);
                assert_right(&machine, &parts, &exact, &format!("{tool}, {edits:?}"));
            }
        }
    }
}

#[test]
fn a_map_at_rest_alone_asks_for_modes_all_the_same() {
    let machine =
        machine("two_parts.toml", &[("frequencies = { from = 0, to = 6000, step = 5 }", "frequencies = [0]")]);
    let (meshes, parts) = reduced(&machine);
    let exact = unreduced(&machine, &meshes, 1e6);
    assert_right(&machine, &parts, &exact, "0 Hz");
}

#[test]
fn a_mode_that_is_missing_is_still_seen() {
    let machine = machine("two_parts.toml", &[]);
    let (_, parts) = reduced(&machine);
    let (model, found) = solved(&machine, &parts).expect("solves");
    let mut fewer = found.modes[0].clone();
    fewer.eigenvalues.remove(3);
    assert!(stiffmap::modal::check_count(&model, &fewer, fewer.free + 12).is_err());
}
