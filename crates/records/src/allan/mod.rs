//! Deviations of a record: Allan, modified Allan, time and Hadamard, with intervals.
//!
//! ```text
//! rates, increments or angles ─▶ Angles ─ Taus::factors ─▶ curve ─▶ Points ─ minimum ─▶ in-run bias stability
//! ```
//!
//! 1 ″/s is 1 °/h, so a curve of angles in ″ is in °/h. Sums are in a fixed order and functions are libm's, so values
//! have the same bits on every machine and for any number of threads. The exception is the incomplete gamma function of
//! statrs behind the ends of intervals, which may differ in the last digits.
//!
//! Definitions and test values: W. J. Riley, "Handbook of frequency stability analysis", NIST SP 1065; IEEE Std 952.

pub mod angles;
pub mod chi_squared;
pub mod curve;
pub mod deviation;
pub(crate) mod differences;
pub(crate) mod edf;
pub mod fisher;
pub mod noise;
pub mod spread;
pub mod sums;
pub mod tau;
#[cfg(test)]
mod tests;
pub mod trend;
pub mod unit;

pub use crate::allan::angles::Angles;
pub use crate::allan::curve::{Minimum, Point, Supposed, curve, minimum, suppose};
pub use crate::allan::deviation::{Deviation, UnknownDeviation};
pub use crate::allan::noise::{MIN_GROUPS, Noise};
pub use crate::allan::spread::Spread;
pub use crate::allan::tau::{MAX_FOR_ALL, MAX_OF_COLUMNS, TauError, Taus};
pub use crate::allan::trend::{Line, Trend};
pub use crate::allan::unit::Unit;
