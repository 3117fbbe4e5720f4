//! How much memory a job may still take, and what it needs: asked before anything long starts.
//!
//! Four things bound a process on Linux, and the smallest counts: the memory that the machine has available, the
//! limit of each control group that the process is in (a container, a batch job, a service; every group up to the
//! root has a limit of its own, in version 1 and in version 2), and the limits of the process itself (`ulimit -v`,
//! `ulimit -d`). All are read from `/proc` and `/sys`; where they do not exist nothing is known and nothing is
//! refused.
//!
//! Source: Linux, Documentation/admin-guide/cgroup-v1/memory.rst and cgroup-v2.rst; proc(5).

mod reserve;

pub use reserve::{Share, foreseen, reserve};

use std::fmt;
use std::path::{Path, PathBuf};

/// Limits of control groups from here on (bytes) stand for none.
const NONE: u64 = 1 << 60;

/// Bytes that a process can still take, and what says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// Bytes.
    pub bytes: u64,
    /// The limit, such as `the control group /batch/job_7`.
    pub limit: String,
}

/// A job that needs more than there is.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{what} takes about {} of memory, and {} are left by {limit}; {advice}", Size(*.need), Size(*.left)
)]
pub struct NoMemory {
    /// What needs it.
    pub what: String,
    /// Bytes needed.
    pub need: u64,
    /// Bytes left.
    pub left: u64,
    /// What limits them.
    pub limit: String,
    /// What to do.
    pub advice: String,
}

/// Bytes in words: `640 MB`, `5.8 GB`.
#[derive(Clone, Copy, Debug)]
pub struct Size(pub u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.0 as f64;
        if bytes < 1e9 { write!(f, "{:.0} MB", bytes / 1e6) } else { write!(f, "{:.1} GB", bytes / 1e9) }
    }
}

/// Refuses what does not fit into the room that there is; where nothing is known of it, nothing is refused.
///
/// # Errors
/// [`NoMemory`] with both figures and the advice.
pub fn admit(what: &str, need: u64, room: Option<&Room>, advice: &str) -> Result<(), NoMemory> {
    match room {
        Some(room) if need > room.bytes => Err(NoMemory {
            what: what.to_owned(),
            need,
            left: room.bytes,
            limit: room.limit.clone(),
            advice: advice.to_owned(),
        }),
        _ => Ok(()),
    }
}

/// What a thread that multiplies dense matrices sets aside for itself, bytes. Little of it is ever touched, but the
/// limits of a process count it all.
const BUFFER_OF_A_THREAD: u64 = 64 << 20;
/// Threads beside those of the pool that multiply: the main one, and those that reduce parts.
const OTHER_THREADS: u64 = 2;

/// The room of this process now, less what its threads still set aside where a limit counts that; `None` where the system
/// does not say.
pub fn room() -> Option<Room> {
    let threads = rayon::current_num_threads() as u64 + OTHER_THREADS;
    smallest(Path::new("/"), threads * BUFFER_OF_A_THREAD)
}

/// The largest memory that this process has held so far, bytes; `None` where the system does not say.
pub fn peak() -> Option<u64> {
    kilobytes(&read(Path::new("/proc/self/status"))?, "VmHWM:")
}

/// The memory that this process holds now, bytes.
fn used() -> Option<u64> {
    kilobytes(&read(Path::new("/proc/self/status"))?, "VmRSS:")
}

/// The room with `/proc` and `/sys` below another folder.
pub fn room_below(root: &Path) -> Option<Room> {
    smallest(root, 0)
}

fn smallest(root: &Path, set_aside: u64) -> Option<Room> {
    let mut rooms = Vec::new();
    if let Some(bytes) = read(&root.join("proc/meminfo")).and_then(|text| kilobytes(&text, "MemAvailable:")) {
        rooms.push(Room { bytes, limit: "the machine".to_owned() });
    }
    rooms.extend(groups(root));
    rooms.extend(of_process(root).into_iter().map(|r| Room { bytes: r.bytes.saturating_sub(set_aside), ..r }));
    rooms.into_iter().min_by_key(|room| room.bytes)
}

