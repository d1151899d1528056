//! Computation without Python's lock.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;

use super::failure::Failure;

/// Does `work` while other Python threads continue. A panic becomes an error like any other.
pub fn compute<T: Send>(py: Python, work: impl FnOnce() -> Result<T, Failure> + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(Failure::Panic)));
    done.map_err(PyErr::from)
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
    compute(py, || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|error| Failure::Threads(error.to_string()))?.install(work)
    })
}
