//! Damping: responses against a direct complex solve of the superelements side by side, which knows no modes.

mod sensitivities;
#[path = "../support/mod.rs"]
mod support;
mod time;

use stiffmap::coupling::{BasisOptions, couple};
use stiffmap::frf::metrics::{direct_pairs, metrics};
use stiffmap::frf::{FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use stiffmap::machine::{Damping, Machine, Motion, Port};
use stiffmap::modal::modes_at;
use support::direct::Direct;
use support::slide::Slide;

const HIGHEST: f64 = 1500.0;

/// A machine with one kind of damping, and its name.
fn models() -> Vec<(&'static str, Machine, Slide)> {
    let own =
        |ratio: f64, rayleigh, loss_factor| Damping { ratios: vec![ratio], rayleigh, loss_factor, projected: false };
    let kinds: [(&str, Damping, f64, f64, [f64; 2]); 8] = [
        ("ratio", own(0.02, None, 0.0), 0.0, 0.0, [0.0; 2]),
        ("Rayleigh", own(0.0, Some([20.0, 1e-5]), 0.0), 0.0, 0.0, [0.0; 2]),
        ("loss factor of the machine", own(0.0, None, 0.03), 0.0, 0.0, [0.0; 2]),
        ("dampers", own(0.0, None, 0.0), 3e4, 0.0, [0.0; 2]),
        ("loss factors of joints", own(0.001, None, 0.0), 0.0, 0.3, [0.0; 2]),
        ("loss factors of parts", own(0.0, None, 0.01), 0.0, 0.0, [0.05, 0.02]),
        ("dampers with a ratio", own(0.01, None, 0.0), 3e4, 0.0, [0.0; 2]),
        ("everything", own(0.005, Some([5.0, 1e-6]), 0.01), 2e4, 0.1, [0.04, 0.02]),
    ];
    let one = |(name, damping, damper, joints, parts): (&'static str, Damping, f64, f64, [f64; 2])| {
        let slide = Slide::new(true);
        let mut machine = slide.machine.clone();
        machine.analysis.damping = damping;
        for joint in &mut machine.joints {
            joint.loss_factor = (joints > 0.0).then_some(joints);
            for (k, spring) in joint.springs.iter_mut().enumerate() {
                // A rotation's damper in N m s/rad is that of a lever of some 50 mm.
                let lever = if spring.motion == Motion::Rotation { 3e-3 } else { 1.0 };
                spring.damping = lever * damper * (1.0 + 0.3 * k as f64);
            }
        }
        for (part, eta) in machine.parts.iter_mut().zip(parts) {
            part.loss_factor = (eta > 0.0).then_some(eta);
        }
        (name, machine, slide)
    };
    kinds.map(one).into()
}

/// The last of them with a sensor beside the tool: outputs that are not inputs.
fn with_sensor() -> (Machine, Slide) {
    let (_, mut machine, slide) = models().pop().expect("models");
    let tool = machine.ports[0].clone();
    let interface = support::slide::side(1, 1);
    let directions = tool.directions[..2].to_vec();
    machine.ports.insert(0, Port { name: "sensor".into(), interface, directions, input: false, output: true });
    (machine, slide)
}

/// Largest differences of a map from the direct solve: of the norm, and of the refined peaks.
fn differences(machine: &Machine, slide: &Slide, projected: bool) -> [f64; 2] {
    let mut machine = machine.clone();
    machine.analysis.damping.projected = projected;
    let model = couple(&machine, &slide.parts, BasisOptions::up_to(HIGHEST)).expect("coupled");
    let positions = [0.3, -0.21];
    let damping = &machine.analysis.damping;
    let modes: Vec<_> = positions.iter().map(|&p| modes_at(&model, damping, p).expect("modes")).collect();
    let (systems, _) = modal_systems(&modes, HIGHEST, Selection::Controlled { tolerance: 1e-6 }).expect("systems");
    let frequencies: Vec<f64> = (0..=60).map(|k| 25.0 * k as f64).collect();
    let (outputs, inputs) = (model.output_names(), model.input_names());
    let request = FrfRequest {
        positions: &positions,
        systems: &systems,
        frequencies: &frequencies,
        outputs: &outputs,
        inputs: &inputs,
        quantity: Quantity::Receptance,
    };
    let map = modal_sum(&request).expect("a map");
    let found = metrics(&request, &map, &direct_pairs(&request)).expect("metrics");
    let (mut norm, mut peak): (f64, f64) = (0.0, 0.0);
    for (p, &position) in positions.iter().enumerate() {
        let direct = Direct::new(&machine, &model, position);
        let all: Vec<_> = frequencies.iter().map(|f| direct.at(*f)).collect();
        for (k, h) in all.iter().enumerate() {
            norm = norm.max((map.matrix(p, k) - h).norm() / h.norm());
        }
        for own in &found[p] {
            // The refined peak is the direct solve's value there, and no neighbour is larger.
            let at = |f: f64| direct.at(f)[(own.output, own.input)].norm();
            let f = own.peak.frequency;
            peak = peak.max((own.peak.value / at(f) - 1.0).abs());
            let beside = [f * (1.0 - 1e-3), f * (1.0 + 1e-3)].map(at);
            let inside = f > 1.0 && f < HIGHEST * 0.999;
            if inside {
                peak = peak.max(beside[0].max(beside[1]) / own.peak.value - 1.0);
            }
            let grid = all.iter().map(|h| h[(own.output, own.input)].norm()).fold(0.0, f64::max);
            peak = peak.max(grid / own.peak.value - 1.0);
        }
    }
    [norm, peak]
}

#[test]
fn maps_and_peaks_are_those_of_the_damped_equations() {
    for (name, machine, slide) in models() {
        let [norm, peak] = differences(&machine, &slide, false);
        let [projected, _] = differences(&machine, &slide, true);
        println!("{name}: norm {norm:.1e}, peak {peak:.1e}; projected {projected:.1e}");
        // What parts lose is exact to second order in their loss factors.
        let bound = if machine.parts.iter().any(|p| p.loss_factor.is_some()) { 1e-3 } else { 1e-4 };
        assert!(norm < bound && peak < bound, "{name}: {norm:e} {peak:e}");
        // The comparison sees what projection leaves out.
        let couples = !["ratio", "Rayleigh", "loss factor of the machine"].contains(&name);
        assert_eq!(projected > 3e-3, couples, "{name}: projected {projected:e}");
    }
}

#[test]
fn outputs_that_are_not_inputs_have_exact_responses_too() {
    let (machine, slide) = with_sensor();
    let [norm, peak] = differences(&machine, &slide, false);
    assert!(norm < 1e-3 && peak < 1e-3, "{norm:e} {peak:e}");
    let [projected, _] = differences(&machine, &slide, true);
    assert!(projected > 3e-3, "{projected:e}");
}
