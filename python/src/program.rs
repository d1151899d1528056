//! The program `sagnac`, which `pip install` puts on the path.

use std::ffi::OsString;
use std::panic::catch_unwind;

use pyo3::prelude::*;

/// Exit code of a Rust program after a panic.
const PANICKED: u8 = 101;

/// The script `sagnac`: runs the program with the arguments of Python and ends the process with its exit code, as if there
/// were no Python.
///
/// # Errors
/// `sys` or `signal` are not those of Python.
#[pyfunction]
pub fn main(py: Python<'_>) -> PyResult<()> {
    let arguments: Vec<OsString> = py.import("sys")?.getattr("argv")?.extract()?;
    without_handler(py)?;
    #[cfg(unix)]
    open_streams();
    let code = py.detach(|| {
        // SAFETY: the script has only this thread.
        catch_unwind(|| unsafe { sagnac_cli::main(arguments.into_iter()) }).unwrap_or(PANICKED)
    });
    std::process::exit(code.into())
}

/// Lets Ctrl-C end the program. Python's handler only notes it for Python code, of which no more runs. A shell may have
/// the program ignore Ctrl-C, and then it still does.
fn without_handler(py: Python<'_>) -> PyResult<()> {
    let signal = py.import("signal")?;
    let interrupt = signal.getattr("SIGINT")?;
    if signal.call_method1("getsignal", (&interrupt,))?.is(signal.getattr("default_int_handler")?) {
        signal.call_method1("signal", (interrupt, signal.getattr("SIG_DFL")?))?;
    }
    Ok(())
}

/// Opens the standard streams that are closed, as every Rust program does at its start: a file that is opened later must
/// not become one of them.
#[cfg(unix)]
fn open_streams() {
    use std::fs::File;
    use std::os::fd::{AsRawFd, IntoRawFd};

    while let Ok(file) = File::options().read(true).write(true).open("/dev/null")
        && file.as_raw_fd() <= 2
    {
        // It stays open.
        let _ = file.into_raw_fd();
    }
}
