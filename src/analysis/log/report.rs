//! Tables and notes of a log, and the table of the records of logs.

use std::path::Path;

use crate::analysis::data_sheet::{DataSheet, Row};
use crate::analysis::log::{self, Analysis, Column, Curve};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{Deviation, Minimum, Point, Unit as Curves};
use sagnac_records::events::Event;
use sagnac_records::fit::{Fit, RankedModel, Term};
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::outliers::{OUTLYING, Outliers};
use sagnac_records::spectrum::Density;

/// A row of `curve.csv`.
pub(crate) struct CurveRow<'a> {
    column: &'a log::Column,
    curve: &'a Curve,
    point: &'a Point,
    treatment: &'a str,
}

impl CurveRow<'_> {
    /// A cell of a point of a record; blank for one of a curve that was read.
    fn sampled(&self, cell: Cell) -> Cell {
        if self.point.m == 0 { Cell::Blank } else { cell }
    }
}

/// The columns of `curve.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn curve_columns<'a>() -> Vec<ColumnOf<CurveRow<'a>>> {
    type Of<'a> = ColumnOf<CurveRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("deviation", Unit::NONE, "deviation", |row| text(row.curve.deviation.name()))
            .is(Role::Key, "The deviation, as `--deviation` names it."),
        Of::new("m", Unit::NONE, "m", |row| row.sampled(Cell::Integer(row.point.m as i64)))
            .is(Role::Count, "Averaging factor in samples."),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.point.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("differences", Unit::NONE, "differences", |row| row.sampled(Cell::Integer(row.point.terms as i64)))
            .is(Role::Count, "Number of differences behind the value."),
        Of::new("alpha", Unit::NONE, "alpha", |row| {
            row.point.noise.map_or(Cell::Blank, |noise| Cell::Integer(noise.alpha.into()))
        })
            .is(Role::Estimate, "α of the noise that the lag-1 autocorrelation shows, from a spectral density of the rate as f^α: 2 \
                quantization, 1 flicker of the angle, 0 angle random walk, -1 bias instability, -2 rate random \
                walk."),
        Of::new("lower", Unit::NONE, "lower", |row| row.point.interval.map(|ends| ends.0).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("value", Unit::NONE, "value", |row| row.point.value.into())
            .is(Role::Error, "The deviation, in `unit`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.point.interval.map(|ends| ends.1).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(row.curve.deviation)))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
        Of::new("alpha_from", Unit::NONE, "alpha_from", |row| text(alpha_from(row.point)))
            .is(Role::Note, "`estimated` at this τ, or `carried` from a shorter one, for example where there are fewer than 30 groups."),
        Of::new("treatment", Unit::NONE, "treatment", |row| text(row.treatment))
            .is(Role::Note, "What was done to the record: skipped, cut, a line removed, outliers removed, temperature compensated."),
        Of::new("edf", Unit::NONE, "edf", |row| row.point.edf.into())
            .is(Role::Estimate, "Equivalent degrees of freedom of the interval."),
        Of::new("edf_from", Unit::NONE, "edf_from", |row| text(row.point.edf.map_or("", |_| row.point.supposes.name())))
            .is(Role::Note, "The noise that `edf` supposes: `model`, the fitted noise of the record; `differences`, the \
                autocorrelation of the differences at that τ; `alpha`, the noise of `alpha`."),
    ]
}

/// All curves, one row for each deviation and τ: `curve.csv`.
pub fn table(analysis: &Analysis) -> Table {
    curves(&analysis.columns, &analysis.treatment.summary())
}

/// The curves of some columns after a treatment.
pub(crate) fn curves(columns: &[Column], treatment: &str) -> Table {
    let mut rows = Vec::new();
    for column in columns {
        for curve in &column.curves {
            rows.extend(curve.points.iter().map(|point| CurveRow { column, curve, point, treatment }));
        }
    }
    Table { columns: columns_of(&curve_columns(), &rows) }
}

/// A text, or a blank where it is empty.
pub(crate) fn text(text: &str) -> Cell {
    if text.is_empty() { Cell::Blank } else { text.into() }
}

/// The column that names the column of a log.
pub(crate) fn key<R>(name: fn(&R) -> Cell) -> ColumnOf<R> {
    ColumnOf::new("column", Unit::NONE, "column", name)
        .is(Role::Key, "Column of the log to which the row belongs.")
}

/// A row of `coefficients.csv`.
pub(crate) struct Line<'a> {
    column: &'a str,
    row: Row,
    intervals: String,
    range: Option<[f64; 2]>,
}

