//! The cases read an input of each target and check what they make of it. The fuzzers of `tests/fuzz` and of `fuzz/` share them.

pub mod databases;
pub mod records;
pub mod studies;
pub mod tallies;

/// What came of an input.
pub enum Outcome {
    /// The input was read; the text says as what.
    Accepted(String),
    /// The input was refused with this message.
    Refused(String),
}
