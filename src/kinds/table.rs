//! The tables of studies: swept keys, then the columns of the kind.

use rayon::prelude::*;

use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::table::cells::Growing;
use crate::table::column::columns_of;
use crate::table::{Cells, Column, ColumnOf, Role, Table};

/// The name of each swept key with its value at a point, in the order of the sweeps.
pub(crate) type Values = [(&'static str, Swept)];

/// A table of these rows; `swept` gives the values of the swept keys in each row.
pub(crate) fn table<R>(
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

/// The rows of all tables, which have the same columns, one table below the other. Each table is made when its rows are
/// needed, so that only the cells of all rows are in memory, and not what they are made from.
///
/// # Errors
/// Those of a table.
pub(crate) fn appended<E>(tables: impl Iterator<Item = Result<Table, E>>) -> Result<Table, E> {
    let mut all: Vec<(Column, Growing)> = Vec::new();
    let mut rows = 0;
    for table in tables {
        let table = table?;
        if all.is_empty() {
            let bare = |column: &Column| Column {
                cells: Cells::default(),
                band: column.band.as_ref().map(|_| vec![]),
                ..column.clone()
            };
            all = table.columns.iter().map(|column| (bare(column), Growing::default())).collect();
        }
        let more = table.rows();
        // Looking up which cells of a long column are known takes as long as making them.
        all.par_iter_mut().zip(table.columns).for_each(|((whole, cells), column)| {
            cells.extend(column.cells.iter().cloned());
            if let Some((band, own)) = whole.band.as_mut().zip(column.band)
                && (!band.is_empty() || own.iter().any(Option::is_some))
            {
                band.resize(rows, None);
                band.extend(own);
            }
        });
        rows += more;
    }
    let columns = all.into_iter().map(|(column, cells)| Column { cells: cells.into_cells(), ..column });
    Ok(Table { columns: columns.collect() })
}

/// The column of a swept key, without its cells.
pub(crate) fn column_of(sweep: &Sweep) -> Column {
    Column {
        name: sweep.key.name.to_owned(),
        label: sweep.key.label.to_owned(),
        unit: sweep.values.first().map(Swept::unit).unwrap_or_default(),
        role: Role::Key,
        meaning: sweep.key.label.to_owned(),
        ..Column::default()
    }
}