/// The coefficients of a column and the minimum of its curve.
fn lines(column: &log::Column) -> Vec<Line<'_>> {
    let name = column.noise().map_or_else(String::new, |noise| noise.intervals.name());
    let range = column.noise().map(|noise| noise.fit.tau_range);
    let found = column.coefficients().iter().cloned().map(|row| (row, name.clone(), range));
    let stability = stability(column).into_iter().map(|row| (row, "of the curve".to_owned(), None));
    let line = |(row, intervals, range)| Line { column: &column.name, row, intervals, range };
    found.chain(stability).map(line).collect()
}

/// The columns of `coefficients.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn coefficient_columns<'a>() -> Vec<ColumnOf<Line<'a>>> {
    type Of<'a> = ColumnOf<Line<'a>>;
    vec![
        key(|line| text(line.column)),
        Of::new("coefficient", Unit::NONE, "coefficient", |line| text(line.row.name))
            .is(Role::Key, "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L, and \
                `in_run_bias_stability`, the minimum up to an eighth of the record, with its `in_run_bias_stability_tau`."),
        Of::new("value", Unit::NONE, "value", |line| line.row.value.into())
            .is(Role::Estimate, "The coefficient in `unit`; blank where the record does not show it."),
        Of::new("lower", Unit::NONE, "lower", |line| line.row.interval.map(|ends| ends[0]).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval."),
        Of::new("upper", Unit::NONE, "upper", |line| line.row.interval.map(|ends| ends[1]).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval; if `value` is blank, an upper bound on the coefficient."),
        Of::new("unit", Unit::NONE, "unit", |line| text(line.row.unit))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
        Of::new("status", Unit::NONE, "status", |line| text(line.row.verdict))
            .is(Role::Note, "Whether the record identifies the coefficient, in words."),
        Of::new("intervals", Unit::NONE, "intervals", |line| text(&line.intervals))
            .is(Role::Note, "How the intervals were found: by bootstrap or in closed form; for the minimum, those of the curve."),
        Of::new("fit_from", Unit::S, "fit_from", |line| line.range.map(|range| range[0]).into())
            .is(Role::Coordinate, "Shortest τ of the fit, s: the shortest from which its terms describe the curve."),
        Of::new("fit_to", Unit::S, "fit_to", |line| line.range.map(|range| range[1]).into())
            .is(Role::Coordinate, "Longest τ of the fit, s."),
        Of::new("fitted", Unit::NONE, "fitted", |line| line.row.fitted.into())
            .is(Role::Estimate, "What the coefficient is in the fit, in `unit`, also where it is not identified; blank where the fit does without it."),
    ]
}

/// The coefficients of all columns, each with the minimum of its curve: `coefficients.csv`.
pub fn coefficients(analysis: &Analysis) -> Table {
    coefficients_of(&analysis.columns)
}

/// The coefficients of some columns.
pub(crate) fn coefficients_of(columns: &[Column]) -> Table {
    let lines: Vec<Line> = columns.iter().flat_map(lines).collect();
    Table { columns: columns_of(&coefficient_columns(), &lines) }
}

/// Most models of a column in `ranking.csv`.
const MAX_RANKED: usize = 10;

/// A row of `ranking.csv`.
pub(crate) struct RankedRow<'a> {
    column: &'a str,
    model: &'a RankedModel,
    difference: f64,
    is_fit: bool,
}

/// The columns of `ranking.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn ranking_columns<'a>() -> Vec<ColumnOf<RankedRow<'a>>> {
    type Of<'a> = ColumnOf<RankedRow<'a>>;
    vec![
        key(|row| text(row.column)),
        Of::new("model", Unit::NONE, "model", |row| text(&symbols(&row.model.terms)))
            .is(Role::Key, "The symbols of its terms, the best model first."),
        Of::new("chi_squared", Unit::NONE, "χ²", |row| Cell::Number(row.model.chi_squared))
            .is(Role::Estimate, "Weighted sum of the squared residuals of its fit, with the covariance of the fit of the record."),
        Of::new("degrees_of_freedom", Unit::NONE, "degrees of freedom", |row| Cell::Integer(row.model.degrees_of_freedom as i64))
            .is(Role::Count, "Number of points of the fit less that of parameters."),
        Of::new("criterion", Unit::NONE, "criterion", |row| Cell::Number(row.model.criterion))
            .is(Role::Error, "Wavelet information criterion: χ² plus twice the number of parameters."),
        Of::new("difference", Unit::NONE, "difference", |row| Cell::Number(row.difference))
            .is(Role::Estimate, "The criterion less that of the best model; models within 2 are hardly worse."),
        Of::new("fit", Unit::NONE, "fit", |row| text(if row.is_fit { "of the record" } else { "" }))
            .is(Role::Note, "`of the record` for the model of coefficients.csv, whose terms have to show more clearly."),
    ]
}

