//! A map from the columns of a table.

use super::super::from_table::{axis, check_unit, grouping, limit, numbers, style};
use super::super::spec::ChartError;
use super::super::{Grouping, Scale};
use super::grid::Grid;
use super::winners::winners;
use super::{Cells, Map, MapNotes, MapSpec, Show};
use crate::table::{Column, Table};

impl Map {
    /// The map of `table` that `spec` describes, with a cell for each pair of values of x and y.
    ///
    /// # Errors
    /// Two rows on one cell, or of one series where series compete; a limit in another unit than that of z; the same column for
    /// both axes; a column that is not there, holds text instead of numbers, or has no row with a value asked for.
    pub fn from_table(table: &Table, spec: &MapSpec) -> Result<(Map, MapNotes), ChartError> {
        let (x, y, z) = (numbers(table, &spec.x)?, numbers(table, &spec.y)?, numbers(table, &spec.z)?);
        check_unit(&spec.z, z, [spec.limit.map(|limit| ("limit", limit.1))])?;
        if x.name == y.name {
            return Err(ChartError::SameAxes { column: spec.y.clone() });
        }
        let of = match &spec.show {
            Show::Values(_) => None,
            Show::Winners(of) => Some(table.column(of)?),
        };
        let rows = table.rows_where(&spec.filter)?;
        let competing = grouping(of, &rows);
        let series_of = |row: usize| of.map_or(0, |of| style(&competing, &of.cells[row]));
        let series = competing.entries.len().max(1);
        let grid = Grid::new(table, &rows, (x, spec.x_scale), (y, spec.y_scale), series, series_of)?;
        let mut notes = MapNotes { off_axes: grid.off_axes, ..MapNotes::default() };
        let (cells, z_scale) = match &spec.show {
            Show::Values(scale) => (Cells::Values(values(&grid, z, *scale, &mut notes)), *scale),
            Show::Winners(_) => (competition(&grid, z, competing, &mut notes), Scale::Linear),
        };
        let map = Map {
            title: spec.title.clone(),
            subtitle: spec.subtitle.clone(),
            x: axis(x, spec.x_scale),
            y: axis(y, spec.y_scale),
            z: axis(z, z_scale),
            cells,
            limit: spec.limit.map(|(value, _)| limit(value, z)),
            chosen: table.chosen(&spec.filter)?,
            columns: grid.columns,
            rows: grid.rows,
        };
        notes.within_limit = map.within_limit().map(|within| (within, map.known()));
        Ok((map, notes))
    }
}

/// The value of each cell that the scale can show.
fn values(grid: &Grid, z: &Column, scale: Scale, notes: &mut MapNotes) -> Vec<Option<f64>> {
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
    grid.found.iter().flatten().map(&mut value).collect()
}

/// The winner of each cell in which the value of everyone who competes is known.
fn competition(grid: &Grid, z: &Column, mut of: Grouping, notes: &mut MapNotes) -> Cells {
    let cells = grid.columns.len() * grid.rows.len();
    let mut values = vec![vec![None; cells]; of.entries.len()];
    for cell in 0..cells {
        let rows: Vec<Option<usize>> = grid.found.iter().map(|found| found[cell]).collect();
        let known: Vec<Option<f64>> =
            rows.iter().map(|row| row.and_then(|row| z.cells[row].number())).collect();
        if rows.contains(&None) {
            notes.no_row += 1;
        } else if known.contains(&None) {
            notes.blank += 1;
        }
        let band = |row: usize| z.band.as_ref().and_then(|band| band.get(row).copied().flatten());
        for (series, (row, value)) in rows.iter().zip(known).enumerate() {
            values[series][cell] = value.map(|value| (value, row.and_then(band)));
        }
    }
    let (won, merged) = winners(&mut of.entries, &values);
    notes.merged = merged;
    Cells::Winners { of, won, banded: z.band.is_some() }
}
