//! Values of logs and tables as text.

use crate::allan::Minimum;
use crate::analysis::log::Column;
use crate::fit::Fit;
use crate::quantity::number::{significant, with_unit};
use crate::table::{self, Role, Table};
use crate::view::report::sections::{Cell, Grid};

/// Significant digits of values.
const DIGITS: usize = 4;

/// The range of a fit.
pub(crate) fn range(fit: &Fit) -> String {
    let [from, to] = fit.tau_range.map(|tau_s| significant(tau_s, DIGITS));
    format!("τ from {from} s to {to} s")
}

/// An interval such as `0.199 … 0.201`.
pub(crate) fn interval(ends: [f64; 2]) -> String {
    ends.map(|end| significant(end, DIGITS)).join(" … ")
}

/// A table to read, with the ends of an interval below its value; without columns of these names, and those without values.
pub(crate) fn grid(table: &Table, omitted: &[&str]) -> Grid {
    let is_blank =
        |column: &table::Column| (0..table.rows()).all(|row| column.cells[row] == table::Cell::Blank);
    let is_shown = |column: &&table::Column| {
        let is_end = matches!(column.role, Role::Lower | Role::Upper);
        !is_end && !omitted.contains(&column.name.as_str()) && !is_blank(column)
    };
    let shown: Vec<&table::Column> = table.columns.iter().filter(is_shown).collect();
    let end = |column: &table::Column, role: Role, row: usize| {
        let end = table.columns.iter().find(|end| end.role == role && end.of == column.name)?;
        end.cells[row].number()
    };
    let cell = |column: &table::Column, row: usize| {
        let ends = end(column, Role::Lower, row).zip(end(column, Role::Upper, row));
        let below = ends.map(|ends| interval(ends.into())).unwrap_or_default();
        Cell { text: column.cells[row].rounded(DIGITS), below }
    };
    Grid {
        head: shown.iter().map(|column| column.title()).collect(),
        rows: (0..table.rows()).map(|row| shown.iter().map(|column| cell(column, row)).collect()).collect(),
    }
}

/// A value with its unit, if it has one.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    with_unit(value, DIGITS, unit)
}

/// The minimum of the first curve of rates, such as `0.01 °/h (0.009 … 0.012) at τ = 100 s`.
pub(crate) fn stability(column: &Column) -> Option<String> {
    let curve = column.curves.iter().find(|curve| !curve.deviation.is_of_angle())?;
    let Minimum { point, at_end } = curve.minimum?;
    let value = in_unit(point.value?, column.unit.symbol(curve.deviation));
    let ends = point.interval.map(|ends| format!(" ({})", interval(ends.into()))).unwrap_or_default();
    let end = if at_end { ", where the curve ends" } else { "" };
    Some(format!("{value}{ends} at τ = {} s{end}", significant(point.tau_s, DIGITS)))
}
