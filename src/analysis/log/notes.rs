//! Notes attached to the results of an analysis.

use crate::allan::Unit;
use crate::analysis::log::{Analysis, Column};
use crate::quantity::number::significant;
use crate::record::log::measure::Data;
use crate::record::log::outliers::OUTLYING;

/// Probability of the residuals of a fit below which it does not describe its curve. It leaves room for the scatter of
/// single records at long τ, which is wider than that of a χ².
const UNLIKELY: f64 = 1e-9;

/// All notes on the results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let of_column = |column: &Column| {
        let notes = of_column(column, analysis).into_iter().flatten();
        notes.map(|note| format!("{}: {note}", column.name)).collect::<Vec<_>>()
    };
    let reading = analysis.reading.iter().cloned();
    reading.chain(analysis.columns.iter().flat_map(of_column)).collect()
}

fn of_column(column: &Column, analysis: &Analysis) -> [Option<String>; 8] {
    let noise = column.noise();
    let misfit = noise.filter(|noise| noise.fit.p_value().is_some_and(|p| p < UNLIKELY)).map(|noise| {
        format!(
            "the fit does not describe the curve, χ² = {} of {} degrees of freedom: other terms are needed, and the \
             coefficients mean little",
            significant(noise.fit.chi_squared, 3),
            noise.fit.degrees_of_freedom
        )
    });
    let closed = noise.and_then(|noise| noise.intervals.without.as_ref());
    let (is_plain, has_gaps) = (column.unit == Unit::Plain, column.missing > 0);
    let said = |when: bool, what: &str| when.then(|| what.to_owned());
    [
        column.overruled.as_ref().map(|unit| format!("the header says {unit}, but the given unit was used")),
        column.noise.as_ref().err().map(|why| format!("no coefficients: {why}")),
        said(is_plain && noise.is_some(), "no noise.toml: plain numbers are not the noise of a gyro"),
        closed.map(|why| format!("intervals of coefficients are in closed form: {why}")),
        misfit,
        said(has_gaps && noise.is_some(), "intervals of coefficients are those of a record without gaps"),
        has_gaps.then(|| missing(column.missing, analysis.samples)),
        outliers(column, analysis),
    ]
}

fn missing(missing: usize, samples: usize) -> String {
    let percent = significant(100.0 * missing as f64 / samples.max(1) as f64, 2);
    format!("{missing} of {samples} samples are missing ({percent} %); terms that touch a gap are left out")
}

fn outliers(column: &Column, analysis: &Analysis) -> Option<String> {
    const MOST: usize = 5;
    let found = &column.outliers.samples;
    let times: Vec<String> = analysis.times(found).take(MOST).map(|time_s| significant(time_s, 9)).collect();
    let more = if found.len() > MOST { ", …" } else { "" };
    let fate = match analysis.treatment.outliers_removed {
        true => "treated as gaps",
        false => "kept, unless outliers are removed",
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
