//! Logs that users recorded: text in columns, Stable32 .DAT and NumPy .npy, read into evenly spaced samples.
//!
//! ```text
//! file ─ layout, names ─▶ columns ─ text | npy ─▶ rows ─ time ─▶ Log ─ cut, check, outliers ─▶ channels ─▶ allan::Angles
//! ```
//!
//! Text is read in blocks, and their lines parsed in parallel: memory is 8 bytes for each sample of a column that was
//! asked for, besides 16 MiB. Numbers are the standard library's correctly rounded ones. The csv crate is not used
//! here: it takes one delimiter and one comment sign, no runs of blanks, and does not tell where a cell stands.

mod cells;
mod channel;
mod check;
mod error;
mod layout;
mod measure;
mod names;
mod npy;
mod outliers;
mod read;
mod samples;
mod text;
mod time;

#[cfg(test)]
mod tests;

pub use channel::{Channel, Log};
pub use check::{LEAST_SAMPLES, UnitCheck};
pub use error::LogError;
pub(crate) use error::Place;
pub use measure::{Data, Unit, UnitMismatch};
pub use outliers::{OUTLYING, Outliers, outliers};
pub use read::{Request, Timing};
pub use samples::{Fault, Samples};
pub use time::JITTER;

/// Most samples of a log, 2^28: a week at 400 Hz.
pub const MOST_SAMPLES: usize = 1 << 28;

/// What to do about other steps than [`STEPS_S`](super::STEPS_S).
pub(super) const STEPS_HELP: &str = "accepted: 1e-9 s to 1e9 s; is the unit of the time right?";

fn unreadable(file: &str, error: &std::io::Error) -> LogError {
    LogError::new(format!("cannot read {file}: {error}"), "", "give the path of a log", None)
}
