//! Files that are there whole or not at all.
//!
//! A file is written under a temporary name in its own folder and renamed when complete. The
//! rename replaces an older file in one step, so a reader sees the old or the new content. The
//! temporary is removed on errors and panics. A signal handler that ends the process without
//! unwinding calls [`remove_temporaries`] first; the list it reads is this module's only state
//! outside a call.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::ExportError;

/// Temporaries that exist now, for the signal handler.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn live() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes a temporary off the list when its write ends, however it ends.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        live().remove(&self.0);
    }
}

/// Writer that [`write_atomic`] hands out.
pub type FileWriter = BufWriter<File>;

/// A file that is being written aside. It takes its place with [`AtomicFile::commit`]; dropped before, it is removed.
pub struct AtomicFile {
    path: PathBuf,
    writer: FileWriter,
    name: tempfile::TempPath,
    // After `name`: the temporary is on the list as long as it is there.
    _listed: Listed,
}

impl AtomicFile {
    /// Begins a file. The folder of `path` is made where it is missing.
    ///
    /// # Errors
    /// [`ExportError::Io`] if the folder or the temporary cannot be made.
    pub fn create(path: &Path) -> Result<AtomicFile, ExportError> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(folder).map_err(io(path, "make the folder of"))?;
        let (file, name) = temporary_beside(path, folder)?.into_parts();
        live().insert(name.to_path_buf());
        let _listed = Listed(name.to_path_buf());
        Ok(AtomicFile { path: path.to_path_buf(), writer: BufWriter::with_capacity(1 << 18, file), name, _listed })
    }

    /// The path that the file will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes bytes.
    ///
    /// # Errors
    /// [`ExportError::Io`] with the file and the reason.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), ExportError> {
        self.writer.write_all(bytes).map_err(io(&self.path, "write"))
    }

    /// Puts the file in its place.
    ///
    /// The content is handed to the operating system before the rename, not forced to the disk: an interrupted process
    /// leaves no partial file, a power cut may.
    ///
    /// # Errors
    /// [`ExportError::Io`] if the last bytes or the rename fail; the temporary is removed and the path keeps its old
    /// content.
    pub fn commit(self) -> Result<(), ExportError> {
        let AtomicFile { path, mut writer, name, _listed } = self;
        writer.flush().map_err(io(&path, "write"))?;
        drop(writer.into_inner().map_err(|e| io(&path, "write")(e.into_error()))?);
        name.persist(&path).map_err(|e| io(&path, "replace")(e.error))
    }
}

/// Writes a file aside with `write` and renames it to `path`; as [`AtomicFile`].
///
/// # Errors
/// [`ExportError::Io`] with the file and the reason if a step fails, and whatever `write` returns;
/// the temporary is removed and `path` keeps its old content.
pub fn write_atomic(
    path: &Path,
    write: impl FnOnce(&mut FileWriter) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    let mut file = AtomicFile::create(path)?;
    write(&mut file.writer)?;
    file.commit()
}

/// Writes bytes that are complete in memory; as [`write_atomic`].
///
/// # Errors
/// As [`write_atomic`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    write_atomic(path, |file| file.write_all(bytes).map_err(io(path, "write")))
}

/// Removes the temporaries of all writes under way, for a signal handler about to end the process.
///
/// # Errors
/// The temporaries that could not be removed, each with the reason.
pub fn remove_temporaries() -> Result<(), Vec<ExportError>> {
    let failures: Vec<_> = std::mem::take(&mut *live())
        .iter()
        .filter_map(|path| match std::fs::remove_file(path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Some(io(path, "remove")(e)),
            _ => None,
        })
        .collect();
    if failures.is_empty() { Ok(()) } else { Err(failures) }
}

/// Turns an I/O error into one that names the file and what was tried.
pub fn io(path: &Path, action: &'static str) -> impl Fn(std::io::Error) -> ExportError {
    move |source| ExportError::Io { path: path.to_path_buf(), action, source }
}

/// A hidden temporary beside the file, `.compliance.mat.<random>.tmp`, with ordinary permissions.
fn temporary_beside(path: &Path, folder: &Path) -> Result<tempfile::NamedTempFile, ExportError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".{name}.");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    builder.tempfile_in(folder).map_err(io(path, "create"))
}
