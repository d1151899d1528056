//! Progress for a function of the caller, and the end that it or Ctrl-C puts to a run.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use sagnac::progress::Progress;

/// Between two calls of the function.
const INTERVAL: Duration = Duration::from_millis(100);

/// Tells a function how far a run has come, `progress(done, total, unit)`, and hears of interruptions.
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

    /// What the function raised, or the interruption, if the run was ended by one.
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
        // A thread that finds another one telling has nothing to add.
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
        // Signals are heard on Python's main thread alone; elsewhere this finds none.
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            self.keep(error);
        }
        self.raised.lock().is_ok_and(|raised| raised.is_some())
    }
}
