//! Progress of work that may be repeated.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::device::Advance;

/// Attempts at the same work, which report each of its units once.
pub(crate) struct Attempts<'a> {
    progress: Advance<'a>,
    /// Most units that an attempt has reported.
    told: AtomicU64,
}

impl<'a> Attempts<'a> {
    pub(crate) fn new(progress: Advance<'a>) -> Attempts<'a> {
        Attempts { progress, told: AtomicU64::new(0) }
    }

    /// The progress of the next attempt. Units that an earlier one has reported are not reported again.
    pub(crate) fn next(&self) -> impl Fn(u64) + Sync {
        let done = AtomicU64::new(0);
        move |more| {
            let done = done.fetch_add(more, Ordering::Relaxed) + more;
            let before = self.told.fetch_max(done, Ordering::Relaxed);
            if done > before {
                (self.progress)(done - before);
            }
        }
    }
}
