//! `stiffmap simulate` as its user meets it.

use super::apart;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The built binary in a folder of the test's own.
fn stiffmap(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command.current_dir(folder).env_remove("STIFFMAP_ADAPTER");
    if std::env::var_os("STIFFMAP_CACHE").is_none() {
        command.env("STIFFMAP_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("response-cache"));
    }
    command
}

fn simulate(folder: &Path, arguments: &[&str]) -> Output {
    stiffmap(folder).arg("simulate").args(arguments).args(["--out", "out"]).output().unwrap()
}

fn good(folder: &Path, arguments: &[&str]) -> Value {
    let run = simulate(folder, arguments);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("out/manifest.json")).unwrap()).unwrap();
    for file in manifest["files"].as_array().unwrap() {
        assert!(folder.join("out").join(file.as_str().unwrap()).exists(), "{file} is missing");
    }
    manifest
}

fn files(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder.join("out")).map_or_else(|_| Vec::new(), |f| f.map(|e| e.unwrap().path()).collect())
}

fn column(file: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let at = reader.headers().unwrap().iter().position(|h| h == name);
    let at = at.unwrap_or_else(|| panic!("{}: no column {name}", file.display()));
    reader.records().map(|record| record.unwrap()[at].parse().unwrap()).collect()
}

#[test]
fn the_papers_study_writes_histories_spectra_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = good(folder.path(), &["--impulse", "--positions", "0,-0.3,-0.6", "--duration", "0.2"]);
    let check = &manifest["checks"][0];
    assert!(check["name"].as_str().unwrap().starts_with("spectra of the time histories against the modes"));
    assert_eq!(check["passed"], true, "{check}");
    let out = folder.path().join("out");
    for picture in ["time_history", "spectrum", "frf_x_amplitude", "frf_y_frequency", "frf_z_amplitude"] {
        assert!(out.join(format!("figures/{picture}.png")).exists(), "{picture}");
    }
    let (time, force) =
        (column(&out.join("time_history.csv"), "time_s"), column(&out.join("time_history.csv"), "force_y_N"));
    assert_eq!((time.len(), time[2]), (4000, 1e-4));
    assert!((force[10] - 1.0).abs() < 3e-3 && force[21] == 0.0, "1 N, 1 ms");
    let momentum: f64 = (force.iter().sum::<f64>() - 0.5 * force[0]) / 20e3;
    assert!((momentum / (2e-3 / std::f64::consts::PI) - 1.0).abs() < 1e-9, "a half-sine's: {momentum} N s");
    let lines = column(&out.join("spectrum_x.csv"), "frequency_hz");
    assert_eq!(lines.len(), 3 * 180, "5 Hz apart up to 900 Hz, at three positions");
}

#[test]
fn a_path_reports_its_energy_and_a_force_file_is_the_force_it_names() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("path.csv"), "time_s,position_m\n0,-0.1\n0.02,-0.11\n").unwrap();
    let sine = "x:sine,amplitude=100,frequency=200";
    let manifest = good(folder.path(), &["--path-file", "path.csv", "--force", sine, "--velocity", "--no-figures"]);
    let check = &manifest["checks"][0];
    assert!(check["name"].as_str().unwrap().starts_with("energy balance") && check["passed"] == true, "{check}");
    let history = folder.path().join("out/time_history.csv");
    let (positions, own) = (column(&history, "position_m"), column(&history, "x_m"));
    assert!((positions[200] + 0.105).abs() < 1e-9 && positions.len() == 400);
    assert!(column(&history, "x_m_per_s").iter().any(|v| *v != 0.0));
    let force = column(&history, "force_x_N");
    let lines: Vec<String> = (0..400).map(|k| format!("{},{:e}\n", f64::from(k) / 20e3, force[k as usize])).collect();
    std::fs::write(folder.path().join("forces.csv"), format!("time_s,x\n{}", lines.concat())).unwrap();
    good(folder.path(), &["--path-file", "path.csv", "--force-file", "forces.csv", "--no-figures"]);
    assert!(apart(&column(&history, "x_m"), &own) < 1e-9);
    let travel =
        ["--path", "-0.1:-0.11", "--feed-rate", "30", "--force", "x:sine,amplitude=101,frequency=200", "--no-figures"];
    good(folder.path(), &travel);
    assert!((apart(&column(&history, "x_m"), &own) - 0.01).abs() < 1e-4, "control: a hundredth more force");
}

