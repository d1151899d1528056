//! A tally that keeps one row of integers of fixed length for each trial, such as the sums of a record.

/// Rows of consecutive trials, in order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rows {
    /// Integers per trial.
    pub width: usize,
    /// The integers, trial by trial.
    pub values: Vec<u128>,
}

impl Rows {
    /// Number of trials.
    pub fn trials(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// The rows, trial by trial.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[u128]> {
        self.values.chunks_exact(self.width.max(1))
    }
}
