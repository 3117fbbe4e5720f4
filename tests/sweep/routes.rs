//! What answers a design: modes around the nominal machine, and its receptances modified; both against a machine that
//! is built for the design.

use crate::support::slide::{Slide, ratio};
use crate::support::steel;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::{LazyLock, OnceLock};
use stiffmap::coupling::{BasisOptions, CoupledModel, couple};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Damping, JointKind, Machine, Material, SpringStiffness, read_machine};
use stiffmap::modal::{Modes, modes_at};
use stiffmap::pipeline::{read_meshes, reduce_parts};
use stiffmap::reduction::{Cache, Superelement};
use stiffmap::sweep::{CouplingRoute, Design, Evaluation, Evaluator, Kept, ModesRoute, PartScale, Request, SweepError};

static INTERRUPT: LazyLock<Interrupt> = LazyLock::new(Interrupt::default);

fn slide() -> &'static Slide {
    static SLIDE: OnceLock<Slide> = OnceLock::new();
    SLIDE.get_or_init(|| Slide::new(true))
}

fn lossy(eta: f64) -> Damping {
    Damping { ratios: Vec::new(), rayleigh: None, loss_factor: eta, projected: false }
}

/// The machine with every spring scaled by its own factor, the screw by its diameter.
fn scaled(machine: &Machine, factors: &mut dyn FnMut() -> f64) -> Design {
    let mut design = Design::nominal(machine);
    for spring in design.machine.joints.iter_mut().flat_map(|j| &mut j.springs) {
        match &mut spring.stiffness {
            SpringStiffness::Constant(k) => *k *= factors(),
            SpringStiffness::BallScrew { diameter, .. } => *diameter *= factors().sqrt(),
        }
    }
    design
}

/// Factors between 0.3 and 3, log-uniform and the same in each run.
fn factors() -> impl FnMut() -> f64 {
    let mut state = 20_261_122_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.3 * 10f64.powf((state >> 33) as f64 / (1_u64 << 31) as f64)
    }
}

fn request(machine: &Machine, highest: f64, positions: Vec<f64>) -> Request {
    let frequencies = (0..=450).map(|k| highest * k as f64 / 450.0).collect();
    assert!(positions.iter().all(|p| machine.axis.stations().contains(p)), "stations");
    let families = Vec::new();
    Request { positions, frequencies, families, highest, kept: Kept::Needed, tracked: 0 }
}

fn slide_with(damping: Damping) -> Machine {
    let mut machine = slide().machine.clone();
    machine.analysis.damping = damping;
    machine
}

const REACH: f64 = 2500.0;

fn slide_request(machine: &Machine) -> Request {
    request(machine, REACH, vec![0.3, 0.05, -0.3])
}

/// The largest relative differences of peaks, most negative real parts and static compliances.
fn differences(a: &[Result<Evaluation, SweepError>], b: &[Result<Evaluation, SweepError>]) -> [f64; 3] {
    assert!(a.len() == b.len() && !a.is_empty());
    let mut worst = [0.0f64; 3];
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a.as_ref().expect("answered"), b.as_ref().expect("answered"));
        assert!(a.len() == b.len() && !a.is_empty());
        for (a, b) in a.iter().zip(b) {
            for (a, b) in a.pairs.iter().zip(&b.pairs) {
                worst[0] = worst[0].max((a.peak.value / b.peak.value - 1.0).abs());
                worst[1] = worst[1].max((a.most_negative_real.value / b.most_negative_real.value - 1.0).abs());
            }
            for (a, b) in a.static_compliance.iter().zip(&b.static_compliance) {
                worst[2] = worst[2].max((a / b - 1.0).abs());
            }
        }
    }
    worst
}

fn worst_frequency(found: &Modes, expected: &Modes, count: usize) -> f64 {
    assert_eq!(found.free, expected.free);
    let one = |r: usize| (found.frequency(r) / expected.frequency(r) - 1.0).abs();
    (found.free..found.free + count).map(one).fold(0.0, f64::max)
}

