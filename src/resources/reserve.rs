//! Shares of the memory for steps that run side by side.
//!
//! A process has one memory, so there is one account of it. A step says beforehand what it will take. It goes on at
//! once while everything fits; it waits for the others where it would fit alone; and it is refused where it would
//! not.

use super::{NoMemory, Room, Size, admit, room};
use crate::interrupt::Interrupt;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Share of the room that is given out, in hundredths: estimates are some per cent off, and files need buffers.
const GIVEN_OUT: u64 = 95;
/// How often a step that waits looks whether the user has asked to stop.
const LOOK: Duration = Duration::from_millis(100);

struct Account {
    /// Bytes given out now, to how many steps.
    given: u64,
    steps: usize,
    /// What there was when none was given out.
    room: Option<Room>,
    /// Bytes in use then, and the most that was ever expected with what was given out.
    base: u64,
    foreseen: u64,
}

static ACCOUNT: Mutex<Account> = Mutex::new(Account { given: 0, steps: 0, room: None, base: 0, foreseen: 0 });
static RETURNED: Condvar = Condvar::new();

fn account() -> MutexGuard<'static, Account> {
    ACCOUNT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A share, which is given back when it is dropped.
#[derive(Debug)]
pub struct Share(u64);

impl Drop for Share {
    fn drop(&mut self) {
        let mut account = account();
        account.given -= self.0;
        account.steps -= 1;
        RETURNED.notify_all();
    }
}

/// The largest memory that steps were expected to bring this process to, bytes; 0 if none asked.
pub fn foreseen() -> u64 {
    account().foreseen
}

/// A share of `need` bytes for the step `what`; waits until it fits beside the shares of others. `None` if the user
/// asked to stop meanwhile.
///
/// # Errors
/// [`NoMemory`] where it does not fit alone.
pub fn reserve(what: &str, need: u64, advice: &str, interrupt: Option<&Interrupt>) -> Result<Option<Share>, NoMemory> {
    let mut account = account();
    loop {
        if account.steps == 0 {
            account.room = room().map(|room| Room { bytes: room.bytes / 100 * GIVEN_OUT, ..room });
            account.base = super::used().unwrap_or(0);
        }
        let alone = admit(what, need, account.room.as_ref(), advice);
        // Beside others the room is a little short of what it will be; far beyond it there is nothing to wait for.
        let hopeless = account.room.as_ref().is_some_and(|room| need > room.bytes.saturating_add(room.bytes / 8));
        if account.steps == 0 || hopeless {
            alone?;
        }
        let left = account.room.as_ref().map_or(u64::MAX, |room| room.bytes.saturating_sub(account.given));
        if need <= left {
            account.given += need;
            account.steps += 1;
            account.foreseen = account.foreseen.max(account.base + account.given);
            return Ok(Some(Share(need)));
        }
        if interrupt.is_some_and(Interrupt::requested) {
            return Ok(None);
        }
        tracing::info!("{what} waits for {} of memory", Size(need));
        account = RETURNED.wait_timeout(account, LOOK).unwrap_or_else(PoisonError::into_inner).0;
    }
}