/// The symbols of some terms.
fn symbols(terms: &[Term]) -> String {
    terms.iter().map(|term| term.symbol()).collect::<Vec<_>>().join(" + ")
}

/// The best models of a column, and that of its fit.
fn ranked(column: &Column) -> Vec<RankedRow<'_>> {
    let Some(noise) = column.noise().filter(|noise| !noise.ranking.is_empty()) else { return vec![] };
    let least = noise.ranking[0].criterion;
    let fitted: Vec<Term> = noise.fit.process.parts.iter().map(|part| part.term).collect();
    let is_fit =
        |terms: &[Term]| terms.len() == fitted.len() && terms.iter().all(|term| fitted.contains(term));
    let rows = noise.ranking.iter().map(|model| RankedRow {
        column: &column.name,
        model,
        difference: model.criterion - least,
        is_fit: is_fit(&model.terms),
    });
    let rows = rows.enumerate();
    rows.filter(|(place, row)| *place < MAX_RANKED || row.is_fit).map(|(_, row)| row).collect()
}

/// The best models of each column: `ranking.csv`.
pub(crate) fn ranking(columns: &[Column]) -> Table {
    let rows: Vec<RankedRow> = columns.iter().flat_map(ranked).collect();
    Table { columns: columns_of(&ranking_columns(), &rows) }
}

/// The minimum of the first curve of rates as a row, and its averaging time as another.
fn stability(column: &log::Column) -> Vec<Row> {
    let Some((curve, minimum)) = column.minimum() else { return vec![] };
    let row = in_run_bias_stability(column.unit, curve.deviation, minimum);
    let tau = Row {
        name: "in_run_bias_stability_tau",
        unit: "s",
        symbol: "s",
        value: Some(minimum.point.tau_s),
        interval: None,
        ..row
    };
    vec![row, tau]
}

/// The name of the row of the minimum of a curve, with which that of its τ begins.
pub(crate) const MINIMUM: &str = "in_run_bias_stability";

/// The minimum of a curve as a row: the in-run bias stability of data sheets, not B. Where the curve still falls there, the row has no
/// value, and its interval ends in an upper bound.
pub fn in_run_bias_stability(unit: Curves, deviation: Deviation, minimum: &Minimum) -> Row {
    let Minimum { point, at_end } = *minimum;
    Row {
        name: MINIMUM,
        unit: unit.in_files(deviation),
        symbol: unit.symbol(deviation),
        value: point.value.filter(|_| !at_end),
        fitted: None,
        interval: point.interval.map(|(lower, upper)| [if at_end { 0.0 } else { lower }, upper]),
        verdict: if at_end { "upper bound: the curve still falls there" } else { "" },
    }
}

/// Whether the noise was identified at this τ.
fn alpha_from(point: &Point) -> &'static str {
    match point.noise {
        Some(noise) if noise.carried => "carried",
        Some(_) => "estimated",
        None => "",
    }
}

/// All notes on a log and its results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    analysis.reading.iter().cloned().chain(of_columns(analysis)).collect()
}

/// The notes on the results; equal ones of several columns are one.
pub(crate) fn of_columns(analysis: &Analysis) -> Vec<String> {
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for column in &analysis.columns {
        for note in of_column(column, analysis) {
            match found.iter_mut().find(|(other, _)| *other == note) {
                Some((_, names)) => names.push(&column.name),
                None => found.push((note, vec![&column.name])),
            }
        }
    }
    found.into_iter().map(|(note, names)| format!("{}: {note}", names.join(", "))).collect()
}

