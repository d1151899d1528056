//! Logs of sensors, read into evenly spaced samples, some of which may be missing, and prepared for analysis.
//!
//! ```text
//! Recording ─ Request ─▶ Log ─ cut, check, outliers ─▶ channels ─▶ allan::Angles
//! ```

pub mod channel;
pub mod check;
pub mod doubt;
pub mod measure;
pub mod outliers;
pub mod read;
pub mod samples;
pub mod temperature;
#[cfg(test)]
mod tests;
pub(crate) mod timing;
mod unnamed;
mod write;

/// Most samples of a log, 2^28, which is a week at 400 Hz.
pub const MAX_SAMPLES: usize = 1 << 28;
