//! A long step for each of a few items, on threads of its own.

use super::PipelineError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Results of a step for each item, computed by as many threads as rayon has.
///
/// The threads are not rayon's: one of those, while it waits for a product that others finish, would begin another
/// part in between, and hold the memory of both. The first error ends the rest, and is the one that is told: what it
/// stopped says only that it was stopped.
pub(super) fn side_by_side<T: Send>(
    items: &[usize],
    one: &(dyn Fn(&usize) -> Result<T, PipelineError> + Sync),
) -> Result<Vec<T>, PipelineError> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || {
        let mut found = Vec::new();
        while !failed.load(Ordering::Relaxed)
            && let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed))
        {
            let made = one(item);
            failed.fetch_or(made.is_err(), Ordering::Relaxed);
            found.push(made);
        }
        found
    };
    let threads = rayon::current_num_threads().min(items.len());
    let all: Vec<_> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        started.into_iter().map(|thread| thread.join()).collect()
    });
    let whole = |made: std::thread::Result<Vec<_>>| made.unwrap_or_else(|fault| std::panic::resume_unwind(fault));
    let (mut found, mut stopped) = (Vec::with_capacity(items.len()), Ok(()));
    for made in all.into_iter().flat_map(whole) {
        match made {
            Err(PipelineError::Interrupted) => stopped = Err(PipelineError::Interrupted),
            made => found.push(made?),
        }
    }
    stopped.map(|()| found)
}
