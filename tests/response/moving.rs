//! Along a path: second order in the step, the energy balance by an account of its own, and the frozen limit.

use super::{apart, mill, modes, names};
use nalgebra::{DMatrix, DVector};
use stiffmap::interrupt::Interrupt;
use stiffmap::response::moving::{PathModel, PathOptions, Travel, TravelOptions, travel};
use stiffmap::response::{Forces, Path, Plant, Recording, parse_force, simulate};

fn path_model(range: [f64; 2], options: PathOptions) -> PathModel {
    let damping = &mill().machine.analysis.damping;
    PathModel::new(&mill().model, damping, range, options, &Interrupt::default(), &|| ()).unwrap()
}

/// 200 Hz, 100 N in x, at a rate.
fn sine(duration: f64, rate: f64) -> Forces {
    let mut forces = Forces::none(&names(), duration, rate).unwrap();
    forces.add(0, &parse_force("sine,amplitude=100,frequency=200").unwrap());
    forces
}

fn run(model: &PathModel, path: &Path, forces: &Forces) -> Travel {
    travel(model, path, forces, TravelOptions::default(), &Interrupt::default(), &|| ()).unwrap()
}

/// Every `stride`-th sample of the first output.
fn thinned(travel: &Travel, stride: usize) -> Vec<f64> {
    travel.history.output(0).into_iter().step_by(stride).collect()
}

#[test]
fn along_thirty_metres_a_minute_the_step_hardly_matters_and_the_energy_closes() {
    // 0.03 m in 0.06 s; docs/time_response.md has the figures of all 0.6 m.
    let model = path_model([-0.3, -0.27], PathOptions::up_to(900.0));
    println!("{} coordinates", model.n());
    let path = Path::constant_speed(-0.27, -0.3, 0.5).unwrap();
    let rates = [10e3, 20e3, 40e3, 80e3];
    let runs: Vec<Travel> = rates.iter().map(|rate| run(&model, &path, &sine(0.06, *rate))).collect();
    let errors: Vec<f64> = (0..3)
        .map(|k| {
            let fine = thinned(&runs[3], 8);
            let own = thinned(&runs[k], 1 << k);
            apart(&own[..fine.len().min(own.len())], &fine[..fine.len().min(own.len())])
        })
        .collect();
    let slopes: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("difference to 80 kHz at 10, 20, 40 kHz: {errors:?}, slopes {slopes:.2?}");
    // The sine's samples carry its amplitude at every rate; what is left is K held for two samples and the wave's mirror.
    assert!(errors[0] < 1e-5 && errors[1] < 1e-6 && errors[2] < 1e-6, "{errors:?}");
    assert!(slopes.iter().all(|s| *s > 1.8), "at least second order: {slopes:?}");
    let mut lower = sine(0.06, rates[1]);
    let plain = (std::f64::consts::PI * 200.0 / rates[1]).sin() / (std::f64::consts::PI * 200.0 / rates[1]);
    lower.values.iter_mut().for_each(|f| *f *= plain * plain);
    let control = apart(&thinned(&run(&model, &path, &lower), 2), &thinned(&runs[3], 8));
    assert!(control > 1e-4, "control: lines through the wave's own values, {control:.1e}");
    let closure: Vec<f64> = runs.iter().map(|r| r.energy.closure()).collect();
    println!("energy closed to {closure:?}");
    assert!(closure[1] < 1e-6, "{:.1e}", closure[1]);
    let e = &runs[1].energy;
    let last = |list: &[f64]| *list.last().unwrap();
    println!(
        "stored {:.3e} J, force {:.3e} J, dissipated {:.3e} J, through the change of K {:.3e} J",
        last(&e.kinetic) + last(&e.potential),
        last(&e.force),
        last(&e.dissipated),
        last(&e.travel)
    );
    let mut without = e.clone();
    without.travel.fill(0.0);
    assert!(without.closure() > 1e-5, "control: without the guide's work it does not close, {:.1e}", without.closure());
    let mut less = e.clone();
    less.dissipated.iter_mut().for_each(|w| *w *= 1.0 - 1e-5);
    assert!(less.closure() > 1e-6, "control: a loss of 1e-5 of the dissipation shows");
}

