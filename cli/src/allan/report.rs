//! What `sagnac allan` says to people.

use sagnac::allan::curve::{Minimum, Point};
use sagnac::allan::noise::LEAST_GROUPS;
use sagnac::allan::trend::Trend;
use sagnac::allan::unit::Unit;
use sagnac::fit::noise::{Intervals, Row};
use sagnac::quantity::number::significant;
use sagnac::record::log::measure::Data;
use sagnac::record::log::outliers::OUTLYING;

use crate::allan::analysis::{Analysis, Column, Curve};
use crate::terminal::aligned;

/// Probability of the residuals of a fit below which it does not describe its curve, with room for the scatter of single
/// records at long τ, which is wider than that of a χ².
const UNLIKELY: f64 = 1e-9;

/// Lines of a curve that are shown; of longer ones every second, third, … is.
const MOST_LINES: usize = 48;

/// What should be known besides the results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let mut notes = Vec::new();
    for column in &analysis.columns {
        if let Some(unit) = &column.overruled {
            notes.push(format!("{}: the header says {unit}, --unit or --scale was followed", column.name));
        }
        if let Err(why) = &column.noise {
            notes.push(format!("{}: no coefficients: {why}", column.name));
        }
        if column.unit == Unit::Plain && column.noise().is_some() {
            notes.push(format!("{}: no noise.toml: plain numbers are no noise of a gyro", column.name));
        }
        if let Some(Intervals::ClosedForm { why: Some(why) }) = column.noise().map(|noise| &noise.intervals) {
            notes.push(format!("{}: intervals of coefficients are in closed form: {why}", column.name));
        }
        if let Some(noise) = column.noise()
            && noise.fit.p_value().is_some_and(|p| p < UNLIKELY)
        {
            notes.push(format!(
                "{}: the fit does not describe the curve, χ² = {} of {} degrees of freedom: other terms are needed (--fit auto), \
                 and the coefficients mean little",
                column.name,
                significant(noise.fit.chi_squared, 3),
                noise.fit.degrees_of_freedom
            ));
        }
        if column.missing > 0 && column.noise().is_some() {
            notes.push(format!(
                "{}: intervals of coefficients are those of a record without gaps",
                column.name
            ));
        }
        notes.extend(missing(column, analysis.samples));
        notes.extend(outliers(column, analysis));
    }
    notes
}

fn missing(column: &Column, samples: usize) -> Option<String> {
    let percent = significant(100.0 * column.missing as f64 / samples.max(1) as f64, 2);
    let said = || {
        format!(
            "{}: {} of {samples} samples are missing ({percent} %); terms that touch a gap are left out",
            column.name, column.missing
        )
    };
    (column.missing > 0).then(said)
}

fn outliers(column: &Column, analysis: &Analysis) -> Option<String> {
    const MOST: usize = 5;
    let found = &column.outliers.samples;
    let start_s = analysis.treatment.skip_s;
    let times: Vec<String> = found
        .iter()
        .take(MOST)
        .map(|&sample| significant(start_s + sample as f64 * analysis.step_s, 9))
        .collect();
    let more = if found.len() > MOST { ", …" } else { "" };
    let fate = match analysis.treatment.outliers_removed {
        true => "taken for gaps",
        false => "kept; --remove-outliers takes them for gaps",
    };
    let named = if found.len() == 1 { "outlier" } else { "outliers" };
    let of = if analysis.data == Data::Angle { "increments " } else { "" };
    (!found.is_empty()).then(|| {
        format!(
            "{}: {} {named}, {of}more than {OUTLYING} standard deviations ({} in the file's unit) from the median of \
             their neighbours, at {}{more} s: {fate}",
            column.name,
            found.len(),
            significant(column.outliers.threshold, 3),
            times.join(", "),
        )
    })
}

/// The curves of all columns, with what they were taken of.
pub fn report(analysis: &Analysis) -> String {
    let mut text = format!("{}{}\n", heading(analysis), analysis.treatment.left_out());
    text += &format!("{}\n", analysis.treatment.effect(analysis.length_s()));
    for column in &analysis.columns {
        for curve in &column.curves {
            text += &format!("\n{}\n", of_curve(analysis, column, curve));
        }
        text += &coefficients(column);
    }
    text
}

