//! Friction and backlash against closed forms of a single mass.

use nalgebra::DMatrix;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::Friction;
use stiffmap::response::contact::{ContactHistory, Element, EventKind, Law, simulate_contact};
use stiffmap::response::{Forces, Plant, Recording, ResponseError, Shape};

/// A mass on a spring, kg and N/m; the mass-normalised shape is 1 / sqrt(m).
struct Mass {
    m: f64,
    k: f64,
}

impl Mass {
    fn plant(&self) -> Plant {
        let shape = DMatrix::from_element(1, 1, self.m.sqrt().recip());
        Plant {
            position: 0.0,
            omega: vec![(self.k / self.m).sqrt()],
            zeta: vec![0.0],
            dampers: DMatrix::zeros(0, 1),
            outputs: shape.clone(),
            inputs: shape,
            direct: DMatrix::zeros(1, 1),
        }
    }

    fn element(&self, law: Law) -> Element {
        Element {
            joint: "guide".into(),
            law,
            row: vec![self.m.sqrt().recip()],
            flexibility: 0.0,
            towards: vec![],
            outputs: vec![],
            inputs: vec![],
        }
    }

    /// From a place and a speed.
    fn run(&self, law: Law, forces: &Forces, place: f64, speed: f64) -> ContactHistory {
        self.try_run(law, forces, place, speed).unwrap()
    }

    fn try_run(&self, law: Law, forces: &Forces, place: f64, speed: f64) -> Result<ContactHistory, ResponseError> {
        let root = self.m.sqrt();
        let recording = Recording { velocity: true, acceleration: false };
        let state: [&[f64]; 2] = [&[place * root], &[speed * root]];
        let elements = [self.element(law)];
        simulate_contact(&self.plant(), &elements, forces, recording, Some(state), &Interrupt::default())
    }
}

fn nothing(duration: f64, rate: f64) -> Forces {
    Forces::none(&["x".to_owned()], duration, rate).unwrap()
}

fn coulomb(force: f64) -> Law {
    Law::Friction(Friction { coulomb: force, breakaway: force, stribeck: f64::INFINITY })
}

#[test]
fn a_sliding_mass_stops_when_and_where_coulomb_says() {
    // t = m v / F, x = m v^2 / (2 F), at a rate that has no sample there.
    let mass = Mass { m: 3.0, k: 0.0 };
    let (v, f) = (0.37, 11.0);
    let run = mass.run(coulomb(f), &nothing(0.2, 1000.0), 0.0, v);
    let stops: Vec<_> = run.events.iter().filter(|e| e.kind == EventKind::Stops).collect();
    assert_eq!(stops.len(), 1);
    let (time, place) = (mass.m * v / f, mass.m * v * v / (2.0 * f));
    println!("stop at {} s ({time} s), {} m", stops[0].time, run.history.displacement[199]);
    assert!((stops[0].time - time).abs() < 1e-12, "{} {time}", stops[0].time);
    let after = &run.history.displacement[(time * 1000.0).ceil() as usize..];
    assert!(after.iter().all(|x| (x - place).abs() < 1e-13), "it stays where it stopped");
    assert!(run.history.velocity.as_ref().unwrap().last().unwrap().abs() < 1e-13);
    let less = mass.run(coulomb(f * 0.999), &nothing(0.2, 1000.0), 0.0, v);
    assert!((less.history.displacement[199] - place).abs() > 1e-6, "control: a thousandth less force shows");
}

