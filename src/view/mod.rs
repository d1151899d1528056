//! The charts of a study: figures and maps from the rows of a table that a chart selects. [`Shown`] makes one column of several,
//! so that each is a curve.
//!
//! ```
//! use sagnac_engine::chart::{Chart, Limit, Shows};
//! use sagnac_engine::key::sweep::Scale;
//! use sagnac::table::{Cell, Column, Table, Unit};
//! use sagnac::view::from_table::{figure, map};
//! use sagnac::report::chart::Picture;
//!
//! let column = |name: &str, unit, values: &[f64]| Column {
//!     name: name.to_owned(),
//!     label: name.to_owned(),
//!     unit,
//!     cells: values.iter().map(|x| Cell::Number(*x)).collect(),
//!     ..Column::default()
//! };
//! let table = Table {
//!     columns: vec![
//!         column("frequency", Unit::HZ, &[2.0, 2.0, 20.0, 20.0]),
//!         column("amplitude", Unit::ARCSEC_PER_S, &[100.0, 1000.0, 100.0, 1000.0]),
//!         column("rms", Unit::ARCSEC, &[0.02, 0.2, 2.0, 20.0]),
//!     ],
//! };
//!
//! let curves = Chart {
//!     title: "Error".to_owned(),
//!     x: "frequency".into(),
//!     y: "rms".into(),
//!     shows: Shows::Curves { series: vec!["amplitude".into()], laws: vec![] },
//!     limit: Some(Limit { value: 10.0, unit: Unit::ARCSEC }),
//!     ..Chart::default()
//! };
//! let (drawn, notes) = figure(&table, &curves)?;
//! assert_eq!((drawn.series.len(), notes.left_out), (2, 0));
//! assert!(Picture::Curves(drawn).svg().starts_with("<svg"));
//!
//! let shows = Shows::HeatMap { z: "rms".into(), z_scale: Scale::Log };
//! let cells = Chart { y: "amplitude".into(), shows, ..curves };
//! let (drawn, _) = map(&table, &cells)?;
//! assert_eq!((drawn.known(), drawn.within_limit()), (4, Some(3)));
//! assert!(Picture::Map(drawn).svg().contains("Error"));
//! # Ok::<(), sagnac::report::chart::ChartError>(())
//! ```

pub mod from_table;

use std::borrow::Cow;

use crate::view::from_table::{figure, map};
use sagnac_base::diagnostics::{StudyError, nearest};
use sagnac_base::quantity::number::short;
use sagnac_base::quantity::{Dimension, bare};
use sagnac_base::table::{Cell, Column, ColumnError, Role, Table};
use sagnac_engine::chart::{Chart, Named, Shows, Source};
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::{explain_key, explained_keys};
use sagnac_engine::run::{RESOLVED, Tables};
use sagnac_engine::study::Study;
use sagnac_report::chart::{ChartError, Picture};
use sagnac_report::page::FILE as REPORT;

pub use sagnac_report::chart::Drawn;

/// The names of a chart's files, without their endings.
pub fn chart_stem(index: usize, charts: usize) -> String {
    if charts == 1 { "chart".to_owned() } else { format!("chart-{}", index + 1) }
}

/// The names of the files that a run of a study always writes into its folder.
pub fn file_names(study: &Study) -> Vec<String> {
    let inputs = study.inputs().into_iter().map(|input| input.name.clone());
    let charts = (0..study.charts.len()).map(|index| chart_stem(index, study.charts.len()));
    let pictures = charts.flat_map(|stem| ["svg", "png"].map(|ending| format!("{stem}.{ending}")));
    let fixed = [RESOLVED, REPORT, Source::Points.file()].map(str::to_owned);
    fixed.into_iter().chain(inputs).chain(pictures).collect()
}

/// What results say that lack trials.
pub fn incomplete(lacking: u64) -> Option<String> {
    (lacking > 0).then(|| format!("the run is incomplete: {} trials are missing", short(lacking as f64)))
}

