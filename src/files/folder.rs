//! A result folder: written by one job at a time, and whole if and only if it holds a manifest.
//!
//! 1. [`ResultFolder::open`] locks the folder with a lock of the operating system, which ends with its process however
//!    that ends. A second job is told at once who holds it. Nothing of an earlier result is touched yet.
//! 2. [`ResultFolder::begin`], before the first file takes its place: the old manifest goes first, then the files that it
//!    lists and those that killed jobs left. Only files that this program wrote are removed.
//! 3. The job writes its files, [`ResultFolder::sync`] puts them on the disk, and the manifest comes last.
//! 4. [`ResultFolder::finish`] puts the manifest on the disk and gives the folder back.
//!
//! The lock is the file `.stiffmap.lock`, which also lists what the job has begun to write. It is there while a job
//! runs, and after one that did not finish.

use super::aside::{close_journal, folder_of, goes, open_journal, stays};
use super::holder::{file_lines, files, holder, job_line};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

/// Name of the manifest in a result folder; it is written last, so a folder without it holds no whole result.
pub const MANIFEST: &str = "manifest.json";
/// Name of the record of a sweep or a search, which stands in its folder before the first row.
pub const SWEEP_RECORD: &str = "sweep.json";
/// Name of lock and journal.
const LOCK: &str = ".stiffmap.lock";
/// How often, and how far apart, the line of a job that has just locked a folder is looked for.
const LOOKS: (usize, Duration) = (10, Duration::from_millis(10));

/// Why a folder is not written to, or not read.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb.
        action: &'static str,
        /// The reason given.
        source: std::io::Error,
    },
    /// Another job writes the folder.
    #[error("{}: another job writes this folder: {holder}; wait for it, or choose another folder with --out", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
        /// Process, command and since when.
        holder: String,
    },
    /// The folder holds something that this job may not replace.
    #[error("{}: {holds}; it is not replaced: choose another folder with --out, or remove it", path.display())]
    Taken {
        /// The file that says so.
        path: PathBuf,
        /// What is there.
        holds: String,
    },
    /// The job that wrote the folder did not come to its end.
    #[error("{}: no {MANIFEST} is there, so the job that wrote the folder did not finish; {advice}", path.display())]
    Unfinished {
        /// The folder.
        path: PathBuf,
        /// What to do.
        advice: &'static str,
    },
}

impl FolderError {
    /// Whether the choice of the folder is to blame.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}

fn io(path: &Path, action: &'static str) -> impl Fn(std::io::Error) -> FolderError {
    move |source| FolderError::Io { path: path.to_path_buf(), action, source }
}

/// A result folder that this process may write.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    lock: File,
    /// Files of jobs that did not finish.
    left: Vec<String>,
    begun: bool,
    finished: bool,
}

impl ResultFolder {
    /// Makes the folder if it is missing and locks it for a command such as `run`; `line` is the whole command line.
    ///
    /// # Errors
    /// [`FolderError::InUse`]; [`FolderError::Taken`] if the folder holds the result of another command, an unfinished
    /// sweep, or a manifest that is not this program's; [`FolderError::Io`].
    pub fn open(path: &Path, command: &str, line: &str) -> Result<Self, FolderError> {
        std::fs::create_dir_all(path).map_err(io(path, "make the folder"))?;
        let name = path.join(LOCK);
        let mut lock = loop {
            let file =
                OpenOptions::new().read(true).append(true).create(true).open(&name).map_err(io(&name, "open"))?;
            match file.try_lock() {
                // The job before may have removed the file between the opening and the lock.
                Ok(()) if is_at(&file, &name) => break file,
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(FolderError::InUse { path: path.to_path_buf(), holder: holder_of(file) });
                }
                Err(TryLockError::Error(source)) => return Err(io(&name, "lock")(source)),
            }
        };
        let mut text = String::new();
        lock.seek(SeekFrom::Start(0)).map_err(io(&name, "read"))?;
        lock.read_to_string(&mut text).map_err(io(&name, "read"))?;
        let folder = Self { path: path.to_path_buf(), lock, left: files(&text), begun: false, finished: false };
        folder.check_taken(command)?;
        let temporary =
            |name: &&String| name.rsplit('/').next().is_some_and(|n| n.starts_with('.') && n.ends_with(".tmp"));
        folder.left.iter().filter(temporary).try_for_each(|name| folder.remove_own(name))?;
        folder.append(&job_line(line))?;
        open_journal(path, folder.lock.try_clone().map_err(io(&name, "open"))?);
        // Until something is begun, a job that a signal ends leaves the folder as it was.
        if folder.left.is_empty() {
            goes(&name);
        }
        Ok(folder)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn append(&self, text: &str) -> Result<(), FolderError> {
        (&self.lock).write_all(text.as_bytes()).map_err(io(&self.path.join(LOCK), "write"))
    }

