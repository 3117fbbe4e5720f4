//! What was read: every file that a result depends on, with the hash of the bytes that were parsed.
//!
//! A reader takes its bytes from [`Inputs::read`], which reads a file once and hashes what it hands out. The hash can
//! therefore never be that of a later version of the file. Readers return their [`Inputs`] beside what they made;
//! whoever joins them ([`Inputs::extend`]) learns of a file that two readers saw with different contents. Keys of
//! caches, `input_hashes` in the manifest and the records of sweeps are made from these hashes and from no others.

use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Why what was read is not one state of its files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InputError {
    /// A file had two contents within one job.
    #[error("{}: it changed between two readings, and a result of both would be of neither; run again once it is no longer edited", path.display())]
    TwoContents {
        /// The file.
        path: PathBuf,
    },
}

/// A file as it was read.
#[derive(Clone, Debug)]
pub struct InputFile {
    /// Its path as the reader named it.
    pub path: PathBuf,
    /// BLAKE3 of the bytes that were parsed.
    pub hash: blake3::Hash,
    /// Its path without links, so that two spellings of one file are known as one.
    real: PathBuf,
    /// The file's state when it was read; none for bytes that came from elsewhere.
    stamp: Option<Stamp>,
}

/// What tells that a file has been written to, without reading it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    node: u64,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let node = std::os::unix::fs::MetadataExt::ino(metadata);
        #[cfg(not(unix))]
        let node = 0;
        Self { length: metadata.len(), modified: metadata.modified().ok(), node }
    }
}

/// Bytes of a machine file or study, at most: what is larger is a mesh by mistake, or a device that never ends.
const LARGEST_TEXT: u64 = 16 << 20;

/// The files that were read, in the order of their reading.
#[derive(Clone, Default)]
pub struct Inputs {
    files: Vec<InputFile>,
}

impl std::fmt::Debug for Inputs {
    /// Their number alone: what was read from a file does not differ by where the file lies.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Inputs({})", self.files.len())
    }
}

impl Inputs {
    /// Reads a file whole and records it.
    ///
    /// # Errors
    /// The system's, and one of its own where the file is written to while it is read, or had other contents before.
    pub fn read(&mut self, path: &Path) -> std::io::Result<Vec<u8>> {
        self.read_up_to(path, u64::MAX)
    }

    fn read_up_to(&mut self, path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
        let mut file = File::open(path)?;
        let before = file.metadata()?;
        let mut bytes = Vec::with_capacity(usize::try_from(before.len().min(most)).unwrap_or(0));
        (&mut file).take(most.saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most {
            let problem = format!("it is larger than {} MiB", most >> 20);
            return Err(std::io::Error::new(std::io::ErrorKind::FileTooLarge, problem));
        }
        let after = Stamp::of(&file.metadata()?);
        if before.is_file() && (Stamp::of(&before) != after || bytes.len() as u64 != after.length) {
            return Err(std::io::Error::other("it is being written to; run again once it is whole"));
        }
        // A pipe has no state to come back to.
        let stamp = before.is_file().then_some(after);
        self.push(path, &bytes, stamp).map_err(std::io::Error::other)?;
        Ok(bytes)
    }

    /// As [`Inputs::read`], as text: a machine file, a study.
    ///
    /// # Errors
    /// As [`Inputs::read`]; [`std::io::ErrorKind::InvalidData`] for what is not UTF-8, and
    /// [`std::io::ErrorKind::FileTooLarge`] above 16 MiB.
    pub fn read_text(&mut self, path: &Path) -> std::io::Result<String> {
        let invalid = |_| std::io::Error::new(std::io::ErrorKind::InvalidData, "the file is not text in UTF-8");
        String::from_utf8(self.read_up_to(path, LARGEST_TEXT)?).map_err(invalid)
    }

    /// Records bytes that are in memory already; `path` is what messages call them.
    ///
    /// # Errors
    /// [`InputError::TwoContents`].
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), InputError> {
        self.push(path, bytes, None)
    }

    fn push(&mut self, path: &Path, bytes: &[u8], stamp: Option<Stamp>) -> Result<(), InputError> {
        // A path that cannot be resolved stands for itself.
        let real = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        self.take(InputFile { path: path.to_path_buf(), hash: blake3::hash(bytes), real, stamp })
    }

    fn take(&mut self, file: InputFile) -> Result<(), InputError> {
        if self.files.iter().any(|known| known.real == file.real && known.hash != file.hash) {
            return Err(InputError::TwoContents { path: file.path });
        }
        self.files.push(file);
        Ok(())
    }

    /// Takes over what another reader read.
    ///
    /// # Errors
    /// [`InputError::TwoContents`] if both read a file and saw different bytes.
    pub fn extend(&mut self, other: &Inputs) -> Result<(), InputError> {
        other.files.iter().try_for_each(|file| self.take(file.clone()))
    }

    /// The files, a file read twice standing twice.
    pub fn files(&self) -> &[InputFile] {
        &self.files
    }

    /// Hashes in hexadecimal by path relative to a folder where the file lies below it; otherwise by the path as it was
    /// named. Each file once, so two files of one name in two folders are two.
    pub fn named(&self, folder: &Path) -> Vec<(String, String)> {
        let mut named: Vec<(String, String)> = Vec::new();
        for file in &self.files {
            let name = file.path.strip_prefix(folder).unwrap_or(&file.path).to_string_lossy().replace('\\', "/");
            if named.iter().all(|(seen, _)| *seen != name) {
                named.push((name, file.hash.to_hex().to_string()));
            }
        }
        named
    }

    /// Files that have been written to, replaced or removed since they were read.
    pub fn changed(&self) -> Vec<&Path> {
        let now = |file: &InputFile| std::fs::metadata(&file.path).ok().map(|m| Stamp::of(&m));
        let changed = self.files.iter().filter(|file| file.stamp.is_some() && now(file) != file.stamp);
        let mut paths: Vec<&Path> = changed.map(|file| file.path.as_path()).collect();
        paths.dedup();
        paths
    }
}