#[test]
fn friction_and_backlash_of_the_machine_file_act_and_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    assert!(stiffmap(folder.path()).args(["init", "mill"]).output().unwrap().status.success());
    let file = folder.path().join("mill/machine.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let run = |text: &str, more: &[&str]| {
        std::fs::write(&file, text).unwrap();
        let force = ["mill", "--force", "z:sine,amplitude=400,frequency=40", "--duration", "0.1", "--no-figures"];
        good(folder.path(), &[&force[..], more].concat());
        column(&folder.path().join("out/time_history.csv"), "z_m")
    };
    let linear = run(&text, &[]);
    let footprint = "footprint = \"90 mm\"\n";
    let rough = text.replace(
        footprint,
        &format!("{footprint}friction = {{ coulomb = \"20 N\", breakaway = \"30 N\", stribeck = \"1 mm/s\" }}\n"),
    );
    let rough = rough.replace("diameter = \"40 mm\"\n", "diameter = \"40 mm\"\nbacklash = \"1 um\"\n");
    let held = run(&rough, &[]);
    assert!(apart(&held, &linear) > 1e-2, "{:.1e}", apart(&held, &linear));
    let events = std::fs::read_to_string(folder.path().join("out/joint_events.csv")).unwrap();
    assert!(events.contains("guide A,slides") && events.contains("ball screw,touches"), "{events:.500}");
    let history = folder.path().join("out/time_history.csv");
    let of = |name: &str| column(&history, name);
    let (slip, speed, force) = (of("guide_A_slip_m"), of("guide_A_slip_m_per_s"), of("guide_A_contact_force_N"));
    let most = |x: &[f64]| x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(most(&slip) > 1e-7 && most(&force) <= 30.0 * (1.0 + 1e-9) && most(&force) > 20.0, "{}", most(&force));
    // Where it slides, friction opposes the slip.
    let slides: Vec<usize> = (0..slip.len()).filter(|&k| speed[k].abs() > 1e-4).collect();
    let opposed = slides.iter().filter(|&&k| force[k] * speed[k] > 0.0).count();
    assert!(slides.len() > 100 && opposed > slides.len() * 95 / 100, "{opposed} of {}", slides.len());
    // The screw's force is that of its spring beyond the play of 0.5 um to either side.
    let (play, screw) = (of("ball_screw_slip_m"), of("ball_screw_contact_force_N"));
    assert!(play.iter().zip(&screw).all(|(e, f)| (e.abs() < 0.5e-6) == (*f == 0.0) && e * f >= 0.0));
    assert!(most(&screw) > 1.0, "control: the play is taken up");
    let without = run(&rough, &["--linear"]);
    assert!(!std::fs::read_to_string(&history).unwrap().contains("slip"), "no contact, no column");
    assert!(
        apart(&without, &linear) < 1e-6,
        "the friction's own row changes the basis by {:.1e}",
        apart(&without, &linear)
    );
    let refused = simulate(folder.path(), &["mill", "--path", "0:-0.01", "--feed-rate", "1", "--force", "x:step"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--linear leaves them out"));
}

#[test]
fn wrong_input_is_refused_with_key_value_and_what_is_allowed_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &[&str]); 21] = [
        (&[], &["no force", "--impulse, --force, --force-file, --milling"]),
        (&["--force", "w:step"], &["the input of a force: found \"w\"", "x, y, z"]),
        (&["--force", "step"], &["--force: \"step\" is not INPUT:KIND", "x, y, z, all"]),
        (&["--force", "x:sine,frequency=-1"], &["frequency: found -1", "a positive number"]),
        (&["--impulse=shape=round"], &["shape: found round", "half-sine, rectangle, triangle"]),
        (&["--impulse", "--rate", "0"], &["--rate: found 0", "a positive number"]),
        (&["--impulse", "--duration", "-1"], &["--duration: found -1", "a positive time in s"]),
        (&["--impulse", "--positions", "0.1"], &["--positions: 0.1 m is outside the travel", "0 to -0.6 m"]),
        (&["--force", "x:step", "--path", "0:-0.6"], &["--path needs --feed-rate"]),
        (&["--force", "x:step", "--path", "0", "--feed-rate", "30"], &["--path: \"0\" is not FROM:TO"]),
        (&["--force", "x:step", "--path", "0:-0.7", "--feed-rate", "30"], &["outside the travel of axis \"z\""]),
        (
            &["--force", "x:step", "--path", "0:-0.6", "--feed-rate", "-3"],
            &["--feed-rate: found -3", "a positive speed"],
        ),
        (&["--force-file", "none.csv"], &["none.csv"]),
        (&["--milling", "teeth=4"], &["--milling: found no speed", "speed=NUMBER"]),
        (&["--impulse", "--no-residual"], &["--no-residual needs --modes N"]),
        (
            &["--force", "x:step", "--path", "0:-0.6", "--feed-rate", "30", "--position", "0"],
            &["--positions and a path exclude each other"],
        ),
        (&["--force", "x:sine,frequency=247", "--rate", "300"], &["frequency: found 247 Hz", "half the rate"]),
        (&["--force", "x:step,start=2"], &["start: found 2 s", "a longer --duration"]),
        (
            &["--force", "all:step", "--duration", "2400", "--velocity", "--positions", "0,-0.1"],
            &[
                "48000000 samples of 3 inputs and 6 outputs at 2 positions",
                "`displacement`",
                "2.3 GB",
                "shorten --duration",
            ],
        ),
        (
            &["--milling", "teeth=4,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3,entry=180,exit=360"],
            &["180 to 360 degrees", "negative"],
        ),
        (
            &["--milling", "teeth=4,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3,port=head"],
            &["port: found \"head\"", "tool"],
        ),
    ];
    for (arguments, parts) in cases {
        let run = simulate(folder.path(), arguments);
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(parts.iter().all(|p| message.contains(p)), "{arguments:?}: {message}");
        assert_eq!(files(folder.path()), Vec::<PathBuf>::new(), "{arguments:?}");
    }
    let endless = simulate(folder.path(), &["--impulse=start=0.0995", "--duration", "0.1", "--position", "0"]);
    let message = String::from_utf8_lossy(&endless.stderr).into_owned();
    assert_eq!(endless.status.code(), Some(2), "{message}");
    assert!(message.contains("must be over before the last sample"), "{message}");
    assert_eq!(files(folder.path()), Vec::<PathBuf>::new());
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_a_travel_and_leaves_nothing() {
    use std::io::{BufRead, BufReader};
    let folder = tempfile::tempdir().unwrap();
    let mut command = stiffmap(folder.path());
    command.args(["simulate", "--path", "0:-0.6", "--feed-rate", "30", "--force", "x:step", "--out", "out"]);
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let reached = lines.find(|line| line.starts_with("stations of the path"));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let rest: Vec<String> = lines.collect();
    let code = child.wait().unwrap().code();
    assert!(reached.is_some() && sent.success());
    assert_eq!(code, Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("error: interrupted")), "{rest:?}");
    assert_eq!(files(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn run_writes_rows_and_discrete_systems_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let base = ["run", "--positions", "0:-0.05:0.005", "--frequencies", "0:100:50", "--no-figures", "--out", "out"];
        stiffmap(folder.path()).args(base).args(more).output().unwrap()
    };
    let done = run(&["--velocity", "--acceleration", "--sample-time", "5e-5", "--hold", "first"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let file = folder.path().join("out/state_space.mat");
    let Some(figure) = super::python("shapes", &[&file, &file]) else { return };
    assert_eq!(figure, 0.0);
    let refused = run(&["--sample-time", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--sample-time: 0 is not allowed"));
    assert_eq!(run(&["--hold", "first"]).status.code(), Some(2), "hold needs a sample time");
}
