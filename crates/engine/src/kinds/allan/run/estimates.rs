//! The estimates of all records of a point.

use rayon::prelude::*;

use sagnac_kernel::rows::Rows;

/// Estimates, (″/s)², record by record, each at the averaging factors of the point.
#[derive(Debug, Default)]
pub(crate) struct Estimates {
    width: usize,
    values: Vec<f64>,
}

impl Estimates {
    /// The estimates computed by `variances` from the sums of the records.
    pub(crate) fn of(rows: Vec<Rows>, variances: impl Fn(&[u128]) -> Vec<f64>) -> Estimates {
        let width = rows.first().map_or(0, |rows| rows.width);
        let mut values = Vec::with_capacity(rows.iter().map(|rows| rows.values.len()).sum());
        // Rows are dropped once they are read, which saves memory.
        for rows in rows {
            rows.rows().for_each(|sums| values.extend(variances(sums)));
        }
        Estimates { width, values }
    }

    /// Number of records.
    pub(crate) fn count(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// The estimates of all records at one averaging factor.
    pub(crate) fn at(&self, place: usize) -> Vec<f64> {
        self.values.iter().skip(place).step_by(self.width.max(1)).copied().collect()
    }

    /// The estimates of each record, in order.
    pub(crate) fn records(&self) -> impl IndexedParallelIterator<Item = &[f64]> {
        self.values.par_chunks_exact(self.width.max(1))
    }
}
