//! Files under temporary names until they are complete.
//!
//! A signal handler that ends the process without unwinding calls [`remove_temporaries`] first. A process that is killed
//! cannot; so the temporaries and files of a result folder are also written into that folder's journal
//! ([`super::ResultFolder`]), and the next job removes them. Both lists are this module's only state outside a call.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Temporaries that exist now, for the signal handler.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// Journals of the result folders that this process writes.
static JOURNALS: Mutex<Vec<(PathBuf, File)>> = Mutex::new(Vec::new());

fn lock<T>(list: &'static Mutex<T>) -> MutexGuard<'static, T> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes a temporary off the list when its write ends, however it ends.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        lock(&LIVE).remove(&self.0);
    }
}

/// A file that is written under a temporary name in the folder of the one it becomes; dropped before
/// [`Aside::persist`], it is removed.
pub struct Aside {
    /// The file, open for writing.
    pub file: File,
    name: tempfile::TempPath,
    // After `name`: the temporary is on the list as long as it is there.
    _listed: Listed,
}

impl Aside {
    /// A hidden temporary beside a path, `.compliance.mat.<random>.tmp`, with the permissions that the umask leaves.
    ///
    /// # Errors
    /// The system's.
    pub fn beside(path: &Path) -> std::io::Result<Aside> {
        note(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".tmp");
        // Noted before it is there, so that no kill leaves one that nobody knows.
        let create = |name: &Path| {
            // By the path that the folder was opened under; `name` is absolute.
            note(&folder_of(path).join(name.file_name().unwrap_or_default()))?;
            File::options().read(true).write(true).create_new(true).open(name)
        };
        let (file, name) = builder.make_in(folder_of(path), create)?.into_parts();
        lock(&LIVE).insert(name.to_path_buf());
        let _listed = Listed(name.to_path_buf());
        Ok(Aside { file, name, _listed })
    }

    /// Closes the file and gives it its place.
    ///
    /// # Errors
    /// The system's; the temporary is then removed.
    pub fn persist(self, path: &Path) -> std::io::Result<()> {
        let Aside { file, name, _listed } = self;
        drop(file);
        name.persist(path).map_err(|error| error.error)
    }
}

/// Writes bytes aside and renames them to `path`.
///
/// # Errors
/// The system's; `path` keeps its old content.
pub fn write(path: &Path, pieces: &[&[u8]]) -> std::io::Result<()> {
    let mut aside = Aside::beside(path)?;
    pieces.iter().try_for_each(|piece| aside.file.write_all(piece))?;
    aside.persist(path)
}

/// The folder that a path lies in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Removes the temporaries of all writes under way, for a signal handler about to end the process; returns those that
/// could not be removed, with the reason.
pub fn remove_temporaries() -> Vec<(PathBuf, std::io::Error)> {
    let failure = |path: PathBuf| match std::fs::remove_file(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Some((path, error)),
        _ => None,
    };
    std::mem::take(&mut *lock(&LIVE)).into_iter().filter_map(failure).collect()
}

/// A file that goes where a signal ends the process, until [`stays`].
pub(super) fn goes(path: &Path) {
    lock(&LIVE).insert(path.to_path_buf());
}

/// Ends what [`goes`] began.
pub(super) fn stays(path: &Path) {
    lock(&LIVE).remove(path);
}

/// From now on files that are written below a folder are noted in its journal.
pub(super) fn open_journal(folder: &Path, journal: File) {
    lock(&JOURNALS).push((folder.to_path_buf(), journal));
}

/// Ends what [`open_journal`] began.
pub(super) fn close_journal(folder: &Path) {
    lock(&JOURNALS).retain(|(known, _)| known != folder);
}

/// Notes a file in the journal of the result folder that it lies in, if it lies in one.
fn note(path: &Path) -> std::io::Result<()> {
    for (folder, journal) in lock(&JOURNALS).iter_mut() {
        if let Ok(name) = path.strip_prefix(folder) {
            journal.write_all(file_line(&name.to_string_lossy()).as_bytes())?;
        }
    }
    Ok(())
}

/// A file in a journal; names hold no line breaks there.
pub(super) fn file_line(name: &str) -> String {
    if name.contains(['\n', '\r']) { String::new() } else { format!("file {name}\n") }
}