#[test]
fn a_path_that_rests_is_the_fixed_position() {
    let position = -0.2025;
    let model = path_model(
        [position - 1e-3, position + 1e-3],
        PathOptions { band: f64::INFINITY, ..PathOptions::up_to(900.0) },
    );
    assert_eq!(model.n(), mill().model.n());
    let path = Path::through(vec![(0.0, position)]).unwrap();
    let mut forces = sine(0.01, 20e3);
    forces.add(2, &parse_force("impulse").unwrap());
    let recording = Recording { velocity: true, acceleration: false };
    let options = TravelOptions { recording, ..TravelOptions::default() };
    let moving = travel(&model, &path, &forces, options, &Interrupt::default(), &|| ()).unwrap();
    let fixed = simulate(&Plant::whole(&modes(position)), &forces, recording);
    let found = apart(&moving.history.displacement, &fixed.displacement);
    println!("at rest: {found:.1e}");
    // The eigensolver of every step keeps 1e-12 of the largest eigenvalue, (2 pi 70 kHz)^2 in the whole basis.
    assert!(found < 2e-6, "{found:.1e}");
    let beside = simulate(&Plant::whole(&modes(position + 5e-4)), &forces, recording);
    let control = apart(&moving.history.displacement, &beside.displacement);
    assert!(control > 5e-6, "control: 0.5 mm away, {control:.1e}");
}

#[test]
fn the_paths_basis_follows_the_whole_fixed_basis() {
    let range = [-0.3, -0.285];
    let forces = sine(0.03, 20e3);
    let path = Path::constant_speed(-0.285, -0.3, 0.5).unwrap();
    let reduced = path_model(range, PathOptions::up_to(900.0));
    let whole = path_model(range, PathOptions { band: f64::INFINITY, ..PathOptions::up_to(900.0) });
    let hold = TravelOptions { hold: 30, ..TravelOptions::default() };
    let go = |model: &PathModel| travel(model, &path, &forces, hold, &Interrupt::default(), &|| ()).unwrap();
    let expected = go(&whole).history.displacement;
    let found = apart(&go(&reduced).history.displacement, &expected);
    println!("{} of {} coordinates: {found:.1e} of the peak", reduced.n(), whole.n());
    assert!(found < 2e-3, "{found:.1e}");
    let narrow = path_model(range, PathOptions { band: 150.0, ..PathOptions::up_to(900.0) });
    assert!(apart(&go(&narrow).history.displacement, &expected) > 4e-3, "control");
}