#[test]
fn a_sprung_mass_loses_four_times_f_over_k_a_cycle_and_then_sticks() {
    // Turning points x_n = (-1)^n (x_0 - 2 n F/k), half a period apart, until |x| <= F/k.
    let mass = Mass { m: 2.0, k: 8e4 };
    let (f, x0) = (40.0, 5.3e-3);
    let run = mass.run(coulomb(f), &nothing(0.12, 20e3), x0, 0.0);
    let half = std::f64::consts::PI * (mass.m / mass.k).sqrt();
    let stops: Vec<_> = run.events.iter().filter(|e| e.kind == EventKind::Stops).collect();
    assert_eq!(stops.len(), 5);
    for (n, stop) in stops.iter().enumerate() {
        assert!((stop.time - half * (n + 1) as f64).abs() < 1e-9, "turn {n}: {} s", stop.time);
    }
    let last = -(x0 - 10.0 * f / mass.k);
    let found = *run.history.displacement.last().unwrap();
    println!("sticks at {found:e} m, {last:e} m");
    assert!((found - last).abs() < 1e-9 * x0, "{found} {last}");
    assert!(last.abs() < f / mass.k);
    let held = *run.tension.last().unwrap();
    assert!((held + mass.k * found).abs() < 1e-6, "sticking friction carries the spring: {held} N");
    let control = mass.run(coulomb(f * 1.001), &nothing(0.12, 20e3), x0, 0.0);
    assert!((control.history.displacement.last().unwrap() - last).abs() > 1e-6 * x0, "control");
}

#[test]
fn a_stuck_mass_does_not_creep_and_breaks_away_at_its_limit() {
    let mass = Mass { m: 1.0, k: 0.0 };
    let friction = Friction { coulomb: 6.0, breakaway: 10.0, stribeck: 0.01 };
    let mut ramp = nothing(1.0, 2000.0);
    let n = ramp.samples();
    (0..n).for_each(|k| ramp.values[k] = 20.0 * k as f64 / n as f64);
    let run = mass.run(Law::Friction(friction), &ramp, 0.0, 0.0);
    let slides = run.events.iter().find(|e| e.kind == EventKind::Slides).unwrap();
    assert!((slides.time - 0.5).abs() <= 1.1 / 2000.0, "{}", slides.time);
    // Between samples the friction is constant and the force is not: the joint yields by F h^2 / (12 m), and no more.
    let yields = |k: usize| -ramp.values[k] * (1.0 / 2000.0_f64).powi(2) / 12.0;
    assert!((0..999).all(|k| (run.history.displacement[k] - yields(k)).abs() < 1e-12), "no creep");
    let held: Vec<f64> = run.tension[1..900].to_vec();
    assert!(held.iter().enumerate().all(|(k, l)| (l - 0.5 * (ramp.values[k] + ramp.values[k + 1])).abs() < 1e-9));
    assert!(run.history.displacement[n - 1] > 0.1);
    let mut less = ramp.clone();
    less.values.iter_mut().for_each(|f| *f *= 0.499);
    let control = mass.run(Law::Friction(friction), &less, 0.0, 0.0);
    assert!(control.events.is_empty(), "control: half of it never breaks away");
}

