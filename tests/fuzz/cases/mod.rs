//! What is done with an input of each target. The fuzzers of `tests/fuzz` and of `fuzz/` share it.

pub mod databases;
pub mod records;
pub mod studies;
pub mod tallies;

/// What came of an input.
pub enum Outcome {
    /// As what.
    Accepted(String),
    /// With this message.
    Refused(String),
}
