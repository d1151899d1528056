//! The table of a relock study.

use crate::kinds::relock::columns::{Row, columns};
use crate::kinds::relock::run::Plan;
use crate::kinds::table::table;
use crate::sampling::batches::estimates;
use crate::sampling::found::Found;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::Table;

impl Plan<'_> {
    /// The table of all stored estimates; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn table(&self, store: Option<&Store>) -> Result<Table, StoreError> {
        let mut rows = self.rows();
        if let Some(store) = store {
            let units =
                self.points.iter().flat_map(|point| vec![point.fixed.lsb_arcsec; point.estimates.len()]);
            let sampled: Vec<_> = rows.iter().map(|row| row.estimate).zip(units).collect();
            let found =
                estimates(store, &sampled, |(estimate, unit)| (estimate.address, estimate.bin_base, *unit))?;
            rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        }
        Ok(self.table_of(&rows))
    }

    fn rows(&self) -> Vec<Row<'_>> {
        let points = self.relock.points.iter().zip(&self.points);
        let each = points
            .flat_map(|(point, lowered)| lowered.estimates.iter().map(move |estimate| (point, estimate)));
        each.map(|(point, estimate)| Row { point, estimate, found: Found::default() }).collect()
    }

    /// The table, with a column for each law that a chart draws.
    fn table_of(&self, rows: &[Row]) -> Table {
        let mut table = table(&self.study.sweeps, &columns(), rows, |row| &row.point.swept);
        let law = || rows.iter().map(|row| row.published().into()).collect();
        table.columns.extend(self.study.laws().into_iter().map(|drawn| drawn.about().with(law())));
        table
    }
}
