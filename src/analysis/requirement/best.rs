//! Which of several records is the best.

use crate::allan::Unit;
use crate::analysis::data_sheet::Row;
use crate::analysis::decision::Figure;
use crate::analysis::decision::words::with_interval;
use crate::analysis::requirement::judged::Judged;
use crate::analysis::requirement::limit::Limited;
use crate::analysis::requirement::subject::Subject;
use crate::fit::Term;
use crate::quantity::number::{significant, with_unit};

/// Coefficients by which records are compared without a limit, the first that two records show.
const ORDER: [Term; 5] =
    [Term::AngleRandomWalk, Term::BiasInstability, Term::Quantisation, Term::RateRandomWalk, Term::RateRamp];

/// Records of a unit, by a coefficient that they identify.
pub(crate) struct Ranked<'a> {
    pub(crate) term: Term,
    /// By rising value.
    pub(crate) by_value: Vec<(&'a Subject<'a>, &'a Row, f64)>,
    /// Number of records of the unit.
    of: usize,
}

/// The records of a unit by the first coefficient that at least `fewest` of them identify.
pub(crate) fn ranked<'a>(subjects: &'a [Subject<'a>], unit: Unit, fewest: usize) -> Option<Ranked<'a>> {
    let alike: Vec<&Subject> = subjects.iter().filter(|subject| subject.unit == unit).collect();
    ORDER.into_iter().find_map(|term| {
        let row = |subject: &&'a Subject<'a>| {
            let row = subject.shown(Limited::Coefficient(term)).ok()?;
            Some((*subject, row, row.value?))
        };
        let mut by_value: Vec<_> = alike.iter().filter_map(row).collect();
        by_value.sort_by(|a, b| a.2.total_cmp(&b.2));
        (by_value.len() >= fewest).then_some(Ranked { term, by_value, of: alike.len() })
    })
}

/// A value with its interval and unit.
fn measured(row: &Row, value: f64) -> String {
    let interval = row.interval.map(|[low, high]| (low, high));
    with_interval(Figure { value, interval }, |value| with_unit(value, 4, row.symbol))
}

impl Ranked<'_> {
    fn told(&self, what: &str) -> Option<String> {
        let [(best, first, least), .., (worst, last, most)] = self.by_value[..] else { return None };
        let name = self.term.symbol();
        let of = match self.by_value.len() {
            all if all == self.of => format!("Of {all} {what}s"),
            some => format!("Of {some} {what}s that identify {name}"),
        };
        let overlap = first.interval.zip(last.interval).is_some_and(|([_, high], [low, _])| low <= high);
        let apart = if overlap { "; the intervals overlap" } else { "" };
        Some(format!(
            "{of} {} has the least {name}, {}, and {} the largest, {}{apart}.",
            best.label,
            measured(first, least),
            worst.label,
            measured(last, most)
        ))
    }
}

/// The best and the worst of some records without limits; `what` they are.
pub(crate) fn by_value(subjects: &[Subject], what: &str) -> String {
    if subjects.len() < 2 {
        return format!("There is only one {what}.");
    }
    let of_unit = |unit: Unit| {
        let count = subjects.iter().filter(|subject| subject.unit == unit).count();
        if count < 2 {
            return None;
        }
        let told = ranked(subjects, unit, 2).and_then(|ranked| ranked.told(what));
        Some(told.unwrap_or_else(|| {
            format!("No coefficient is identified in two of {count} {what}s of {}.", unit.content())
        }))
    };
    let told: Vec<String> = Unit::ALL.into_iter().filter_map(of_unit).collect();
    match told.is_empty() {
        true => format!("The {what}s measure different quantities, which cannot be compared."),
        false => told.join(" "),
    }
}

/// The best and the worst of some records by their least margins.
pub(crate) fn by_margin(judged: &[Judged], subjects: &[Subject], what: &str) -> String {
    let worst_of = |subject: &Subject| {
        let own = judged.iter().filter(|one| std::ptr::eq(one.subject, subject));
        own.max_by(|a, b| a.upper().total_cmp(&b.upper()))
    };
    let mut rated: Vec<&Judged> = subjects.iter().filter_map(worst_of).collect();
    let all = rated.len();
    rated.retain(|one| one.shown.is_ok());
    rated.sort_by(|a, b| a.upper().total_cmp(&b.upper()));
    let upper = |one: &Judged| significant(one.upper(), 3);
    match rated[..] {
        [] => format!("No {what} can be rated."),
        [only] if subjects.len() == 1 => {
            format!("There is only one {what}; {} is {}.", only.of().told(), only.times())
        }
        [only] if all == 1 => {
            format!("Only {} has a limit; {} is {}.", only.subject.label, only.of().told(), only.times())
        }
        [only] => format!("Only {} of {all} {what}s can be rated.", only.subject.label),
        [best, .., worst] => {
            let of = match rated.len() {
                some if some == all => format!("{all} {what}s"),
                some => format!("{some} {what}s that can be rated"),
            };
            format!(
                "Of {of} {} is the best, with {} at most {} times the limit, and {} the worst, with {} at most {} times.",
                best.subject.label,
                best.of().told(),
                upper(best),
                worst.subject.label,
                worst.of().told(),
                upper(worst)
            )
        }
    }
}
