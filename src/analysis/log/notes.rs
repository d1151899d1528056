//! Notes attached to the results of an analysis.

use crate::allan::unit::Unit;
use crate::analysis::log::{Analysis, Column};
use crate::quantity::number::significant;
use crate::record::log::measure::Data;
use crate::record::log::outliers::OUTLYING;

/// Probability of the residuals of a fit below which it does not describe its curve. It leaves room for the scatter of
/// single records at long τ, which is wider than that of a χ².
const UNLIKELY: f64 = 1e-9;

/// All notes on the results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let mut notes = Vec::new();
    for column in &analysis.columns {
        if let Some(unit) = &column.overruled {
            notes.push(format!("{}: the header says {unit}, but the given unit was used", column.name));
        }
        if let Err(why) = &column.noise {
            notes.push(format!("{}: no coefficients: {why}", column.name));
        }
        if column.unit == Unit::Plain && column.noise().is_some() {
            notes.push(format!("{}: no noise.toml: plain numbers are not the noise of a gyro", column.name));
        }
        if let Some(why) = column.noise().and_then(|noise| noise.intervals.without.as_ref()) {
            notes.push(format!("{}: intervals of coefficients are in closed form: {why}", column.name));
        }
        if let Some(noise) = column.noise()
            && noise.fit.p_value().is_some_and(|p| p < UNLIKELY)
        {
            notes.push(format!(
                "{}: the fit does not describe the curve, χ² = {} of {} degrees of freedom: other terms are needed, \
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
        true => "treated as gaps",
        false => "kept, unless outliers are removed",
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

/// The file, its rate and the part that was used.
pub fn heading(analysis: &Analysis) -> String {
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    format!(
        "{file}: {} samples at {} Hz, {}",
        analysis.samples,
        significant(1.0 / analysis.step_s, 7),
        duration(analysis.length_s())
    )
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
