//! Along a path: second order in the step, the energy balance by an account of its own, and the frozen limit.

use super::{apart, mill, modes, names};
use nalgebra::DVector;
use stiffmap::interrupt::Interrupt;
use stiffmap::linalg::symmetric_eigen_fast;
use stiffmap::response::moving::{PathModel, PathOptions, Travel, TravelOptions, travel};
use stiffmap::response::{Forces, History, Path, Plant, Recording, parse_force, simulate};
use stiffmap::state_space::ModeStep;

fn path_model(path: &Path, options: PathOptions) -> PathModel {
    let damping = &mill().machine.analysis.damping;
    PathModel::new(&mill().model, damping, path, options, &Interrupt::default(), &|| ()).unwrap()
}

/// 200 Hz, 100 N in x, at a rate.
fn sine(duration: f64, rate: f64) -> Forces {
    let mut forces = Forces::none(&names(), duration, rate).unwrap();
    forces.add(0, &parse_force("sine,amplitude=100,frequency=200").unwrap());
    forces
}

/// 250 Hz, 100 N in x, straight between corners that are samples at every rate.
fn triangles(duration: f64, rate: f64) -> Forces {
    let mut forces = Forces::none(&names(), duration, rate).unwrap();
    for k in 0..forces.samples() {
        let phase = (forces.time(k) / 0.004).fract();
        forces.values[3 * k] = 100.0 * (1.0 - 4.0 * ((phase + 0.25).fract() - 0.5).abs());
    }
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
    let path = Path::constant_speed(-0.27, -0.3, 0.5).unwrap();
    let model = path_model(&path, PathOptions::default());
    println!("{} coordinates, {} stations", model.n(), model.stations());
    let rates = [10e3, 20e3, 40e3, 80e3];
    let runs: Vec<Travel> = rates.iter().map(|rate| run(&model, &path, &triangles(0.06, *rate))).collect();
    let errors: Vec<f64> = (0..3)
        .map(|k| {
            let fine = thinned(&runs[3], 8);
            let own = thinned(&runs[k], 1 << k);
            apart(&own[..fine.len().min(own.len())], &fine[..fine.len().min(own.len())])
        })
        .collect();
    let slopes: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("difference to 80 kHz at 10, 20, 40 kHz: {errors:?}, slopes {slopes:.2?}");
    assert!(slopes.iter().all(|s| *s > 1.7), "{slopes:?}");
    assert!(errors[1] < 1e-4, "at 20 kHz {:.1e}", errors[1]);
    let closure: Vec<f64> = runs.iter().map(|r| r.energy.closure()).collect();
    println!("energy closed to {closure:?}");
    assert!(closure.iter().all(|c| *c < 1e-10), "{closure:?}");
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
    less.dissipated.iter_mut().for_each(|w| *w *= 1.0 - 1e-8);
    assert!(less.closure() > 1e-9, "control: a loss of 1e-8 of the dissipation shows");
}

/// A sine and a pulse, and the recorded rates.
fn rest(model: &PathModel, at: f64) -> (Forces, History) {
    let path = Path::through(vec![(0.0, at)]).unwrap();
    let mut forces = sine(0.05, 20e3);
    forces.add(2, &parse_force("impulse").unwrap());
    let options = TravelOptions { recording: ALL, ..TravelOptions::default() };
    let moving = travel(model, &path, &forces, options, &Interrupt::default(), &|| ()).unwrap();
    (forces, moving.history)
}

const ALL: Recording = Recording { velocity: true, acceleration: true };

#[test]
fn a_path_that_rests_is_the_fixed_position() {
    let position = -0.2025;
    let model = path_model(&Path::through(vec![(0.0, position)]).unwrap(), PathOptions::default());
    let (forces, moving) = rest(&model, position);
    let fixed = simulate(&Plant::whole(&modes(position)), &forces, ALL);
    let rows = |h: &History| [h.displacement.clone(), h.velocity.clone().unwrap(), h.acceleration.clone().unwrap()];
    for (a, b) in rows(&moving).iter().zip(&rows(&fixed)) {
        let found = apart(a, b);
        println!("at rest: {found:.1e}");
        assert!(found < 1e-10, "{found:.1e}");
    }
    let beside = simulate(&Plant::whole(&modes(position + 5e-4)), &forces, ALL);
    let control = apart(&moving.displacement, &beside.displacement);
    assert!(control > 5e-6, "control: 0.5 mm away, {control:.1e}");
}