/// The file, its rate and how much of it was taken.
pub fn heading(analysis: &Analysis) -> String {
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    format!(
        "{file}: {} samples at {} Hz, {}",
        analysis.samples,
        significant(1.0 / analysis.step_s, 7),
        duration(analysis.length_s())
    )
}

/// For a comment in a file, which ends where its line does and may have no other control characters either.
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

fn of_curve(analysis: &Analysis, column: &Column, curve: &Curve) -> String {
    let unit = column.unit.symbol(curve.deviation);
    let comma = if unit.is_empty() { "" } else { ", " };
    let mut text = format!(
        "{}: {}{comma}{unit}, with {} intervals",
        column.name,
        curve.deviation.title(),
        analysis.percent()
    );
    text += &trend(analysis, column);
    let header = ["τ, s", "terms", curve.deviation.name(), "lower", "upper", "α", "noise"].map(str::to_owned);
    let step = curve.points.len().div_ceil(MOST_LINES).max(1);
    let lines = curve.points.iter().step_by(step).map(line);
    let rows: Vec<Vec<String>> = std::iter::once(header.to_vec()).chain(lines).collect();
    text += &format!("\n{}", aligned(&rows));
    if step > 1 {
        text += &format!("  one of {step} of the {} times; all are in curve.csv\n", curve.points.len());
    }
    if curve.points.iter().any(|point| point.noise.is_some_and(|noise| noise.carried)) {
        text += &format!("  * of fewer than {LEAST_GROUPS} groups: the noise is that of a shorter τ\n");
    }
    text + &stability(curve, column.unit)
}

/// The coefficients of a column, a line each.
fn coefficients(column: &Column) -> String {
    let Some(noise) = column.noise() else { return String::new() };
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 4));
    let header = ["", "value", "lower", "upper", "", ""].map(str::to_owned);
    let line = |row: &Row| {
        let end = |k: usize| number(row.interval.map(|ends| ends[k]));
        [
            row.name.to_owned(),
            number(row.value),
            end(0),
            end(1),
            row.symbol.to_owned(),
            row.verdict.to_owned(),
        ]
        .to_vec()
    };
    let rows: Vec<Vec<String>> =
        std::iter::once(header.to_vec()).chain(noise.rows.iter().map(line)).collect();
    format!(
        "{}: coefficients of the overlapping Allan curve up to an eighth of the record, with 95 % intervals {}\n{}",
        column.name,
        noise.intervals.words(),
        aligned(&rows)
    )
}

/// The slope that was removed.
fn trend(analysis: &Analysis, column: &Column) -> String {
    match (analysis.treatment.trend, column.unit) {
        (Trend::Linear, Unit::Angular) => {
            format!("; a trend of {} °/h per h was removed", significant(3600.0 * column.slope, 4))
        }
        (Trend::Linear, Unit::Plain) => {
            format!("; a trend of {} per s was removed", significant(column.slope, 4))
        }
        (Trend::None, _) => String::new(),
    }
}

fn line(point: &Point) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 5));
    let (alpha, name) = point.noise.map_or_else(Default::default, |noise| {
        let mark = if noise.carried { "*" } else { "" };
        (format!("{}{mark}", noise.alpha), noise.name().to_owned())
    });
    vec![
        significant(point.tau_s, 7),
        point.terms.to_string(),
        number(point.value),
        number(point.interval.map(|ends| ends.0)),
        number(point.interval.map(|ends| ends.1)),
        alpha,
        name,
    ]
}

/// The minimum of a curve, and whether the record shows it.
fn stability(curve: &Curve, unit: Unit) -> String {
    // A time deviation rises with τ: its minimum is no stability.
    let Some(Minimum { point, at_end }) = curve.minimum.filter(|_| !curve.deviation.is_of_angle()) else {
        return String::new();
    };
    let symbol = unit.symbol(curve.deviation);
    let shown = |value: f64| significant(value, 4);
    let interval = point
        .interval
        .map_or_else(String::new, |(lower, upper)| format!(" ({} … {})", shown(lower), shown(upper)));
    let end = if at_end { "; the curve ends there, a longer record may show less" } else { "" };
    format!(
        "  in-run stability, the minimum: {}{interval} {symbol}{}at τ = {} s{end}\n",
        shown(point.value.unwrap_or_default()),
        if symbol.is_empty() { "" } else { " " },
        significant(point.tau_s, 7)
    )
}
