//! stderr and stdout that cannot be written, and the one module that writes them.

use super::*;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

/// A device on which every write fails, as on a full disk.
fn full() -> Stdio {
    File::options().write(true).open("/dev/full").unwrap().into()
}

#[test]
#[cfg(target_os = "linux")]
fn an_unwritable_stderr_changes_nothing() {
    let [plain, unread] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    assert_eq!(run(&input("machine.toml"), plain.path()).output().unwrap().status.code(), Some(0));
    let status = run(&input("machine.toml"), unread.path()).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(0));
    assert!(results(plain.path()).len() >= 4);
    assert_eq!(results(plain.path()), results(unread.path()));
    // Control: what is said of a failure is lost there too, its exit code is not.
    let refused = run(Path::new("/no/such/machine.toml"), unread.path()).stderr(full()).status().unwrap();
    assert_eq!(refused.code(), Some(2));
}

#[test]
#[cfg(target_os = "linux")]
fn a_log_on_a_full_disk_costs_no_job() {
    let out = tempfile::tempdir().unwrap();
    let mut job = run(&input("machine.toml"), out.path());
    let status = job.env("STIFFMAP_LOG", "trace").stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(0));
}

#[test]
#[cfg(target_os = "linux")]
fn an_answer_that_cannot_be_written_is_an_error_and_one_that_is_read_no_further_is_none() {
    let out = tempfile::tempdir().unwrap();
    let output = run(&input("machine.toml"), out.path()).arg("--json").stdout(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("standard output cannot be written"), "{}", said(&output));
    assert!(out.path().join("manifest.json").exists(), "the job is whole");

    // `stiffmap .. | head -1`: the reader goes away at once.
    for arguments in [&["check"][..], &["run", "--json", "--no-cache", "--no-figures", "--out", "OUT"]] {
        let mut job = program();
        job.arg(arguments[0]).arg(input("machine.toml")).args(&arguments[1..]);
        let mut child = job.current_dir(out.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", said(&output));
        assert!(!said(&output).contains("error:"), "{}", said(&output));
    }
    assert!(out.path().join("OUT/manifest.json").exists());
}

#[test]
fn a_reader_of_both_streams_that_reads_one_line_leaves_the_job_whole() {
    let out = tempfile::tempdir().unwrap();
    let mut child = run(&input("machine.toml"), out.path()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("read meshes"), "{line}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(out.path().join("manifest.json").exists());
}

/// Whether a source writes a stream by one of the standard library's macros, which panic.
fn writes(text: &str) -> bool {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or(line)).collect();
    ["println!", "eprintln!", "print!(", "eprint!(", "dbg!("].iter().any(|name| code.join("\n").contains(name))
}

#[test]
fn no_source_writes_a_stream_by_a_macro_that_panics() {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { walk(&path, found) } else { found.push(path) }
        }
    }
    let mut files = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    files.retain(|file| file.extension().is_some_and(|e| e == "rs"));
    assert!(files.len() > 100);
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(!writes(&text), "{}: write by src/cli/streams.rs", file.display());
    }
    assert!(writes("eprintln!(\"x\");") && writes("x => print!(\"y\")") && !writes("// println!(1)"), "control");
}