/// All charts of a study, in order. Each states how many trials are `lacking`.
///
/// # Errors
/// The table lacks something that a chart requires; the error points at the name in the study. Charts of
/// [`Plan::blank_tables`](sagnac_engine::run::Plan::blank_tables) show this before anything is sampled.
pub fn pictures(study: &Study, tables: &Tables, lacking: u64) -> Result<Vec<Drawn>, StudyError> {
    let of = |(index, chart): (usize, &Chart)| {
        let table = tables.of(chart.source);
        let drawn = match &chart.shows {
            Shows::Curves { .. } => {
                figure(table, chart).map(|(figure, notes)| (Picture::Curves(figure), notes.sentence()))
            }
            Shows::HeatMap { .. } | Shows::WinnerMap { .. } => {
                map(table, chart).map(|(map, notes)| (Picture::Map(map), notes.sentence()))
            }
        };
        let (mut picture, note) = drawn.map_err(|error| refused(study, chart, &error))?;
        if lacking > 0 {
            picture.preface(&format!("Incomplete, {} trials are missing.", short(lacking as f64)));
        }
        Ok(Drawn { stem: chart_stem(index, study.charts.len()), picture, note })
    };
    study.charts.iter().enumerate().map(of).collect()
}

/// The part of a table that each chart of a study shows.
///
/// # Errors
/// The table lacks something that a chart requires.
pub fn shown<'t>(study: &Study, tables: &'t Tables) -> Result<Vec<Shown<'t>>, StudyError> {
    let of = |chart: &Chart| Shown::new(tables.of(chart.source), chart);
    study.charts.iter().map(|chart| of(chart).map_err(|error| refused(study, chart, &error))).collect()
}

/// The rows that a chart selects, without supplied values except those common to all charts of the table, which has a
/// row for each.
pub fn written(study: &Study, chart: &Chart) -> Vec<(String, String)> {
    let ground = study.ground(chart.source);
    let texts = ground.map_or(vec![], |ground| ground.texts);
    let is_usual = |name: &str| texts.iter().any(|text| text.name == name && text.usual.is_some());
    let asked = |(name, _): &&(Named, Cell)| !name.span.is_empty() || is_usual(&name.name);
    chart.rows.iter().filter(asked).map(|(column, value)| (column.name.clone(), value.text())).collect()
}

/// A chart's error at the name in the study that caused it.
pub fn refused(study: &Study, chart: &Chart, error: &ChartError) -> StudyError {
    let rows: Vec<&Named> = chart.rows.iter().map(|row| &row.0).collect();
    let estimates: Vec<&Named> = std::iter::once(chart.estimate()).chain(chart.columns()).collect();
    // A default has no place in the text; another name may have one.
    let place = |names: &[&Named], name: &str| {
        let written = names.iter().find(|named| named.name == name && !named.span.is_empty());
        written.map_or(0..0, |named| named.span.clone())
    };
    let file = chart.source.file();
    let mut column = format!("name a column of {file}, with or without its unit");
    if let ChartError::Column(ColumnError::Unknown { name, known }) = error {
        let is_called = |key: &&str| *key == name || key.ends_with(&format!(".{name}"));
        let is_swept = |key: &&str| explain_key(key).is_some_and(|key| key.swept.is_some());
        if let Some(key) = explained_keys().filter(is_called).find(is_swept) {
            column = format!(
                "{key} has a column where a [[sweep]] varies it; else {column}, or leave out the chart"
            );
        } else if let Some(nearest) = nearest_column(name, known) {
            column = format!("did you mean `{nearest}`? {column}");
        }
    }
    let (span, help) = match error {
        ChartError::Column(ColumnError::Unknown { name, .. } | ColumnError::Ambiguous { name, .. })
        | ChartError::NotNumbers { column: name, .. } => {
            let series: Vec<&Named> = chart.series().iter().collect();
            (place(&[&[&chart.x], &estimates[..], &series, &rows].concat(), name), column)
        }
        ChartError::Column(ColumnError::NoRow { column, .. }) => {
            (place(&rows, column), format!("`where` takes values that the column has in {file}"))
        }
        ChartError::OtherUnit { column, beside, wanted, .. } => {
            let instead = match *wanted {
                "" => "a relative column".to_owned(),
                unit => format!("an estimate in {unit}"),
            };
            let help = format!("name {instead} instead, or leave out the {beside}");
            (place(&estimates, column), help)
        }
        ChartError::Twice { column } => {
            // The first one with this name may be the other one.
            let last = chart.beside.iter().rev().find(|named| named.name == *column);
            (last.unwrap_or(&chart.y).span.clone(), "leave it out here".to_owned())
        }
        ChartError::SameAxes { .. } => (chart.y.span.clone(), "name another column as y".to_owned()),
        ChartError::SeveralRows { column, values, .. } => {
            let help = column.as_ref().zip(values.first()).map_or_else(
                || "choose one of the rows in `where`".to_owned(),
                |(column, value)| choose_one(study, column, value, |name| format!("make {name} an axis")),
            );
            (chart.estimate().span.clone(), help)
        }
        ChartError::MixedCurve { column, values, .. } => {
            let otherwise = |name: &str| match chart.series().len() {
                0 | 1 => format!("name {name} in `series` too"),
                _ => "make a chart for each".to_owned(),
            };
            let written = chart.series().iter().rev().map(|named| &named.span).find(|span| !span.is_empty());
            let first = values.first().map_or("", String::as_str);
            (written.unwrap_or(&chart.y.span).clone(), choose_one(study, column, first, otherwise))
        }
        ChartError::TooManySeries { .. } => (0..0, column),
    };
    study.error_at(span, format!("chart: {error}"), help)
}

