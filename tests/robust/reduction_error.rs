//! The estimate of the reduction's own error against the error itself.

use crate::{machine, reduced, solved, unreduced};
use std::f64::consts::TAU;
use stiffmap::modal::reduction_estimate;
use stiffmap::pipeline::few_component_modes;

#[test]
fn the_estimate_is_near_the_true_error_wherever_there_is_one() {
    let mut seen = 0;
    for (method, components) in
        [("craig-bampton", 2), ("craig-bampton", 5), ("craig-bampton", 10), ("free-interface", 8)]
    {
        let component = format!("component = {{ modes = {components}, method = \"{method}\" }}\nmodes = 24");
        let machine = machine("two_parts.toml", &[("component = { modes = 30 }\nmodes = 12", &component)]);
        let (meshes, parts) = reduced(&machine);
        let (model, found) = solved(&machine, &parts).expect("solves");
        let modes = &found.modes[0];
        let exact = unreduced(&machine, &meshes, 1e6);
        let mut tampered = parts.clone();
        tampered.iter_mut().for_each(|p| {
            p.beyond.stiffness *= 0.3;
            p.beyond.mass *= 0.3;
        });
        let estimate = reduction_estimate(&model, &parts, modes, 24).expect("estimates");
        let control = reduction_estimate(&model, &tampered, modes, 24).expect("estimates");
        let (mut inside, mut outside) = (0, 0);
        for r in 0..24 {
            let f = exact[modes.free + r].sqrt() / TAU;
            let error = modes.frequency(modes.free + r) / f - 1.0;
            // Below this the fixed basis has its own share.
            if error < 3e-5 {
                continue;
            }
            let near = |e: f64| (error / 3.0..5.0 * error).contains(&e);
            assert!(
                near(estimate.frequencies[r]),
                "{method} {components}, mode {}: {error:.1e}, estimate {:.1e}",
                r + 1,
                estimate.frequencies[r]
            );
            inside += 1;
            outside += usize::from(!near(control.frequencies[r]));
        }
        seen += inside;
        assert!(inside == 0 || outside > 0, "control: a third of the coupling is seen");
    }
    println!("{seen} errors");
    assert!(seen > 20, "{seen}");
}

#[test]
fn component_modes_follow_the_frequency_unless_the_file_fixes_them() {
    let fixed = machine("two_parts.toml", &[("component = { modes = 30 }", "component = { modes = 3 }")]);
    let (_, parts) = reduced(&fixed);
    let said = few_component_modes(&fixed, &parts, 60_000.0);
    assert!(said.len() == 1 && said[0].contains("\"bed\"") && said[0].contains("leave `modes`"), "{said:?}");
    assert!(few_component_modes(&fixed, &parts, 10.0).is_empty());
    let follows = machine(
        "two_parts.toml",
        &[("component = { modes = 30 }\n", ""), ("to = 6000, step = 5", "to = 60000, step = 50")],
    );
    let (_, parts) = reduced(&follows);
    assert!(few_component_modes(&follows, &parts, 60_000.0).is_empty());
    for part in &parts {
        let next = part.beyond.eigenvalues.first().map_or(f64::INFINITY, |l| l.sqrt() / TAU);
        assert!(next > 1.99 * 60_000.0, "{}: the first motion left out lies at {next} Hz", part.part);
    }
}
