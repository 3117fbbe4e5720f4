//! Forces between samples: momentum, moments and motions against closed forms.

use super::names;
use nalgebra::DMatrix;
use std::f64::consts::{PI, TAU};
use stiffmap::response::{ForceFile, Forces, Plant, Recording, Shape, mirrored_share, parse_force, simulate};

const RATE: f64 = 20e3;

fn one(duration: f64) -> Forces {
    Forces::none(&["x".to_owned()], duration, RATE).unwrap()
}

fn file(folder: &std::path::Path, text: &str) -> ForceFile {
    let path = folder.join("force.csv");
    std::fs::write(&path, text).unwrap();
    ForceFile::read(&path).unwrap()
}

/// int u dt and int t u dt / int u dt of straight lines between samples.
fn momentum(forces: &Forces) -> (f64, f64) {
    let (u, h) = (forces.input(0), forces.step);
    let mut sums = (0.0, 0.0);
    for k in 0..u.len() - 1 {
        // Simpson's rule, which is exact for t u.
        let (a, b, t) = (u[k], u[k + 1], forces.time(k));
        sums.0 += 0.5 * h * (a + b);
        sums.1 += h / 6.0 * (t * a + 4.0 * (t + 0.5 * h) * 0.5 * (a + b) + (t + h) * b);
    }
    (sums.0, sums.1 / sums.0)
}

/// 1 kg on a spring of (2 pi f)^2 N/m with a little damping.
struct Oscillator {
    omega: f64,
    zeta: f64,
}

impl Oscillator {
    fn new(frequency: f64, zeta: f64) -> Self {
        Self { omega: TAU * frequency, zeta }
    }

    fn motion(&self, forces: &Forces) -> Vec<f64> {
        let shape = DMatrix::from_element(1, 1, 1.0);
        let plant = Plant {
            position: 0.0,
            omega: vec![self.omega],
            zeta: vec![self.zeta],
            dampers: DMatrix::zeros(0, 1),
            outputs: shape.clone(),
            inputs: shape,
            direct: DMatrix::zeros(1, 1),
        };
        simulate(&plant, forces, Recording::default()).displacement
    }

    /// After a blow of no length.
    fn struck(&self, momentum: f64, since: f64) -> f64 {
        let damped = self.omega * (1.0 - self.zeta * self.zeta).sqrt();
        momentum / damped * (-self.zeta * self.omega * since).exp() * (damped * since).sin()
    }
}

#[test]
fn a_blow_shorter_than_a_sample_moves_a_mass_by_its_momentum() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = "time_s,x\n0,0\n0.010010,0\n0.010020,1000\n0.010030,0\n";
    let blow = |text: &str| {
        let mut forces = one(0.1);
        forces.add(0, &parse_force(text).unwrap());
        forces
    };
    let mut from_file = one(0.1);
    let told = file(folder.path(), triangle).add_to(&mut from_file).unwrap();
    assert!(told.len() == 1 && told[0].contains("its momentum is kept, its form is not"), "{told:?}");
    let cases = [
        (from_file, 0.01, 0.01002),
        (blow("impulse,shape=rectangle,length=1e-6,amplitude=1000,start=0.01002"), 1e-3, 0.0100205),
        (blow("impulse,shape=rectangle,length=1e-6,amplitude=1000,start=0.01"), 1e-3, 0.0100005),
        (blow("impulse,length=60e-6,amplitude=1000,start=0.01"), 0.12 / PI, 0.01003),
        (blow("impulse,length=60e-6,amplitude=-7,start=0.010037"), -0.00084 / PI, 0.010067),
        (blow("impulse,shape=triangle,length=90e-6,amplitude=1000,start=0.010037"), 0.045, 0.010082),
    ];
    let mass = Oscillator::new(120.0, 0.02);
    for (i, (forces, expected, middle)) in cases.iter().enumerate() {
        let (found, at) = momentum(forces);
        assert!((found / expected - 1.0).abs() < 1e-9, "{i}: {found} N s of {expected}");
        assert!((at - middle).abs() < 1e-10, "{i}: at {at} s, not {middle}");
        let motion = mass.motion(forces);
        let off = |momentum: f64, delay: f64| {
            let exact = |k: usize| mass.struck(momentum, forces.time(k) - middle - delay);
            (210..2000).map(|k| (motion[k] - exact(k)).abs()).fold(0.0, f64::max) / (expected.abs() / mass.omega)
        };
        // The blow's own length counts to (omega L)^2 / 24 of a rectangle, less of the others: 1e-4 for the longest.
        println!("{i}: momentum {:.1e}, motion {:.1e}", found / expected - 1.0, off(*expected, 0.0));
        assert!(off(*expected, 0.0) < 1e-4, "{i}: {:.1e}", off(*expected, 0.0));
        assert!(off(1.002 * expected, 0.0) > 1e-3, "control: two thousandths more momentum");
        assert!(off(*expected, 5e-6) > 1e-3, "control: a tenth of a sample later");
    }
}

