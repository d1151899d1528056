//! Figures and maps from a table and the specification of its chart.

use std::collections::HashMap;

use crate::view::Shown;
use sagnac_base::table::{Cell, Column, Role, Table, Unit, grouped};
use sagnac_engine::chart::{self, Chart, Shows};
use sagnac_engine::key::sweep::Scale;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Limit, Series, SeriesPoint};
use sagnac_report::chart::map::{Cells, Estimate, Layer, Map, winners};
use sagnac_report::chart::palette::styles;
use sagnac_report::chart::{ChartError, MapNotes, Notes};

/// The curves of `table` that `chart` selects, in the order of their first rows, with points by rising x. Identical
/// curves are merged by [`Figure::merge_coincident`].
///
/// # Errors
/// A limit or a law has another unit than y; a column is missing, holds text instead of numbers, or has no row with
/// a selected value; or a curve runs through rows that belong to several curves.
pub fn figure(table: &Table, chart: &Chart) -> Result<(Figure, Notes), ChartError> {
    let Shown { table, estimate, series } = Shown::new(table, chart)?;
    let filter = chart.filter();
    let (rows, chosen) = (table.rows_where(&filter)?, table.chosen(&filter)?);
    let table: &Table = &table.read();
    let (x, y) = (table.column(&chart.x.name)?, numbers(table, &estimate)?);
    let law = chart.references().first().map(|law| ("law", law.about().unit));
    check_unit(&estimate, y, [chart.limit.map(|limit| ("limit", limit.unit)), law])?;
    let laws =
        chart.references().iter().map(|law| numbers(table, law.column())).collect::<Result<Vec<_>, _>>()?;
    let theory = table.beside(y, Role::Theory);
    let is_key = |column: &&Column| x.role == Role::Coordinate && column.name == x.of;
    let key = table.columns.iter().find(is_key);
    let (colours, dashes) = match &series[..] {
        [] => (None, None),
        [colour] => (Some(table.column(colour)?), None),
        [colour, dash] => (Some(table.column(colour)?), Some(table.column(dash)?)),
        more => return Err(ChartError::TooManySeries { found: more.len() }),
    };
    check_curves(table, chart, &series, &rows)?;
    let mut figure = Figure {
        title: chart.title.clone(),
        subtitle: chart.subtitle(),
        x: named_axis(x, &rows).unwrap_or_else(|| axis(x, chart.x_scale)),
        y: axis(y, chart.y_scale),
        key: key.map(|key| axis(key, Scale::Linear)),
        colours: styled(colours, &rows),
        dashes: styled(dashes, &rows),
        // The closed form is not sampled.
        points: if y.role == Role::Theory { "closed form".to_owned() } else { chart.points.clone() },
        bands: chart.bands.clone(),
        lines: "closed form".to_owned(),
        limit: chart.limit.map(limit),
        chosen,
        ..Figure::default()
    };
    let mut notes = Notes::default();
    let names = figure.x.names.clone();
    let place = |row: usize| match names.is_empty() {
        true => x.cells[row].number(),
        false => Some(1.0 + names.iter().position(|name| *name == x.cells[row].text())? as f64),
    };
    // Rows without a place on an axis where other rows have one are of another kind, such as the sum of all ticks.
    let some = rows.iter().any(|&row| place(row).is_some());
    let rows = rows.into_iter().filter(|&row| !some || x.cells[row] != Cell::Blank);
    let styles = |row: usize| {
        let of = |column: Option<&Column>, grouping| {
            column.map_or(0, |column| style(grouping, &column.cells[row]))
        };
        (of(colours, &figure.colours), of(dashes, &figure.dashes))
    };
    let mut curves = grouped(rows, styles);
    for ((colour, dash), rows) in &mut curves {
        let all = rows.len();
        rows.retain(|&row| place(row).is_some());
        rows.sort_by(|&a, &b| place(a).unwrap_or(f64::NAN).total_cmp(&place(b).unwrap_or(f64::NAN)));
        let point = |&row: &usize| {
            Some(SeriesPoint {
                x: place(row)?,
                y: y.cells[row].number()?,
                band: y.interval(row),
                key: key.and_then(|key| key.cells[row].number()),
            })
        };
        let points: Vec<SeriesPoint> = rows.iter().filter_map(point).collect();
        notes.blank += all - points.len();
        let law = theory.map_or(vec![], |theory| with_gaps(theory, rows, place));
        figure.series.push(Series { colour: *colour, dash: *dash, points, law });
    }
    // In the order of the legend.
    curves.sort_by_key(|(styles, _)| *styles);
    figure.laws = laws
        .iter()
        .map(|law| Law {
            label: law.label.clone(),
            is_area: false,
            lines: curves
                .iter()
                .map(|((colour, _), rows)| LawLine {
                    colours: vec![*colour],
                    points: along(law, rows, place),
                })
                .collect(),
        })
        .collect();
    notes.left_out = figure.left_out();
    figure.leave_out_unseen();
    if figure.has_laws() && figure.x.names.is_empty() && !figure.series.iter().all(Series::has_law) {
        "closed form, else joined".clone_into(&mut figure.lines);
    }
    let units = [axis_unit(x, chart.x_scale), axis_unit(y, chart.y_scale)];
    figure.rescale([units[0].0, units[1].0]);
    [figure.x.unit, figure.y.unit] = units.map(|(_, unit)| unit.to_owned());
    notes.merged = figure.merge_coincident();
    notes.coincident = figure.coincident();
    figure.merge_laws();
    Ok((figure, notes))
}