struct Mill {
    machine: Machine,
    superelements: Vec<Superelement>,
}

fn mill() -> &'static Mill {
    static MILL: OnceLock<Mill> = OnceLock::new();
    MILL.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
        let machine = read_machine(&folder).expect("the bundled machine file");
        let meshes = read_meshes(&machine).expect("the bundled meshes");
        let cache = std::env::var_os("STIFFMAP_CACHE").map(Cache::in_folder);
        let parts = reduce_parts(&machine, &meshes, cache.as_ref(), &INTERRUPT, &|| {}).expect("reduces");
        Mill { machine, superelements: parts.into_iter().map(|p| p.superelement).collect() }
    })
}

/// The five variables of the bundled study.
fn study_design(machine: &Machine, f: [f64; 5]) -> Design {
    let mut design = Design::nominal(machine);
    for joint in &mut design.machine.joints {
        for spring in &mut joint.springs {
            let factor = match (joint.kind, spring.label.as_str()) {
                (JointKind::LinearGuide, "x") => f[0],
                (JointKind::LinearGuide, _) => f[1],
                (JointKind::Bearing, "axial") => f[3],
                (JointKind::Bearing, _) => f[2],
                (JointKind::BallScrew, _) => f[4],
                _ => 1.0,
            };
            match &mut spring.stiffness {
                SpringStiffness::Constant(k) => *k *= factor,
                SpringStiffness::BallScrew { diameter, .. } => *diameter *= factor.sqrt(),
            }
        }
    }
    design
}

fn study_corners(machine: &Machine) -> Vec<Design> {
    vec![study_design(machine, [0.3; 5]), study_design(machine, [3.0; 5])]
}

#[test]
fn a_changed_mill_has_the_frequencies_of_one_that_is_built_so() {
    let Mill { machine, superelements } = mill();
    let positions = vec![0.0, -0.305, -0.6];
    let probes = study_corners(machine);
    let route =
        ModesRoute::new(machine, superelements, request(machine, 900.0, positions.clone()), &probes, &INTERRUPT)
            .expect("prepared");
    let mut next = factors();
    let mut designs = probes;
    designs.push(study_design(machine, std::array::from_fn(|_| next())));
    for design in &designs {
        let built = couple(&design.machine, superelements, BasisOptions::up_to(900.0)).expect("couples");
        for (k, &position) in positions.iter().enumerate() {
            let found = route.modes(route.prepared(), design, k).expect("modes");
            let expected = modes_at(&built, &machine.analysis.damping, position).expect("modes");
            let worst = worst_frequency(&found, &expected, 30);
            assert!(worst < 5e-6, "{worst:.1e} at {position} m");
        }
    }
    // Negative control: half a per cent of one variable is seen.
    let built =
        couple(&study_design(machine, [3.015, 3.0, 3.0, 3.0, 3.0]).machine, superelements, BasisOptions::up_to(900.0));
    let expected = modes_at(&built.expect("couples"), &machine.analysis.damping, 0.0).expect("modes");
    let found = route.modes(route.prepared(), &designs[1], 0).expect("modes");
    assert!(worst_frequency(&found, &expected, 30) > 5e-5);
}

#[test]
fn both_routes_agree_on_the_mill_with_one_structural_loss_factor() {
    let Mill { machine, superelements } = mill();
    let mut machine = machine.clone();
    machine.analysis.damping = lossy(0.02);
    let asked = request(&machine, 900.0, vec![0.0, -0.3, -0.6]);
    let probes = study_corners(&machine);
    let modes = ModesRoute::new(&machine, superelements, asked.clone(), &probes, &INTERRUPT).expect("prepared");
    let coupling = CouplingRoute::new(&machine, superelements, asked, &probes, &INTERRUPT).expect("prepared");
    let mut next = factors();
    let designs: Vec<Design> = (0..50).map(|_| study_design(&machine, std::array::from_fn(|_| next()))).collect();
    let (a, b) = (coupling.evaluate(&designs), modes.evaluate(&designs));
    let [peak, real, at_rest] = differences(&a, &b);
    println!("routes on the mill: peak {peak:.1e}, real part {real:.1e}, static {at_rest:.1e}");
    assert!(peak < 2e-3 && real < 2e-3 && at_rest < 1e-6, "{peak:.1e} {real:.1e} {at_rest:.1e}");
    // Negative control: another design's answers.
    let mut shifted = b;
    shifted.rotate_left(1);
    assert!(differences(&a, &shifted).iter().all(|d| *d > 0.1));
}

