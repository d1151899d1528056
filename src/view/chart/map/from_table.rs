//! A map from the columns of a table.

use crate::chart::{Chart, Shows};
use crate::key::scale::Scale;
use crate::table::{Column, Table};
use crate::view::chart::figure::{Entry, Grouping};
use crate::view::chart::from_table::{axis, check_unit, grouping, limit, numbers, style};
use crate::view::chart::map::grid::Grid;
use crate::view::chart::map::winners::winners;
use crate::view::chart::map::{Cells, Estimate, Layer, Map};
use crate::view::chart::notes::{ChartError, MapNotes};

impl Map {
    /// The map of `table` that `chart` selects, with a cell for each pair of values of x and y.
    ///
    /// # Errors
    /// Two rows fall on one cell, or two of one series where series compete; a limit has another unit than z; both axes
    /// have the same column; or a column is missing, holds text instead of numbers, or has no row with a selected
    /// value.
    pub fn from_table(table: &Table, chart: &Chart) -> Result<(Map, MapNotes), ChartError> {
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
        let filter = chart.filter();
        let rows = table.rows_where(&filter)?;
        let competing = grouping(of, &rows);
        let series_of = |row: usize| of.map_or(0, |of| style(&competing, &of.cells[row]));
        let series = competing.entries.len().max(1);
        let grid = Grid::new(table, &rows, (x, chart.x_scale), (y, chart.y_scale), series, series_of)?;
        let mut notes = MapNotes { off_axes: grid.off_axes, ..MapNotes::default() };
        let estimates = estimates(&grid, z, series);
        let ((cells, layers), z_scale) = match chart.shows {
            Shows::HeatMap { z_scale, .. } => (heat(&grid, z, z_scale, estimates, &mut notes), z_scale),
            _ => (competition(&grid, z, competing, estimates, &mut notes), Scale::Linear),
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
            chosen: table.chosen(&filter)?,
            columns: grid.columns,
            rows: grid.rows,
        };
        notes.within_limit = map.within_limit().map(|within| (within, map.known()));
        Ok((map, notes))
    }
}

/// The estimate of each cell, for each of `series` series.
fn estimates(grid: &Grid, z: &Column, series: usize) -> Vec<Vec<Option<Estimate>>> {
    let estimate = |row: &Option<usize>| row.and_then(|row| Some((z.cells[row].number()?, z.interval(row))));
    grid.found.iter().take(series).map(|found| found.iter().map(estimate).collect()).collect()
}

/// The value of each cell, where the scale can show it.
fn heat(
    grid: &Grid,
    z: &Column,
    scale: Scale,
    estimates: Vec<Vec<Option<Estimate>>>,
    notes: &mut MapNotes,
) -> (Cells, Vec<Layer>) {
    let mut value = |row: &Option<usize>| {
        let Some(row) = row else {
            notes.no_row += 1;
            return None;
        };
        let Some(value) = z.cells[*row].number() else {
            notes.blank += 1;
            return None;
        };
        if !scale.shows(value) {
            notes.left_out += 1;
        }
        Some(value).filter(|value| scale.shows(*value))
    };
    let cells = grid.found.iter().flatten().map(&mut value).collect();
    let layers = estimates.into_iter().map(|values| Layer { style: 0, name: String::new(), values });
    (Cells::Values(cells), layers.collect())
}

/// The winner of each cell in which the values of all competitors are known.
fn competition(
    grid: &Grid,
    z: &Column,
    mut of: Grouping,
    mut estimates: Vec<Vec<Option<Estimate>>>,
    notes: &mut MapNotes,
) -> (Cells, Vec<Layer>) {
    for cell in 0..grid.columns.len() * grid.rows.len() {
        if grid.found.iter().any(|found| found[cell].is_none()) {
            notes.no_row += 1;
        } else if estimates.iter().any(|values| values[cell].is_none()) {
            notes.blank += 1;
        }
    }
    estimates.truncate(of.entries.len());
    let (won, merged) = winners(&mut of.entries, &estimates);
    notes.merged = merged;
    // Neither merged entries nor those of ties, which come last.
    let layer = |entry: &Entry| {
        let values = estimates.get_mut(entry.style).map(std::mem::take)?;
        Some(Layer { style: entry.style, name: entry.name.clone(), values })
    };
    let layers = of.entries.iter().filter_map(layer).collect();
    (Cells::Winners { of, won, banded: z.band.is_some() }, layers)
}
