//! The table of a gap-fill study.

use crate::chart::law::Law;
use crate::kinds::gap_fill::columns::{Row, columns};
use crate::kinds::gap_fill::run::Plan;
use crate::kinds::table::table;
use crate::sampling::batches::estimates;
use crate::sampling::found::Found;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::Table;

impl Plan<'_> {
    /// The table before anything is sampled, with all rows but without estimates.
    pub(crate) fn blank_table(&self) -> Table {
        self.table_of(&self.rows())
    }

    /// The table of all stored estimates, with a row for each point, filler and error.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn table(&self, store: &Store) -> Result<Table, StoreError> {
        let mut rows = self.rows();
        let found = estimates(store, &rows, |Row { estimate, .. }| {
            (estimate.address, estimate.bin_base, estimate.unit_arcsec)
        })?;
        for (row, mut found) in rows.iter_mut().zip(found) {
            let known = row.estimate.oracle.noise_of_square.zip(found.estimates.as_mut());
            if let Some((noise, estimates)) = known.filter(|(_, estimates)| estimates.rms > 0.0) {
                estimates.rms_se = Some(noise / libm::sqrt(found.trials as f64) / (2.0 * estimates.rms));
            }
            row.found = found;
        }
        Ok(self.table_of(&rows))
    }

    /// Whether a record is replayed over all its places, so that only whole replays are possible.
    pub(crate) fn replays(&self) -> bool {
        self.points.iter().any(|point| point.trials(1) > 1)
    }

    /// The table, with a column for each law that a chart draws.
    fn table_of(&self, rows: &[Row]) -> Table {
        let mut table = table(&self.study.sweeps, &columns(), rows, |row| &row.point.swept);
        let of_law = |law: Law| law.about().with(rows.iter().map(|row| row.law(law).into()).collect());
        table.columns.extend(self.study.laws().into_iter().map(of_law));
        table
    }

    /// Every point, filler and error, in the order of the table.
    fn rows(&self) -> Vec<Row<'_>> {
        let mut rows = Vec::new();
        for (point, lowered) in self.gap_fill.points.iter().zip(&self.points) {
            for (filler, estimates) in self.gap_fill.fillers.iter().zip(&lowered.fillers) {
                let row = |estimate| Row { point, filler, estimate, found: Found::default() };
                rows.extend(estimates.iter().map(row));
            }
        }
        rows
    }
}
