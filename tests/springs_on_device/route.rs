//! The coupling route on a device: the processor's metrics, and the processor's help.

use crate::modal_fixture::Numbers;
use crate::modal_fixture::device::device;
use crate::support::slide::Slide;
use stiffmap::gpu::{Backend, Precision};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Damping, Machine, SpringStiffness};
use stiffmap::sweep::{CouplingRoute, Design, Evaluation, Evaluator, Kept, Request, SpringBackend, SweepError};

fn scaled(machine: &Machine, mut factor: impl FnMut() -> f64) -> Design {
    let mut design = Design::nominal(machine);
    for spring in design.machine.joints.iter_mut().flat_map(|j| &mut j.springs) {
        match &mut spring.stiffness {
            SpringStiffness::Constant(k) => *k *= factor(),
            SpringStiffness::BallScrew { diameter, .. } => *diameter *= factor().sqrt(),
        }
    }
    design
}

/// Evaluations of 30 designs between 0.3 and 3 times the stiffness of a slide at three positions.
fn evaluate(
    slide: &Slide,
    backend: SpringBackend,
) -> (Vec<Result<Evaluation, SweepError>>, stiffmap::sweep::BackendUse) {
    let machine = &slide.machine;
    let mut numbers = Numbers(40);
    let designs: Vec<Design> =
        (0..30).map(|_| scaled(machine, || 0.3 * 10f64.powf(numbers.within(0.0, 1.0)))).collect();
    let probes = [0.3, 3.0].map(|factor| scaled(machine, || factor));
    let request = Request {
        positions: vec![0.3, 0.0171, -0.2113],
        frequencies: (0..=300).map(|k| 10.0 * f64::from(k)).collect(),
        families: Vec::new(),
        highest: 3000.0,
        kept: Kept::FixedBasis,
        tracked: 0,
    };
    let interrupt = Interrupt::default();
    let route = CouplingRoute::new(machine, &slide.parts, request, &probes, &interrupt).unwrap().on(backend).unwrap();
    (route.evaluate(&designs), route.backend())
}

#[test]
fn the_route_on_a_device_has_the_processors_metrics_and_outlives_the_device() {
    let Some(gpu) = device() else { return };
    let mut slide = Slide::new(true);
    slide.machine.analysis.damping =
        Damping { ratios: Vec::new(), rayleigh: None, loss_factor: 0.02, projected: false };
    let (expected, on_cpu) = evaluate(&slide, SpringBackend::cpu("asked for"));
    let expected: Vec<Evaluation> = expected.into_iter().map(Result::unwrap).collect();
    assert_eq!((on_cpu.backend, on_cpu.pairs_on_cpu, on_cpu.pairs_on_device), ("cpu", 90, 0));
    let same = |found: Vec<Result<Evaluation, SweepError>>| {
        for (found, expected) in found.into_iter().zip(&expected) {
            for (a, b) in found.unwrap().iter().zip(expected) {
                assert_eq!(a.static_compliance, b.static_compliance);
                for (a, b) in a.pairs.iter().zip(&b.pairs) {
                    let near = |a: f64, b: f64| (a / b - 1.0).abs() <= 1e-6;
                    assert!(near(a.peak.value, b.peak.value), "{a:?} {b:?}");
                    assert!(near(a.most_negative_real.value, b.most_negative_real.value), "{a:?} {b:?}");
                    assert!(!near(a.peak.value * 1.000_01, b.peak.value), "control");
                }
            }
        }
    };
    let opened = SpringBackend::open(Backend::Gpu, Precision::F32).unwrap();
    let (found, used) = evaluate(&slide, opened);
    println!("{used:?}");
    same(found);
    assert_eq!((used.backend, used.pairs_on_device, used.pairs_on_cpu), ("gpu", 90, 0));
    assert!(used.trust.is_some_and(|figure| figure < 1e-4), "{used:?}");

    let lost = SpringBackend::with(gpu, Backend::Auto, Precision::F32);
    lost.destroy();
    let (found, used) = evaluate(&slide, lost);
    same(found);
    assert_eq!((used.backend, used.pairs_on_cpu), ("gpu, finished on the cpu", 90), "{used:?}");
    assert!(used.why.contains("an open device; the device failed: "), "{used:?}");

    let lost = SpringBackend::open(Backend::Gpu, Precision::F32).unwrap();
    lost.destroy();
    let (found, _) = evaluate(&slide, lost);
    assert!(found.iter().all(|e| matches!(e, Err(SweepError::Device { .. }))));
}

#[test]
fn a_software_adapter_is_not_taken_for_springs_unless_it_is_asked_for() {
    let opened = SpringBackend::open(Backend::Auto, Precision::F32).unwrap().used();
    let software = stiffmap::gpu::list_adapters().first().is_none_or(|a| a.is_software());
    println!("{opened:?}");
    if software {
        assert_eq!(opened.backend, "cpu", "{opened:?}");
        assert!(opened.why.contains("runs on the processor itself") || opened.why.contains("no GPU adapter"));
    } else {
        assert_eq!(opened.backend, "gpu", "{opened:?}");
    }
    assert_eq!(SpringBackend::open(Backend::Cpu, Precision::F32).unwrap().used().why, "asked for");
}
