//! What to do next with a log, from what its analysis found.

use rayon::prelude::*;

use crate::allan::Spread;
use crate::analysis::compare::length::expected;
use crate::analysis::compare::words::duration;
use crate::analysis::log::{self, Column, noise_file};
use crate::analysis::spectrum::Analysis;
use crate::events::Event;
use crate::fit::{Fit, Terms, Verdict};
use crate::quantity::number::significant;
use crate::theory::allan::{Process, Term};
use crate::view::report::sections::{Block, Section};

/// How many times longer records are tried.
const LONGER: [f64; 3] = [4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MOST_SAMPLES: f64 = 6e7;
/// Most lines that are named.
const MOST_LINES: usize = 4;

pub(crate) fn section(analysis: &Analysis) -> Section {
    let noise = &analysis.noise;
    let steps = [misfit(noise), events(noise), outliers(noise), gaps(noise), lines(analysis)];
    let steps: Vec<String> = steps.into_iter().flatten().chain(longer(noise)).chain(further(noise)).collect();
    let block = match steps.is_empty() {
        true => Block::Text(format!("Nothing: the record shows no fault{}.", identified(noise))),
        false => Block::List(steps),
    };
    Section { id: "next", heading: "What to do next", blocks: vec![block] }
}

/// That all coefficients are identified, if they are.
fn identified(noise: &log::Analysis) -> &'static str {
    let is_whole = |column: &Column| {
        let rows = column.coefficients();
        !rows.is_empty() && rows.iter().all(|row| row.value.is_some())
    };
    if noise.columns.iter().all(is_whole) { ", and every coefficient is identified" } else { "" }
}

/// The columns for which something holds, in words; `None` if there are none.
fn named(noise: &log::Analysis, holds: impl Fn(&Column) -> bool) -> Option<String> {
    let names: Vec<&str> =
        noise.columns.iter().filter(|column| holds(column)).map(|column| &*column.name).collect();
    let is_single = noise.columns.len() == 1;
    (!names.is_empty()).then(|| if is_single { "the record".to_owned() } else { names.join(", ") })
}

fn misfit(noise: &log::Analysis) -> Option<String> {
    let names = named(noise, |column| column.noise().is_some_and(|noise| !noise.fit.is_described()))?;
    Some(format!(
        "The terms of the fit do not describe {names}. Look in the charts for what they miss: a drift, a line, steps. Fit other terms, as \
         in `fit = N,B,K,markov`, leave out short or long τ, as in `fit_from = 1s` and `fit_to = 100s`, or leave out the start of the \
         record, as in `skip = 30min`."
    ))
}

fn events(noise: &log::Analysis) -> Option<String> {
    let names = named(noise, |column| !column.events.is_empty())?;
    Some(format!(
        "Look at the events of {names} in the charts: the list under \"What this record shows\" says where they are and what was \
         done with them."
    ))
}

fn outliers(noise: &log::Analysis) -> Option<String> {
    if noise.treatment.outliers_removed {
        return None;
    }
    let few = |column: &Column| !column.has_long_tails(noise.samples);
    // Those of an event are in its list.
    let has =
        |column: &Column| column.outliers.samples.iter().any(|&sample| !Event::is_in(&column.events, sample));
    let spikes = named(noise, |column| has(column) && few(column)).map(|names| {
        format!(
            "There are outliers in {names}. Look at them in the chart (events.csv has their times); if they are not noise, \
             `remove_outliers = true` treats them as gaps."
        )
    });
    let tails = named(noise, |column| has(column) && !few(column)).map(|names| {
        format!(
            "Many samples of {names} stand out: the noise has long tails. Keep them, since each removed one is a gap that costs long τ. \
             The intervals of deviations and coefficients contain what they add, those of the spectrum do not."
        )
    });
    let said: Vec<String> = spikes.into_iter().chain(tails).collect();
    (!said.is_empty()).then(|| said.join(" "))
}

fn gaps(noise: &log::Analysis) -> Option<String> {
    let names = named(noise, |column| !column.gaps.is_empty())?;
    Some(format!(
        "Samples of {names} are missing (events.csv has the times). Find out whether the logger drops them: differences that touch a gap \
         are left out, so many gaps cost long τ."
    ))
}

