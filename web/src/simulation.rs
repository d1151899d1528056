//! Simulated records for the intervals of a log, divided among workers. Each reads the log, makes its part of the records of every
//! column, and gives their sums, from all of which one of them takes the intervals.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use sagnac::device::Cpu;
use sagnac_base::progress::Progress;
use sagnac_engine::kinds::allan::run::Simulator;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::width::Width;
use serde::Deserialize;

use crate::message::Refusal;

/// A part of some records.
#[derive(Deserialize)]
pub(crate) struct Part {
    /// Number of the first record.
    from: usize,
    /// Number of the record after the last one; if absent, or beyond them, all others.
    to: Option<usize>,
    number: usize,
    of: usize,
}

impl Part {
    /// The numbers of its records of `count`.
    fn of(&self, count: usize) -> Range<usize> {
        let [from, to] = [self.from, self.to.unwrap_or(count)].map(|end| end.min(count));
        let at = |number: usize| from + to.saturating_sub(from) * number.min(self.of) / self.of.max(1);
        at(self.number.saturating_sub(1))..at(self.number)
    }
}

/// Notes of which records an analysis needs the sums, and how many; it knows none.
#[derive(Debug, Default)]
pub(crate) struct Recorder(Mutex<Vec<(Arc<dyn Recorded>, usize)>>);

impl Simulator for Recorder {
    fn simulate(&self, recipe: &dyn Recorded, count: usize) -> Option<Vec<u128>> {
        let whole = recipe.shortened(recipe.curve().samples);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((whole, count));
        None
    }
}

impl Recorder {
    /// The sums of a part of the records that were noted, as a file for each column.
    pub(crate) fn sums(&self, part: &Part, progress: &dyn Progress) -> Result<Vec<Vec<u8>>, Refusal> {
        let noted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let cpu = Cpu::new(Width::widest(), 1).map_err(|error| Refusal::other(&error.to_string()))?;
        let all = noted.iter().map(|(_, count)| part.of(*count).len() as u64).sum();
        progress.start("records", 0, all);
        let of_column = |(recipe, count): &(Arc<dyn Recorded>, usize)| {
            let records = part.of(*count);
            let sums =
                cpu.sums(&**recipe, records.start as u64, records.len(), &|more| progress.advance(more));
            sums.into_iter().flat_map(u128::to_le_bytes).collect()
        };
        Ok(noted.iter().map(of_column).collect())
    }
}

/// Gives the sums of the columns in the order in which they were noted.
#[derive(Debug)]
pub(crate) struct Player(Mutex<VecDeque<Vec<u128>>>);

impl Player {
    /// The sums in the files of some parts, in the order of their records.
    pub(crate) fn new(files: &[&[u8]], parts: usize) -> Player {
        let columns = files.len() / parts.max(1);
        let sum = |bytes: &[u8]| bytes.try_into().map_or(0, u128::from_le_bytes);
        let of_column = |column: usize| {
            let parts = files.iter().skip(column).step_by(columns);
            parts.flat_map(|file| file.chunks_exact(16).map(sum)).collect()
        };
        Player(Mutex::new((0..columns).map(of_column).collect()))
    }
}

impl Simulator for Player {
    fn simulate(&self, recipe: &dyn Recorded, count: usize) -> Option<Vec<u128>> {
        let next = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        next.filter(|sums| sums.len() == count * recipe.values())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_records_in_their_order() {
        for (from, to, count) in [(0, Some(200), 1000), (200, None, 1000), (200, None, 150), (0, Some(7), 5)]
        {
            for of in [1, 2, 3, 8] {
                let part = |number| Part { from, to, number, of }.of(count);
                let all: Vec<usize> = (1..=of).flat_map(part).collect();
                let expected: Vec<usize> = (from..to.unwrap_or(count).min(count)).collect();
                assert_eq!(all, expected, "{from} {to:?} {count} {of}");
            }
        }
    }
}
