//! What bounds a process's memory, and jobs that do not fit.

use super::*;
use stiffmap::resources::{Room, admit, room, room_below};

/// A file below a folder that stands for the root of the file system.
fn put(root: &Path, path: &str, text: &str) {
    let file = root.join(path);
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(file, text).unwrap();
}

fn machine_of_8_gb() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    put(root.path(), "proc/meminfo", "MemTotal: 9000000 kB\nMemAvailable:    8000000 kB\n");
    root
}

#[test]
fn the_machine_alone_bounds_where_nothing_else_does() {
    let root = machine_of_8_gb();
    assert_eq!(room_below(root.path()), Some(Room { bytes: 8_192_000_000, limit: "the machine".into() }));
    assert_eq!(room_below(&root.path().join("nothing")), None, "where nothing is known nothing is refused");
    assert!(room().is_none_or(|room| room.bytes > 0));
}

#[test]
fn a_group_of_version_2_bounds_by_its_own_limit_or_that_of_one_around_it() {
    let root = machine_of_8_gb();
    let put = |path: &str, text: &str| put(root.path(), path, text);
    put("proc/self/cgroup", "0::/batch/job_7/step\n");
    put("proc/self/mountinfo", "31 23 0:28 / /sys/fs/cgroup rw - cgroup2 cgroup2 rw,nsdelegate\n");
    put("sys/fs/cgroup/batch/job_7/step/memory.max", "max\n");
    put("sys/fs/cgroup/batch/job_7/memory.max", "3000000000\n");
    put("sys/fs/cgroup/batch/job_7/memory.current", "1200000000\n");
    // Pages of files are given up when memory is asked for.
    put("sys/fs/cgroup/batch/job_7/memory.stat", "anon 700000000\ninactive_file 200000000\n");
    let found = room_below(root.path()).unwrap();
    assert_eq!((found.bytes, &*found.limit), (2_000_000_000, "the control group /batch/job_7"));
    // Control: without that limit the machine's counts again.
    put("sys/fs/cgroup/batch/job_7/memory.max", "max\n");
    assert_eq!(room_below(root.path()).unwrap().limit, "the machine");
}

#[test]
fn a_group_of_version_1_bounds_seen_from_inside_a_container_too() {
    let root = machine_of_8_gb();
    let put = |path: &str, text: &str| put(root.path(), path, text);
    // The mount shows a part of the tree; the path is told from the root of the whole.
    put("proc/self/cgroup", "4:cpu:/x\n9:memory:/docker/abc/job\n0::/\n");
    put("proc/self/mountinfo", "35 31 0:32 /docker/abc /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n");
    put("sys/fs/cgroup/memory/memory.limit_in_bytes", "1500000000\n");
    put("sys/fs/cgroup/memory/memory.usage_in_bytes", "500000000\n");
    put("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "9223372036854771712\n");
    assert_eq!(room_below(root.path()).unwrap().bytes, 1_000_000_000);
    put("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "600000000\n");
    put("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "100000000\n");
    assert_eq!(room_below(root.path()).unwrap().bytes, 500_000_000);
}

#[test]
fn a_limit_of_the_process_bounds() {
    let root = machine_of_8_gb();
    put(root.path(), "proc/self/status", "VmSize:  1000000 kB\nVmData:   100000 kB\n");
    let limits = |space: &str, data: &str| {
        let text = format!(
            "Limit          Soft Limit  Hard Limit  Units\nMax data size   {data}  unlimited  bytes\n\
             Max address space   {space}  unlimited  bytes\n"
        );
        put(root.path(), "proc/self/limits", &text);
        room_below(root.path()).unwrap()
    };
    assert_eq!(limits("4096000000", "unlimited").bytes, 3_072_000_000);
    let data = limits("4096000000", "1024000000");
    assert!(data.bytes == 921_600_000 && data.limit.contains("ulimit -d"), "{data:?}");
    assert_eq!(limits("unlimited", "unlimited").limit, "the machine", "control");
}

#[test]
fn a_refusal_says_both_figures_the_limit_and_what_to_do() {
    let room = Room { bytes: 4_000_000_000, limit: "the machine".into() };
    let said = admit("the job", 5_800_000_000, Some(&room), "buy memory").unwrap_err().to_string();
    assert_eq!(said, "the job takes about 5.8 GB of memory, and 4.0 GB are left by the machine; buy memory");
    assert_eq!(admit("the job", 4_000_000_000, Some(&room), ""), Ok(()));
    assert_eq!(admit("the job", u64::MAX, None, ""), Ok(()));
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_that_its_process_may_not_hold_is_refused_before_it_is_reduced_and_runs_with_more() {
    let limited = |kilobytes: u64| {
        let out = tempfile::tempdir().unwrap();
        let mut shell = Command::new("sh");
        let script = format!("ulimit -d {kilobytes}; exec \"$0\" \"$@\"");
        shell.args(["-c", &script]).arg(env!("CARGO_BIN_EXE_stiffmap")).args(["run", "--no-cache", "--no-figures"]);
        shell.args(["--position", "0", "--frequencies", "0,40", "--out"]).arg(out.path());
        let started = std::time::Instant::now();
        let output = shell.env("RAYON_NUM_THREADS", "1").output().unwrap();
        (output.status.code(), said(&output), started.elapsed().as_secs_f64())
    };
    // The bundled mill's largest part takes 1.0 GB.
    let (code, said, _) = limited(600_000);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("part \"column\"") && said.contains("ulimit -d") && said.contains("coarser mesh"), "{said}");
    let (code, said, _) = limited(3_000_000);
    assert_eq!(code, Some(0), "control: {said}");
}

#[test]
fn the_manifest_holds_what_was_foreseen_and_what_was_taken() {
    let out = tempfile::tempdir().unwrap();
    let output = run(&input("machine.toml"), out.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = std::fs::read(out.path().join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let memory = &manifest["settings"]["memory"];
    assert!(memory["foreseen_bytes"].as_u64().is_some_and(|bytes| bytes > 1_000_000), "{memory}");
    assert!(cfg!(not(target_os = "linux")) || memory["peak_bytes"].as_u64().is_some_and(|b| b > 1_000_000), "{memory}");
}
