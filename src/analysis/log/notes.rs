//! Notes attached to the results of an analysis.

use crate::analysis::log::{Analysis, Column};
use sagnac_base::quantity::number::significant;
use sagnac_records::events::Event;
use sagnac_records::fit::Fit;
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::outliers::OUTLYING;

/// All notes on a log and its results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    analysis.reading.iter().cloned().chain(of_columns(analysis)).collect()
}

/// The notes on the results; equal ones of several columns are one.
pub(crate) fn of_columns(analysis: &Analysis) -> Vec<String> {
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for column in &analysis.columns {
        for note in of_column(column, analysis).into_iter().flatten() {
            match found.iter_mut().find(|(other, _)| *other == note) {
                Some((_, names)) => names.push(&column.name),
                None => found.push((note, vec![&column.name])),
            }
        }
    }
    found.into_iter().map(|(note, names)| format!("{}: {note}", names.join(", "))).collect()
}

fn of_column(column: &Column, analysis: &Analysis) -> [Option<String>; 9] {
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