#[test]
fn half_way_between_stations_the_machine_is_that_of_the_fixed_position() {
    let wide = Path::constant_speed(-0.3, -0.28, 0.5).unwrap();
    let model = path_model(&wide, PathOptions::default());
    // Stations at -0.300, -0.295 ..; the furthest tabulated position from two, and one between tabulated ones.
    for position in [-0.2924, -0.2876] {
        let (forces, moving) = rest(&model, position);
        let fixed = simulate(&Plant::whole(&modes(position)), &forces, ALL);
        let found = apart(&moving.displacement, &fixed.displacement);
        println!("at {position} m: {found:.1e} of the peak");
        assert!(found < 3e-4, "{found:.1e}");
        let other = simulate(&Plant::whole(&modes(position - 0.0026)), &forces, ALL);
        let control = apart(&other.displacement, &fixed.displacement);
        assert!(control > 3.0 * found, "control: the station's own response is {control:.1e} away");
    }
    let damping = &mill().machine.analysis.damping;
    let found = model.difference(&mill().model, damping, 900.0, 4).unwrap();
    println!("eigenvalues between tabulated positions: {found:.1e}");
    assert!(found < 1e-7, "{found:.1e}");
    let sparse = path_model(&wide, PathOptions { stations: 0.01, spacing: 0.005 });
    let control = sparse.difference(&mill().model, damping, 900.0, 4).unwrap();
    assert!(control > 10.0 * found, "control: five times as far apart, {control:.1e}");
}

/// z'' + C z' + K(p) z = f by the exact flow of the whole machine's own modes at the middle of every small step, and
/// kinetic energy, potential energy and the work of the force at its end.
fn fine_steps(model: &PathModel, path: &Path, force: impl Fn(f64) -> f64, time: f64, steps: usize) -> [f64; 3] {
    let (n, h, zeta) = (model.n(), time / steps as f64, 0.02);
    let (mut z, mut v, mut work) = (DVector::zeros(n), DVector::zeros(n), 0.0);
    for s in 0..steps {
        let middle = path.at((s as f64 + 0.5) * h);
        let own = symmetric_eigen_fast(&model.stiffness(middle)).unwrap();
        let input = own.vectors.tr_mul(&model.at(middle).inputs.row(0).transpose());
        let (q, rate) = (own.vectors.tr_mul(&z), own.vectors.tr_mul(&v));
        let f = [force(s as f64 * h), force((s + 1) as f64 * h)];
        let (mut next, mut next_rate) = (DVector::zeros(n), DVector::zeros(n));
        for r in 0..n {
            let step = ModeStep::new(own.values[r].max(0.0).sqrt(), zeta, h);
            [next[r], next_rate[r]] = step.advance([q[r], rate[r]], f.map(|f| f * input[r]));
        }
        work += 0.5 * (f[0] + f[1]) * input.dot(&(&next - &q));
        (z, v) = (&own.vectors * next, &own.vectors * next_rate);
    }
    let k = model.stiffness(path.at(time));
    [0.5 * v.norm_squared(), 0.5 * z.dot(&(&k * &z)), work]
}

#[test]
fn each_energy_is_that_of_fine_steps_with_the_whole_machines_modes() {
    // A fast carriage, so that the guide's work is a good share, over a few stations.
    let path = Path::constant_speed(-0.2, -0.27, 20.0).unwrap();
    let model = path_model(&path, PathOptions { stations: 0.002, ..PathOptions::default() });
    let time = 0.0035;
    let found = run(&model, &path, &sine(time + 0.5 / 100e3, 100e3)).energy;
    let force = |t: f64| 100.0 * (std::f64::consts::TAU * 200.0 * t).sin();
    let steps = found.kinetic.len() - 1;
    let expected = fine_steps(&model, &path, force, steps as f64 / 100e3, 120);
    let of = |e: &[f64]| *e.last().unwrap();
    let own = [of(&found.kinetic), of(&found.potential), of(&found.force)];
    println!("stepping {own:?}\nfine     {expected:?}");
    for (a, b) in own.iter().zip(expected) {
        assert!((a - b).abs() < 5e-4 * b.abs(), "{a:e} {b:e}");
    }
    let travel = of(&found.travel).abs() / of(&found.force);
    assert!(travel > 1e-4, "control: the guide's work is no rounding, {travel:.1e}");
    let slow = Path::through(vec![(0.0, -0.2)]).unwrap();
    let other = run(&model, &slow, &sine(time + 0.5 / 100e3, 100e3)).energy;
    let control = (of(&other.potential) / expected[1] - 1.0).abs();
    assert!(control > 1e-3, "control: at rest the potential energy is another, {control:.1e}");
}

#[test]
fn a_path_outside_the_travel_is_refused_and_stopping_is_obeyed() {
    let damping = &mill().machine.analysis.damping;
    let options = PathOptions::default();
    let outside = Path::constant_speed(-0.7, -0.5, 1.0).unwrap();
    let error = PathModel::new(&mill().model, damping, &outside, options, &Interrupt::default(), &|| ()).unwrap_err();
    assert!(error.is_input() && error.to_string().contains("outside the travel"), "{error}");
    let asked = Interrupt::default();
    asked.request();
    let path = Path::constant_speed(-0.3, -0.29, 1.0).unwrap();
    assert!(PathModel::new(&mill().model, damping, &path, options, &asked, &|| ()).is_err());
    let points = Path::through(vec![(0.0, -0.1), (1.0, -0.2), (1.0, -0.3)]).unwrap_err().to_string();
    assert!(points.contains("1 s after 1 s"), "{points}");
}
