//! Which term of the noise is the largest at which averaging times.

use crate::analysis::requirement::limit::Limited;
use crate::analysis::requirement::subject::Subject;
use crate::fit::{Fit, Term};
use crate::quantity::number::significant;
use crate::theory::allan::{Estimator, Part, Process};
use crate::view::report::agreement::capitalised;

/// A range of octaves of τ at which the same term is the largest part of the expected Allan variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Run {
    /// The term; `None` where the largest part is one that the record does not identify.
    pub(crate) term: Option<Term>,
    /// Shortest and longest τ, s.
    pub(crate) taus: [f64; 2],
    /// Number of octaves.
    pub(crate) octaves: usize,
}

/// The largest part at each octave of the fit, where equal ones are one. A band limit takes from the variance and is no part
/// of it.
pub(crate) fn runs(subject: &Subject, fit: &Fit) -> Vec<Run> {
    let samples = subject.samples as u64;
    let [from_s, to_s] = fit.tau_range;
    let mut runs: Vec<Run> = Vec::new();
    for m in (0..u64::BITS).map(|octave| 1_u64 << octave).take_while(|m| 2 * m <= samples) {
        let tau_s = m as f64 * subject.step_s;
        if tau_s < 0.99 * from_s || tau_s > 1.01 * to_s {
            continue;
        }
        let Some(part) = largest(&fit.process, samples, m) else { continue };
        let is_identified = fit.coefficient(part.term).is_some_and(|found| found.value.is_some());
        let term = is_identified.then_some(part.term);
        match runs.last_mut().filter(|last| last.term == term) {
            Some(last) => (last.taus[1], last.octaves) = (tau_s, last.octaves + 1),
            None => runs.push(Run { term, taus: [tau_s; 2], octaves: 1 }),
        }
    }
    runs
}

fn largest(process: &Process, samples: u64, m: u64) -> Option<Part> {
    let parts = process.parts.iter().filter(|part| part.term != Term::BandLimit);
    let variance = |part: &Part| {
        Process { parts: vec![*part], ..*process }.expected(Estimator::OVERLAPPING, samples, m).unwrap_or(0.0)
    };
    parts.copied().max_by(|a, b| variance(a).total_cmp(&variance(b)))
}

/// The identified term that is the largest part over most octaves.
pub(crate) fn usual(runs: &[Run]) -> Option<Term> {
    let octaves = |term: Term| -> usize {
        runs.iter().filter(|run| run.term == Some(term)).map(|run| run.octaves).sum()
    };
    runs.iter().filter_map(|run| run.term).max_by_key(|term| octaves(*term))
}

/// The runs as a sentence about `whose` Allan variance, such as `N is the largest part of the Allan variance of gz from
/// τ = 1 s to 64 s, B from 128 s to 1024 s.`
pub(crate) fn told(runs: &[Run], whose: &str) -> String {
    let name = |run: &Run| run.term.map_or("no identified term", |term| Limited::Coefficient(term).told());
    let at = |run: &Run| match run.taus.map(|tau_s| significant(tau_s, 4)) {
        [from, to] if from == to => format!("at τ = {from} s"),
        [from, to] => format!("from τ = {from} s to {to} s"),
    };
    let Some((first, others)) = runs.split_first() else { return String::new() };
    let mut told = format!("{} is the largest part of the Allan variance{whose} {}", name(first), at(first));
    for run in others {
        told += &format!(", {} {}", name(run), at(run));
    }
    capitalised(&format!("{told}."))
}
