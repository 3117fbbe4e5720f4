//! Files that are there whole or not at all.
//!
//! A file is written under a temporary name in its own folder and renamed when complete
//! ([`crate::files::aside`]). The rename replaces an older file in one step, so a reader sees the old or the new
//! content. The temporary is removed on errors and panics.
//!
//! What is no plain file is never replaced by one. A link stays, and the file that it leads to is replaced. A device
//! that takes characters and a pipe are written through, since they have no content that could be kept. Everything
//! else is refused.

use std::fs::{File, FileType, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::ExportError;
use crate::files::aside::{self, Aside, folder_of};

/// Writer that [`write_atomic`] hands out.
pub type FileWriter = BufWriter<File>;

/// Bytes collected before they are handed to the system.
const BUFFER: usize = 1 << 18;

/// A file that is being written aside. It takes its place with [`AtomicFile::commit`]; dropped before, it is removed.
pub struct AtomicFile {
    path: PathBuf,
    writer: FileWriter,
    /// The temporary and the name that it takes; none where the file is written through.
    aside: Option<(Aside, PathBuf)>,
}

/// Where the bytes of an output go.
enum Destination {
    /// To a file of this name, aside first.
    File(PathBuf),
    /// To what is there, as they come.
    Through,
}

impl AtomicFile {
    /// Begins a file. The folder of `path` is made where it is missing.
    ///
    /// # Errors
    /// [`ExportError::Io`] if the folder or the temporary cannot be made, or `path` is something that is neither
    /// replaced nor written through.
    pub fn create(path: &Path) -> Result<AtomicFile, ExportError> {
        std::fs::create_dir_all(folder_of(path)).map_err(io(path, "make the folder of"))?;
        let (file, aside) = match destination(path).map_err(io(path, "write"))? {
            Destination::File(place) => {
                let aside = Aside::beside(&place).map_err(io(path, "create"))?;
                (aside.file.try_clone().map_err(io(path, "create"))?, Some((aside, place)))
            }
            // Appended: what is there may be a plain file that a shell has opened as /dev/stdout.
            Destination::Through => (OpenOptions::new().append(true).open(path).map_err(io(path, "open"))?, None),
        };
        Ok(AtomicFile { path: path.to_path_buf(), writer: BufWriter::with_capacity(BUFFER, file), aside })
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
        let AtomicFile { path, mut writer, aside } = self;
        writer.flush().map_err(io(&path, "write"))?;
        drop(writer.into_inner().map_err(|e| io(&path, "write")(e.into_error()))?);
        aside.map_or(Ok(()), |(aside, place)| aside.persist(&place)).map_err(io(&path, "replace"))
    }
}

/// Where the bytes for a path go.
fn destination(path: &Path) -> std::io::Result<Destination> {
    let found = match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Destination::File(path.to_path_buf())),
        found => found?,
    };
    if !found.is_symlink() {
        return of_kind(found.file_type(), path.to_path_buf());
    }
    // Links of the system to what a process has open, such as /dev/stdout.
    if ["/dev", "/proc"].iter().any(|system| path.starts_with(system)) {
        return Ok(Destination::Through);
    }
    let lost = |error| std::io::Error::other(format!("it is a link that leads nowhere ({error}); remove or mend it"));
    let real = path.canonicalize().map_err(lost)?;
    of_kind(std::fs::metadata(&real)?.file_type(), real)
}

fn of_kind(kind: FileType, place: PathBuf) -> std::io::Result<Destination> {
    if kind.is_file() {
        return Ok(Destination::File(place));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_char_device() || kind.is_fifo() {
            return Ok(Destination::Through);
        }
    }
    let what = if kind.is_dir() { "a folder" } else { "neither a plain file nor a pipe" };
    Err(std::io::Error::other(format!("it is {what}; name a file")))
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
    let failures: Vec<_> =
        aside::remove_temporaries().into_iter().map(|(path, error)| io(&path, "remove")(error)).collect();
    if failures.is_empty() { Ok(()) } else { Err(failures) }
}

/// Turns an I/O error into one that names the file and what was tried.
pub fn io(path: &Path, action: &'static str) -> impl Fn(std::io::Error) -> ExportError {
    move |source| ExportError::Io { path: path.to_path_buf(), action, source }
}
