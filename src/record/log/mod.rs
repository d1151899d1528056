//! Logs that users recorded: text in columns, Stable32 .DAT and NumPy .npy, read into evenly spaced samples.
//!
//! ```text
//! file ─ layout, names ─▶ columns ─ text | npy ─▶ rows ─ time ─▶ Log ─ cut, check, outliers ─▶ channels ─▶ allan::Angles
//! ```
//!
//! Text is read in blocks, whose lines are parsed in parallel. Memory is 8 bytes for each sample of a requested column,
//! plus 16 MiB. Numbers are parsed by the correctly rounded parser of the standard library. The csv crate is not used
//! here because it takes only one delimiter and one comment sign, no runs of blanks, and does not give the place of a
//! cell.

pub mod cells;
pub mod channel;
pub mod check;
pub mod error;
pub mod layout;
pub mod measure;
pub mod names;
pub mod npy;
pub mod outliers;
pub mod read;
pub mod samples;
#[cfg(test)]
mod tests;
pub mod text;
pub mod time;

pub use crate::record::log::channel::{Channel, Log};
pub use crate::record::log::check::{LEAST_SAMPLES, UnitCheck};
pub use crate::record::log::error::LogError;
pub use crate::record::log::measure::{Data, Unit, UnitMismatch};
pub use crate::record::log::outliers::{OUTLYING, Outliers, outliers};
pub use crate::record::log::read::{Request, Timing};
pub use crate::record::log::samples::{Fault, Samples};
pub use crate::record::log::time::JITTER;

/// Most samples of a log, 2^28, which is a week at 400 Hz.
pub const MOST_SAMPLES: usize = 1 << 28;

/// Advice on steps outside [`STEPS_S`](crate::record::STEPS_S).
pub(crate) const STEPS_HELP: &str = "accepted: 1e-9 s to 1e9 s; is the unit of the time right?";

fn unreadable(file: &str, error: &std::io::Error) -> LogError {
    LogError::new(format!("cannot read {file}: {error}"), "", "give the path of a log", None)
}
