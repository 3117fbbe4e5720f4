//! Sensitivities of every metric to every kind of variable, in every kind of damping, against central differences.

use super::{HIGHEST, models};
use std::sync::LazyLock;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::SpringStiffness;
use stiffmap::sweep::{Design, Evaluation, Evaluator, Kept, ModesRoute, Request, Sensitivity, SweepError};

static INTERRUPT: LazyLock<Interrupt> = LazyLock::new(Interrupt::default);

/// Factors on guide stiffness, screw diameter, dampers, loss factors of joints, of parts and of the machine, the ratio
/// and a part's modulus.
const NAMES: [&str; 8] =
    ["stiffness", "diameter", "dampers", "joint losses", "part losses", "machine loss", "ratio", "modulus"];

fn design(nominal: &Design, v: &[f64]) -> Design {
    let mut design = nominal.clone();
    for spring in &mut design.machine.joints[0].springs {
        if let SpringStiffness::Constant(k) = &mut spring.stiffness {
            *k *= v[0];
        }
    }
    for joint in &mut design.machine.joints {
        joint.loss_factor = joint.loss_factor.map(|eta| eta * v[3]);
        for spring in &mut joint.springs {
            spring.damping *= v[2];
            if let SpringStiffness::BallScrew { diameter, .. } = &mut spring.stiffness {
                *diameter *= v[1];
            }
        }
    }
    for part in &mut design.machine.parts {
        part.loss_factor = part.loss_factor.map(|eta| eta * v[4]);
    }
    design.machine.analysis.damping.loss_factor *= v[5];
    design.machine.analysis.damping.ratios[0] *= v[6];
    design.parts[1].young = v[7];
    design
}

/// Every metric, and the same of its sensitivity, in one order.
fn listed(metrics: &Evaluation) -> Vec<f64> {
    let one = |p: &stiffmap::sweep::PositionMetrics| {
        let pairs = p.pairs.iter().flat_map(|m| [m.peak.value, m.most_negative_real.value]).collect::<Vec<_>>();
        pairs.into_iter().chain(p.static_compliance.clone()).chain(p.families.iter().flatten().copied()).collect()
    };
    metrics.iter().flat_map(|p| -> Vec<f64> { one(p) }).collect()
}

fn slopes(found: &[Sensitivity]) -> Vec<f64> {
    let one = |s: &Sensitivity| -> Vec<f64> {
        let pairs = s.peak.iter().zip(&s.most_negative_real).flat_map(|(a, b)| [*a, *b]).collect::<Vec<_>>();
        pairs.into_iter().chain(s.static_compliance.clone()).chain(s.families.iter().flatten().copied()).collect()
    };
    found.iter().flat_map(one).collect()
}

#[test]
fn sensitivities_are_the_slopes_of_the_metrics_in_every_damping() {
    for (name, machine, slide) in models() {
        let nominal = Design::nominal(&machine);
        let request = Request {
            positions: vec![0.3, -0.1],
            frequencies: (0..=150).map(|k| 10.0 * f64::from(k)).collect(),
            families: vec![1, 2],
            highest: HIGHEST,
            kept: Kept::Needed,
            tracked: 4,
        };
        let probes = [design(&nominal, &[1.3, 1.2, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])];
        let route = ModesRoute::new(&machine, &slide.parts, request, &probes, &INTERRUPT).expect("prepared");
        let make = |v: &[f64]| -> Result<Design, SweepError> { Ok(design(&nominal, v)) };
        let at = [1.1, 1.05, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let found = route.sensitivities(&at, &make).expect("answered");
        for (variable, own) in found.iter().enumerate() {
            // Those to a part's material need extrapolated differences: tests/sweep/slopes.rs has them in every damping.
            if NAMES[variable] == "modulus" {
                continue;
            }
            let step = 2e-5;
            let beside = [-step, step].map(|h| {
                let mut moved = at;
                moved[variable] += h;
                design(&nominal, &moved)
            });
            let answers: Vec<Vec<f64>> =
                route.evaluate(&beside).into_iter().map(|e| listed(&e.expect("answered"))).collect();
            for (k, slope) in slopes(own).into_iter().enumerate() {
                let expected = (answers[1][k] - answers[0][k]) / (2.0 * step);
                // A metric that hardly hangs on a variable has rounding for a slope.
                let scale = expected.abs().max(1e-3 * answers[0][k].abs());
                let label = format!("{name}, {}, metric {k}: {slope:e} {expected:e}", NAMES[variable]);
                assert!((slope - expected).abs() <= 1e-3 * scale, "{label}");
            }
            let lossy = machine.parts.iter().any(|p| p.loss_factor.is_some());
            assert!(variable >= 2 || own[0].analytic != lossy, "{name}, {}: analytic", NAMES[variable]);
        }
        // The check is one of slopes: those of another variable are not these.
        assert!(slopes(&found[0]).iter().zip(slopes(&found[1])).any(|(a, b)| (a - b).abs() > 1e-3 * a.abs()));
    }
}