    fn check_taken(&self, command: &str) -> Result<(), FolderError> {
        let taken = |name: &str, holds: String| Err(FolderError::Taken { path: self.path.join(name), holds });
        match read_manifest(&self.path)? {
            Some(None) => return taken(MANIFEST, "a manifest that stiffmap did not write is there".into()),
            Some(Some(found)) => match found.command {
                Some(other) if other != command => {
                    return taken(MANIFEST, format!("the result of `stiffmap {other}` is there"));
                }
                _ => {}
            },
            None => {}
        }
        let keeps = ["sweep", "optimise"].contains(&command);
        if !keeps && self.path.join(SWEEP_RECORD).exists() {
            return taken(SWEEP_RECORD, "the table of a sweep or a search is there".into());
        }
        Ok(())
    }

    /// Takes the old result away, but for the files to keep; the first call alone does something.
    ///
    /// # Errors
    /// [`FolderError::Io`].
    pub fn begin(&mut self, keep: &[&str]) -> Result<(), FolderError> {
        if self.begun {
            return Ok(());
        }
        let mut old = std::mem::take(&mut self.left);
        if let Some(Some(found)) = read_manifest(&self.path)? {
            old.extend(found.files);
        }
        old.retain(|name| name != MANIFEST);
        old.sort();
        old.dedup();
        // Listed before the manifest goes: a job that is killed in between leaves no file that nobody knows.
        self.append(&file_lines(&old))?;
        self.lock.sync_data().map_err(io(&self.path.join(LOCK), "write"))?;
        self.begun = true;
        stays(&self.path.join(LOCK));
        remove(&self.path.join(MANIFEST))?;
        sync_folder(&self.path)?;
        old.iter().filter(|name| !keep.contains(&name.as_str())).try_for_each(|name| self.remove_own(name))
    }

    /// Removes a file that this program wrote into the folder; nothing outside it, and no link, is touched.
    fn remove_own(&self, name: &str) -> Result<(), FolderError> {
        let relative = Path::new(name);
        let inside = relative.components().all(|part| matches!(part, Component::Normal(_)));
        let file = self.path.join(relative);
        let plain = std::fs::symlink_metadata(&file).is_ok_and(|metadata| metadata.is_file());
        let real = |path: &Path| path.canonicalize().ok();
        let below = file.parent().and_then(real).zip(real(&self.path)).is_some_and(|(a, b)| a.starts_with(b));
        if !(inside && plain && below) {
            return Ok(());
        }
        remove(&file)?;
        // Folders of ours that are empty now; one that is not stays, which is what the failure says.
        let folders = relative.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
        for folder in folders {
            if std::fs::remove_dir(self.path.join(folder)).is_err() {
                break;
            }
        }
        Ok(())
    }

    /// Puts files of the folder on the disk, so that after a power cut too a manifest stands for whole files.
    ///
    /// # Errors
    /// [`FolderError::Io`].
    pub fn sync(&self, files: &[String]) -> Result<(), FolderError> {
        let mut folders = BTreeSet::from([self.path.clone()]);
        for file in files.iter().map(|name| self.path.join(name)).filter(|file| file.is_file()) {
            // Elsewhere than on Unix a file must be open for writing to be forced to the disk.
            let open = OpenOptions::new().read(true).write(!cfg!(unix)).open(&file).map_err(io(&file, "open"))?;
            open.sync_data().map_err(io(&file, "write"))?;
            folders.insert(folder_of(&file).to_path_buf());
        }
        folders.iter().try_for_each(|folder| sync_folder(folder))
    }

