//! The results of a study in a terminal.

use sagnac::chart::{Chart, Source};
use sagnac::quantity::number::significant;
use sagnac::report::chart::notes::ChartError;
use sagnac::run::Tables;
use sagnac::study::Study;
use sagnac::table::text::{aligned, pivot};
use sagnac::table::{Cell, Column, ColumnError, Role, Table, Usual};
use sagnac::view::picture::{refused, written};
use sagnac::view::stack::Shown as Curves;

use crate::failure::Failure;
use crate::look;

/// The table of the first chart and the coefficients, for people.
pub(crate) fn summary(study: &Study, tables: &Tables, curves: &[Curves]) -> Result<String, Failure> {
    let failed = |error: ColumnError| Failure::Picture(error.to_string());
    let points = &tables.points;
    let brief: Vec<&Column> = points.columns.iter().filter(|column| column.brief).collect();
    let shown = match study.charts.iter().zip(curves).next() {
        Some((chart, shown)) if !(shown.is_supplied(chart) && study.sweeps.is_empty()) => {
            of_chart(study, points, shown, chart).map_err(|error| refused(study, chart, &error))?
        }
        _ if study.sweeps.is_empty() && !brief.is_empty() => {
            let keys = points.columns.iter().filter(|column| column.role == Role::Key && !column.brief);
            listed(&keys.chain(brief).collect::<Vec<_>>())
        }
        _ => undrawn(study, points).map_err(failed)?,
    };
    let mut text = shown;
    if let Some(coefficients) = &tables.coefficients {
        text += &format!("\n{}", coefficients_found(study, coefficients));
    }
    Ok(text)
}

/// Each column of a table on its own line, with its values.
fn columns(table: &Table) -> String {
    let table = table.read();
    let line = |column: &Column| {
        let cells = column.cells.iter().map(|cell| cell.rounded(6));
        std::iter::once(column.title()).chain(cells).collect::<Vec<String>>()
    };
    aligned(&table.columns.iter().map(line).collect::<Vec<_>>(), look::columns())
}

/// The points of a study without a chart as a grid, as after sweeps over names alone. Of the texts that a summary of
/// one point lists, only the usual one is shown.
fn undrawn(study: &Study, table: &Table) -> Result<String, ColumnError> {
    let Some(estimate) = table.usual(Usual::Estimate).filter(|_| !study.kind().is_exact) else {
        return Ok(columns(table));
    };
    let mut rows = study.usual_rows();
    rows.retain(|(name, _)| table.column(name).is_ok_and(|column| column.brief));
    let [first, last] = lines(table);
    let swept = study.sweeps.iter().map(|sweep| sweep.key.name);
    let across: Vec<&str> = first.into_iter().chain(swept).chain(last).collect();
    pivot(table, &across, &estimate.name, &[], &study.text_columns(Source::Points), &rows, look::columns())
}

/// The columns of a table of points that label lines, before and after those of swept keys: an abscissa that
/// distinguishes rows, and the text that names its places otherwise.
fn lines(table: &Table) -> [Option<&str>; 2] {
    let name = |usual| table.usual(usual).map(|column| column.name.as_str());
    match name(Usual::Places) {
        None => [name(Usual::Abscissa), None],
        places => [None, places],
    }
}

/// The rows of a chart as a grid.
fn of_chart(study: &Study, points: &Table, shown: &Curves, chart: &Chart) -> Result<String, ChartError> {
    let table: &Table = &shown.table;
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    let across: Vec<&str> = match lines(points) {
        // Compensations are side by side, and ticks one below the other.
        [_, Some(last)] => sweeps.chain([last]).collect(),
        [None, None] if !study.sweeps.is_empty() => sweeps.collect(),
        _ => {
            let x = table.column(&chart.x.name)?.name.as_str();
            std::iter::once(x).chain(sweeps.filter(|sweep| *sweep != x)).collect()
        }
    };
    let series: Vec<&str> = shown.series.iter().map(String::as_str).collect();
    let texts = study.text_columns(chart.source);
    Ok(pivot(table, &across, &shown.estimate, &series, &texts, &written(study, chart), look::columns())?)
}

/// Some columns, with a line for each of their rows.
fn listed(columns: &[&Column]) -> String {
    let line = |row: usize| columns.iter().map(|column| column.cells[row].rounded(4)).collect();
    let heading: Vec<String> = columns.iter().map(|column| column.title()).collect();
    let rows = columns.first().map_or(0, |column| column.cells.len());
    aligned(&std::iter::once(heading).chain((0..rows).map(line)).collect::<Vec<_>>(), look::columns())
}

/// Most coefficients that are shown in addition to their file.
const MAX_COEFFICIENTS: usize = 24;

/// The coefficients of every point, one per line.
fn coefficients_found(study: &Study, table: &Table) -> String {
    if table.rows() > MAX_COEFFICIENTS {
        return format!("coefficients of {} points are in coefficients.csv\n", points_of(study));
    }
    let (table, swept) = (table.read(), study.sweeps.len());
    let (keys, own) = table.columns.split_at(swept);
    let columns: Vec<&Column> = keys.iter().chain(own.iter().filter(|column| column.brief)).collect();
    let heading = |(at, column): (usize, &&Column)| {
        if at < swept { column.title() } else { column.name.clone() }
    };
    let line = |row: usize| {
        let cell = |column: &&Column| match &column.cells[row] {
            Cell::Number(x) => significant(*x, 4),
            cell => cell.text(),
        };
        columns.iter().map(cell).collect::<Vec<String>>()
    };
    let mut lines = vec![columns.iter().enumerate().map(heading).collect::<Vec<String>>()];
    lines.extend((0..table.rows()).map(line));
    format!("coefficients found in each record\n{}", aligned(&lines, look::columns()))
}

fn points_of(study: &Study) -> usize {
    study.sweeps.iter().map(|sweep| sweep.values.len()).product()
}
