//! Forces: their values, their texts, their files, and what is refused.

use super::{mill, names};
use std::io::Write;
use stiffmap::files::Inputs;
use stiffmap::response::{CutterPort, Forces, parse_force, parse_milling, read_force_file, read_path_file};

fn sampled(text: &str, duration: f64, rate: f64) -> Vec<f64> {
    let mut forces = Forces::none(&names(), duration, rate).unwrap();
    forces.add(1, &parse_force(text).unwrap());
    assert!(forces.input(0).iter().chain(&forces.input(2)).all(|f| *f == 0.0));
    forces.input(1)
}

#[test]
fn pulses_have_their_amplitude_length_and_area() {
    for (shape, area) in [("half-sine", 2.0 / std::f64::consts::PI), ("rectangle", 1.0), ("triangle", 0.5)] {
        let f = sampled(&format!("impulse,shape={shape},amplitude=4,length=0.002,start=0.001"), 0.01, 100e3);
        let sum: f64 = f.iter().sum::<f64>() / 100e3;
        assert!((sum / (4.0 * 0.002 * area) - 1.0).abs() < 1e-9, "{shape}: {sum}");
        assert!((f.iter().copied().fold(0.0, f64::max) - 4.0).abs() < 2e-2);
        assert!(f[..99].iter().chain(&f[302..]).all(|v| *v == 0.0), "{shape}");
    }
}

#[test]
fn sine_step_chirp_and_noise_are_what_they_say() {
    let sine = sampled("sine,amplitude=3,frequency=50,phase=90", 0.1, 10e3);
    // Its samples are larger by what straight lines between them lose, 8.2e-5.
    let peak = 3.0 / (0.005f64 * std::f64::consts::PI).sin().powi(2) * (0.005 * std::f64::consts::PI).powi(2);
    assert!((sine[0] - peak).abs() < 1e-12 && (sine[50]).abs() < 1e-9 && (sine[100] + peak).abs() < 1e-9);
    let step = sampled("step,amplitude=-2,start=0.05", 0.1, 10e3);
    assert_eq!((step[499], step[500], step[501]), (0.0, -1.0, -2.0), "half of it at the jump itself");
    let chirp = sampled("chirp,from=100,to=100", 0.1, 10e3);
    assert!(super::apart(&chirp, &sampled("sine,frequency=100", 0.1, 10e3)) < 1e-9);
    // The chirp's last zeros are as far apart as its last frequency says.
    let chirp = sampled("chirp,from=10,to=400", 1.0, 100e3);
    let zeros: Vec<usize> = (1..chirp.len()).filter(|&k| chirp[k - 1] < 0.0 && chirp[k] >= 0.0).collect();
    let last = 100e3 / (zeros[zeros.len() - 1] - zeros[zeros.len() - 2]) as f64;
    assert!((last - 399.0).abs() < 3.0, "{last} Hz");
    let noise = sampled("random,rms=2,seed=7", 1.0, 20e3);
    let mean = noise.iter().sum::<f64>() / 20e3;
    let rms = (noise.iter().map(|f| f * f).sum::<f64>() / 20e3).sqrt();
    let next: f64 = noise.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 20e3;
    assert!(mean.abs() < 0.06 && (rms - 2.0).abs() < 0.04 && next.abs() < 0.1, "{mean} {rms} {next}");
    assert_eq!(noise, sampled("random,rms=2,seed=7", 1.0, 20e3));
    assert_ne!(noise, sampled("random,rms=2,seed=8", 1.0, 20e3));
}

