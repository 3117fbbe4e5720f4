//! The script of docs/distributed.md on a real cluster of two worker processes.

use super::*;

#[test]
#[cfg(unix)]
fn a_dask_cluster_that_loses_a_worker_gives_the_table_of_one_run() {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return;
    }
    let python = std::env::var("STIFFMAP_PYTHON").unwrap_or_else(|_| {
        panic!("STIFFMAP_PYTHON names no Python; set it to one that has distributed, or set STIFFMAP_PYTHON_TESTS=skip")
    });
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = folder_with(STUDY);
    let expected = reference();
    let mut command = Command::new(python);
    command.arg(root.join("tests/sweep/dask_kill.py")).arg(root.join("docs")).arg(env!("CARGO_BIN_EXE_stiffmap"));
    command.args(["study.toml", "dask", "6"]).current_dir(folder.path());
    command.env("STIFFMAP_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep-cache"));
    command.env("DASK_DISTRIBUTED__COMM__RETRY__COUNT", "3").env("RAYON_NUM_THREADS", "1");
    let run = command.output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    assert_eq!(String::from_utf8_lossy(&run.stdout).trim(), "killed 1");
    assert_eq!(table(folder.path(), "dask/whole"), expected);
    for shard in 1..=6 {
        assert_ne!(
            table(folder.path(), &format!("dask/shard_{shard:04}")),
            expected,
            "control: a shard is not the whole"
        );
    }
}
