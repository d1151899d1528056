//! The length of a record that would show a bias instability.

use rayon::prelude::*;

use crate::allan::Spread;
use crate::analysis::compare::length::expected;
use crate::analysis::compare::words::duration;
use crate::analysis::log::{self, Column};
use crate::fit::{Fit, Terms, Verdict};
use crate::quantity::number::{significant, with_unit};
use crate::theory::allan::{Process, Term};

/// How many times longer records are tried.
const LONGER: [f64; 3] = [4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MAX_SAMPLES: f64 = 6e7;

/// For each column whose B is not identified, the record that would show half of its bound, with the name of the column.
pub(crate) fn records(noise: &log::Analysis) -> Vec<(&str, String)> {
    noise.columns.par_iter().filter_map(|column| Some((&*column.name, record(noise, column)?))).collect()
}

fn record(noise: &log::Analysis, column: &Column) -> Option<String> {
    let fit = &column.noise()?.fit;
    let found =
        fit.coefficient(Term::BiasInstability).filter(|found| found.verdict != Verdict::Identified)?;
    let [_, most] = found.interval.filter(|_| fit.is_described())?;
    let row = column.coefficients().iter().find(|row| row.name == Term::BiasInstability.symbol())?;
    let half = with_unit(0.5 * row.interval?[1], 2, row.symbol);
    let terms = Terms::of_model(noise.treatment.trend);
    let samples = noise.samples as f64;
    let mut tried = LONGER.into_iter().filter(|factor| factor * samples <= MAX_SAMPLES);
    let shown = tried
        .find(|factor| is_shown(fit, 0.5 * most, factor * samples, &terms, column.spread.over(*factor)))?;
    let length = duration(shown * noise.length_s());
    Some(format!("{length} ({} × as long), if it is {half}", significant(shown, 2)))
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