/// z'' + C z' + K(p) z = f by the classical Runge-Kutta method in small steps, with all works as further unknowns.
fn runge_kutta(model: &PathModel, path: &Path, force: impl Fn(f64) -> f64, time: f64, steps: usize) -> [f64; 5] {
    let n = model.n();
    let h = time / steps as f64;
    let zeta = 0.02;
    // The damping of the frozen position: 2 zeta sqrt(K).
    let root = |k: &DMatrix<f64>| {
        let eigen = k.clone().symmetric_eigen();
        let d = DMatrix::from_diagonal(&eigen.eigenvalues.map(|l| 2.0 * zeta * l.max(0.0).sqrt()));
        &eigen.eigenvectors * d * eigen.eigenvectors.transpose()
    };
    let local = |t: f64| model.at(path.at(t));
    let rate =
        |t: f64, z: &DVector<f64>, v: &DVector<f64>, m: &(DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DVector<f64>)| {
            let (k, c, change, input) = m;
            let f = input * force(t);
            let damping = c * v;
            let work = [f.dot(v), damping.dot(v), 0.5 * z.dot(&(change * z))];
            (v.clone(), &f - &damping - k * z, work)
        };
    let matrices = |t: f64| {
        let d = 1e-5;
        let l = local(t);
        let change = (local(t + d).stiffness - local(t - d).stiffness) / (2.0 * d);
        (l.stiffness.clone(), root(&l.stiffness), change, l.inputs.row(0).transpose())
    };
    let (mut z, mut v, mut works) = (DVector::zeros(n), DVector::zeros(n), [0.0; 3]);
    let mut now = matrices(0.0);
    for s in 0..steps {
        let t = s as f64 * h;
        let (middle, next) = (matrices(t + 0.5 * h), matrices(t + h));
        let a = rate(t, &z, &v, &now);
        let b = rate(t + 0.5 * h, &(&z + &a.0 * (0.5 * h)), &(&v + &a.1 * (0.5 * h)), &middle);
        let c = rate(t + 0.5 * h, &(&z + &b.0 * (0.5 * h)), &(&v + &b.1 * (0.5 * h)), &middle);
        let d = rate(t + h, &(&z + &c.0 * h), &(&v + &c.1 * h), &next);
        z += (a.0 + (b.0 + c.0) * 2.0 + d.0) * (h / 6.0);
        v += (a.1 + (b.1 + c.1) * 2.0 + d.1) * (h / 6.0);
        for (k, work) in works.iter_mut().enumerate() {
            *work += (a.2[k] + 2.0 * (b.2[k] + c.2[k]) + d.2[k]) * (h / 6.0);
        }
        now = next;
    }
    [0.5 * v.norm_squared(), 0.5 * z.dot(&(&now.0 * &z)), works[0], works[1], works[2]]
}

#[test]
fn each_energy_is_that_of_a_runge_kutta_solution_of_the_continuous_problem() {
    // Few coordinates and a fast carriage, so that the guide's work is a good share and Runge and Kutta are quick.
    let model = path_model([-0.31, -0.19], PathOptions { band: 260.0, tolerance: 0.05, ..PathOptions::up_to(900.0) });
    let path = Path::constant_speed(-0.2, -0.3, 10.0).unwrap();
    let forces = sine(0.009, 200e3);
    let found = run(&model, &path, &forces).energy;
    let sine = |t: f64| 100.0 * (std::f64::consts::TAU * 200.0 * t).sin();
    let expected = runge_kutta(&model, &path, sine, 0.009 - 1.0 / 200e3, 3600);
    let of = |e: &[f64]| *e.last().unwrap();
    let own = [of(&found.kinetic), of(&found.potential), of(&found.force), of(&found.dissipated), of(&found.travel)];
    println!("{} coordinates\nstepping    {own:?}\nRunge-Kutta {expected:?}", model.n());
    let scale = expected[2].abs().max(expected[3]);
    for (a, b) in own.iter().zip(expected) {
        assert!((a - b).abs() < 3e-5 * b.abs(), "{a:e} {b:e}");
    }
    assert!(expected[4].abs() > 1e-4 * scale, "control: the guide's work is no rounding, {:.1e}", expected[4] / scale);
}

#[test]
fn a_path_outside_the_travel_is_refused_and_stopping_is_obeyed() {
    let damping = &mill().machine.analysis.damping;
    let options = PathOptions::up_to(900.0);
    let error =
        PathModel::new(&mill().model, damping, [-0.7, -0.5], options, &Interrupt::default(), &|| ()).unwrap_err();
    assert!(error.is_input() && error.to_string().contains("outside the travel"), "{error}");
    let asked = Interrupt::default();
    asked.request();
    assert!(PathModel::new(&mill().model, damping, [-0.3, -0.29], options, &asked, &|| ()).is_err());
    let points = Path::through(vec![(0.0, -0.1), (1.0, -0.2), (1.0, -0.3)]).unwrap_err().to_string();
    assert!(points.contains("1 s after 1 s"), "{points}");
}
