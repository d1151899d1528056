//! The cells of a map to which rows of a table belong.

use std::collections::HashMap;

use crate::key::scale::Scale;
use crate::table::{Column, Table};
use crate::view::chart::notes::ChartError;

/// The different values of an axis of a grid, ascending, and the index of each by its text in files.
fn lines(column: &Column, rows: &[usize], scale: Scale) -> (Vec<f64>, HashMap<String, usize>) {
    let shown = |&row: &usize| column.cells[row].number().filter(|value| scale.shows(*value));
    let mut cells: Vec<(f64, String)> =
        rows.iter().filter_map(|row| Some((shown(row)?, column.cells[*row].text()))).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    cells.dedup_by(|a, b| a.1 == b.1);
    let (values, texts): (Vec<f64>, Vec<String>) = cells.into_iter().unzip();
    (values, texts.into_iter().zip(0..).collect())
}

/// The values along two axes, with the rows on each cell.
pub(crate) struct Grid {
    pub columns: Vec<f64>,
    pub rows: Vec<f64>,
    /// Row of the table on each cell, for each series.
    pub found: Vec<Vec<Option<usize>>>,
    /// Number of rows of the table without a cell.
    pub off_axes: usize,
}

impl Grid {
    /// Assigns the `rows` of a table to cells by their columns x and y, separately for each of `series` series, which
    /// `series_of` gives for a row.
    ///
    /// # Errors
    /// Two rows of one series fall on one cell.
    pub(crate) fn new(
        table: &Table,
        rows: &[usize],
        (x, x_scale): (&Column, Scale),
        (y, y_scale): (&Column, Scale),
        series: usize,
        series_of: impl Fn(usize) -> usize,
    ) -> Result<Grid, ChartError> {
        let ((columns, across), (lines, down)) = (lines(x, rows, x_scale), lines(y, rows, y_scale));
        let mut found = vec![vec![None; columns.len() * lines.len()]; series];
        let mut off_axes = 0;
        for &row in rows {
            let place = across.get(&x.cells[row].text()).zip(down.get(&y.cells[row].text()));
            let Some((&column, &line)) = place else {
                off_axes += 1;
                continue;
            };
            let cell = &mut found[series_of(row)][line * columns.len() + column];
            if let Some(earlier) = *cell {
                return Err(several(table, [x, y], earlier, row));
            }
            *cell = Some(row);
        }
        Ok(Grid { columns, rows: lines, found, off_axes })
    }
}

/// The error for two rows on one cell. They differ first in a swept column, in the filler or in the error, which
/// precede all estimates.
fn several(table: &Table, axes: [&Column; 2], a: usize, b: usize) -> ChartError {
    let shown = |column: &Column, row: usize| column.cells[row].text();
    let at = axes.map(|axis| format!("{} = {}", axis.name, shown(axis, a)));
    let differing = table.columns.iter().find(|column| shown(column, a) != shown(column, b));
    ChartError::SeveralRows {
        cell: at.join(", "),
        column: differing.map(|column| column.name.clone()),
        values: differing.map_or(vec![], |column| vec![shown(column, a), shown(column, b)]),
    }
}