    /// Puts the manifest, which the job has written, on the disk and gives the folder back.
    ///
    /// # Errors
    /// [`FolderError::Io`].
    pub fn finish(mut self) -> Result<(), FolderError> {
        let manifest = self.path.join(MANIFEST);
        let file = OpenOptions::new().read(true).write(!cfg!(unix)).open(&manifest).map_err(io(&manifest, "open"))?;
        file.sync_all().map_err(io(&manifest, "write"))?;
        sync_folder(&self.path)?;
        self.finished = true;
        Ok(())
    }

    /// Refuses a folder that holds no whole result.
    ///
    /// # Errors
    /// [`FolderError::Unfinished`] with the advice.
    pub fn check_finished(path: &Path, advice: &'static str) -> Result<(), FolderError> {
        match path.join(MANIFEST).is_file() {
            true => Ok(()),
            false => Err(FolderError::Unfinished { path: path.to_path_buf(), advice }),
        }
    }
}

impl Drop for ResultFolder {
    fn drop(&mut self) {
        close_journal(&self.path);
        stays(&self.path.join(LOCK));
        // What an unfinished job began stays listed for the next one, unless a manifest lists it. Elsewhere than on Unix an
        // open file keeps its name.
        let listed = self.left.is_empty() || self.path.join(MANIFEST).exists();
        if cfg!(unix) && (self.finished || !self.begun && listed) {
            // A file that stays is an empty lock, which holds nobody up.
            let _ = std::fs::remove_file(self.path.join(LOCK));
        } else if self.finished {
            // The lists of a finished job are those of its manifest.
            let _ = self.lock.set_len(0);
        }
    }
}

/// The part of a manifest that says what may be removed.
struct Found {
    command: Option<String>,
    files: Vec<String>,
}

/// The manifest of a folder: none, one that is not this program's, or what it lists.
fn read_manifest(folder: &Path) -> Result<Option<Option<Found>>, FolderError> {
    let path = folder.join(MANIFEST);
    let text = match std::fs::read(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(io(&path, "read")(error)),
    };
    let found = serde_json::from_slice::<serde_json::Value>(&text).ok().and_then(|value| {
        let ours = value.get("version").is_some() && value.get("input_hashes").is_some();
        let files = value.get("files")?.as_array()?.iter().filter_map(|f| f.as_str().map(str::to_owned)).collect();
        let command = value.get("command").and_then(|c| c.as_str()).filter(|c| !c.is_empty()).map(str::to_owned);
        ours.then_some(Found { command, files })
    });
    Ok(Some(found))
}

/// Who holds a lock; a job that has just taken it is given a moment to write its line.
fn holder_of(mut file: File) -> String {
    let (looks, apart) = LOOKS;
    for _ in 0..looks {
        let mut text = String::new();
        if file.seek(SeekFrom::Start(0)).is_err() || file.read_to_string(&mut text).is_err() {
            break;
        }
        if text.lines().any(|line| line.starts_with("job ")) {
            return holder(&text);
        }
        std::thread::sleep(apart);
    }
    holder("")
}

/// Whether a path still names an open file.
fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let key = |m: std::fs::Metadata| (m.dev(), m.ino());
        file.metadata().map(key).ok().zip(std::fs::metadata(path).map(key).ok()).is_some_and(|(a, b)| a == b)
    }
    #[cfg(not(unix))]
    {
        // Elsewhere the file is never removed.
        let _ = (file, path);
        true
    }
}

fn remove(file: &Path) -> Result<(), FolderError> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(io(file, "remove")(error)),
        _ => Ok(()),
    }
}

/// Puts renames and removals in a folder on the disk.
fn sync_folder(folder: &Path) -> Result<(), FolderError> {
    #[cfg(unix)]
    {
        File::open(folder).and_then(|f| f.sync_all()).map_err(io(folder, "write"))
    }
    #[cfg(not(unix))]
    {
        // Folders cannot be opened there; renames are journalled by the file system.
        let _ = folder;
        Ok(())
    }
}