#[test]
fn wrong_texts_are_refused_with_key_value_and_what_is_allowed() {
    for (text, parts) in [
        ("sinus,frequency=3", ["the kind of a force: found \"sinus\"", "impulse, step, sine, chirp, random"]),
        ("sine", ["found no frequency", "frequency=NUMBER"]),
        ("sine,frequency=-3", ["frequency: found -3", "a positive number"]),
        ("sine,frequency=3,phase=nan", ["phase: found nan", "a finite number"]),
        ("sine,frequency=3,frequency=4", ["found frequency twice", "each key once"]),
        ("sine,frequency", ["found \"frequency\"", "key=value"]),
        ("step,lenght=3", ["the key \"lenght\"", "amplitude, start"]),
        ("impulse,shape=round", ["shape: found round", "half-sine, rectangle, triangle"]),
        ("impulse,length=0", ["length: found 0", "a positive number"]),
        ("random,seed=-1", ["seed: found -1", "a whole number"]),
    ] {
        let error = parse_force(text).unwrap_err().to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{text}: {error}");
    }
    let ports = CutterPort::of(&mill().machine);
    let milling = "teeth=4,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3";
    for (text, parts) in [
        (milling.replace("teeth=4", "teeth=0"), ["teeth: found 0", "at least 1"]),
        (format!("{milling},entry=90,exit=80"), ["90 to 80 degrees", "entry < exit"]),
        (format!("{milling},along=w"), ["along: found", "x, y, z"]),
        (format!("{milling},along=y,across=y"), ["along and across", "two different inputs"]),
    ] {
        let error = parse_milling(&text, &ports).unwrap_err().to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{text}: {error}");
    }
    assert!(Forces::none(&names(), 1.0, 0.0).unwrap_err().to_string().starts_with("--rate: found 0"));
    assert!(Forces::none(&names(), f64::NAN, 1e3).unwrap_err().to_string().starts_with("--duration: found NaN"));
    let error = Forces::none(&names(), 1e6, 1e6).unwrap_err().to_string();
    assert!(error.contains("allowed"), "{error}");
}

fn file(folder: &std::path::Path, text: &str) -> std::path::PathBuf {
    let path = folder.join("input.csv");
    std::fs::File::create(&path).unwrap().write_all(text.as_bytes()).unwrap();
    path
}

#[test]
fn a_force_file_is_straight_between_its_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "time_s, z_N, x\n0.001, 0, 1\n0.003, 4, 1\n0.004, 0, 1\n");
    let mut forces = Forces::none(&names(), 0.006, 2000.0).unwrap();
    read_force_file(&path, &mut forces).unwrap();
    let near = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(
        near(forces.input(2), &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 2.0, 0.0, 0.0, 0.0, 0.0]),
        "{:?}",
        forces.input(2)
    );
    assert!(
        near(forces.input(0), &[0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0]),
        "{:?}",
        forces.input(0)
    );
}

#[test]
fn wrong_files_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (text, parts) in [
        ("t,x\n0,1\n1,2\n", ["input.csv:1: the first heading is \"t\"", "time_s"]),
        ("time_s,w\n0,1\n1,2\n", ["the heading \"w\" is no input", "x, y, z"]),
        ("time_s,x\n0,1\n0,2\n", ["input.csv:3: the time 0 s follows 0 s", "ascend"]),
        ("time_s,x\n0,1\n1,two\n", ["input.csv:3: x: found \"two\"", "a number"]),
        ("time_s,x\n0,1\n1,nan\n", ["x: found \"nan\"", "a number"]),
        ("time_s,x\n0,1\n1\n", ["input.csv:3: 1 values under 2 headings", ""]),
        ("time_s,x\n0,1\n", ["1 lines of numbers", "at least two"]),
        ("time_s\n0\n1\n", ["no input", "x, y, z"]),
    ] {
        let mut forces = Forces::none(&names(), 0.01, 2000.0).unwrap();
        let error = read_force_file(&file(folder.path(), text), &mut forces).unwrap_err();
        assert!(error.is_input());
        let error = error.to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{text:?}: {error}");
    }
    let error = read_path_file(&file(folder.path(), "time_s,place\n0,1\n1,2\n"), &mut Inputs::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("allowed: time_s,position_m"), "{error}");
    let path =
        read_path_file(&file(folder.path(), "time_s,position_m\n0,-0.1\n2,-0.3\n"), &mut Inputs::default()).unwrap();
    assert!((path.at(1.0) + 0.2).abs() < 1e-15 && path.at(5.0) == -0.3 && path.at(-1.0) == -0.1);
    assert_eq!(path.range(), [-0.3, -0.1]);
    assert!(
        read_path_file(std::path::Path::new("nowhere.csv"), &mut Inputs::default())
            .unwrap_err()
            .to_string()
            .contains("nowhere.csv")
    );
}
