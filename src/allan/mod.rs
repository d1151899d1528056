//! Deviations of a record: Allan, modified Allan, time and Hadamard, with intervals.
//!
//! ```text
//! rates, increments or angles ─▶ Angles ─ Taus::factors ─▶ curve ─▶ Points ─ minimum ─▶ in-run stability
//! ```
//!
//! A rate in ″/s is one in °/h, so a curve of angles in ″ is in °/h. Sums are in a fixed order and functions are
//! libm's, but for the incomplete gamma function behind the ends of intervals, which is statrs': values have the same
//! bits on every machine and for any number of threads, intervals may differ in the last digits.
//!
//! Definitions and test values: W. J. Riley, "Handbook of frequency stability analysis", NIST SP 1065; IEEE Std 952.

mod angles;
mod chi_squared;
mod curve;
mod deviation;
mod edf;
mod noise;
mod sums;
mod tau;
mod trend;
mod unit;

#[cfg(test)]
mod tests;

pub use angles::Angles;
pub use curve::{Minimum, Point, curve, minimum};
pub use deviation::{Deviation, UnknownDeviation};
pub use noise::{LEAST_GROUPS, Noise};
pub use tau::{MOST_FOR_ALL, TauError, Taus};
pub use trend::{Line, Trend};
pub use unit::Unit;
