//! Dampers between the modes in time: state spaces, histories and paths against the direct solve and each other.

use super::support::slide::Slide;
use super::{Direct, HIGHEST, models};
use nalgebra::DVector;
use stiffmap::coupling::{BasisOptions, CoupledModel, couple};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::Machine;
use stiffmap::modal::modes_at;
use stiffmap::response::moving::{PathModel, PathOptions, TravelOptions, travel};
use stiffmap::response::{Forces, Path, Plant, Recording, Shape, simulate};
use stiffmap::state_space::{Hold, StateSpaceOptions, discretise, receptance, state_space};

const AT: f64 = -0.21;

/// The machines that only ratios and dampers damp, which time knows as they are.
fn damped() -> Vec<(&'static str, Machine, Slide)> {
    let wanted = ["dampers", "dampers with a ratio"];
    models().into_iter().filter(|(name, ..)| wanted.contains(name)).collect()
}

fn coupled(machine: &Machine, slide: &Slide) -> CoupledModel {
    couple(machine, &slide.parts, BasisOptions::up_to(HIGHEST)).expect("coupled")
}

/// All modes of the basis.
fn whole(model: &CoupledModel) -> StateSpaceOptions {
    StateSpaceOptions { modes: model.n(), velocity: false, acceleration: false, residual: true }
}

#[test]
fn a_state_space_of_all_modes_answers_as_the_direct_solve() {
    for (name, machine, slide) in damped() {
        let model = coupled(&machine, &slide);
        let direct = Direct::new(&machine, &model, AT);
        let off = |projected: bool| {
            let mut damping = machine.analysis.damping.clone();
            damping.projected = projected;
            let system = state_space(&modes_at(&model, &damping, AT).expect("modes"), whole(&model));
            let one = |k: i32| {
                let f = 30.0 * f64::from(k);
                let h = direct.at(f);
                (receptance(&system, f) - &h).norm() / h.norm()
            };
            (1..50).map(one).fold(0.0, f64::max)
        };
        let (found, projected) = (off(false), off(true));
        println!("{name}: state space {found:.1e}, projected {projected:.1e}");
        assert!(found < 1e-4 && projected > 3e-3, "{name}: {found:e}; control {projected:e}");
    }
}

/// A blow and a sine at different inputs.
fn forces(inputs: usize) -> Forces {
    let names: Vec<String> = (0..inputs).map(|k| format!("input {k}")).collect();
    let mut forces = Forces::none(&names, 0.03, 20e3).expect("forces");
    forces.add(0, &Shape::Sine { amplitude: 100.0, frequency: 240.0, phase: 0.0 });
    forces.add(inputs - 1, &Shape::Step { amplitude: 50.0, start: 0.004 });
    forces
}

/// Largest difference of two lists as a share of the second's largest.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let peak = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert!(peak > 0.0 && a.iter().all(|x| x.is_finite()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
}

#[test]
fn a_discrete_state_space_and_a_history_are_one() {
    for (name, machine, slide) in damped() {
        let model = coupled(&machine, &slide);
        let modes = modes_at(&model, &machine.analysis.damping, AT).expect("modes");
        let forces = forces(modes.inputs.nrows());
        let history = simulate(&Plant::whole(&modes), &forces, Recording::default()).displacement;
        let discrete = discretise(&state_space(&modes, whole(&model)), forces.step, Hold::First);
        // Its state is x - P u, and the machine rests at the first sample.
        let u = |k: usize| DVector::from_column_slice(&forces.values[k * forces.inputs.len()..][..forces.inputs.len()]);
        let mut x = DVector::zeros(discrete.a.nrows());
        let first = forces.values[..forces.inputs.len()].iter().all(|f| *f == 0.0);
        assert!(first, "no force at the beginning");
        let mut found = Vec::new();
        for k in 0..forces.samples() {
            found.extend((&discrete.c * &x + &discrete.d * u(k)).iter());
            x = &discrete.a * x + &discrete.b * u(k);
        }
        let off = apart(&found, &history);
        println!("{name}: discrete system against history {off:.1e}");
        assert!(off < 1e-9, "{name}: {off:e}");
        let zero = discretise(&state_space(&modes, whole(&model)), 1.001 * forces.step, Hold::First);
        assert!((zero.a - &discrete.a).norm() > 1e-6 * discrete.a.norm(), "control: another step is another system");
    }
}

#[test]
fn a_path_that_rests_is_the_fixed_position_with_dampers_too() {
    for (name, machine, slide) in damped() {
        let model = coupled(&machine, &slide);
        let history = |projected: bool| {
            let mut damping = machine.analysis.damping.clone();
            damping.projected = projected;
            let modes = modes_at(&model, &damping, AT).expect("modes");
            let forces = forces(modes.inputs.nrows());
            let fixed = simulate(&Plant::whole(&modes), &forces, Recording::default());
            let path = Path::through(vec![(0.0, AT)]).expect("path");
            let go = |options| travel(&path_model(&model, &damping, &path), &path, &forces, options, &quiet(), &|| ());
            let moving = go(TravelOptions::default()).expect("travel");
            println!("{name}: energy {:.1e}", moving.energy.closure());
            assert!(moving.energy.closure() < 1e-10, "{name}: {:e}", moving.energy.closure());
            (moving.history.displacement, fixed.displacement)
        };
        let (moving, fixed) = history(false);
        let off = apart(&moving, &fixed);
        println!("{name}: at rest {off:.1e}");
        assert!(off < 1e-6, "{name}: {off:e}");
        let (_, projected) = history(true);
        assert!(apart(&projected, &fixed) > 1e-3, "control: projected dampers move otherwise");
    }
}

fn quiet() -> Interrupt {
    Interrupt::default()
}

fn path_model(model: &CoupledModel, damping: &stiffmap::machine::Damping, path: &Path) -> PathModel {
    PathModel::new(model, damping, path, PathOptions::default(), &quiet(), &|| ()).expect("a path")
}
