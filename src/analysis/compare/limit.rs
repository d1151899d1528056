//! Limits on the ratio of the coefficients of two logs.

use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::Row;
use crate::analysis::compare::words::times;
use crate::analysis::requirement::{Judgement, LimitError, Limited, Standing, is_fitted, named, twice};
use sagnac_records::fit::Term;
use sagnac_report::answer::reading::range;

/// A requirement on two logs: the largest accepted ratio of a coefficient, the second log over the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatioLimit {
    /// The term of the coefficient.
    pub term: Term,
    /// Largest accepted ratio of the second log over the first.
    pub most: f64,
}

impl RatioLimit {
    /// Reads a limit such as `N=1.1`: the second log has at most 1.1 times the N of the first.
    ///
    /// # Errors
    /// The text is no limit on a coefficient, or its value is not a positive number.
    pub fn parse(text: &str) -> Result<RatioLimit, LimitError> {
        let (of, value) = named(text, &Term::ALL.map(Limited::Coefficient), "N=1.1")?;
        let most = value.parse().ok().filter(|most: &f64| *most > 0.0 && most.is_finite());
        match (of, most) {
            (Limited::Coefficient(term), Some(most)) => Ok(RatioLimit { term, most }),
            _ => Err(LimitError {
                message: format!("the limit on {}: \"{value}\" is not a positive number", of.name()),
                help: format!(
                    "a comparison limits the ratio of the second log over the first, as in \"{}=1.1\"; limits on the coefficient of a log are those of \
                     its own analysis",
                    of.name()
                ),
            }),
        }
    }
}

/// Checks limits that were given together: each is on another coefficient, and `fitted` contains their terms; `None` stands
/// for no fit.
///
/// # Errors
/// Two limits are on the same coefficient, or the fit does not contain a term.
pub fn check(limits: &[RatioLimit], fitted: Option<&[Term]>) -> Result<(), LimitError> {
    let text = |limit: &RatioLimit| format!("{}={}", limit.term.symbol(), limit.most);
    for (place, limit) in limits.iter().enumerate() {
        if let Some(first) = limits[..place].iter().find(|first| first.term == limit.term) {
            return Err(twice(&text(first), &text(limit)));
        }
        is_fitted(limit.term, &text(limit), fitted)?;
    }
    Ok(())
}

/// A limit with the ends of the ratio's interval, where it has some.
pub(super) struct Judged<'a> {
    pub(super) limit: &'a RatioLimit,
    ratio: Option<f64>,
    /// An absent end is not determined by the records.
    ends: [Option<f64>; 2],
    /// Why nothing is known.
    pub(super) why: Option<String>,
    pub(super) standing: Standing,
}

impl<'a> Judged<'a> {
    pub(super) fn new(analysis: &Analysis, limit: &'a RatioLimit) -> Judged<'a> {
        let name = limit.term.symbol();
        let row = analysis.rows.as_deref().map(|rows| rows.iter().find(|row| row.name == name));
        let unknown = |why: String| {
            let standing = Standing::Unknown;
            Judged { limit, ratio: None, ends: [None; 2], why: Some(why), standing }
        };
        if analysis.is_one_record {
            return unknown("both logs are one record".to_owned());
        }
        match row {
            Err(why) => unknown(format!("there are no coefficients: {why}")),
            Ok(None) => unknown(format!("the fits do not contain {name}")),
            Ok(Some(row)) if row.described != [true; 2] => {
                unknown(format!("the fits do not describe both curves and say nothing about {name}"))
            }
            Ok(Some(Row { found, .. })) => match found.ratio_interval {
                [None, None] => unknown(format!("the records do not determine the ratio of {name}")),
                ends => {
                    let part = |end: Option<f64>, without: f64| end.map_or(without, |end| end / limit.most);
                    let standing = Standing::of([part(ends[0], 0.0), part(ends[1], f64::INFINITY)]);
                    Judged { limit, ratio: found.ratio, ends, why: None, standing }
                }
            },
        }
    }

    pub(super) fn upper(&self) -> f64 {
        self.ends[1].map_or(f64::INFINITY, |end| end / self.limit.most)
    }

    /// Whether the limit is met, in a sentence of one value.
    pub(super) fn headline(&self) -> String {
        let (name, limit) = (self.limit.term.symbol(), times(self.limit.most, 4));
        let verb = match self.standing {
            Standing::Met => "meets",
            Standing::NotMet => "misses",
            _ => "may miss",
        };
        let shown = |ratio: f64| times(ratio, 3);
        match (self.ratio, self.ends) {
            (Some(ratio), [Some(low), Some(high)]) => {
                let ends = range(&shown(low), &shown(high));
                format!("{name} ratio {} {verb} the limit {limit} ({ends})", shown(ratio))
            }
            (_, [None, Some(high)]) => format!("{name} ratio ≤ {} {verb} the limit {limit}", shown(high)),
            (_, [Some(low), _]) => format!("{name} ratio ≥ {} {verb} the limit {limit}", shown(low)),
            (..) => format!("{name} ratio is unknown, limit {limit}"),
        }
    }

    /// How many times as long records decide the limit, if the ratio stays; `None` where it is decided, or does not follow from these
    /// records.
    pub(super) fn factor(&self, most: f64) -> Option<f64> {
        let is_white = matches!(self.limit.term, Term::AngleRandomWalk | Term::Quantization);
        let (Standing::Open, Some(ratio), [Some(low), Some(high)], true) =
            (self.standing, self.ratio, self.ends, is_white)
        else {
            return None;
        };
        let end = if ratio < self.limit.most { libm::log(high / ratio) } else { libm::log(ratio / low) };
        let times = end / libm::log(self.limit.most / ratio);
        Some(times * times).filter(|factor| *factor <= most)
    }

    pub(super) fn judgement(&self, [a, b]: [&str; 2]) -> Judgement {
        Judgement {
            record: format!("{b} / {a}"),
            coefficient: self.limit.term.symbol(),
            unit: "",
            limit: self.limit.most,
            value: self.ratio,
            interval: self.ends[0].zip(self.ends[1]).map(Into::into),
            standing: self.standing,
        }
    }
}
