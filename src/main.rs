//! The `sagnac` program: arguments to library calls, with one exit point.

mod cli;

use std::path::Path;

fn main() -> std::process::ExitCode {
    without_display();
    cli::main()
}

/// Keeps a layer of Mesa's Vulkan drivers out where there is no display: it orders devices, which is done here, and asks for one, and
/// complains on the terminal of whoever has none.
fn without_display() {
    let has_display = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if !has_display {
        // SAFETY: nothing else runs yet.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
