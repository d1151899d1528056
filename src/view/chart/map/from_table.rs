//! A map from the columns of a table.

use crate::chart::{Chart, Shows};
use crate::key::scale::Scale;
use crate::table::Table;
use crate::view::chart::figure::Entry;
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
        let mut competing = grouping(of, &rows);
        let series_of = |row: usize| of.map_or(0, |of| style(&competing, &of.cells[row]));
        let series = competing.entries.len().max(1);
        let grid = Grid::new(table, &rows, (x, chart.x_scale), (y, chart.y_scale), series, series_of)?;
        let estimate =
            |row: &Option<usize>| row.and_then(|row| Some((z.cells[row].number()?, z.interval(row))));
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
                let (won, merged) = winners(&mut competing.entries, &estimates);
                notes.merged = merged;
                // Neither merged entries nor those of ties, which come last.
                let layer = |entry: &Entry| {
                    let values = estimates.get_mut(entry.style).map(std::mem::take)?;
                    Some(Layer { style: entry.style, name: entry.name.clone(), values })
                };
                let layers = competing.entries.iter().filter_map(layer).collect();
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
            chosen: table.chosen(&filter)?,
            columns: grid.columns,
            rows: grid.rows,
        };
        notes.within_limit = map.within_limit().map(|within| (within, map.known()));
        Ok((map, notes))
    }
}