/// The column with that name, if it holds numbers.
pub(crate) fn numbers<'t>(table: &'t Table, name: &str) -> Result<&'t Column, ChartError> {
    let column = table.column(name)?;
    match column.cells.iter().find(|cell| matches!(cell, Cell::Text(_))) {
        Some(text) => Err(ChartError::NotNumbers { column: name.to_owned(), example: text.text() }),
        None => Ok(column),
    }
}

/// Refuses the first item `beside` a column that has another unit.
pub(crate) fn check_unit<const N: usize>(
    name: &str,
    column: &Column,
    beside: [Option<(&'static str, Unit)>; N],
) -> Result<(), ChartError> {
    match beside.into_iter().flatten().find(|(_, wanted)| column.unit != *wanted) {
        Some((beside, wanted)) => {
            let (column, unit) = (name.to_owned(), column.unit.symbol.to_owned());
            Err(ChartError::OtherUnit { column, unit, beside, wanted: wanted.symbol })
        }
        None => Ok(()),
    }
}

pub(crate) fn axis(column: &Column, scale: Scale) -> Axis {
    let mut cells = column.cells.iter().filter(|cell| **cell != Cell::Blank).peekable();
    let whole = cells.peek().is_some() && cells.all(|cell| matches!(cell, Cell::Integer(_)));
    let unit = column.unit.symbol.to_owned();
    let (label, defined) = (column.label.clone(), column.defined.to_owned());
    let sizes = || column.cells.iter().filter_map(Cell::number);
    let times = column.unit == Unit::S
        && scale == Scale::Log
        && sizes().all(|seconds| seconds >= 60.0)
        && sizes().any(|seconds| seconds >= 3600.0);
    Axis { label, defined, unit, scale, whole, names: vec![], times }
}

/// The factor and the sign of the unit in which an axis shows a column: fractions in percent as limits of them are, angle random
/// walks in °/√h, large rates in °/s, and times on a linear axis by their size.
pub(crate) fn axis_unit(column: &Column, scale: Scale) -> (f64, &'static str) {
    let largest =
        || column.cells.iter().filter_map(Cell::number).fold(0.0, |most: f64, value| most.max(value.abs()));
    match (column.unit, scale) {
        _ if column.is_relative() => (100.0, "%"),
        (Unit::ARCSEC_PER_RT_S, _) => (1.0 / 60.0, "°/√h"),
        (Unit::ARCSEC_PER_S, _) if largest() >= 36_000.0 => (1.0 / 3600.0, "°/s"),
        (Unit::S, Scale::Linear) if largest() >= 259_200.0 => (1.0 / 86_400.0, "d"),
        (Unit::S, Scale::Linear) if largest() >= 10_800.0 => (1.0 / 3600.0, "h"),
        (Unit::S, Scale::Linear) if largest() >= 600.0 => (1.0 / 60.0, "min"),
        (unit, _) => (1.0, unit.symbol),
    }
}

/// An axis with the different texts of a column side by side, in the order of their first rows; `None` for numbers.
fn named_axis(column: &Column, rows: &[usize]) -> Option<Axis> {
    let mut names: Vec<String> = vec![];
    for &row in rows {
        if let Cell::Text(name) = &column.cells[row]
            && !names.contains(name)
        {
            names.push(name.clone());
        }
    }
    (!names.is_empty()).then(|| Axis { whole: true, names, ..axis(column, Scale::Linear) })
}

pub(crate) fn limit(limit: chart::Limit) -> Limit {
    Limit { value: limit.value, label: format!("limit {}", limit.text()) }
}

/// The different values of a column, in the order of their first rows, with the styles of their names.
fn styled(column: Option<&Column>, rows: &[usize]) -> Grouping {
    let mut grouping = grouping(column, rows);
    let styles = styles(column, &grouping.entries);
    grouping.entries.iter_mut().zip(styles).for_each(|(entry, style)| entry.style = style);
    grouping
}

/// The different values of a column, in the order of their first rows.
pub(crate) fn grouping(column: Option<&Column>, rows: &[usize]) -> Grouping {
    let Some(column) = column else {
        return Grouping::default();
    };
    let mut entries: Vec<Entry> = vec![];
    for name in rows.iter().map(|&row| name(&column.cells[row])) {
        if entries.iter().all(|entry| entry.name != name) {
            entries.push(Entry { style: entries.len(), name });
        }
    }
    Grouping { title: column.title(), entries }
}

/// The name of a value in the legend.
fn name(cell: &Cell) -> String {
    if *cell == Cell::Blank { "(blank)".to_owned() } else { cell.text() }
}

pub(crate) fn style(grouping: &Grouping, cell: &Cell) -> usize {
    let name = name(cell);
    grouping.entries.iter().find(|entry| entry.name == name).map_or(0, |entry| entry.style)
}

/// The values of a column over the places of some rows, from the first to the last row that has one; NaN where one between has
/// none.
fn with_gaps(column: &Column, rows: &[usize], place: impl Fn(usize) -> Option<f64>) -> Vec<(f64, f64)> {
    let has = |row: &usize| column.cells[*row].number().is_some();
    let Some((first, last)) = rows.iter().position(has).zip(rows.iter().rposition(has)) else {
        return vec![];
    };
    let value = |row: usize| column.cells[row].number().unwrap_or(f64::NAN);
    rows[first..=last].iter().filter_map(|&row| Some((place(row)?, value(row)))).collect()
}

/// The values of a column over the places of some rows.
fn along(column: &Column, rows: &[usize], place: impl Fn(usize) -> Option<f64>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|&row| place(row).zip(column.cells[row].number())).collect()
}

/// Refuses curves along which more than one of the columns that distinguish rows varies, or whose abscissa is constant
/// while one of them varies.
///
/// # Errors
/// A column is missing, or a curve is refused; the error is for the first such curve.
fn check_curves(table: &Table, chart: &Chart, series: &[String], rows: &[usize]) -> Result<(), ChartError> {
    let columns =
        |names: &[String]| names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>();
    let (x, series, apart) = (table.column(&chart.x.name)?, columns(series)?, columns(&chart.apart)?);
    let texts = |row: usize| series.iter().map(|column| column.cells[row].text()).collect::<Vec<_>>();
    let curves = grouped(rows.iter().copied(), texts);
    // The key with which x varies; for an estimate that of the first coordinate.
    let coordinate = |column: &&Column| column.role == Role::Coordinate && !column.of.is_empty();
    let base = Some(x).filter(coordinate).or_else(|| table.columns.iter().find(coordinate));
    let base = base.map_or("", |column| column.of.as_str());
    let mixed = curves.iter().find_map(|(_, rows)| Some((rows[0], mixed(x, base, &apart, rows)?)));
    let Some((row, (column, values))) = mixed else { return Ok(()) };
    let names: Vec<String> = series.iter().map(|column| column.valued(&column.cells[row].text())).collect();
    let (curve, column) = (names.join(", "), column.name.clone());
    Err(ChartError::MixedCurve { curve, column, values: values.into() })
}

/// The other column that varies along the rows of one curve, with two of its values.
fn mixed<'t>(
    x: &Column,
    base: &str,
    apart: &[&'t Column],
    rows: &[usize],
) -> Option<(&'t Column, [String; 2])> {
    let differ = |column: &Column, a: usize, b: usize| column.cells[a] != column.cells[b];
    let found = |column: &'t Column, a: usize, b: usize| (column, [a, b].map(|row| column.cells[row].text()));
    let mut varying: Vec<(&Column, usize)> = apart
        .iter()
        .filter_map(|column| Some((*column, *rows.iter().find(|&&row| differ(column, rows[0], row))?)))
        .collect();
    let named = |name: &str| varying.iter().position(|(column, _)| column.name == name);
    let along = named(&x.name).or_else(|| named(base));
    let along = (!varying.is_empty()).then(|| varying.remove(along.unwrap_or(0)));
    if let Some((column, row)) = varying.first() {
        return Some(found(column, rows[0], *row));
    }
    // An x that is constant while another column varies; an estimate may be constant by chance.
    let (column, row) = along?;
    // A value that follows from the study is not constant by chance.
    let coordinate = x.role == Role::Coordinate || apart.iter().any(|column| column.name == x.name);
    let known = x.cells[rows[0]] != Cell::Blank;
    let still = coordinate && known && !rows.iter().any(|&row| differ(x, rows[0], row));
    still.then(|| found(column, rows[0], row))
}

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
mod map_tests;
#[cfg(test)]
mod tests;
