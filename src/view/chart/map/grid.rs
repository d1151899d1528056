//! The cells that rows of a table fall on.

use std::collections::HashMap;

use crate::key::scale::Scale;
use crate::table::{Column, Table};
use crate::view::chart::notes::ChartError;

/// One axis of a grid: its different values, as files show them.
struct Lines {
    /// Values, ascending.
    values: Vec<f64>,
    /// The place of each value that files show, as text.
    places: HashMap<String, usize>,
}

impl Lines {
    fn new(column: &Column, rows: &[usize], scale: Scale) -> Lines {
        let shown = |&row: &usize| column.cells[row].number().filter(|value| scale.shows(*value));
        let mut cells: Vec<(f64, String)> =
            rows.iter().filter_map(|row| Some((shown(row)?, column.cells[*row].text()))).collect();
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.dedup_by(|a, b| a.1 == b.1);
        let places = cells.iter().enumerate().map(|(place, (_, text))| (text.clone(), place)).collect();
        Lines { values: cells.into_iter().map(|cell| cell.0).collect(), places }
    }
}

/// The values along two axes, and what falls on which cell.
pub(crate) struct Grid {
    pub columns: Vec<f64>,
    pub rows: Vec<f64>,
    /// For each series, the row of the table on each cell.
    pub found: Vec<Vec<Option<usize>>>,
    /// Rows of the table without a place.
    pub off_axes: usize,
}

impl Grid {
    /// Places the `rows` of a table by their columns x and y, apart for each of `series` as `series_of` a row says.
    ///
    /// # Errors
    /// Two rows of one series fall on one cell.
    pub fn new(
        table: &Table,
        rows: &[usize],
        (x, x_scale): (&Column, Scale),
        (y, y_scale): (&Column, Scale),
        series: usize,
        series_of: impl Fn(usize) -> usize,
    ) -> Result<Grid, ChartError> {
        let (across, down) = (Lines::new(x, rows, x_scale), Lines::new(y, rows, y_scale));
        let cells = across.values.len() * down.values.len();
        let mut found = vec![vec![None; cells]; series];
        let mut off_axes = 0;
        for &row in rows {
            let place = across.places.get(&x.cells[row].text()).zip(down.places.get(&y.cells[row].text()));
            let Some((&column, &line)) = place else {
                off_axes += 1;
                continue;
            };
            let cell = &mut found[series_of(row)][line * across.values.len() + column];
            if let Some(earlier) = *cell {
                return Err(several(table, [x, y], earlier, row));
            }
            *cell = Some(row);
        }
        Ok(Grid { columns: across.values, rows: down.values, found, off_axes })
    }
}

/// Two rows are on one cell: they differ first in a swept column, in the filler or in the error, which stand before all
/// estimates.
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