fn read(path: &Path) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The value of a line such as `MemAvailable:  24003988 kB`, bytes.
fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

/// What is left of the process's own limits on address space and data.
fn of_process(root: &Path) -> Vec<Room> {
    let (Some(limits), Some(status)) = (read(&root.join("proc/self/limits")), read(&root.join("proc/self/status")))
    else {
        return Vec::new();
    };
    let one = |(name, used, said): (&str, &str, &str)| {
        let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
        let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
        let bytes = limit.saturating_sub(kilobytes(&status, used)?);
        Some(Room { bytes, limit: format!("the process's limit on {said}") })
    };
    let all = [
        ("Max address space", "VmSize:", "address space (ulimit -v)"),
        ("Max data size", "VmData:", "data (ulimit -d)"),
    ];
    all.into_iter().filter_map(one).collect()
}

/// What is left in the memory of every control group that the process is in, up to the root.
fn groups(root: &Path) -> Vec<Room> {
    let own = read(&root.join("proc/self/cgroup")).unwrap_or_default();
    let mounts = read(&root.join("proc/self/mountinfo")).unwrap_or_default();
    let mut rooms = Vec::new();
    for line in own.lines() {
        // `0::/batch/job_7` in version 2, `9:memory:/batch/job_7` in version 1.
        let mut fields = line.splitn(3, ':');
        let (_, Some(controllers), Some(path)) = (fields.next(), fields.next(), fields.next()) else { continue };
        let version = match controllers {
            "" => &V2,
            list if list.split(',').any(|c| c == "memory") => &V1,
            _ => continue,
        };
        for (point, below) in mounts.lines().filter_map(|line| mount(line, version)) {
            // What is mounted may be a part of the tree, as in a container; then the path begins in it.
            let inside = Path::new(path).strip_prefix(&below).or_else(|_| Path::new(path).strip_prefix("/"));
            let top = root.join(point.strip_prefix("/").unwrap_or(&point));
            let start = top.join(inside.unwrap_or(Path::new("")));
            let folders = start.ancestors().take_while(|folder| folder.starts_with(&top));
            rooms.extend(folders.filter_map(|folder| group(folder, &top, version)));
        }
    }
    rooms
}

/// How a version of control groups names its files.
struct Version {
    kind: &'static str,
    limit: &'static str,
    used: &'static str,
    /// Pages of files that are given up when memory is asked for; they count as used.
    cache: &'static str,
}

const V1: Version = Version {
    kind: "cgroup",
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    cache: "total_inactive_file",
};
const V2: Version = Version { kind: "cgroup2", limit: "memory.max", used: "memory.current", cache: "inactive_file" };

/// Mount point of a hierarchy and the part of it that is mounted, from a line of mountinfo.
fn mount(line: &str, version: &Version) -> Option<(PathBuf, PathBuf)> {
    let (mount, system) = line.split_once(" - ")?;
    let mut system = system.split(' ');
    if system.next()? != version.kind {
        return None;
    }
    let options = system.nth(1).unwrap_or_default();
    if version.kind == V1.kind && !options.split(',').any(|option| option == "memory") {
        return None;
    }
    let mut fields = mount.split(' ').skip(3);
    let (below, point) = (fields.next()?, fields.next()?);
    Some((PathBuf::from(point), PathBuf::from(below)))
}

/// What is left in one group; `None` without a limit.
fn group(folder: &Path, top: &Path, version: &Version) -> Option<Room> {
    let number = |name: &str| read(&folder.join(name))?.trim().parse::<u64>().ok();
    let limit = number(version.limit).filter(|limit| *limit < NONE)?;
    let stat = read(&folder.join("memory.stat")).unwrap_or_default();
    let of_cache = |line: &str| line.strip_prefix(version.cache)?.trim().parse::<u64>().ok();
    let cache = stat.lines().find_map(of_cache).unwrap_or(0);
    let used = number(version.used).unwrap_or(0).saturating_sub(cache);
    let name = folder.strip_prefix(top).unwrap_or(folder).display().to_string();
    Some(Room { bytes: limit.saturating_sub(used), limit: format!("the control group /{name}") })
}
