//! The program `sagnac`.

use std::process::ExitCode;

fn main() -> ExitCode {
    // SAFETY: the program has only this thread.
    ExitCode::from(unsafe { sagnac_cli::main(std::env::args_os()) })
}
