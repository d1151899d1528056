//! The part that a column plays in the question of a study.

use crate::chart::Source;
use crate::kinds::navigation::keys::{ALIGNMENT, FILTER};
use crate::motion::keys::GYRO as SUSPENDED_GYRO;
use crate::noise::keys::{FILE as NOISE_FILE, INTERVAL};
use crate::study::Study;
use crate::table::{Column, ColumnError, Role, Table};

/// Prefixes of keys that are conditions or requirements instead of choices of a designer.
const GIVEN: [&str; 14] = [
    "coefficient",
    "record.rate",
    "suspension.frequency",
    "run.",
    "motion.",
    "drift.",
    "noise.",
    "navigation.",
    "relock.adc_noise",
    "lock_in.threshold",
    "input.rate",
    "gyro.tick_noise",
    "gyro.readout_lsb",
    "switching.gap_ticks",
];

/// Keys of these between which a designer chooses: those that tell gyros or filters apart, the time of alignment, and the interval
/// between switches.
const CHOSEN: [&str; 5] = [SUSPENDED_GYRO.name, NOISE_FILE.name, FILTER.name, ALIGNMENT.name, INTERVAL.name];

/// Whether a column is a condition or a requirement instead of a choice.
pub(crate) fn is_given(column: &Column) -> bool {
    let key = if column.of.is_empty() { &column.name } else { &column.of };
    !CHOSEN.contains(&key.as_str()) && GIVEN.iter().any(|given| key.starts_with(given))
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
    let estimate = if column.role == Role::Oracle { table.referred(column) } else { Some(column) };
    let signed = rows.iter().any(|&row| column.value(row) < 0.0);
    estimate.is_some_and(|column| column.role.less_is_better()) && !signed
}
