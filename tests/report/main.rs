//! The report page in a real browser, its local coordinates, the parts' skins, and the files for ParaView.

#[path = "../support/mod.rs"]
mod support;

mod browser;
mod commands;
mod local;
mod page;
mod skins;
mod vtk;
mod what_if;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// A folder of this test binary's own, emptied when first asked for.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// `stiffmap` with the given arguments, which must succeed.
fn stiffmap(arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    if std::env::var_os("STIFFMAP_CACHE").is_none() {
        command.env("STIFFMAP_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-cache"));
    }
    let run = command.args(arguments).output().unwrap();
    assert!(run.status.success(), "stiffmap {arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
}

/// The bundled mill's results with pictures and page, computed once.
fn mill() -> &'static Path {
    static MILL: OnceLock<PathBuf> = OnceLock::new();
    MILL.get_or_init(|| {
        let out = folder("mill");
        stiffmap(&["run", "--out", out.to_str().unwrap()]);
        out
    })
}
