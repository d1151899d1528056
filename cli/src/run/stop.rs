//! Causes that end a run early: signals and the time limit.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::{Duration, Instant};

#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};

use crate::progress::leave;

/// Other systems have no such signals; an interruption ends the program at once, and completed work is kept.
#[cfg(not(unix))]
const SIGINT: i32 = 2;
#[cfg(not(unix))]
const SIGTERM: i32 = 15;
#[cfg(not(unix))]
const SIGUSR1: i32 = 10;

/// Why a run ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A signal with its number.
    Signal(i32),
    TimeLimit,
}

impl Cause {
    /// The exit code: 130 for SIGINT, 143 for SIGTERM; 4 for SIGUSR1 and the time limit, after which the run is to
    /// continue.
    pub fn code(self) -> u8 {
        match self {
            Cause::Signal(signal) if signal != SIGUSR1 => 128_u8.wrapping_add(signal as u8),
            Cause::Signal(_) | Cause::TimeLimit => 4,
        }
    }
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match *self {
            Cause::TimeLimit => "the time limit",
            Cause::Signal(SIGINT) => "SIGINT",
            Cause::Signal(SIGTERM) => "SIGTERM",
            Cause::Signal(SIGUSR1) => "SIGUSR1",
            Cause::Signal(_) => "a signal",
        })
    }
}

/// Receives signals and watches the time limit. While the program [samples](Stop::sampling), a first signal ends it
/// after the current batch, and a second one at once. At other times, when everything not yet on disk can be
/// recomputed, the first one ends it at once.
#[derive(Debug, Clone)]
pub struct Stop {
    signal: Arc<AtomicI32>,
    sampling: Arc<AtomicBool>,
    deadline: Option<Instant>,
}

impl Stop {
    /// Starts listening; the time `limit` counts from now.
    ///
    /// # Errors
    /// The system refuses to register a handler.
    pub fn listen(limit: Option<Duration>) -> std::io::Result<Stop> {
        let deadline = limit.and_then(|limit| Instant::now().checked_add(limit));
        let stop = Stop {
            signal: Arc::new(AtomicI32::new(0)),
            sampling: Arc::new(AtomicBool::new(false)),
            deadline,
        };
        #[cfg(unix)]
        stop.hear()?;
        Ok(stop)
    }

    #[cfg(unix)]
    fn hear(&self) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGUSR1])?;
        let stop = self.clone();
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in signals.forever() {
                let first = stop.signal.swap(signal, Ordering::SeqCst) == 0;
                let cause = Cause::Signal(signal);
                if first && stop.sampling.load(Ordering::SeqCst) {
                    say!("{cause}: stopping after this batch; a second signal leaves at once");
                    continue;
                }
                leave();
                say!("stopped by {cause}; completed work is kept; resumable: run again to continue");
                signal_hook::low_level::exit(cause.code().into());
            }
        })?;
        Ok(())
    }

    /// The cause to stop, if there is one.
    pub fn cause(&self) -> Option<Cause> {
        match self.signal.load(Ordering::SeqCst) {
            0 if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) => Some(Cause::TimeLimit),
            0 => None,
            signal => Some(Cause::Signal(signal)),
        }
    }

    /// Does work that stops by itself when there is a cause.
    pub fn sampling<T>(&self, work: impl FnOnce() -> T) -> T {
        self.sampling.store(true, Ordering::SeqCst);
        let done = work();
        self.sampling.store(false, Ordering::SeqCst);
        done
    }
}