#[test]
fn momentum_and_its_middle_are_kept_wherever_a_pulse_begins() {
    for (shape, area) in [("half-sine", 2.0 / PI), ("rectangle", 1.0), ("triangle", 0.5)] {
        for samples in [0.3, 1.0, 1.7, 2.6, 4.5, 8.0, 13.7, 20.0] {
            for offset in [0.0, 0.13, 0.5, 0.81] {
                let (length, start) = (samples / RATE, (100.0 + offset) / RATE);
                let mut forces = one(0.02);
                let text = format!("impulse,shape={shape},amplitude=3,length={length:e},start={start:e}");
                forces.add(0, &parse_force(&text).unwrap());
                let (found, at) = momentum(&forces);
                assert!((found / (3.0 * area * length) - 1.0).abs() < 1e-9, "{text}: {found}");
                let late = (at - start - 0.5 * length) * RATE;
                assert!(late.abs() < 0.02, "{text}: {late} samples");
                let u = forces.input(0);
                let least = u.iter().copied().fold(0.0, f64::min);
                assert!(
                    samples < 8.0 || least > -0.03 * 3.0,
                    "{text}: a resolved pulse hardly turns its sign, {least}"
                );
                let before = u[..97].iter().chain(&u[104 + samples as usize..]).any(|f| f.abs() > 1e-12);
                assert!(!before, "{text}: nothing far from the pulse");
            }
        }
    }
}

#[test]
fn a_step_begins_when_it_says_and_does_not_overshoot() {
    let mass = Oscillator::new(150.0, 0.0);
    for start in [0.01, 0.010013, 0.010037] {
        let mut forces = one(0.1);
        forces.add(0, &Shape::Step { amplitude: 5.0, start });
        let u = forces.input(0);
        assert!(u.windows(2).all(|w| w[0] <= w[1]) && u[199] == 0.0 && (u[202] - 5.0).abs() < 1e-12, "{start}");
        let motion = mass.motion(&forces);
        let exact = |k: usize, late: f64| 1.0 - (mass.omega * (forces.time(k) - start - late)).cos();
        let off = |late: f64| {
            let scale = 5.0 / mass.omega.powi(2);
            (202..2000).map(|k| (motion[k] / scale - exact(k, late)).abs()).fold(0.0, f64::max)
        };
        println!("step at {start} s: {:.1e}", off(0.0));
        // Means lose x^2 / 6 of the wave, x = 0.047: 3.7e-4.
        assert!(off(0.0) < 5e-4, "{start}: {:.1e}", off(0.0));
        assert!(off(0.5 / RATE) > 1e-2, "control: half a sample late, as plain samples are");
    }
}

#[test]
fn waves_have_the_amplitude_that_was_asked_for() {
    // Steady state of an oscillator below its resonance, by its receptance.
    let mass = Oscillator::new(1500.0, 0.3);
    for (frequency, mirrored) in [(200.0, 1.1e-4), (700.0, 1.4e-3)] {
        let mut forces = one(0.1);
        forces.add(0, &Shape::Sine { amplitude: 2.0, frequency, phase: 30.0 });
        let motion = mass.motion(&forces);
        // Amplitude at the frequency over whole periods at the end.
        let share = |x: &[f64]| {
            let sums = (1000..2000).map(|k| {
                let (s, c) = (TAU * frequency * forces.time(k)).sin_cos();
                (x[k] * c, x[k] * s)
            });
            let (a, b) = sums.fold((0.0, 0.0), |t, v| (t.0 + v.0, t.1 + v.1));
            a.hypot(b) / 500.0
        };
        let r = frequency / 1500.0;
        let exact = 2.0 / mass.omega.powi(2) / (1.0 - r * r).hypot(2.0 * 0.3 * r);
        let off = (share(&motion) / exact - 1.0).abs();
        let half = PI * frequency / RATE;
        let lost = 1.0 - (half.sin() / half).powi(2);
        println!("{frequency} Hz: {off:.1e}");
        // The second wave at rate - f is seen at f in the samples; the oscillator hardly follows it.
        assert!(off < 0.02 * mirrored, "{frequency} Hz: {off:.1e}");
        assert!(lost > 50.0 * off, "control: straight lines through the wave itself lose {lost:.1e}");
        assert!((0.9..1.0).contains(&(mirrored_share(frequency, RATE) / mirrored)), "what lies at rate - f");
    }
}

