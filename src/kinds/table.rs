//! The tables of studies: swept keys, then the columns of the kind.

use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::table::column::columns_of;
use crate::table::{Column, ColumnOf, Role, Table};

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
