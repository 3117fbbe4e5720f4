//! A fault of the program itself: what to say when an assertion fails that no input should be able to break.
//!
//! The computation unwinds, in whichever thread it happens, so that every file written aside is removed. The user
//! is told that it is not his input, and what we need to find it.

use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

/// What failed first, and where; later ones follow from it.
static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// Notes the first failure in place of printing each thread's.
fn note(info: &PanicHookInfo<'_>) {
    let payload = info.payload();
    let said = payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let said = said.unwrap_or("no message");
    let place = info.location().map_or_else(|| "an unknown place".into(), |at| format!("{}:{}", at.file(), at.line()));
    FIRST.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(format!("{said} ({place})"));
}

/// Runs a job; a failed assertion in it comes back as the text to tell.
///
/// # Errors
/// The text, where the job ended by a fault of the program.
pub fn caught<T>(job: impl FnOnce() -> T) -> Result<T, String> {
    set_hook(Box::new(note));
    catch_unwind(AssertUnwindSafe(job)).map_err(|_| {
        let first = FIRST.lock().unwrap_or_else(PoisonError::into_inner).take();
        format!(
            "this is a fault of stiffmap {} and not of your input: {}; nothing half-written is left. Please report \
             this line with the command and, if you may, the machine file",
            env!("CARGO_PKG_VERSION"),
            first.as_deref().unwrap_or("no message")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_assertion_in_any_thread_comes_back_as_a_text_with_its_place() {
        let before = std::panic::take_hook();
        let here = caught(|| -> usize { panic!("one {}", 1) });
        let there = caught(|| rayon::join(|| 1, || -> usize { panic!("two") }));
        let fine = caught(|| 5);
        set_hook(before);
        let here = here.unwrap_err();
        assert!(here.contains("a fault of stiffmap") && here.contains("one 1 (src/cli/fault.rs:"), "{here}");
        assert!(there.unwrap_err().contains("two (src/cli/fault.rs:"));
        assert_eq!(fine, Ok(5), "control");
    }
}
