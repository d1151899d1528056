//! The part that a column plays in the question of a study.

use crate::chart::Source;
use crate::kinds::KINDS;
use crate::kinds::allan::columns::COEFFICIENT;
use crate::study::Study;
use crate::table::{Column, ColumnError, Role, Table};

/// Whether a column is a condition instead of a choice: that of a key by its role, of others the names of coefficients.
pub(crate) fn is_given(column: &Column) -> bool {
    let name = if column.of.is_empty() { &column.name } else { &column.of };
    let keys = KINDS.iter().flat_map(|kind| (kind.keys)().into_iter().chain((kind.sweepable)()));
    keys.into_iter()
        .find(|key| key.name == *name)
        .map_or_else(|| name.starts_with(COEFFICIENT), |key| key.role.is_given())
}

/// The columns that distinguish rows, each once, after some `columns`.
pub(crate) fn apart<'t>(
    study: &Study,
    source: Source,
    table: &'t Table,
    mut columns: Vec<&'t Column>,
) -> Result<Vec<&'t Column>, ColumnError> {
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    for name in study.text_columns(source).into_iter().chain(sweeps) {
        if columns.iter().all(|column| column.name != name) {
            columns.push(table.column(name)?);
        }
    }
    Ok(columns)
}

/// Whether less of an estimate is better in all selected rows: its role says so, and none of its values is negative.
pub(crate) fn less_is_better(table: &Table, column: &Column, rows: &[usize]) -> bool {
    let estimate = if column.role == Role::Theory { table.referred(column) } else { Some(column) };
    let signed = rows.iter().any(|&row| column.value(row) < 0.0);
    estimate.is_some_and(|column| column.role.less_is_better()) && !signed
}