/// The existing column whose name is most similar to an unknown one, without its unit.
fn nearest_column<'k>(name: &str, headers: &'k [String]) -> Option<&'k str> {
    let bare = |header: &'k String| bare(header).min_by_key(|name| name.len()).unwrap_or(header);
    nearest(name, &headers.iter().map(bare).collect::<Vec<_>>())
}

/// Advice to select one of several rows that differ in `column`, with an alternative for its name.
fn choose_one(study: &Study, column: &str, value: &str, otherwise: impl Fn(&str) -> String) -> String {
    // In the notation of studies, with the unit that files omit.
    let swept = study.sweeps.iter().find(|sweep| sweep.key.name == column);
    let shown = swept.and_then(|sweep| sweep.values.iter().find(|swept| swept.cell().text() == value));
    let value = match shown {
        Some(SweepValue::Quantity(quantity)) if quantity.dimension == Dimension::Count => {
            quantity.to_string()
        }
        Some(swept) => format!("\"{}\"", swept.to_string().replace(" ″", " arcsec").replace('″', " arcsec")),
        None => format!("\"{value}\""),
    };
    // The last part of a key suffices where no other sweep has the same ending; a key with dots is quoted.
    let last = |key: &str| key.rsplit('.').next().map(str::to_owned).unwrap_or_default();
    let alike = study.sweeps.iter().filter(|sweep| last(sweep.key.name) == last(column)).count();
    let name = if alike > 1 { format!("\"{column}\"") } else { last(column) };
    format!("choose one, as in where = {{ {name} = {value} }}, or {}", otherwise(&name))
}

/// The column with the names of the stacked quantities.
pub const CURVE: &str = "curve";

/// Separator in labels between the common quantity and its parts.
const BETWEEN: &str = ": ";

/// The table of a chart; for a chart of several columns, a table in which these are stacked.
#[derive(Debug)]
pub struct Shown<'t> {
    /// Table, with a column that distinguishes the stacked ones.
    pub table: Cow<'t, Table>,
    /// Column of the estimates.
    pub estimate: String,
    /// The columns whose values distinguish curves.
    pub series: Vec<String>,
}