#[test]
fn a_file_with_many_lines_a_sample_is_as_good_as_its_waves() {
    let folder = tempfile::tempdir().unwrap();
    let wave = |t: f64| 10.0 * (TAU * 310.0 * t + 0.4).sin();
    let rows: String =
        (0..=7031).map(|k| format!("{:e},{:e}\n", f64::from(k) / 70310.0, wave(f64::from(k) / 70310.0))).collect();
    let mut forces = one(0.09);
    let told = file(folder.path(), &format!("time_s,x\n{rows}")).add_to(&mut forces).unwrap();
    // The file is longer than the history: that alone is told.
    assert!(told.len() == 1 && told[0].contains("goes on to 0.1 s"), "{told:?}");
    let half = PI * 310.0 / RATE;
    let kept = (half.sin() / half).powi(2);
    let (lines, u) = (70310.0, forces.input(0));
    // The file's own straight lines lose as much at their rate.
    let of_file = (PI * 310.0 / lines).powi(2) / 3.0;
    let off =
        (10..1790).map(|k| (u[k] * kept - (1.0 - of_file) * wave(forces.time(k))).abs()).fold(0.0, f64::max) / 10.0;
    assert!(off < 3e-5, "{off:.1e}");
    let plain = 1.0 - kept;
    assert!(plain > 3e-4 && off < 0.1 * plain, "control: plain samples lose {plain:.1e}");
}

#[test]
fn random_forces_differ_from_input_to_input_and_stay_what_their_seed_says() {
    let run = |text: &str, earlier: u64| -> Vec<Vec<f64>> {
        let shape = parse_force(text).unwrap();
        (0..3)
            .map(|input| {
                let mut forces = Forces::none(&names(), 0.5, RATE).unwrap();
                forces.add(input, &shape.at_input(input, earlier));
                forces.input(input)
            })
            .collect()
    };
    let correlation = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
    let all: Vec<Vec<f64>> = [run("random", 0), run("random", 1), run("random,seed=9", 0)].concat();
    for i in 0..all.len() {
        assert!((correlation(&all[i], &all[i]) - 1.0).abs() < 0.05, "control: with itself");
        for j in 0..i {
            // Ten standard deviations of 10,000 independent products would be 0.1; neighbours in time too.
            for shift in 0..3 {
                let found = correlation(&all[i][shift..], &all[j][..all[j].len() - shift]).abs();
                assert!(found < 0.06, "{i} {j} {shift}: {found}");
            }
        }
    }
    assert_eq!(run("random,seed=9", 0), run("random,seed=9", 5));
    let mut plain = Forces::none(&names(), 0.5, RATE).unwrap();
    plain.add(0, &parse_force("random,seed=9").unwrap());
    assert_eq!(plain.input(0), run("random,seed=9", 0)[0], "the first input has the seed itself");
}

#[test]
fn what_samples_cannot_hold_is_refused_or_told() {
    let forces = Forces::none(&names(), 1.0, 300.0).unwrap();
    let check = |text: &str| parse_force(text).unwrap().check("--force", &forces);
    for (text, parts) in [
        ("sine,frequency=247", ["frequency: found 247 Hz", "less than 150 Hz, half the rate"]),
        ("sine,frequency=150", ["found 150 Hz", "--rate 1500 or more"]),
        ("sine,frequency=300", ["found 300 Hz", "half the rate"]),
        ("chirp,from=1,to=200", ["the highest frequency: found 200 Hz", "half the rate"]),
        ("chirp,from=200,to=1", ["the highest frequency: found 200 Hz", "half the rate"]),
        ("step,start=1", ["start: found 1 s", "a longer --duration"]),
        ("impulse,start=7", ["start: found 7 s", "a longer --duration"]),
    ] {
        let error = check(text).unwrap_err();
        assert!(error.is_input());
        let error = error.to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{text}: {error}");
    }
    for (text, part) in [
        ("sine,frequency=100", "a second wave at 200 Hz with 25.0 % of its amplitude"),
        ("chirp,from=1,to=60", "6.2 %"),
        ("impulse,length=0.005", "its momentum is kept, its form is not"),
        ("impulse,length=0.5,start=0.6", "the rest is left out"),
    ] {
        let told = check(text).unwrap();
        assert!(told.len() == 1 && told[0].contains(part), "{text}: {told:?}");
    }
    for text in ["sine,frequency=30", "chirp,from=0,to=30", "impulse,length=0.1", "step,start=0.9", "random"] {
        assert_eq!(check(text).unwrap(), Vec::<String>::new(), "{text}");
    }
}
