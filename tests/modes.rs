//! Modes at a position: counted, named, damped, followed.

mod support;

use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::OnceLock;
use stiffmap::coupling::{BasisOptions, CoupledModel, couple};
use stiffmap::machine::{Damping, Machine, Motion};
use stiffmap::modal::{ModalError, Modes, check_count, mode_table, modes_at, track};
use support::slide::{Slide, ratio, side, spring, springs};

/// The basis reaches to three times this frequency, Hz.
const BAND: f64 = 8000.0;

fn slide() -> &'static Slide {
    static SLIDE: OnceLock<Slide> = OnceLock::new();
    SLIDE.get_or_init(|| Slide::new(true))
}

fn model(change: impl Fn(&mut Machine)) -> CoupledModel {
    let mut machine = slide().machine.clone();
    change(&mut machine);
    couple(&machine, &slide().parts, BasisOptions::up_to(BAND)).expect("couples")
}

fn undamped(model: &CoupledModel, position: f64) -> Modes {
    modes_at(model, &ratio(0.0), position).expect("modes")
}

#[test]
fn the_count_passes_and_notices_a_mode_that_is_removed() {
    let model = model(|_| {});
    for position in [0.3, 0.0123, -0.3] {
        let modes = undamped(&model, position);
        let count = check_count(&model, &modes, 10).expect("complete");
        assert!(count.found == count.counted && count.found >= 10);
        for lost in [0, 5, 9] {
            let mut fewer = modes.clone();
            fewer.eigenvalues.remove(lost);
            let Err(ModalError::Missed { found, counted, .. }) = check_count(&model, &fewer, 10) else {
                panic!("mode {lost}")
            };
            assert_eq!(counted, found + 1);
        }
        let mut doubled = modes.clone();
        doubled.eigenvalues.insert(3, doubled.eigenvalues[3]);
        assert!(matches!(check_count(&model, &doubled, 10), Err(ModalError::Missed { .. })));
    }
}

#[test]
fn motions_that_nothing_resists_are_at_exactly_zero_and_named() {
    let screwless = model(|m| {
        m.joints.truncate(1);
    });
    let free = undamped(&screwless, 0.1);
    assert_eq!((free.free, free.frequency(0)), (1, 0.0));
    let motions = free.free_motions(&screwless);
    assert_eq!(motions[0].name, "carriage slides along z");
    // A mass-normalised translation moves every point by 1 / sqrt(m).
    let mass = slide().parts[1].mass;
    assert!((motions[0].at_outputs * mass.sqrt() - 1.0).abs() < 1e-6, "{}", motions[0].at_outputs);
    let turning = model(|m| {
        m.joints[0].springs.remove(3);
    });
    let free = undamped(&turning, 0.1);
    assert_eq!((free.free, free.frequency(0)), (1, 0.0));
    let name = &free.free_motions(&turning)[0].name;
    assert!(name.starts_with("carriage") && free.frequency(1) > 10.0, "{name}");
    let held = model(|_| {});
    assert!(
        undamped(&held, 0.1).free == 0 && undamped(&held, 0.1).frequency(0) > 10.0,
        "control: the whole machine is held"
    );
}

/// Elongation of a spring in the exact modes: d omega^2 / d k by differences of the machine itself.
fn sensitivity(joint: usize, place: usize, position: f64, mode: usize) -> f64 {
    let eigenvalue = |factor: f64| {
        let changed = model(|m| {
            if let stiffmap::machine::SpringStiffness::Constant(k) = &mut m.joints[joint].springs[place].stiffness {
                *k *= factor;
            }
        });
        undamped(&changed, position).eigenvalues[mode]
    };
    let k = match slide().machine.joints[joint].springs[place].stiffness {
        stiffmap::machine::SpringStiffness::Constant(k) => k,
        _ => panic!("a plain spring"),
    };
    (eigenvalue(1.001) - eigenvalue(0.999)) / (0.002 * k)
}

// zeta_r = c (b phi_r)^2 / (2 omega_r), and (b phi_r)^2 = d omega_r^2 / d k by Rayleigh's quotient.
#[test]
fn a_joints_damper_damps_each_mode_by_its_elongation() {
    let (c, position) = (1e3, 0.05);
    let damped = model(|m| m.joints[0].springs[0].damping = c);
    let modes = undamped(&damped, position);
    for r in 0..6 {
        let expected = c * sensitivity(0, 0, position, r) / (2.0 * modes.eigenvalues[r].sqrt());
        let (off, largest) = (
            (modes.damping_ratios[r] - expected).abs(),
            modes.damping_ratios[..6].iter().fold(0.0f64, |m, z| m.max(*z)),
        );
        assert!(off < 1e-5 * largest, "mode {r}: {} against {expected}", modes.damping_ratios[r]);
    }
    assert!(modes.damping_ratios.iter().any(|z| *z > 1e-4), "and some mode is damped");
    let wrong = c * sensitivity(0, 1, position, 0) / (2.0 * modes.eigenvalues[0].sqrt());
    assert!(
        (modes.damping_ratios[0] - wrong).abs() > 1e-3 * modes.damping_ratios[0],
        "control: another spring's elongation"
    );
}

