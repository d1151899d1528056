//! The `sagnac` program: arguments to library calls, with one exit point.

mod cli;

use std::path::Path;

fn main() -> std::process::ExitCode {
    without_session();
    cli::main()
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
