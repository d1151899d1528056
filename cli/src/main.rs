//! The `sagnac` program: arguments to library calls, with one exit point.

/// A line on the standard error stream. Where that cannot be written, as to a full disk, there is nobody to tell, and what the program
/// does and its exit code stay the same.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        $crate::progress::aside(|| {
            let _ = writeln!(std::io::stderr(), $($words)*);
        });
    }};
}

mod allan;
mod bench;
mod chart;
mod charts;
mod check;
mod compare;
mod design;
mod devices;
mod explain;
mod failure;
mod filler;
mod folders;
mod look;
mod merge;
mod new;
mod one_point;
mod optima;
mod output;
mod program;
mod progress;
mod reading;
mod report;
mod results;
mod run;
mod schemas;
mod shells;
mod terminal;
mod verify;
mod whole;

use std::path::Path;

fn main() -> std::process::ExitCode {
    without_session();
    program::main()
}

/// Keeps a layer of Mesa's Vulkan drivers out where there is no desktop session: it orders devices, which is done here, asks for the
/// folder of the session, and complains on the terminal of whoever has none.
fn without_session() {
    const LAYER_OFF: &str = "NODEVICE_SELECT";
    let has_session = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if !has_session && std::env::var_os(LAYER_OFF).is_none() {
        // SAFETY: nothing else runs yet.
        unsafe { std::env::set_var(LAYER_OFF, "1") };
    }
}