/// The notes on a column.
pub(crate) fn of_column(column: &Column, analysis: &Analysis) -> impl Iterator<Item = String> {
    let noise = column.noise();
    let misfit = noise.filter(|noise| !noise.fit.is_described()).map(|noise| {
        format!(
            "the terms of the fit describe the curve over no range of τ, χ² = {} of {} degrees of freedom: fit other terms, \
             or set the range, as in `fit_from = 1s` and `fit_to = 100s`",
            significant(noise.fit.chi_squared, 3),
            noise.fit.degrees_of_freedom
        )
    });
    let limit = noise.and_then(|noise| band_limit(&noise.fit, column, analysis.step_s));
    let closed = noise.and_then(|noise| noise.intervals.without.as_ref());
    let has_gaps = column.missing > 0;
    let said = |when: bool, what: &str| when.then(|| what.to_owned());
    [
        column.overruled.as_ref().map(|unit| format!("the header says {unit}, but the given unit was used")),
        column.noise.as_ref().err().map(|why| format!("no coefficients: {why}")),
        closed.map(|why| format!("intervals of coefficients are in closed form: {why}")),
        misfit,
        limit,
        said(
            noise.is_some_and(|noise| noise.is_hump),
            "what falls as 1/τ at short τ is no quantization noise, which would show at the highest frequencies too: see the spectrum for a \
             line or a hump",
        ),
        has_gaps.then(|| missing(column.missing, analysis.samples)),
        outliers(column, analysis),
        spread(column),
    ]
    .into_iter()
    .flatten()
}

/// Where a fit starts that leaves out the shortest τ, and what it says of the filter of the sensor if it shows one.
fn band_limit(fit: &Fit, column: &Column, step_s: f64) -> Option<String> {
    let is_cut = fit.is_described() && fit.tau_range[0] > 1.01 * step_s;
    let from = significant(fit.tau_range[0], 4);
    let Some(time_s) = fit.filter_s() else {
        return is_cut.then(|| {
            format!("the coefficients are those of τ from {from} s on, where the terms describe the curve")
        });
    };
    let time = significant(time_s, 3);
    let corner = significant(1.0 / (2.0 * core::f64::consts::PI * time_s), 3);
    Some(format!(
        "the sensor filters its {} like a first-order low-pass of {time} s ({corner} Hz) would: the coefficients are those of τ from \
         {from} s on",
        column.unit.measured()
    ))
}

/// The deviations of estimates beyond those of Gaussian noise.
fn spread(column: &Column) -> Option<String> {
    // A relative error of a variance is twice that of the deviation.
    let error = 0.5 * column.spread.most();
    (error > 0.0).then(|| {
        format!(
            "parts of the record differ by more than those of steady Gaussian noise, as with long tails, bursts, a changing size or a \
             resonance. This adds a standard error of {} % to deviations and coefficients, which is part of all intervals but those of \
             Stable32",
            significant(100.0 * error, 2)
        )
    })
}

fn missing(missing: usize, samples: usize) -> String {
    let percent = significant(100.0 * missing as f64 / samples.max(1) as f64, 2);
    format!(
        "{missing} of {samples} samples are missing ({percent} %); intervals are as much wider as that costs"
    )
}

fn outliers(column: &Column, analysis: &Analysis) -> Option<String> {
    const MAX_LISTED: usize = 5;
    let found = &column.outliers.samples;
    let times: Vec<String> =
        analysis.times(found).take(MAX_LISTED).map(|time_s| significant(time_s, 9)).collect();
    let more = if found.len() > MAX_LISTED { ", …" } else { "" };
    let are_in_events = found.iter().all(|&sample| Event::is_in(&column.events, sample));
    let fate = match column.has_long_tails(analysis.samples) {
        _ if analysis.treatment.outliers_removed => "treated as gaps",
        _ if are_in_events && analysis.treatment.events_removed => "left out with their events",
        is_long if column.noise().is_some() && (are_in_events || !is_long) => {
            "kept in the curve, and left out of the fit"
        }
        false => "kept, unless outliers are removed",
        true => "kept; so many are long tails of the noise",
    };
    let named = if found.len() == 1 { "outlier" } else { "outliers" };
    let of = if analysis.data == Data::Angle { "increments " } else { "" };
    (!found.is_empty()).then(|| {
        format!(
            "{} {named}, {of}more than {OUTLYING} standard deviations ({} in the file's unit) from the median of their \
             neighbours, at {}{more} s: {fate}",
            found.len(),
            significant(column.outliers.threshold, 3),
            times.join(", "),
        )
    })
}

/// The file, its rate and the part that was used.
pub fn heading(analysis: &Analysis) -> String {
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    let (samples, length) = (analysis.samples, duration(analysis.length_s()));
    format!("{file}: {samples} samples at {} Hz, {length}", significant(1.0 / analysis.step_s, 7))
}

/// Text for a comment in a file, which must be a single line without control characters.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn duration(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{} s", significant(seconds, 4)),
        ..7200.0 => format!("{} min", significant(seconds / 60.0, 4)),
        _ => format!("{} h", significant(seconds / 3600.0, 4)),
    }
}