#[test]
fn stribeck_friction_slows_a_mass_as_its_integral_says() {
    // Time to slow from v0 to v1 is the integral of m dv / F(v), by Simpson's rule.
    let mass = Mass { m: 2.0, k: 0.0 };
    let friction = Friction { coulomb: 5.0, breakaway: 12.0, stribeck: 0.05 };
    let v0 = 0.3;
    let time = |v1: f64| {
        let n = 2000;
        let h = (v0 - v1) / f64::from(n);
        let g = |k: i32| mass.m / friction.at(v1 + h * f64::from(k));
        let weight = |k: i32| {
            if k == 0 || k == n {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=n).map(|k| weight(k) * g(k)).sum::<f64>() * h / 3.0
    };
    let error = |rate: f64| {
        let run = mass.run(Law::Friction(friction), &nothing(0.12, rate), 0.0, v0);
        let stop = run.events.iter().find(|e| e.kind == EventKind::Stops).unwrap().time;
        (stop - time(0.0)).abs() / time(0.0)
    };
    let errors = [error(2e3), error(8e3)];
    println!("stop time: {errors:?}");
    assert!(errors[1] < 1e-5 && errors[0] < 3e-4, "{errors:?}");
    assert!((time(0.0) - mass.m * v0 / 5.0).abs() > 1e-3, "control: Coulomb alone would stop at another time");
}

/// Free vibration of a mass on a spring with play: the speed through the play is constant, each contact half a period.
fn period(mass: &Mass, gap: f64, amplitude: f64) -> f64 {
    let omega = (mass.k / mass.m).sqrt();
    let deflection = amplitude - gap / 2.0;
    2.0 * std::f64::consts::PI / omega + 2.0 * gap / (deflection * omega)
}

#[test]
fn a_mass_with_backlash_has_the_piecewise_linear_period() {
    let mass = Mass { m: 1.5, k: 6e5 };
    let (gap, amplitude) = (2e-4, 5e-4);
    let expected = period(&mass, gap, amplitude);
    let law = Law::Backlash { gap, stiffness: mass.k };
    let error = |rate: f64| {
        let run = mass.run(law, &nothing(10.5 * expected, rate), amplitude, 0.0);
        // Upward crossings of zero, straight between samples: inside the play they are exact.
        let x = &run.history.displacement;
        let times: Vec<f64> = (1..x.len())
            .filter(|&k| x[k - 1] < 0.0 && x[k] >= 0.0)
            .map(|k| (k as f64 - x[k] / (x[k] - x[k - 1])) / rate)
            .collect();
        assert_eq!(times.len(), 10);
        let peak = x[x.len() / 2..].iter().fold(0.0f64, |m, v| m.max(*v));
        assert!((peak / amplitude - 1.0).abs() < 2e-3, "the amplitude stays, {peak}");
        ((times[9] - times[0]) / 9.0 / expected - 1.0).abs()
    };
    let errors = [error(5e3), error(20e3), error(80e3)];
    println!("period: {errors:?}");
    assert!(errors[2] < 2e-6, "{errors:?}");
    assert!(errors[0] > 30.0 * errors[2], "it falls with the step: {errors:?}");
    let control = (period(&mass, 1.01 * gap, amplitude) / expected - 1.0).abs();
    assert!(control > 1e-3, "control: a hundredth more play shows, {control:.1e}");
}

#[test]
fn no_play_and_no_friction_are_the_linear_machine() {
    let mass = Mass { m: 1.5, k: 6e5 };
    let mut forces = nothing(0.1, 20e3);
    forces.add(0, &Shape::Sine { amplitude: 3.0, frequency: 70.0, phase: 0.0 });
    let linear = stiffmap::response::simulate(&mass.plant(), &forces, Recording::default());
    for law in [coulomb(0.0), Law::Backlash { gap: 0.0, stiffness: mass.k }] {
        let found = mass.run(law, &forces, 0.0, 0.0);
        let apart = super::apart(&found.history.displacement, &linear.displacement);
        assert!(apart < 1e-11, "{law:?}: {apart:.1e}");
    }
    let some = mass.run(Law::Backlash { gap: 1e-7, stiffness: mass.k }, &forces, 0.0, 0.0);
    assert!(super::apart(&some.history.displacement, &linear.displacement) > 1e-3, "control");
}

#[test]
fn two_joints_that_share_a_mass_hold_together() {
    let mass = Mass { m: 1.0, k: 0.0 };
    let elements = [mass.element(coulomb(4.0)), mass.element(coulomb(7.0))];
    let state: [&[f64]; 2] = [&[0.0], &[0.5]];
    let run = |elements: &[Element]| {
        let forces = nothing(0.2, 1000.0);
        simulate_contact(&mass.plant(), elements, &forces, Recording::default(), Some(state), &Interrupt::default())
    };
    let both = run(&elements).unwrap();
    let (place, stop) = (0.25 / 22.0, 0.5 / 11.0);
    assert!((both.history.displacement[199] - place).abs() < 1e-12, "{}", both.history.displacement[199]);
    assert!(both.events.iter().all(|e| (e.time - stop).abs() < 1e-9), "{:?}", both.events);
    let one = run(&elements[..1]).unwrap();
    assert!((one.history.displacement[199] - 0.25 / 8.0).abs() < 1e-12, "control: one of them alone");
    // Pushed with 9 N, of which neither holds more than its own, both hold.
    let mut push = nothing(0.1, 1000.0);
    push.values.iter_mut().for_each(|f| *f = 9.0);
    let still = simulate_contact(&mass.plant(), &elements, &push, Recording::default(), None, &Interrupt::default());
    let still = still.unwrap();
    assert!(still.history.displacement[99].abs() < 1e-9, "{}", still.history.displacement[99]);
    let shares = &still.tension[still.tension.len() - 2..];
    assert!((shares[0] + shares[1] - 9.0).abs() < 1e-9 && shares[0] <= 4.0 + 1e-9 && shares[1] <= 7.0, "{shares:?}");
    push.values.iter_mut().for_each(|f| *f = 12.0);
    let slides = simulate_contact(&mass.plant(), &elements, &push, Recording::default(), None, &Interrupt::default());
    assert!(slides.unwrap().history.displacement[99] > 1e-3, "control: 12 N are more than both hold");
}

/// Four modes, two of them too fast for most rates, two joints, a flexibility that no mode carries, and two outputs.
struct Elastic {
    plant: Plant,
    elements: Vec<Element>,
}

impl Elastic {
    fn new(laws: [Law; 2]) -> Self {
        let outputs = DMatrix::from_row_slice(2, 4, &[1.0, 0.5, -0.8, 0.3, 0.4, -0.9, 0.7, 1.1]);
        let inputs = outputs.rows(0, 1).into_owned();
        let plant = Plant {
            position: 0.0,
            omega: vec![300.0, 900.0, 3e4, 1.5e5],
            zeta: vec![0.05; 4],
            dampers: DMatrix::zeros(0, 4),
            outputs,
            inputs,
            direct: DMatrix::from_column_slice(2, 1, &[2e-10, 1e-10]),
        };
        let rows = [[0.9, -0.4, 0.6, 1.2], [0.2, 1.0, 0.9, -0.7]];
        let element = |k: usize| Element {
            joint: format!("guide {k}"),
            law: laws[k],
            row: rows[k].to_vec(),
            flexibility: 4e-10,
            towards: if k == 0 { vec![4e-10, 1e-10] } else { vec![1e-10, 4e-10] },
            outputs: vec![1.5e-10, 0.5e-10],
            inputs: vec![1.5e-10],
        };
        Self { plant, elements: vec![element(0), element(1)] }
    }

    fn still(&self, a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64) -> f64 {
        (0..4).map(|r| a(r) * b(r) / self.plant.omega[r].powi(2)).sum()
    }

    /// Displacements of the outputs under a constant force with both joints held, by eliminating them.
    fn held(&self, force: f64) -> Vec<f64> {
        let e = |k: usize| move |r: usize| self.elements[k].row[r];
        let between = DMatrix::from_fn(2, 2, |a, b| self.still(&e(a), &e(b)) + self.elements[a].towards[b]);
        let input = |r: usize| self.plant.inputs[(0, r)];
        let free = DMatrix::from_fn(2, 1, |a, _| force * (self.still(&e(a), &input) + self.elements[a].inputs[0]));
        let lambda = between.lu().solve(&free).unwrap();
        let output = |i: usize| {
            let own = |r: usize| self.plant.outputs[(i, r)];
            let joints: f64 =
                (0..2).map(|k| (self.still(&own, &e(k)) + self.elements[k].outputs[i]) * lambda[(k, 0)]).sum();
            force * (self.still(&own, &input) + self.plant.direct[(i, 0)]) - joints
        };
        vec![output(0), output(1)]
    }

    fn last(&self, force: f64, rate: f64) -> (Vec<f64>, ContactHistory) {
        let mut ramp = nothing(2.0, rate);
        let n = ramp.samples();
        (0..n).for_each(|k| ramp.values[k] = force * (k as f64 / (0.25 * n as f64)).min(1.0));
        let run =
            simulate_contact(&self.plant, &self.elements, &ramp, Recording::default(), None, &Interrupt::default())
                .unwrap();
        (run.history.displacement[2 * (n - 1)..].to_vec(), run)
    }
}

#[test]
fn joints_that_hold_answer_statically_at_every_rate() {
    let machine = Elastic::new([coulomb(1e9), coulomb(1e9)]);
    let expected = machine.held(1000.0);
    for rate in [1000.0, 2000.0, 20_000.0] {
        let (found, run) = machine.last(1000.0, rate);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-3, "at {rate} Hz: {found:e} {expected:e}");
        }
        let slip = run.relative[run.relative.len() - 2..].iter().fold(0.0f64, |m, e| m.max(e.abs()));
        assert!(slip < 1e-3 * expected[0].abs(), "at {rate} Hz: slip {slip:e}");
    }
    // Joints that slide at once give the free machine, which is something else.
    let (free, _) = Elastic::new([coulomb(1e-6), coulomb(1e-6)]).last(1000.0, 20_000.0);
    assert!((free[0] / expected[0] - 1.0).abs() > 0.1, "{free:?} {expected:?}");
}

