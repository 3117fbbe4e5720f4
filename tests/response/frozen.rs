//! Fixed position: SciPy, the matrix exponential and python-control on the exported system.

use super::{apart, modes, names, python};
use nalgebra::{DMatrix, DVector};
use stiffmap::export::{history, mat};
use stiffmap::frf::{FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use stiffmap::interrupt::Interrupt;
use stiffmap::response::{
    Forces, History, Plant, Recording, acceleration_share_above, parse_force, simulate, simulate_all,
};
use stiffmap::state_space::{Database, Hold, StateSpace, StateSpaceOptions, discretise, state_space};

const EVERYTHING: StateSpaceOptions =
    StateSpaceOptions { modes: 30, velocity: true, acceleration: true, residual: true };
const ALL: Recording = Recording { velocity: true, acceleration: true };

/// A chirp, noise and an impulse at once.
fn forces(duration: f64) -> Forces {
    let mut forces = Forces::none(&names(), duration, 20e3).unwrap();
    forces.add(0, &parse_force("chirp,amplitude=5,from=10,to=2000").unwrap());
    forces.add(1, &parse_force("impulse,amplitude=3,start=0.01").unwrap());
    forces.add(2, &parse_force("sine,amplitude=2,frequency=333").unwrap());
    forces
}

fn write(folder: &std::path::Path, name: &str, system: &StateSpace) -> std::path::PathBuf {
    let path = folder.join(name);
    mat::write_state_space(&path, std::slice::from_ref(system), &names(), &names()).unwrap();
    path
}

#[test]
fn the_response_is_lsims_and_the_matrix_exponentials_to_1e_9_of_the_peak() {
    let folder = tempfile::tempdir().unwrap();
    let system = state_space(&modes(-0.2375), EVERYTHING);
    let forces = forces(0.25);
    let found = simulate(&Plant::of_state_space(&system), &forces, ALL);
    let record = folder.path().join("history.mat");
    let write_record = |h: &stiffmap::response::History| {
        history::write_mat(&record, &[0.0], std::slice::from_ref(h), &forces, &names(), None, &[]).unwrap()
    };
    write_record(&found);
    let file = write(folder.path(), "system.mat", &system);
    for check in ["lsim", "expm"] {
        let Some(figure) = python(check, &[&file, &record]) else { return };
        println!("{check}: {figure:.1e} of the peak");
        assert!(figure < 1e-9, "{check}: {figure:.1e}");
    }
    let mut wrong = found.clone();
    let at = wrong.displacement.len() / 2;
    wrong.displacement[at] += 1e-8 * wrong.displacement.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    write_record(&wrong);
    assert!(python("expm", &[&file, &record]).unwrap() > 1e-9, "control: one sample off by 1e-8 of the peak shows");
    write_record(&found);
    let mut stiffer = system.clone();
    let n = stiffer.eigenvalues.len();
    stiffer.a[(n + 3, 3)] *= 1.0 + 1e-6;
    let file = write(folder.path(), "stiffer.mat", &stiffer);
    assert!(python("lsim", &[&file, &record]).unwrap() > 1e-9, "control: one part in 1e6 of a mode's stiffness shows");
}

#[test]
fn scipy_steps_the_discretised_system_to_the_same_response() {
    let folder = tempfile::tempdir().unwrap();
    let solved = [modes(-0.2375)];
    let mut database = Database::new(&solved, EVERYTHING).unwrap();
    let continuous = database.states[0].clone();
    let forces = forces(0.1);
    let found = simulate(&Plant::of_state_space(&continuous), &forces, ALL);
    let record = folder.path().join("history.mat");
    history::write_mat(&record, &[0.0], &[found], &forces, &names(), None, &[]).unwrap();
    database.states[0] = discretise(&continuous, forces.step, Hold::First);
    let file = folder.path().join("discrete.mat");
    mat::write_database(&file, &database, &names(), &names(), Some((forces.step, Hold::First))).unwrap();
    let Some(figure) = python("discrete", &[&file, &record]) else { return };
    assert!(figure < 1e-9, "{figure:.1e}");
    database.states[0].b[(1, 0)] *= 1.0 + 1e-5;
    mat::write_database(&file, &database, &names(), &names(), Some((forces.step, Hold::First))).unwrap();
    assert!(python("discrete", &[&file, &record]).unwrap() > 1e-9, "control");
}

#[test]
fn python_control_has_the_same_frequency_response_to_1e_10() {
    let folder = tempfile::tempdir().unwrap();
    let solved = [modes(-0.4125)];
    let (systems, _) = modal_systems(&solved, 900.0, Selection::Exactly { modes: 30, residual: true }).unwrap();
    let frequencies: Vec<f64> = (0..=180).map(|k| 5.0 * f64::from(k)).collect();
    let request = FrfRequest {
        positions: &[-0.4125],
        systems: &systems,
        frequencies: &frequencies,
        outputs: &names(),
        inputs: &names(),
        quantity: Quantity::Receptance,
    };
    let map = folder.path().join("map.mat");
    mat::write_compliance(&map, &modal_sum(&request).unwrap()).unwrap();
    let mut system = state_space(&solved[0], EVERYTHING);
    let file = write(folder.path(), "system.mat", &system);
    let Some(figure) = python("control", &[&file, &map]) else { return };
    println!("python-control: {figure:.1e}");
    assert!(figure < 1e-10, "{figure:.1e}");
    system.d[(0, 0)] *= 1.0 + 1e-6;
    let file = write(folder.path(), "system.mat", &system);
    assert!(python("control", &[&file, &map]).unwrap() > 1e-10, "control");
}

#[test]
fn every_row_of_the_database_is_the_same_motion() {
    // The velocity is the displacement's derivative, the acceleration the velocity's: Hermite's rule on both.
    let plant = Plant::whole(&modes(-0.1));
    let mut smooth = Forces::none(&names(), 0.05, 40e3).unwrap();
    smooth.add(2, &parse_force("sine,amplitude=2,frequency=120").unwrap());
    let plant = Plant { direct: plant.direct.clone() * 0.0, ..plant };
    let found = simulate(&plant, &smooth, ALL);
    let (h, n) = (found.step, 3);
    let (v, a) = (found.velocity.as_ref().unwrap(), found.acceleration.as_ref().unwrap());
    let step = |x: &[f64], slope: &[f64], k: usize, i: usize| {
        let at = |k: usize| k * n + i;
        (x[at(k + 1)] - x[at(k)]) / h - 0.5 * (slope[at(k)] + slope[at(k + 1)])
    };
    let peak = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let worst = (10..found.samples() - 1).map(|k| step(&found.displacement, v, k, 2).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-3 * peak, "{:.1e}", worst / peak);
    let peak = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let worst = (400..found.samples() - 1).map(|k| step(v, a, k, 2).abs()).fold(0.0, f64::max);
    assert!(worst < 3e-2 * peak, "{:.1e}", worst / peak);
}

#[test]
fn positions_in_parallel_are_those_one_by_one_and_can_be_stopped() {
    let plants: Vec<Plant> = [0.0, -0.3].map(|p| Plant::whole(&modes(p))).to_vec();
    let forces = forces(0.02);
    let both = simulate_all(&plants, &forces, ALL, &Interrupt::default(), &|| ()).unwrap();
    assert_eq!(both[1], simulate(&plants[1], &forces, ALL));
    assert!(apart(&both[0].displacement, &both[1].displacement) > 1e-3, "control: the positions differ");
    let stopped = Interrupt::default();
    stopped.request();
    assert!(simulate_all(&plants, &forces, ALL, &stopped, &|| ()).is_err());
}

/// Three modes, the first free, with two dampers between them.
fn damped() -> Plant {
    Plant {
        position: 0.0,
        omega: vec![0.0, 900.0, 4000.0],
        zeta: vec![0.0, 0.01, 0.02],
        dampers: DMatrix::from_row_slice(2, 3, &[6.0, -11.0, 20.0, 2.0, 9.0, 14.0]),
        outputs: DMatrix::from_row_slice(2, 3, &[0.5, 1.0, -0.8, 0.3, -0.7, 0.9]),
        inputs: DMatrix::from_row_slice(1, 3, &[0.4, 0.6, 1.1]),
        direct: DMatrix::from_column_slice(2, 1, &[1e-8, -2e-8]),
    }
}

/// Displacements, rates and accelerations of all samples by the classical Runge-Kutta method in small steps.
fn by_small_steps(plant: &Plant, forces: &Forces, parts: usize) -> Vec<[f64; 6]> {
    let n = plant.omega.len();
    let damping = plant.dampers.transpose() * &plant.dampers;
    let accelerate = |q: &DVector<f64>, v: &DVector<f64>, u: f64| {
        let own = |r: usize| {
            let w = plant.omega[r];
            plant.inputs[(0, r)] * u - 2.0 * plant.zeta[r] * w * v[r] - w * w * q[r]
        };
        DVector::from_fn(n, |r, _| own(r)) - &damping * v
    };
    let (mut q, mut v) = (DVector::zeros(n), DVector::zeros(n));
    let h = forces.step / parts as f64;
    let mut out = Vec::new();
    for k in 0..forces.samples() {
        let u = forces.values[k];
        let rows =
            [&plant.outputs * &q + &plant.direct * u, &plant.outputs * &v, &plant.outputs * accelerate(&q, &v, u)];
        out.push(std::array::from_fn(|i| rows[i / 2][i % 2]));
        let Some(next) = forces.values.get(k + 1) else { break };
        for p in 0..parts {
            let u = |s: f64| u + (next - u) * (p as f64 + s) / parts as f64;
            let a = (v.clone(), accelerate(&q, &v, u(0.0)));
            let step = |d: &(DVector<f64>, DVector<f64>), t: f64, s: f64| {
                let (q, v) = (&q + &d.0 * t, &v + &d.1 * t);
                (v.clone(), accelerate(&q, &v, u(s)))
            };
            let b = step(&a, 0.5 * h, 0.5);
            let c = step(&b, 0.5 * h, 0.5);
            let d = step(&c, h, 1.0);
            q += (a.0 + (b.0 + c.0) * 2.0 + d.0) * (h / 6.0);
            v += (a.1 + (b.1 + c.1) * 2.0 + d.1) * (h / 6.0);
        }
    }
    out
}

#[test]
fn dampers_between_modes_act_as_small_steps_say() {
    let plant = damped();
    // More than two blocks of samples, and a rest.
    let mut forces = Forces::none(&["x".to_owned()], 0.015, 10e3).unwrap();
    forces.add(0, &parse_force("impulse,length=2e-3").unwrap());
    let expected = by_small_steps(&plant, &forces, 60);
    let differences = |found: &History| {
        let lists = [&found.displacement, found.velocity.as_ref().unwrap(), found.acceleration.as_ref().unwrap()];
        let one = |i: usize| {
            let own: Vec<f64> = lists[i / 2].iter().skip(i % 2).step_by(2).copied().collect();
            super::apart(&own, &expected.iter().map(|e| e[i]).collect::<Vec<_>>())
        };
        (0..6).map(one).fold(0.0, f64::max)
    };
    let found = differences(&simulate(&plant, &forces, ALL));
    println!("dampers between modes: {found:.1e} of the peak");
    assert!(found < 1e-8, "{found:.1e}");
    let projected = Plant { zeta: plant.projected_ratios(), dampers: DMatrix::zeros(0, 3), ..plant.clone() };
    let control = differences(&simulate(&projected, &forces, ALL));
    assert!(control > 1e-2, "control: projected on the modes, {control:.1e}");
    let share = acceleration_share_above(400.0, &plant, &simulate(&plant, &forces, ALL), &forces).unwrap();
    assert!((0.05..1.5).contains(&share), "share of the fastest mode {share}");
}