/// A record with its fit and its spectrum: a row of `records.csv`.
pub(crate) struct Record<'a> {
    /// The column of the log, or the label of the record.
    pub name: &'a str,
    pub path: &'a Path,
    pub data: Data,
    pub samples: usize,
    pub step_s: f64,
    pub missing: usize,
    pub outliers: &'a Outliers,
    pub unit: Curves,
    pub mean: Option<f64>,
    pub slope: Option<f64>,
    pub noise: Option<&'a DataSheet>,
    pub density: Option<&'a Density>,
}

impl<'a> Record<'a> {
    /// The record of a column of a log.
    pub(crate) fn new(log: &'a Analysis, column: &'a Column, name: &'a str) -> Record<'a> {
        Record {
            name,
            path: &log.path,
            data: log.data,
            samples: log.samples,
            step_s: log.step_s,
            missing: column.missing,
            outliers: &column.outliers,
            unit: column.unit,
            mean: column.mean_rate,
            slope: Some(column.slope),
            noise: column.noise(),
            density: None,
        }
    }
}

fn count(count: impl Into<Option<usize>>) -> Cell {
    count.into().map_or(Cell::Blank, |count| Cell::Integer(count as i64))
}

/// The columns of `records.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn record_columns<'a>() -> Vec<ColumnOf<Record<'a>>> {
    type Of<'a> = ColumnOf<Record<'a>>;
    vec![
        Of::new("column", Unit::NONE, "column", |row| text(row.name))
            .is(Role::Key, "Column of the log, or the label of the record among several logs."),
        Of::new("file", Unit::NONE, "file", |row| text(&row.path.display().to_string()))
            .is(Role::Note, "The log."),
        Of::new("data", Unit::NONE, "data", |row| text(row.data.name()))
            .is(Role::Note, "What the samples are: `rate`, `increment` or `angle`."),
        Of::new("samples", Unit::NONE, "samples", |row| count(row.samples))
            .is(Role::Count, "Number of samples, including missing ones."),
        Of::new("step", Unit::S, "step", |row| Cell::Number(row.step_s))
            .is(Role::Estimate, "Time from sample to sample, s."),
        Of::new("missing", Unit::NONE, "missing", |row| count(row.missing))
            .is(Role::Count, "Number of samples that are missing in the file or removed."),
        Of::new("outliers", Unit::NONE, "outliers", |row| count(row.outliers.samples.len()))
            .is(Role::Count, "Number of samples that stand out from their neighbours."),
        Of::new("outlier_threshold", Unit::NONE, "outlier threshold", |row| row.outliers.threshold.into())
            .is(Role::Estimate, "Distance from the median of the neighbours beyond which a sample is an outlier, in ″/s or ″, or for accelerometers µg or µg·s."),
        Of::new("mean", Unit::NONE, "mean", |row| row.mean.into())
            .is(Role::Estimate, "Mean rate or acceleration in `unit`."),
        Of::new("removed_slope", Unit::NONE, "removed slope", |row| row.slope.into())
            .is(Role::Estimate, "Slope that was removed, in `unit` per s."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `mean`."),
        Of::new("chi_squared", Unit::NONE, "χ²", |row| row.noise.map(|noise| noise.fit.chi_squared).into())
            .is(Role::Estimate, "χ² of the residuals of the fit."),
        Of::new("degrees_of_freedom", Unit::NONE, "degrees of freedom", |row| count(row.noise.map(|noise| noise.fit.degrees_of_freedom)))
            .is(Role::Count, "Degrees of freedom of `chi_squared`."),
        Of::new("p", Unit::NONE, "p", |row| row.noise.and_then(|noise| noise.fit.p_value()).into())
            .is(Role::Estimate, "Probability of residuals at least as large if the model of the fit holds."),
        Of::new("simulated_records", Unit::NONE, "simulated records", |row| count(row.noise.map(|noise| noise.intervals.records)))
            .is(Role::Count, "Number of simulated records behind the intervals of the coefficients; 0 for intervals in closed form."),
        Of::new("segment", Unit::NONE, "segment", |row| count(row.density.map(|density| density.segment)))
            .is(Role::Count, "Samples of a segment of the power spectral density, which has a Hann window and overlaps half of the next one."),
        Of::new("segments", Unit::NONE, "segments", |row| count(row.density.map(|density| density.segments)))
            .is(Role::Count, "Number of segments that the density averages."),
    ]
}

/// Records with their fits and spectra: `records.csv`.
pub(crate) fn records<'a>(records: impl Iterator<Item = Record<'a>>) -> Table {
    Table { columns: columns_of(&record_columns(), &records.collect::<Vec<_>>()) }
}
