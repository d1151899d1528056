//! A map from the columns of a table.

use std::collections::HashMap;

use crate::view::from_table::{axis, check_unit, grouping, limit, numbers, style};
use sagnac_base::table::{Column, Table};
use sagnac_engine::chart::{Chart, Shows};
use sagnac_engine::key::sweep::Scale;
use sagnac_report::chart::figure::Entry;
use sagnac_report::chart::map::{Cells, Estimate, Layer, Map, winners};
use sagnac_report::chart::notes::{ChartError, MapNotes};
use sagnac_report::chart::palette::styles;

/// The map of `table` that `chart` selects, with a cell for each pair of values of x and y.
///
/// # Errors
/// Two rows fall on one cell, or two of one series where series compete; a limit has another unit than z; both axes
/// have the same column; or a column is missing, holds text instead of numbers, or has no row with a selected
/// value.
pub fn map(table: &Table, chart: &Chart) -> Result<(Map, MapNotes), ChartError> {
    let filter = chart.filter();
    let (rows, chosen) = (table.rows_where(&filter)?, table.chosen(&filter)?);
    let table: &Table = &table.read();
    let estimate = &chart.estimate().name;
    let (x, y, z) =
        (numbers(table, &chart.x.name)?, numbers(table, &chart.y.name)?, numbers(table, estimate)?);
    check_unit(estimate, z, [chart.limit.map(|limit| ("limit", limit.unit))])?;
    if x.name == y.name {
        return Err(ChartError::SameAxes { column: chart.y.name.clone() });
    }
    let of = match &chart.shows {
        Shows::WinnerMap { of, .. } => Some(table.column(&of.name)?),
        _ => None,
    };
    let mut competing = grouping(of, &rows);
    let series_of = |row: usize| of.map_or(0, |of| style(&competing, &of.cells[row]));
    let series = competing.entries.len().max(1);
    let grid = Grid::new(table, &rows, (x, chart.x_scale), (y, chart.y_scale), series, series_of)?;
    let estimate = |row: &Option<usize>| row.and_then(|row| Some((z.cells[row].number()?, z.interval(row))));
    let mut estimates: Vec<Vec<Option<Estimate>>> =
        grid.found.iter().map(|found| found.iter().map(estimate).collect()).collect();
    let mut notes = MapNotes { off_axes: grid.off_axes, ..MapNotes::default() };
    for cell in 0..grid.columns.len() * grid.rows.len() {
        if grid.found.iter().any(|found| found[cell].is_none()) {
            notes.no_row += 1;
        } else if estimates.iter().any(|values| values[cell].is_none()) {
            notes.blank += 1;
        }
    }
    let (cells, layers, z_scale) = match chart.shows {
        Shows::HeatMap { z_scale, .. } => {
            let values = estimates.swap_remove(0);
            let known = || values.iter().map(|estimate| estimate.map(|(value, _)| value));
            notes.left_out = known().flatten().filter(|value| !z_scale.shows(*value)).count();
            let shown = known().map(|value| value.filter(|value| z_scale.shows(*value))).collect();
            (Cells::Values(shown), vec![Layer { style: 0, name: String::new(), values }], z_scale)
        }
        _ => {
            estimates.truncate(competing.entries.len());
            // Ties come behind the competitors.
            let of_names = styles(of, &competing.entries);
            let first = of_names.iter().copied().max().map_or(0, |most| most + 1);
            let styled =
                |place: usize| of_names.get(place).copied().unwrap_or_else(|| first + place - of_names.len());
            let (mut won, merged) = winners(&mut competing.entries, &estimates);
            notes.merged = merged;
            // Neither merged entries nor those of ties, which come last.
            let layer = |entry: &Entry| {
                let values = estimates.get_mut(entry.style).map(std::mem::take)?;
                Some(Layer { style: styled(entry.style), name: entry.name.clone(), values })
            };
            let layers = competing.entries.iter().filter_map(layer).collect();
            won.iter_mut().flatten().for_each(|won| won.style = styled(won.style));
            competing.entries.iter_mut().for_each(|entry| entry.style = styled(entry.style));
            (Cells::Winners { of: competing, won, banded: z.band.is_some() }, layers, Scale::Linear)
        }
    };
    let map = Map {
        title: chart.title.clone(),
        subtitle: chart.subtitle(),
        x: axis(x, chart.x_scale),
        y: axis(y, chart.y_scale),
        z: axis(z, z_scale),
        cells,
        layers,
        limit: chart.limit.map(limit),
        chosen,
        columns: grid.columns,
        rows: grid.rows,
    };
    notes.within_limit = map.within_limit().map(|within| (within, map.known()));
    Ok((map, notes))
}
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
struct Grid {
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// Row of the table on each cell, for each series.
    found: Vec<Vec<Option<usize>>>,
    /// Number of rows of the table without a cell.
    off_axes: usize,
}

impl Grid {
    /// Assigns the `rows` of a table to cells by their columns x and y, separately for each of `series` series, which
    /// `series_of` gives for a row.
    ///
    /// # Errors
    /// Two rows of one series fall on one cell.
    fn new(
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

#[cfg(test)]
mod tests;
