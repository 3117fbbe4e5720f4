//! Maps that go to their files tile by tile.

use super::*;
#[cfg(unix)]
use std::io::{BufRead, BufReader};
#[cfg(unix)]
use std::process::Stdio;

/// Three positions of 90,001 frequencies: two tiles.
const TWO_TILES: [&str; 4] = ["--positions", "0,-0.2,-0.4", "--frequencies", "0:900:0.01"];

/// Compares a streamed map with a whole one by `tests/readers.py`; `None` where the Python tests are switched off.
fn compare(streamed: &Path, whole: &Path) -> Option<Result<(), String>> {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return None;
    }
    let python = std::env::var("STIFFMAP_PYTHON")
        .expect("STIFFMAP_PYTHON names a Python with scipy, or STIFFMAP_PYTHON_TESTS=skip");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/readers.py");
    let run = Command::new(python).args([script, "streamed"]).arg(streamed).arg(whole).output().unwrap();
    match run.status.code() {
        Some(0) => Some(Ok(())),
        Some(1) if !stderr(&run).contains("Traceback") => Some(Err(stderr(&run))),
        other => panic!("readers.py ended with {other:?}: {}", stderr(&run)),
    }
}

#[test]
fn a_streamed_map_is_the_map() {
    let [whole, streamed, other] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let record = quick(whole.path(), &[&TWO_TILES[..], &["--map-memory", "1GiB"]].concat());
    assert_eq!(record["settings"]["map_streamed"], false);
    assert!(!whole.path().join("compliance.npy").exists());
    let record = quick(streamed.path(), &[&TWO_TILES[..], &["--map-memory", "1MB"]].concat());
    let settings = &record["settings"];
    assert_eq!((&settings["map_streamed"], &settings["map_tiles"]), (&true.into(), &2.into()));
    assert_eq!(settings["map_bytes"], 3 * 90_001 * 9 * 16);
    assert_eq!(settings["map_tile_bytes"], 2 * 90_001 * 9 * 16);
    assert_eq!(
        settings["smallest_dynamic_stiffness"],
        manifest(whole.path())["settings"]["smallest_dynamic_stiffness"]
    );
    let listed: Vec<&str> = record["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    let mut expected = files_below(streamed.path());
    expected.sort();
    assert_eq!(listed.len(), expected.len());
    assert!(expected.iter().all(|f| listed.contains(&&*f.to_string_lossy())), "{listed:?}");
    for name in ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv", "state_space.mat", "eigenfrequencies.csv"] {
        let read = |folder: &TempDir| std::fs::read(folder.path().join(name)).unwrap();
        assert!(read(&whole) == read(&streamed), "{name} differs");
    }
    if let Some(same) = compare(streamed.path(), &whole.path().join("compliance.mat")) {
        assert_eq!(same, Ok(()));
        // A whole map takes the place of a streamed one, and the comparison notices another map.
        let few = ["--positions", "0,-0.2,-0.4", "--frequencies", "0:900:0.01", "--damping", "0.021"];
        quick(other.path(), &few);
        let differs = compare(streamed.path(), &other.path().join("compliance.mat")).unwrap();
        assert!(differs.unwrap_err().contains("receptance"));
    }
    quick(streamed.path(), &["--position", "0", "--frequencies", "10"]);
    assert!(!streamed.path().join("compliance.npy").exists(), "an earlier run's map would pass as this one's");
}

#[test]
#[cfg(unix)]
fn an_interrupted_stream_leaves_no_map() {
    let out = tempfile::tempdir().unwrap();
    let mut command = stiffmap(warm_cache());
    // 4.5 million pairs: seconds of writing.
    command.args(["run", "--no-figures", "--map-memory", "0", "--positions", "0:-0.04:0.01"]);
    command.args(["--frequencies", "0:900:0.001", "--out"]).arg(out.path());
    let mut run = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("modes")), "the run never came to its map");
    // The stream has begun when its file stands aside.
    while files_below(out.path()).is_empty() && run.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let rest: Vec<String> = lines.collect();
    assert_eq!(run.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("error: interrupted")), "{rest:?}");
    assert_eq!(files_below(out.path()), Vec::<PathBuf>::new());
}

#[test]
#[cfg(unix)]
fn a_stream_that_cannot_be_written_leaves_no_map() {
    let out = tempfile::tempdir().unwrap();
    quick(out.path(), &["--position", "0", "--frequencies", "10"]);
    let before = std::fs::read(out.path().join("compliance.mat")).unwrap();
    // Files of at most 16 MiB (a shell's unit is 512 or 1024 bytes); the map takes 37.
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 16384; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_stiffmap"), "run"]);
    shell.args(TWO_TILES).args(["--no-figures", "--map-memory", "0", "--out"]).arg(out.path());
    let run = shell.env("STIFFMAP_CACHE", warm_cache()).output().unwrap();
    let said = stderr(&run);
    assert_eq!(run.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write") && said.contains("compliance.npy"), "{said}");
    assert!(!out.path().join("compliance.npy").exists());
    assert_eq!(std::fs::read(out.path().join("compliance.mat")).unwrap(), before, "the earlier map stays");
    assert!(files_below(out.path()).iter().all(|f| !f.to_string_lossy().ends_with(".tmp")));
}

#[test]
fn streaming_takes_the_same_memory_for_any_number_of_positions() {
    let bench = |arguments: &[&str]| -> Vec<Value> {
        let sizes = ["bench", "--backend", "cpu", "--repetitions", "1", "--json"];
        let run = stiffmap(Path::new("unused")).args(sizes).args(arguments).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
        serde_json::from_str(&stdout(&run)).unwrap()
    };
    let rows = bench(&["--positions", "30", "--growth"]);
    let positions: Vec<u64> = rows.iter().map(|row| row["positions"].as_u64().unwrap()).collect();
    assert_eq!(positions, [30, 300, 3000]);
    assert!(rows.iter().all(|row| row["streamed"] == true));
    let whole = bench(&["--positions", "1000"]);
    assert_eq!(whole[0]["streamed"], false);
    assert_eq!(bench(&["--positions", "3000"])[0]["streamed"], true, "864 MB are not held");
    if !cfg!(target_os = "linux") {
        return println!("skipped: no peak of the memory");
    }
    let peak = |row: &Value| row["peak_rss_bytes"].as_u64().unwrap();
    // Ten times the positions: 6 MB of modal data more, where the map has 777 MB more.
    assert!(peak(&rows[2]) < peak(&rows[1]) + (32 << 20), "{rows:?}");
    assert!(peak(&whole[0]) > 288_000_000, "control: a map in memory shows: {whole:?}");
}
