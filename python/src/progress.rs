//! Progress for a function of the caller, which can end the run, as Ctrl-C can.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use sagnac::progress::Progress;

/// Interval between two calls of the function.
const INTERVAL: Duration = Duration::from_millis(100);

/// Calls a function with the progress of a run, `progress(done, total, unit)`, and checks for interruptions.
pub struct Listener {
    function: Option<Py<PyAny>>,
    unit: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
    told: Mutex<Instant>,
    raised: Mutex<Option<PyErr>>,
}

impl Listener {
    pub fn new(function: Option<Py<PyAny>>) -> Listener {
        Listener {
            function,
            unit: Mutex::new("trials"),
            done: AtomicU64::new(0),
            total: AtomicU64::new(0),
            told: Mutex::new(Instant::now()),
            raised: Mutex::new(None),
        }
    }

    /// The exception or the interruption that ended the run, if any.
    pub fn raised(&self) -> Option<PyErr> {
        self.raised.lock().ok().and_then(|mut raised| raised.take())
    }

    fn keep(&self, error: PyErr) {
        if let Ok(mut raised) = self.raised.lock() {
            raised.get_or_insert(error);
        }
    }

    fn tell(&self) {
        let Some(function) = &self.function else { return };
        // If another thread is calling the function, there is nothing to add.
        let Ok(mut told) = self.told.try_lock() else { return };
        *told = Instant::now();
        let [done, total] = [&self.done, &self.total].map(|count| count.load(Ordering::Relaxed));
        let unit = self.unit.lock().map_or("trials", |unit| *unit);
        if let Err(error) = Python::attach(|py| function.call1(py, (done, total, unit)).map(drop)) {
            self.keep(error);
        }
    }

    fn is_due(&self) -> bool {
        self.function.is_some() && self.told.try_lock().is_ok_and(|told| told.elapsed() >= INTERVAL)
    }
}

impl Progress for Listener {
    fn start(&self, unit: &'static str, done: u64, total: u64) {
        // Fits may follow the samples.
        if let Ok(mut current) = self.unit.lock() {
            *current = unit;
        }
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        self.tell();
    }

    fn advance(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        if done == self.total.load(Ordering::Relaxed) || self.is_due() {
            self.tell();
        }
    }

    fn stops(&self) -> bool {
        // Signals arrive only on Python's main thread; elsewhere this finds none.
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            self.keep(error);
        }
        self.raised.lock().is_ok_and(|raised| raised.is_some())
    }
}