/// The machine with a loss factor for all parts and another for all joints.
fn lossy(parts: f64, joints: f64) -> CoupledModel {
    model(|m| {
        m.parts.iter_mut().for_each(|p| p.loss_factor = Some(parts));
        m.joints.iter_mut().for_each(|j| j.loss_factor = Some(joints));
    })
}

/// Largest relative difference of the first twenty loss factors from `eta`.
fn loss_error(model: &CoupledModel, eta: f64) -> f64 {
    let losses = undamped(model, 0.1).loss_factors;
    losses.iter().take(20).map(|loss| (loss / eta - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn one_loss_factor_for_all_parts_and_joints_is_the_loss_factor_of_every_mode() {
    let eta = 0.013;
    let error = loss_error(&lossy(eta, eta), eta);
    println!("loss factors: {error:.1e}");
    // The parts' shares in the residual flexibility are an approximation; see the next test.
    assert!(error < 5e-3, "{error:.1e}");
    let uneven = undamped(&lossy(eta, 0.0), 0.1).loss_factors;
    assert!(uneven.iter().take(6).any(|loss| loss / eta < 0.9), "control: without the joints' losses it is less");
}

#[test]
fn the_energies_of_parts_and_joints_add_up_to_the_last_digit() {
    let model = lossy(0.013, 0.013);
    let at = model.at(0.1).expect("rows");
    let s = at.residual.nrows();
    let whole = at.residual.clone();
    let sum = at.residual_of_part.iter().flatten().fold(DMatrix::zeros(s, s), |sum, part| sum + &part.between_forces);
    let error = (&sum - &whole).amax() / whole.amax();
    assert!(error < 1e-10, "the parts' residual flexibilities differ from the whole by {error:.1e} of it");
    assert!(loss_error(&model, 0.013) < 1e-8);
}

#[test]
fn ratios_rayleigh_and_loss_factors_add_up() {
    let model = model(|_| {});
    let damping =
        Damping { ratios: vec![0.01, 0.02], rayleigh: Some([3.0, 1e-6]), loss_factor: 0.004, projected: false };
    let modes = modes_at(&model, &damping, 0.0).expect("modes");
    for r in 0..10 {
        let omega = TAU * modes.frequency(r);
        let expected = if r == 0 { 0.01 } else { 0.02 } + 0.5 * (3.0 / omega + 1e-6 * omega);
        assert!((modes.damping_ratios[r] - expected).abs() < 1e-12 && modes.loss_factors[r] == 0.004);
        assert!((modes.damping_ratios[r] - 0.02).abs() > 1e-6);
    }
}

#[test]
fn tracking_a_real_machine_keeps_every_mode_once() {
    let model =
        model(|m| m.joints.push(springs("stop", [side(0, 1), side(1, 1)], vec![spring(Motion::Translation, 0, 1e4)])));
    let stations: Vec<Modes> = slide().machine.axis.stations().into_iter().map(|p| undamped(&model, p)).collect();
    let families = track(&stations, 8, &|p| modes_at(&model, &ratio(0.0), p)).expect("tracks");
    assert_eq!(families.positions, slide().machine.axis.stations());
    for (modes, row) in stations.iter().zip(&families.modes) {
        assert_eq!(row.len(), 8);
        let mut names: Vec<usize> = row.iter().map(|m| m.family).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 8, "no family twice at {}", modes.position);
        assert!(row.iter().enumerate().all(|(r, m)| m.rank == r + 1 && m.frequency == modes.frequency(r)));
    }
    for row in mode_table(&families) {
        assert!(
            row.min > 0.0 && row.max >= row.min && row.max < 2.3 * row.min,
            "the screw's stiffness changes fivefold, more would be a lost family: {row:?}"
        );
    }
}

#[test]
fn many_positions_are_solved_as_few_without_their_shapes() {
    use stiffmap::interrupt::Interrupt;
    use stiffmap::pipeline::{solve_many_positions, solve_positions};
    let model = model(|_| ());
    // More than are solved together.
    let positions: Vec<f64> = (0..80).map(|k| 0.3 - 0.0075 * f64::from(k)).collect();
    let go = Interrupt::default();
    let few = solve_positions(&slide().machine, &model, &positions, 10, &go, &|| ()).unwrap();
    let many = solve_many_positions(&slide().machine, &model, &positions, 10, &go, &|| ()).unwrap();
    assert_eq!(few.families.modes, many.families.modes);
    assert_eq!(few.counts, many.counts);
    for (a, b) in few.modes.iter().zip(&many.modes) {
        assert_eq!((&a.eigenvalues, &a.outputs, &a.direct), (&b.eigenvalues, &b.outputs, &b.direct));
    }
    assert!(many.modes[1..].iter().all(|m| m.shapes.is_empty()) && few.modes.iter().all(|m| !m.shapes.is_empty()));
}
