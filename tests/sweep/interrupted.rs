//! Sweeps that were killed.

use super::*;
use std::io::Write as _;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Kills a sweep once its table has some rows and some more time has passed.
fn kill_at(folder: &Path, rows: usize, more: Duration, arguments: &[&str]) -> usize {
    let mut command = stiffmap();
    command.current_dir(folder).args(["sweep", "study.toml", "--no-figures", "--out", "out"]).args(arguments);
    let mut child = command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
    let path = folder.join("out/designs.csv");
    let lines = || std::fs::read(&path).map_or(0, |text| text.iter().filter(|b| **b == b'\n').count());
    let start = Instant::now();
    while lines() < rows + 1 && child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(more);
    // SIGKILL on Unix; it may have ended by itself.
    let _ = child.kill();
    child.wait().unwrap();
    lines()
}

#[test]
fn a_sweep_that_is_killed_ten_times_ends_with_the_same_table() {
    let folder = folder_with(STUDY);
    let path = folder.path();
    let mut unfinished = 0;
    for time in 0..10_u64 {
        // Anywhere from before the first row to the end, and between any two writes.
        let (rows, more) = ((time as usize * 24) / 10, Duration::from_micros(700 * (time * 7 % 10)));
        let lines = kill_at(path, rows, more, if time == 0 { &[] } else { &["--resume"] });
        unfinished += usize::from(lines < 25);
    }
    assert!(unfinished > 0, "no kill came before the end");
    done(&sweep(path, "out", &["--resume"]));
    assert_eq!(table(path, "out"), reference());
    // A finished sweep goes on from its end: nothing is computed.
    done(&sweep(path, "out", &["--resume"]));
    assert_eq!(table(path, "out"), reference());
}

/// The folder of a finished sweep whose table is then cut.
fn cut_to(bytes: impl FnOnce(&str) -> usize) -> TempDir {
    let folder = folder_with(STUDY);
    done(&sweep(folder.path(), "out", &[]));
    let whole = table(folder.path(), "out");
    assert_eq!(whole, reference());
    std::fs::write(folder.path().join("out/designs.csv"), &whole[..bytes(&whole)]).unwrap();
    folder
}

#[test]
fn a_torn_last_row_is_computed_again() {
    // In the middle of a number, of the header, right before a line break, and nothing at all.
    for cut in [2000, 30, 0] {
        let folder = cut_to(|text| if cut == 2000 { text.len() - 1 } else { cut });
        done(&sweep(folder.path(), "out", &["--resume"]));
        assert_eq!(table(folder.path(), "out"), reference(), "cut at {cut}");
    }
    let folder = cut_to(|text| text.match_indices('\n').nth(9).unwrap().0 + 25);
    let refused = sweep(folder.path(), "out", &[]);
    assert_eq!(refused.status.code(), Some(2), "an unfinished sweep is not overwritten by a slip");
    assert!(stderr(&refused).contains("--resume") && stderr(&refused).contains("--overwrite"), "{}", stderr(&refused));
    done(&sweep(folder.path(), "out", &["--resume"]));
    assert_eq!(table(folder.path(), "out"), reference());
}

#[test]
fn a_damaged_row_in_the_middle_and_changed_inputs_are_refused() {
    let folder = cut_to(str::len);
    let path = folder.path().join("out/designs.csv");
    let whole = table(folder.path(), "out");
    let fourth = whole.lines().nth(4).unwrap();
    let damaged = whole.replacen(fourth, &fourth.replacen("3,", "3,9", 1), 1);
    std::fs::write(&path, &damaged).unwrap();
    let refused = sweep(folder.path(), "out", &["--resume"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("designs.csv:5: the row is damaged"), "{}", stderr(&refused));
    assert_eq!(table(folder.path(), "out"), damaged, "nothing is touched");
    std::fs::write(&path, &whole).unwrap();

    for file in ["study.toml", "machine.toml", "bed.inp"] {
        let original = std::fs::read(folder.path().join(file)).unwrap();
        let comment: &[u8] = if file == "bed.inp" { b"** changed\n" } else { b"\n# changed\n" };
        std::fs::OpenOptions::new().append(true).open(folder.path().join(file)).unwrap().write_all(comment).unwrap();
        let refused = sweep(folder.path(), "out", &["--resume"]);
        assert_eq!(refused.status.code(), Some(2));
        let said = stderr(&refused);
        assert!(
            said.contains(&format!("the hash of {file} is")) && said.contains("restore what was changed"),
            "{said}"
        );
        std::fs::write(folder.path().join(file), original).unwrap();
    }
    done(&sweep(folder.path(), "out", &["--resume"]));
}
