//! The program as its user meets it: exit codes, messages, files.

mod bad_input;
mod interrupted;
mod main_job;
mod other_commands;
mod overrides;
mod readme;
mod streaming;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

/// The built binary with a cache folder of the test's own.
fn stiffmap(cache: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command.env("STIFFMAP_CACHE", cache).env_remove("STIFFMAP_ADAPTER");
    command
}

/// A cache that holds the bundled mill's superelements, filled once by the only cold run that most tests need.
fn warm_cache() -> &'static Path {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-cache");
        // One that an earlier program filled would hide what this one computes.
        if folder.exists() {
            std::fs::remove_dir_all(&folder).unwrap();
        }
        let out = tempfile::tempdir().unwrap();
        let run = run_into(&folder, out.path(), &["--no-figures", "--positions", "0"]);
        assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
        assert_eq!(superelements(&folder).len(), 5);
        folder
    })
}

/// A copy of the warm cache to be changed.
fn copied_cache() -> TempDir {
    let cache = tempfile::tempdir().unwrap();
    for file in superelements(warm_cache()) {
        std::fs::copy(&file, cache.path().join(file.file_name().unwrap())).unwrap();
    }
    cache
}

/// `stiffmap run` of the bundled mill into a folder.
fn run_into(cache: &Path, out: &Path, arguments: &[&str]) -> Output {
    let mut command = stiffmap(cache);
    command.arg("run").args(arguments).arg("--out").arg(out);
    command.output().unwrap()
}

/// A quick run of the bundled mill from the warm cache that must succeed; its manifest.
fn quick(out: &Path, arguments: &[&str]) -> Value {
    let run = run_into(warm_cache(), out, &[&["--no-figures"], arguments].concat());
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    manifest(out)
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn manifest(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap()
}

/// Superelements in a cache, in the order of their names.
fn superelements(cache: &Path) -> Vec<PathBuf> {
    let files = files_below(cache).into_iter();
    let kept = files.filter(|f| f.extension().is_some_and(|e| e == "superelement"));
    kept.map(|f| cache.join(f)).collect()
}

/// All files below a folder, relative to it, in order; none if the folder is missing.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    fn walk(folder: &Path, root: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, root, found);
            } else {
                found.push(path.strip_prefix(root).unwrap().to_path_buf());
            }
        }
    }
    let mut found = Vec::new();
    if folder.exists() {
        walk(folder, folder, &mut found);
    }
    found.sort();
    found
}

/// A column of a CSV file as numbers.
fn column(file: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let at = reader.headers().unwrap().iter().position(|h| h == name);
    let at = at.unwrap_or_else(|| panic!("{}: no column {name}", file.display()));
    reader.records().map(|record| record.unwrap()[at].parse().unwrap()).collect()
}

/// The bundled mill written out to be edited.
struct Mill(TempDir);

impl Mill {
    fn new() -> Mill {
        let folder = tempfile::tempdir().unwrap();
        let init = stiffmap(folder.path()).arg("init").arg(folder.path()).output();
        assert_eq!(init.unwrap().status.code(), Some(0));
        Mill(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Replaces the first occurrence of a text, which must be there.
    fn replace(&self, name: &str, old: &str, new: &str) {
        let text = std::fs::read_to_string(self.file(name)).unwrap();
        assert!(text.contains(old), "{name} holds no {old:?}");
        std::fs::write(self.file(name), text.replacen(old, new, 1)).unwrap();
    }

    /// Passes the text of a file through a function.
    fn edit(&self, name: &str, change: impl FnOnce(String) -> String) {
        let text = std::fs::read_to_string(self.file(name)).unwrap();
        std::fs::write(self.file(name), change(text)).unwrap();
    }
}
