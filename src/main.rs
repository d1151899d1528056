//! The `sagnac` program: arguments to library calls, with one exit point.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
