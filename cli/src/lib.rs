//! The program `sagnac` as a function, which its binary and the Python package call: it maps arguments to library calls,
//! with one exit point.

/// Prints a line on the standard error stream, made visible. If that cannot be written, for example on a full disk,
/// neither the work nor the exit code changes.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::output::say(&sagnac_base::diagnostics::visible(&format!($($words)*)))
    };
}

/// Prints a note, broken at words where the standard error stream is a terminal.
macro_rules! note {
    ($($words:tt)*) => {
        say!("{}", $crate::look::of_note(&format!($($words)*)))
    };
}

mod allan;
mod arg_parsers;
mod chart;
mod check;
mod compare;
mod convert;
mod design;
mod device;
mod explain;
mod failure;
mod filler;
mod generate;
mod look;
mod merge;
mod model;
mod output;
mod program;
mod progress;
mod reading;
mod report;
mod results;
mod run;
mod sensitivity;
mod simulate;

use std::ffi::OsString;
use std::path::Path;

/// Runs the program with its arguments, of which the first is its name, and returns the exit code.
///
/// # Safety
/// No other thread runs yet: a variable of the environment may be set.
pub unsafe fn main(arguments: impl Iterator<Item = OsString>) -> u8 {
    // SAFETY: the caller has no other thread.
    unsafe { without_session() };
    sagnac::device::gpu::adapter::on_wait(|sentence| say!("{sentence}"));
    program::main(arguments)
}

/// Disables a layer of Mesa's Vulkan drivers if there is no desktop session. The layer reorders devices, which is not
/// needed here, and prints a warning if it finds no session folder.
///
/// # Safety
/// No other thread runs yet.
unsafe fn without_session() {
    const LAYER_OFF: &str = "NODEVICE_SELECT";
    let has_session = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if !has_session && std::env::var_os(LAYER_OFF).is_none() {
        // SAFETY: no other thread reads the environment.
        unsafe { std::env::set_var(LAYER_OFF, "1") };
    }
}
