//! Computation without Python's lock.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;

use super::failure::Failure;

/// Does `work` while other Python threads continue. A panic becomes an error like any other.
pub fn compute<T: Send>(py: Python, work: impl FnOnce() -> Result<T, Failure> + Send) -> PyResult<T> {
    py.detach(|| caught(work)).map_err(PyErr::from)
}

fn caught<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(Failure::Panic))
}

/// Computes as [`compute`] does, on `threads` threads, for 0 on as many as the machine has logical cores.
///
/// The threads are started for this work alone: a process forked later has none of them, and would wait forever for
/// those of a pool that outlives the call.
pub fn compute_on<T: Send>(
    py: Python,
    threads: usize,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    compute(py, || install(threads, work))
}

/// Reads what Python owns on `threads` threads, as [`compute_on`] does, but with Python's lock: without it another thread
/// could write to an array meanwhile.
pub fn read_on<T: Send>(
    _py: Python,
    threads: usize,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    caught(|| install(threads, work)).map_err(PyErr::from)
}

fn install<T: Send>(threads: usize, work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Failure::Device(format!("cannot start threads: {error}")))?.install(work)
}