impl<'t> Shown<'t> {
    /// The part of a table that `chart` shows.
    ///
    /// # Errors
    /// A column to be stacked is missing, is listed twice or has another unit.
    pub fn new(table: &'t Table, chart: &Chart) -> Result<Shown<'t>, ChartError> {
        let series = chart.series().iter().map(|column| column.name.clone());
        let estimate = chart.estimate().name.clone();
        if chart.beside.is_empty() {
            return Ok(Shown { table: Cow::Borrowed(table), estimate, series: series.collect() });
        }
        let names: Vec<&str> = chart.columns().map(|column| column.name.as_str()).collect();
        let table = Cow::Owned(stacked(table, &names)?);
        Ok(Shown { table, estimate, series: std::iter::once(CURVE.to_owned()).chain(series).collect() })
    }

    /// Whether names stand side by side on the abscissa.
    pub fn is_named(&self, chart: &Chart) -> bool {
        let x = self.table.column(&chart.x.name);
        x.is_ok_and(|x| x.cells.any(|cell| matches!(cell, Cell::Text(_))))
    }

    /// Whether the chart is supplied with names side by side instead of written, as where no number is swept.
    pub fn is_supplied(&self, chart: &Chart) -> bool {
        chart.x.span.is_empty() && self.is_named(chart)
    }
}

/// The table with the columns `names` below one another, under the name of the first. All other columns are repeated
/// for each, closed forms stay with their columns, and [`CURVE`] distinguishes them by their labels. For labels such as
/// `drift: bound` and `drift: mean`, the first part becomes the label of the stacked column, otherwise their common
/// last word does.
///
/// # Errors
/// A name selects no single column, an existing column is in the way, or a column has another unit than the first.
fn stacked(table: &Table, names: &[&str]) -> Result<Table, ChartError> {
    let mut columns: Vec<&Column> = vec![];
    for name in names {
        let column = table.column(name)?;
        if columns.iter().any(|earlier| earlier.name == column.name) {
            return Err(ChartError::Twice { column: (*name).to_owned() });
        }
        if let Some(first) = columns.first().filter(|first| first.unit != column.unit) {
            let (column, unit) = ((*name).to_owned(), column.unit.symbol.to_owned());
            return Err(ChartError::OtherUnit { column, unit, beside: "curve", wanted: first.unit.symbol });
        }
        columns.push(column);
    }
    let Some(first) = columns.first() else { return Ok(table.clone()) };
    let shared = first.label.split_once(BETWEEN).map(|(shared, _)| shared);
    let shared = shared.filter(|shared| columns.iter().all(|column| part(column, shared).is_some()));
    let label =
        |column: &Column| shared.and_then(|shared| part(column, shared)).unwrap_or(&column.label).to_owned();
    let heading = shared.unwrap_or("value").to_owned();
    let quantity = shared.or_else(|| last_word(&columns)).unwrap_or("value").to_owned();
    let rows = table.rows();
    let law = |column: &Column| table.beside(column, Role::Theory);
    let is_stacked = |column: &&Column| {
        let is_law = |stacked: &&Column| law(stacked).is_some_and(|law| law.name == column.name);
        columns.iter().any(|stacked| stacked.name == column.name || is_law(stacked))
    };
    let repeat = |column: &Column| Column {
        cells: columns.iter().flat_map(|_| column.cells.iter().cloned()).collect(),
        band: column.band.as_ref().map(|band| band.repeat(columns.len())),
        band_of_mean: None,
        ..column.clone()
    };
    let mut all: Vec<Column> =
        table.columns.iter().filter(|column| !is_stacked(column)).map(repeat).collect();
    let names = columns.iter().flat_map(|column| vec![Cell::Text(label(column)); rows]).collect();
    let (name, label) = (CURVE.to_owned(), heading);
    all.push(Column { name, label, role: Role::Key, cells: names, ..Column::default() });
    let band = |column: &Column| (0..rows).map(|row| column.interval(row)).collect::<Vec<_>>();
    all.push(Column {
        label: quantity,
        cells: columns.iter().flat_map(|column| column.cells.iter().cloned()).collect(),
        band: Some(columns.iter().flat_map(|column| band(column)).collect()),
        band_of_mean: None,
        ..(*first).clone()
    });
    if columns.iter().any(|column| law(column).is_some()) {
        let cell = |column, row| law(column).map_or(Cell::Blank, |law| law.cells[row].clone());
        let cells = |column| (0..rows).map(move |row| cell(column, row));
        all.push(Column {
            name: format!("theory_{}", first.name),
            label: "closed form".to_owned(),
            unit: first.unit,
            role: Role::Theory,
            of: first.name.clone(),
            cells: columns.iter().copied().flat_map(cells).collect(),
            ..Column::default()
        });
    }
    Ok(Table { columns: all })
}

/// The common last word of the labels of all columns, such as `error` for `rms error` and `99.73 % error`.
fn last_word<'c>(columns: &[&'c Column]) -> Option<&'c str> {
    let words = |column: &&'c Column| column.label.rsplit_once(' ').map(|(_, last)| last);
    let first = words(columns.first()?)?;
    columns.iter().all(|column| words(column) == Some(first)).then_some(first)
}

