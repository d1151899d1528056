//! The table of whole runs.

use crate::kinds::switched_run::columns::{Row, columns};
use crate::kinds::switched_run::run::Plan;
use crate::kinds::table::table;
use crate::sampling::batches::estimates;
use crate::sampling::found::Found;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::Table;

impl Plan<'_> {
    /// The table of all stored estimates; without a store, all rows without estimates.
    pub(crate) fn table(&self, store: Option<&Store>) -> Result<Table, StoreError> {
        let mut rows = self.rows();
        if let Some(store) = store {
            let found = estimates(store, &rows, |row| {
                (row.estimate.address, row.estimate.bin_base, row.estimate.unit_arcsec)
            })?;
            rows.iter_mut().zip(found).for_each(|(row, found)| row.found = found);
        }
        Ok(self.table_of(&rows))
    }

    fn table_of(&self, rows: &[Row]) -> Table {
        let columns = columns(!self.runs.fillers().is_empty());
        table(&self.study.sweeps, &columns, rows, |row| &row.point.swept)
    }

    /// Every point, filler and angle, in the order of the table.
    fn rows(&self) -> Vec<Row<'_>> {
        let mut rows = Vec::new();
        for (point, lowered) in self.runs.points.iter().zip(&self.points) {
            for (place, filled) in lowered.fillers.iter().enumerate() {
                let filler = self.runs.fillers().get(place).map(|filler| filler.name.as_str());
                let row = |estimate| Row { point, filler, filled, estimate, found: Found::default() };
                rows.extend(filled.estimates.iter().map(row));
            }
        }
        rows
    }
}