#[test]
fn a_modal_ratio_stays_with_the_base_on_the_coupling_route() {
    let machine = slide_with(ratio(0.01));
    let probes = [scaled(&machine, &mut || 0.3), scaled(&machine, &mut || 3.0)];
    let parts = &slide().parts;
    let modes = ModesRoute::new(&machine, parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let coupling = CouplingRoute::new(&machine, parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let near = [scaled(&machine, &mut || 1.0)];
    let [peak, real, _] = differences(&coupling.evaluate(&near), &modes.evaluate(&near));
    assert!(peak < 1e-3 && real < 1e-3, "the same model at the base: {peak:.1e} {real:.1e}");
    let [peak, _, at_rest] = differences(&coupling.evaluate(&probes), &modes.evaluate(&probes));
    assert!(peak > 1e-2 && at_rest < 1e-6, "two models away from it: {peak:.1e}, static {at_rest:.1e}");
}

/// H by a complex solve in the fixed basis, joint dampers and loss factors exact.
fn direct(model: &CoupledModel, machine: &Machine, position: f64, frequency: f64) -> DMatrix<Complex<f64>> {
    let at = model.at(position).expect("in the travel");
    let values = model.spring_values(machine, position).expect("couples");
    let omega = TAU * frequency;
    let whole = Complex::new(1.0, machine.analysis.damping.loss_factor);
    let complex = |m: &DMatrix<f64>| m.map(|v| Complex::new(v, 0.0));
    let (s, o, i) = (at.springs.nrows(), at.outputs.nrows(), at.inputs.nrows());
    let left = complex(&at.residual) / whole;
    let part = |r: usize, rows: usize, c: usize, columns: usize| left.view((r, c), (rows, columns)).into_owned();
    let mut series = part(0, s, 0, s);
    for k in 0..s {
        let eta = machine.analysis.damping.loss_factor + values.loss_factors[k];
        series[(k, k)] +=
            Complex::new(values.stiffness[k], values.stiffness[k] * eta + omega * values.damping[k]).inv();
    }
    let series = series.try_inverse().expect("springs in series");
    let springs = complex(&at.springs);
    let forces = &series * &springs;
    let mut dynamic = springs.transpose() * &forces;
    for k in 0..model.n() {
        dynamic[(k, k)] += whole * model.eigenvalues[k] - omega * omega;
    }
    let outputs = complex(&at.outputs) - part(s, o, 0, s) * &forces;
    let inputs = complex(&at.inputs) - part(s + o, i, 0, s) * &forces;
    let inner = dynamic.lu().solve(&inputs.transpose()).expect("damped");
    outputs * inner + part(s, o, s + o, i) - part(s, o, 0, s) * series * part(0, s, s + o, i)
}

#[test]
fn joint_dampers_and_loss_factors_are_exact_on_the_coupling_route() {
    let mut machine = slide_with(lossy(0.01));
    machine.joints[0].loss_factor = Some(0.08);
    machine.joints[0].springs[1].damping = 300.0;
    machine.joints[1].springs[0].damping = 500.0;
    let probes = [scaled(&machine, &mut || 3.0)];
    let parts = &slide().parts;
    let route = CouplingRoute::new(&machine, parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let model = &route.prepared().model;
    let mut next = factors();
    let pairs: Vec<(usize, usize)> = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).collect();
    for _ in 0..4 {
        let design = scaled(&machine, &mut next);
        for (k, &position) in route.positions().iter().enumerate() {
            let around = modes_at(model, &lossy(0.0), position).expect("modes");
            let frequencies: Vec<f64> = (0..6).map(|r| around.frequency(around.free + r)).collect();
            let found = route.compliance(&design, k, &frequencies, &pairs).expect("answered");
            let error = |machine: &Machine| {
                let one = |(n, &frequency): (usize, &f64)| {
                    let exact = direct(model, machine, position, frequency);
                    let here = DMatrix::from_fn(3, 3, |i, j| found[3 * i + j][n]);
                    (here - &exact).norm() / exact.norm()
                };
                frequencies.iter().enumerate().map(one).fold(0.0, f64::max)
            };
            assert!(error(&design.machine) < 1e-6, "{:.1e} at {position} m", error(&design.machine));
            let mut undamped = design.machine.clone();
            undamped.joints[0].loss_factor = None;
            assert!(error(&undamped) > 1e-3, "negative control: a joint without its loss factor");
        }
    }
}

#[test]
fn a_part_of_another_material_is_the_part_reduced_anew() {
    let machine = slide_with(ratio(0.01));
    let probes = [scaled(&machine, &mut || 2.0)];
    let route =
        ModesRoute::new(&machine, &slide().parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let mut design = scaled(&machine, &mut || 1.2);
    design.parts[1] = PartScale { young: 1.3, density: 0.8 };
    let mut other = machine.clone();
    let steel = steel();
    other.parts[1].material = Some(Material { young: 1.3 * steel.young, density: 0.8 * steel.density, ..steel });
    let anew = Slide::of(other.clone(), slide().meshes.clone());
    let built = ModesRoute::new(&other, &anew.parts, slide_request(&other), &[scaled(&other, &mut || 2.0)], &INTERRUPT)
        .expect("prepared");
    let expected = built.evaluate(&[scaled(&other, &mut || 1.2)]);
    let found = route.evaluate(std::slice::from_ref(&design));
    assert!(differences(&found, &expected).iter().all(|d| *d < 1e-5), "{:?}", differences(&found, &expected));
    design.parts[1].young = 0.65;
    let found = route.evaluate(std::slice::from_ref(&design));
    let other = differences(&found, &expected);
    assert!(other[2] > 1e-3, "negative control: half the modulus, {other:?}");
}

#[test]
fn a_design_far_from_nominal_has_a_base_of_its_own() {
    let machine = slide_with(lossy(0.02));
    let probes = [scaled(&machine, &mut || 1.5)];
    let parts = &slide().parts;
    let design = scaled(&machine, &mut || 9.0);
    let built =
        ModesRoute::new(&design.machine, parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let expected = built.evaluate(&[Design::nominal(&design.machine)]);
    let near = ModesRoute::new(&machine, parts, slide_request(&machine), &probes, &INTERRUPT).expect("prepared");
    let mixed = [scaled(&machine, &mut || 1.1), design];
    let found = near.evaluate(&mixed);
    assert!(differences(&found[1..], &expected).iter().all(|d| *d < 1e-5), "{:?}", differences(&found[1..], &expected));
    assert!(differences(&found[..1], &expected)[0] > 0.01, "negative control: the design beside it");
}

#[test]
fn families_keep_their_names_and_are_empty_where_they_are_lost() {
    let machine = slide_with(ratio(0.01));
    let asked = Request { families: vec![1, 3, 6], tracked: 8, ..slide_request(&machine) };
    let probes = [scaled(&machine, &mut || 3.0)];
    let route = ModesRoute::new(&machine, &slide().parts, asked.clone(), &probes, &INTERRUPT).expect("prepared");
    let nominal = route.evaluate(&[Design::nominal(&machine)]).swap_remove(0).expect("answered");
    let first = modes_at(&route.prepared().model, &machine.analysis.damping, 0.3).expect("modes");
    for (family, rank) in [(0, 0), (1, 2), (2, 5)] {
        let found = nominal[0].families[family].expect("kept at the base");
        assert!((found / first.frequency(first.free + rank) - 1.0).abs() < 1e-6);
    }
    // A band far below a family's frequency takes nothing from it.
    let low = Request { highest: 100.0, ..asked.clone() };
    let route = ModesRoute::new(&machine, &slide().parts, low, &probes, &INTERRUPT).expect("prepared");
    let narrow = route.evaluate(&[Design::nominal(&machine)]).swap_remove(0).expect("answered");
    for (found, expected) in narrow.iter().zip(&nominal).flat_map(|(a, b)| a.families.iter().zip(&b.families)) {
        let (found, expected) = (found.expect("kept"), expected.expect("kept"));
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }
    // A bed of a thousandth of its modulus bends before the guides do.
    let mut soft = Design::nominal(&machine);
    soft.parts[0].young = 1e-3;
    let lost = route.evaluate(&[soft]).swap_remove(0).expect("answered");
    assert!(lost.iter().flat_map(|p| &p.families).any(Option::is_none), "{:?}", lost[0].families);
    assert!(lost.iter().flat_map(|p| &p.families).flatten().all(|f| *f > 0.0));
    assert!(matches!(
        CouplingRoute::new(&machine, &slide().parts, asked, &probes, &INTERRUPT),
        Err(SweepError::NeedsModes)
    ));
}

#[test]
fn sensitivities_are_the_slopes_of_the_metrics() {
    for damping in [ratio(0.01), lossy(0.02), Damping { rayleigh: Some([20.0, 1e-6]), ..ratio(0.005) }] {
        let machine = slide_with(damping);
        let asked = Request { families: vec![2], tracked: 4, ..slide_request(&machine) };
        let probes = [scaled(&machine, &mut || 2.0)];
        let route = ModesRoute::new(&machine, &slide().parts, asked, &probes, &INTERRUPT).expect("prepared");
        let design = |v: &[f64]| {
            let mut k = 0;
            let mut next = || {
                k += 1;
                if k <= 5 { v[0] } else { v[1] }
            };
            let mut design = scaled(&machine, &mut next);
            design.parts[1].young = v[2];
            Ok(design)
        };
        let at = [1.2, 0.8, 1.0];
        let found = route.sensitivities(&at, &design).expect("answered");
        assert_eq!(found.iter().map(|v| v[0].analytic).collect::<Vec<_>>(), [true, true, false]);
        for variable in 0..2 {
            let h = 3e-5;
            let beside = [-h, h].map(|step| {
                let mut moved = at;
                moved[variable] += step;
                design(&moved).expect("a design")
            });
            let answers = route.evaluate(&beside);
            let [low, high] = [0, 1].map(|k| answers[k].as_ref().expect("answered"));
            for (position, own) in found[variable].iter().enumerate() {
                let slope = |of: &dyn Fn(usize) -> f64| (of(1) - of(0)) / (2.0 * h);
                let side = |k: usize| if k == 0 { &low[position] } else { &high[position] };
                for pair in 0..3 {
                    let metrics = |k: usize| side(k).pairs[pair];
                    for (own, value, scale) in [
                        (own.peak[pair], slope(&|k| metrics(k).peak.value), metrics(0).peak.value),
                        (
                            own.most_negative_real[pair],
                            slope(&|k| metrics(k).most_negative_real.value),
                            metrics(0).most_negative_real.value.abs(),
                        ),
                        (
                            own.static_compliance[pair],
                            slope(&|k| side(k).static_compliance[pair]),
                            metrics(0).peak.value,
                        ),
                    ] {
                        assert!((own - value).abs() < 1e-5 * scale.max(value.abs()), "{own:e} {value:e} of {scale:e}");
                    }
                }
                let frequency = |k: usize| side(k).families[0].expect("kept");
                let (own, value) = (own.families[0].expect("kept"), slope(&frequency));
                assert!((own - value).abs() < 1e-6 * frequency(0), "{own} {value}");
            }
        }
        // Negative control: the slope by the other variable.
        let ratio = found[0][0].static_compliance[0] / found[1][0].static_compliance[0];
        assert!((ratio - 1.0).abs() > 1e-3);
    }
}
