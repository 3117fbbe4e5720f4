//! A request to stop, set by Ctrl-C and looked at by long computations.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shared flag: once requested, long computations return an error at their next step, so that
/// temporary files are removed and nothing half-written is left.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Flag>);

#[derive(Debug, Default)]
struct Flag {
    asked: AtomicBool,
    /// What this one is part of.
    whole: Option<Interrupt>,
}

impl Interrupt {
    /// One for steps that run side by side: it stops them without stopping the job, and when the job is stopped.
    pub fn within(&self) -> Self {
        Self(Arc::new(Flag { asked: AtomicBool::new(false), whole: Some(self.clone()) }))
    }

    /// Asks to stop.
    pub fn request(&self) {
        self.0.asked.store(true, Ordering::Relaxed);
    }

    /// Whether someone asked to stop.
    pub fn requested(&self) -> bool {
        self.0.asked.load(Ordering::Relaxed) || self.0.whole.as_ref().is_some_and(Self::requested)
    }
}
