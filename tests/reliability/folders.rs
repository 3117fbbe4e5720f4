//! A result folder belongs to one job, and a manifest stands for a whole result.

use super::*;
use std::process::{Child, Stdio};
use std::time::Duration;

/// What a folder holds, by name and hash, without the manifest.
fn content(room: &Room, folder: &str) -> Vec<(String, String)> {
    let files = room.files(folder).into_iter().filter(|name| !name.starts_with('.') && name != "manifest.json");
    files.map(|name| (name.clone(), room.hash(&format!("{folder}/{name}")))).collect()
}

/// The files that a manifest lists, without itself.
fn listed(room: &Room, folder: &str) -> Vec<String> {
    let manifest = room.manifest(folder);
    let mut names: Vec<String> =
        manifest["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap().to_owned()).collect();
    names.retain(|name| name != "manifest.json");
    names.sort();
    names
}

fn start(room: &Room, words: &[&str]) -> Child {
    room.command(words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// A long sweep of the block.
fn long_study(room: &Room, name: &str, seed: usize) {
    room.write(name, &STUDY.replace("designs = 12", "designs = 100000").replace("seed = 3", &format!("seed = {seed}")));
}

/// Waits until a sweep has written some rows.
fn rows(room: &Room, folder: &str, child: &mut Child) {
    let table = room.path(&format!("{folder}/designs.csv"));
    for _ in 0..3000 {
        if std::fs::read(&table).is_ok_and(|text| text.iter().filter(|b| **b == b'\n').count() > 3) {
            return;
        }
        assert!(child.try_wait().unwrap().is_none(), "the sweep ended");
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("no rows");
}

#[test]
fn of_four_jobs_into_one_folder_one_runs_and_three_are_told_who() {
    let room = Room::new();
    long_study(&room, "long.toml", 1);
    let sweep = ["sweep", "long.toml", "--no-figures", "--out", "out"];
    let mut first = start(&room, &sweep);
    rows(&room, "out", &mut first);
    let record = room.read("out/sweep.json");
    let holder = format!("process {}", first.id());
    long_study(&room, "other.toml", 2);
    for words in [
        &["sweep", "other.toml", "--no-figures", "--overwrite", "--out", "out"][..],
        &["optimise", "study.toml", "--no-figures", "--out", "out"],
        &[&QUICK[..], &["--out", "out"]].concat(),
    ] {
        let output = room.run(words);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        // A run is told of the table that it would replace; both say why nothing is written.
        let told = said(&output);
        assert!(
            told.contains(&holder) && told.contains("stiffmap sweep long.toml") && told.contains("since 2"),
            "{told}"
        );
    }
    assert!(room.read("out/sweep.json") == record, "nothing of the first job is touched");
    first.kill().unwrap();
    first.wait().unwrap();
    // The lock of a killed process holds nobody up, and its table goes on with its own study only.
    room.refused(&["sweep", "other.toml", "--no-figures", "--resume", "--out", "out"], &["the hash of"]);
    let mut again = start(&room, &[&sweep[..], &["--resume"]].concat());
    std::thread::sleep(Duration::from_millis(300));
    assert!(again.try_wait().unwrap().is_none(), "the rightful one goes on");
    again.kill().unwrap();
    again.wait().unwrap();
}

#[test]
fn a_used_folder_holds_the_files_of_one_run_and_the_users_own() {
    let room = Room::new();
    let run = ["run", ".", "--frequencies", "0:60:5", "--out", "out"];
    room.done(&run);
    assert_eq!(listed(&room, "out"), content(&room, "out").into_iter().map(|(name, _)| name).collect::<Vec<_>>());
    room.write("out/figures/mine.png", "a picture of the user's");
    room.write("out/surface_measured.csv", "a file of the user's");
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    let mut expected = listed(&room, "out");
    assert!(!expected.contains(&"report.html".to_owned()));
    expected.extend(["figures/mine.png".to_owned(), "surface_measured.csv".to_owned()]);
    expected.sort();
    let found: Vec<String> = content(&room, "out").into_iter().map(|(name, _)| name).collect();
    assert_eq!(found, expected, "stale files go, the user's stay");
    assert_eq!(room.files("out").len(), expected.len() + 1, "no lock is left");

    // Lists that lead out of the folder remove nothing there.
    room.write("precious.csv", "outside");
    let mut manifest = room.manifest("out");
    manifest["files"].as_array_mut().unwrap().push("../precious.csv".into());
    room.write("out/manifest.json", &manifest.to_string());
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    assert_eq!(room.read("precious.csv"), b"outside");
}

#[test]
fn what_another_program_or_command_wrote_is_not_replaced() {
    let room = Room::new();
    room.write("web/manifest.json", "{ \"name\": \"a page\", \"icons\": [] }");
    room.refused(&[&QUICK[..], &["--out", "web"]].concat(), &["web/manifest.json", "stiffmap did not write"]);
    assert_eq!(room.files("web"), ["manifest.json"]);
    room.done(&["sweep", "study.toml", "--no-figures", "--out", "swept"]);
    let before = content(&room, "swept");
    room.refused(&[&QUICK[..], &["--out", "swept"]].concat(), &["the result of `stiffmap sweep` is there"]);
    std::fs::remove_file(room.path("swept/manifest.json")).unwrap();
    room.refused(&[&QUICK[..], &["--out", "swept"]].concat(), &["swept/sweep.json", "the table of a sweep"]);
    room.refused(&["optimise", "study.toml", "--out", "swept"], &["swept/designs.csv", "the table of a sweep"]);
    assert_eq!(content(&room, "swept"), before);
}

#[test]
fn a_complete_table_of_another_study_is_replaced_only_where_this_is_asked_for() {
    let room = Room::new();
    room.write("other.toml", &STUDY.replace("seed = 3", "seed = 4"));
    for (command, table) in [("sweep", "designs.csv"), ("optimise", "evaluations.csv")] {
        let words = |study: &'static str| [command, study, "--no-figures", "--out", command];
        room.done(&words("study.toml"));
        let before = content(&room, command);
        room.refused(&words("other.toml"), &[table, "a complete table of other inputs", "--overwrite"]);
        assert_eq!(content(&room, command), before);
        room.done(&words("study.toml"));
        assert_eq!(content(&room, command), before, "control: its own study may be run again");
        room.done(&[&words("other.toml")[..], &["--overwrite"]].concat());
        assert_ne!(content(&room, command), before);
        // A table of which nobody knows what it belongs to is neither continued nor replaced.
        std::fs::remove_file(room.path(&format!("{command}/sweep.json"))).unwrap();
        for more in [&[][..], &["--resume"]] {
            room.refused(&[&words("other.toml")[..], more].concat(), &[table, "no sweep.json"]);
        }
    }
}

#[test]
fn a_job_that_fails_before_it_writes_leaves_the_old_result_whole() {
    let room = Room::new();
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    let before = (content(&room, "out"), room.read("out/manifest.json"));
    room.write("block/more/steel.inp", &material(-1.0));
    room.refused(&[&QUICK[..], &["--out", "out"]].concat(), &["steel.inp", "DENSITY"]);
    assert_eq!((content(&room, "out"), room.read("out/manifest.json")), before);
    assert!(!room.path("out/.stiffmap.lock").exists());
}

#[test]
fn a_folder_without_manifest_is_known_as_unfinished() {
    let room = Room::new();
    room.done(&["run", ".", "--frequencies", "0:60:5", "--out", "out"]);
    room.done(&["figures", "out"]);
    std::fs::remove_file(room.path("out/manifest.json")).unwrap();
    for command in ["figures", "view"] {
        room.refused(&[command, "out"], &["no manifest.json", "did not finish", "run again"]);
    }
}

/// Ends a run into a used folder after a time; whether it was ended before it was done.
fn ended(room: &Room, signal: &str, after: Duration) -> bool {
    let mut run = start(room, &["run", ".", "--frequencies", "0:60:5", "--damping", "0.05", "--out", "out"]);
    std::thread::sleep(after);
    let _ = Command::new("kill").args([signal, &run.id().to_string()]).stderr(Stdio::null()).status().unwrap();
    run.wait().unwrap().code() != Some(0)
}

#[test]
#[cfg(unix)]
fn a_run_that_is_ended_at_any_moment_leaves_the_old_result_or_an_unfinished_folder() {
    let room = Room::new();
    let run = |damping: &'static str, out: &'static str| {
        ["run", ".", "--frequencies", "0:60:5", "--damping", damping, "--out", out]
    };
    let start = std::time::Instant::now();
    room.done(&run("0.05", "new"));
    let whole = start.elapsed();
    let new = content(&room, "new");
    let (mut ends, mut unfinished) = (0, 0);
    for k in 0..16_u32 {
        room.done(&run("0.02", "out"));
        let old = content(&room, "out");
        let stopped = ended(&room, if k % 2 == 0 { "-KILL" } else { "-INT" }, whole * (k + 1) / 17);
        ends += usize::from(stopped);
        if room.path("out/manifest.json").exists() {
            let found = content(&room, "out");
            // Seconds differ from run to run, and the page holds them.
            let same = |a: &[(String, String)]| {
                let plain = |list: &[(String, String)]| -> Vec<(String, String)> {
                    list.iter().filter(|(name, _)| name != "report.html").cloned().collect()
                };
                plain(a) == plain(&found)
            };
            assert!(same(&old) || same(&new), "end {k}: a mixture");
            assert!(same(&old) != same(&new), "control: the two results differ");
        } else {
            unfinished += 1;
            room.refused(&["figures", "out"], &["out"]);
        }
        assert!(!room.files("out").iter().any(|f| f.ends_with(".tmp")) || stopped);
    }
    room.done(&run("0.05", "out"));
    assert_eq!(room.files("out").iter().filter(|f| f.contains(".tmp") || f.starts_with('.')).count(), 0);
    assert_eq!(listed(&room, "out").len(), content(&room, "out").len());
    assert!(ends > 0 && unfinished > 0, "{ends} ends, {unfinished} unfinished: no end came in time");
}
