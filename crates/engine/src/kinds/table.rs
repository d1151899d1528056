//! The tables of studies: swept keys, then the columns of the kind.

use rayon::prelude::*;

use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use sagnac_base::table::cells::Growing;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cells, Column, ColumnOf, Role, Table};

/// The name of each swept key with its value at a point, in the order of the sweeps.
pub(crate) type Values = [(&'static str, Swept)];

/// A table of these rows; `swept` gives the values of the swept keys in each row.
pub fn table<R: Sync>(
    sweeps: &[Sweep],
    columns: &[ColumnOf<R>],
    rows: &[R],
    swept: impl Fn(&R) -> &Values,
) -> Table {
    let of_sweep = |(at, sweep): (usize, &Sweep)| Column {
        cells: rows.iter().map(|row| swept(row)[at].1.cell()).collect(),
        ..column_of(sweep)
    };
    let keys = sweeps.iter().enumerate().map(of_sweep);
    Table { columns: keys.chain(columns_of(columns, rows)).collect() }
}

/// Tables with the same columns, one below the other. Each table is made when its rows are needed, so that only the cells
/// of all rows are in memory, and not what they are made from.
#[derive(Default)]
pub(crate) struct Appended {
    columns: Vec<(Column, Growing)>,
    rows: usize,
}

impl Appended {
    /// Adds the rows of a table.
    pub(crate) fn push(&mut self, table: Table) {
        if self.columns.is_empty() {
            let bare = |column: &Column| Column {
                cells: Cells::default(),
                band: column.band.as_ref().map(|_| vec![]),
                band_of_mean: None,
                ..column.clone()
            };
            self.columns = table.columns.iter().map(|column| (bare(column), Growing::default())).collect();
        }
        let (rows, more) = (self.rows, table.rows());
        // Looking up which cells of a long column are known takes as long as making them.
        self.columns.par_iter_mut().zip(table.columns).for_each(|((whole, cells), column)| {
            cells.append(column.cells);
            if let Some((band, own)) = whole.band.as_mut().zip(column.band)
                && (!band.is_empty() || own.iter().any(Option::is_some))
            {
                band.resize(rows, None);
                band.extend(own);
            }
        });
        self.rows += more;
    }

    /// All rows.
    pub(crate) fn into_table(self) -> Table {
        let whole = |(column, cells): (Column, Growing)| Column { cells: cells.into_cells(), ..column };
        Table { columns: self.columns.into_iter().map(whole).collect() }
    }
}

/// The column of a swept key, without its cells.
pub(crate) fn column_of(sweep: &Sweep) -> Column {
    Column {
        name: sweep.key.name.to_owned(),
        label: sweep.key.label.to_owned(),
        unit: sweep.values.first().map(Swept::unit).unwrap_or_default(),
        written: sweep.values.last().and_then(Swept::written),
        role: Role::Key,
        meaning: sweep.key.label.to_owned(),
        ..Column::default()
    }
}
