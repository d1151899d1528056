//! A tally of one fixed row of integers for each trial, such as the sums of a record.

/// Rows of some consecutive trials, in their order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rows {
    /// Integers of a trial.
    pub width: usize,
    /// Trial by trial.
    pub values: Vec<u128>,
}

impl Rows {
    /// How many trials there are.
    pub fn trials(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// The rows, trial by trial.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[u128]> {
        self.values.chunks_exact(self.width.max(1))
    }
}
