//! Data to the standard output.

use std::io::Write;

use super::Failure;

/// Prints `text` with a final line end.
///
/// # Errors
/// The reader has gone away.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{}", text.trim_end()).and_then(|()| stdout.flush()).map_err(|_| Failure::OutputClosed)
}