fn lines(analysis: &Analysis) -> Option<String> {
    let mut found: Vec<(f64, f64, &str)> = Vec::new();
    for (column, spectrum) in analysis.columns() {
        found.extend(spectrum.lines.iter().map(|line| (line.over_floor, line.frequency_hz, &*column.name)));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (_, _, names) = found.first()?;
    let is_of_one = found.iter().all(|(_, _, other)| other == names);
    let shown: Vec<String> = found
        .iter()
        .take(MOST_LINES)
        .map(|(_, frequency, name)| match is_of_one {
            true => format!("{} Hz", significant(*frequency, 5)),
            false => format!("{} Hz in {name}", significant(*frequency, 5)),
        })
        .collect();
    let lines = match found.len() {
        1 => format!("the line at {}", shown[0]),
        2..=MOST_LINES => format!("the lines at {}", shown.join(", ")),
        count => format!("the highest of {count} lines, at {}", shown.join(", ")),
    };
    Some(format!(
        "Find what causes {lines}: a dither, a fan, the table, the mains. A line is not noise: it raises the curve, most of all at τ of about \
         0.4 of its period."
    ))
}

/// For each column that does not show B, the length of a record that would show half of its bound.
fn longer(noise: &log::Analysis) -> Vec<String> {
    let said = |column: &Column| {
        let fit = &column.noise()?.fit;
        let found =
            fit.coefficient(Term::BiasInstability).filter(|found| found.verdict != Verdict::Identified)?;
        let [_, most] = found.interval.filter(|_| fit.is_described())?;
        let most = 0.5 * most;
        let of = if noise.columns.len() == 1 { String::new() } else { format!(" of {}", column.name) };
        let row = column.coefficients().iter().find(|row| row.name == Term::BiasInstability.symbol())?;
        let half = format!("{} {}", significant(0.5 * row.interval?[1], 2), row.symbol);
        let half = half.trim_end();
        let terms = Terms::of_model(noise.treatment.trend);
        let samples = noise.samples as f64;
        let tried: Vec<f64> = LONGER.into_iter().filter(|factor| factor * samples <= MOST_SAMPLES).collect();
        let shown = tried
            .iter()
            .find(|factor| is_shown(fit, most, **factor * samples, &terms, column.spread.over(**factor)));
        Some(match (shown, tried.last()) {
            (Some(factor), _) => format!(
                "The record is too short to show B{of}. If B is {half}, half of its bound, a record of {}, {factor} times as long, \
                 shows it.",
                duration(factor * noise.length_s())
            ),
            (None, Some(longest)) => format!(
                "The record does not show B{of}. If B is {half}, half of its bound, even a record of {} hides it under the other \
                 terms.",
                duration(longest * noise.length_s())
            ),
            (None, None) => {
                format!("The record does not show B{of}, of which half the bound is {half}.")
            }
        })
    };
    noise.columns.par_iter().filter_map(said).collect()
}

/// Whether the mean curve of records of this length shows a bias instability b besides the other terms of a fit.
fn is_shown(fit: &Fit, b: f64, samples: f64, terms: &Terms, spread: Spread) -> bool {
    let others = fit.process.parts.iter().filter(|part| part.term != Term::BiasInstability);
    let part = Term::BiasInstability.part(b * b, 1.0, 1);
    let process = Process { parts: others.copied().chain([part]).collect(), ..fit.process };
    let fit = expected(&process, samples as u64, spread, fit.tau_range[0], terms);
    let found = fit.as_ref().and_then(|fit| fit.coefficient(Term::BiasInstability));
    found.is_some_and(|found| found.verdict == Verdict::Identified)
}

/// What the files of noise are for.
fn further(noise: &log::Analysis) -> Option<String> {
    let files = noise_file::files(noise);
    let [(first, _), others @ ..] = &files[..] else { return None };
    let names = if others.is_empty() { first.clone() } else { format!("{first} and the files like it") };
    let have = if others.is_empty() { "has" } else { "have" };
    Some(format!(
        "{names} {have} this noise in the form of a study. `sagnac new allan mine.toml` writes one to start from; with `noise.file` set \
         to the file it shows what longer records, switching or compensation would do to such a gyro."
    ))
}
