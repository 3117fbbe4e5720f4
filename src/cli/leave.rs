//! Leaving when the user asks to.
//!
//! Long loops look at the [`stiffmap::interrupt::Interrupt`] and unwind. Some steps cannot look: one sparse
//! factorisation, one ordering, one dense eigenproblem of a large part may take seconds. So a request starts a
//! clock; where unwinding has not ended the program by then, it is ended from here, in the same state.

use super::{Exit, streams};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// How long the computation may take to unwind. The system needs as long again to take back the memory of a large job.
const PATIENCE: Duration = Duration::from_millis(100);

/// Folders of the program's own that unwinding would have removed.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Names a temporary folder that is removed when the program leaves without unwinding.
pub fn remove_too(folder: &Path) {
    FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).push(folder.to_path_buf());
}

/// Starts the clock.
pub fn soon() {
    let started = std::thread::Builder::new().spawn(|| {
        std::thread::sleep(PATIENCE);
        streams::say("error: interrupted; nothing half-written is left");
        at_once();
    });
    // Without the clock the computation unwinds in its own time.
    if let Err(error) = started {
        tracing::debug!("{error}");
    }
}

/// Ends the program without unwinding, its temporary files removed.
pub fn at_once() -> ! {
    if let Err(failures) = stiffmap::export::atomic::remove_temporaries() {
        failures.iter().for_each(|failure| streams::say(&format!("warning: {failure}")));
    }
    for folder in FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        // It is gone where unwinding came first.
        let _ = std::fs::remove_dir_all(folder);
    }
    end(Exit::Interrupted as i32)
}

/// Ends the process without the steps that libraries have registered for its end: those take away what threads that
/// still compute are using, and a job that was interrupted would end as one that crashed (one in some 60 did).
#[cfg(unix)]
fn end(code: i32) -> ! {
    unsafe extern "C" {
        /// POSIX; ends all threads at once.
        fn _exit(status: i32) -> !;
    }
    // SAFETY: it takes any number, touches no memory of ours and does not return.
    unsafe { _exit(code) }
}

/// Ends the process.
#[cfg(not(unix))]
fn end(code: i32) -> ! {
    std::process::exit(code)
}