#[test]
fn what_stands_beside_a_play_moves_as_statics_say() {
    // Play of 4 um behind springs of the machine: the outputs differ by what the joint's tension moves them.
    let stiffness = 2e7;
    let gap = 4e-6;
    let machine = Elastic::new([Law::Backlash { gap, stiffness }, coulomb(1e-6)]);
    let without = Elastic::new([Law::Backlash { gap: 0.0, stiffness }, coulomb(1e-6)]);
    for rate in [4000.0, 20_000.0] {
        let ((with, run), (plain, _)) = (machine.last(1000.0, rate), without.last(1000.0, rate));
        let lambda = run.tension[run.tension.len() - 2];
        assert!((lambda.abs() / (stiffness * gap / 2.0) - 1.0).abs() < 1e-9, "the play is taken up: {lambda}");
        for i in 0..2 {
            let own = |r: usize| machine.plant.outputs[(i, r)];
            let joint = |r: usize| machine.elements[0].row[r];
            let expected = -lambda * (machine.still(&own, &joint) + machine.elements[0].outputs[i]);
            let found = with[i] - plain[i];
            assert!((found / expected - 1.0).abs() < 1e-2, "output {i} at {rate} Hz: {found:e} {expected:e}");
        }
    }
}

#[test]
fn slip_speed_and_force_of_a_joint_are_recorded_as_they_are() {
    let mass = Mass { m: 2.0, k: 5e4 };
    let mut forces = nothing(0.2, 20e3);
    forces.add(0, &Shape::Sine { amplitude: 40.0, frequency: 20.0, phase: 0.0 });
    // A slider: its force is Coulomb's against its speed, and its speed is the slip's rate.
    let run = mass.run(coulomb(9.0), &forces, 0.0, 0.0);
    let h = forces.step;
    let peak = run.speed.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let apart = |factor: f64| {
        let pairs = run.relative.windows(2).zip(run.speed.windows(2));
        pairs.map(|(e, v)| ((e[1] - e[0]) / h - 0.5 * factor * (v[0] + v[1])).abs()).fold(0.0, f64::max) / peak
    };
    assert!(peak > 1e-2 && apart(1.0) < 2e-2 && apart(1.1) > 5e-2, "{peak:.1e} m/s, {:.1e}", apart(1.0));
    for k in 1..forces.samples() {
        assert!(run.force[k].abs() <= 9.0 * (1.0 + 1e-9), "{k}");
        if run.speed[k].abs() > 0.1 * peak {
            assert!((run.force[k] - 9.0 * run.speed[k].signum()).abs() < 1e-9, "{k}: {} N", run.force[k]);
        }
    }
    // A screw with play: its spring's force beyond the play, nothing inside.
    let (gap, stiffness) = (20e-6, 4e4);
    let run = mass.run(Law::Backlash { gap, stiffness }, &forces, 0.0, 0.0);
    let inside = run.relative.iter().filter(|e| e.abs() < gap / 2.0).count();
    assert!(inside > 10 && inside < forces.samples() - 10);
    for (e, f) in run.relative.iter().zip(&run.force) {
        let expected = if e.abs() < gap / 2.0 { 0.0 } else { stiffness * (e.abs() - gap / 2.0) * e.signum() };
        assert!((f - expected).abs() < 1e-9 * stiffness * gap, "{e} m: {f} N of {expected}");
    }
}