/// The part of the quantity `shared` that a column stands for.
fn part<'c>(column: &'c Column, shared: &str) -> Option<&'c str> {
    column.label.strip_prefix(shared)?.strip_prefix(BETWEEN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Unit;

    fn table() -> Table {
        let column = |name: &str, label: &str, unit, cells: [f64; 2]| Column {
            name: name.to_owned(),
            label: label.to_owned(),
            unit,
            cells: cells.map(Cell::Number).to_vec().into(),
            band: (name == "rms").then(|| vec![Some((1.0, 2.0)), None]),
            ..Column::default()
        };
        Table {
            columns: vec![
                column("run.duration", "run time", Unit::S, [1.0, 2.0]),
                column("bound", "drift: bound", Unit::ARCSEC_PER_S, [3.0, 4.0]),
                column("mean", "drift: mean", Unit::ARCSEC_PER_S, [5.0, 6.0]),
                column("rms", "rms", Unit::ARCSEC_PER_S, [7.0, 8.0]),
            ],
        }
    }

    fn texts(table: &Table, name: &str) -> Vec<String> {
        table.column(name).unwrap().cells.iter().map(Cell::text).collect()
    }

    #[test]
    fn each_column_is_a_curve_of_the_quantity_that_the_labels_share() {
        let stacked = stacked(&table(), &["bound", "mean_arcsec_per_s"]).unwrap();
        assert_eq!(stacked.column("bound").unwrap().title(), "drift, ″/s");
        assert_eq!(texts(&stacked, "bound"), ["3", "4", "5", "6"]);
        assert_eq!(texts(&stacked, CURVE), ["bound", "bound", "mean", "mean"]);
        assert_eq!(texts(&stacked, "duration"), ["1", "2", "1", "2"]);
        assert_eq!(texts(&stacked, "rms"), ["7", "8", "7", "8"]);
    }

    #[test]
    fn bands_stay_with_their_columns_and_labels_that_share_nothing_stay_whole() {
        let stacked = stacked(&table(), &["mean", "rms"]).unwrap();
        let column = stacked.column("mean").unwrap();
        assert_eq!(column.band.as_deref(), Some(&[None, None, Some((1.0, 2.0)), None][..]));
        assert_eq!((column.label.as_str(), texts(&stacked, CURVE)[2].as_str()), ("value", "rms"));
        assert_eq!(texts(&stacked, CURVE)[0], "drift: mean");
    }

    #[test]
    fn a_closed_form_is_that_of_its_own_column() {
        let mut table = table();
        let (role, of) = (Role::Theory, "mean".to_owned());
        let law = Column { name: "theory_mean".to_owned(), role, of, ..table.columns[2].clone() };
        table.columns.push(law);
        let stacked = stacked(&table, &["bound", "mean"]).unwrap();
        assert_eq!(texts(&stacked, "theory_bound"), ["", "", "5", "6"]);
        assert!(stacked.column("theory_mean").is_err());
    }

    #[test]
    fn another_unit_and_the_same_column_twice_are_refused() {
        let error = |names: &[&str]| stacked(&table(), names).unwrap_err().to_string();
        assert_eq!(error(&["bound", "duration"]), "`duration` is in s, a curve in ″/s cannot be drawn on it");
        assert_eq!(
            error(&["bound", "bound_arcsec_per_s"]),
            "`bound_arcsec_per_s` is listed twice among the columns of y"
        );
        assert!(error(&["bound", "none"]).contains("no column is called `none`"));
    }
}
