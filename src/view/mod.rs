//! The charts of a study: figures and maps from the rows of a table that a chart selects.
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
pub mod stack;

use crate::view::from_table::{figure, map};
use crate::view::stack::Shown;
use sagnac_base::diagnostics::{StudyError, nearest};
use sagnac_base::quantity::number::short;
use sagnac_base::quantity::{Dimension, bare};
use sagnac_base::table::{Cell, ColumnError};
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
