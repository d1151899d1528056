//! The decision to which a comparison leads.

use crate::analysis::compare::Length;
use crate::analysis::compare::logs::Analysis;
use crate::analysis::compare::rows::{Row, Verdict};
use crate::analysis::compare::words::{duration, times};
use crate::analysis::decision::words::{LEVEL, at_level, margin_in_words};
use crate::analysis::decision::{Figure, Lines};
use crate::analysis::requirement::{
    Decision, Judgement, LimitError, Limited, Standing, is_fitted, met, named, twice,
};
use crate::fit::Term;
use crate::quantity::list::listed;
use crate::quantity::number::{percent, significant};
use crate::view::report::agreement::capitalised;

/// A requirement on two logs: how many times the coefficient of A that of B may be at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatioLimit {
    /// The term of the coefficient.
    pub term: Term,
    /// Largest accepted ratio of B over A.
    pub most: f64,
}

impl RatioLimit {
    /// Reads a limit such as `N=1.1`: B has at most 1.1 times the N of A.
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
                    "a comparison limits the ratio of B over A, as in \"{}=1.1\"; limits on the coefficient of a log are those of \
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
struct Judged<'a> {
    limit: &'a RatioLimit,
    ratio: Option<f64>,
    /// An absent end is not determined by the records.
    ends: [Option<f64>; 2],
    /// Why nothing is known.
    why: Option<String>,
    standing: Standing,
}

impl<'a> Judged<'a> {
    fn new(analysis: &Analysis, limit: &'a RatioLimit) -> Judged<'a> {
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

    fn upper(&self) -> f64 {
        self.ends[1].map_or(f64::INFINITY, |end| end / self.limit.most)
    }

    fn told(&self, [a, b]: [&str; 2]) -> String {
        let (name, limit) = (self.limit.term.symbol(), times(self.limit.most, 4));
        let shown = match (self.ratio, self.ends, &self.why) {
            (_, _, Some(why)) => return why.clone(),
            (Some(value), [Some(low), Some(high)], _) => {
                at_level(Figure { value, interval: Some((low, high)) }, LEVEL, |ratio| times(ratio, 4))
            }
            (_, [None, Some(high)], _) => format!("at most {}", times(high, 4)),
            (_, [Some(low), _], _) => format!("at least {}", times(low, 4)),
            (..) => "an unknown number of".to_owned(),
        };
        let judged = match self.standing {
            Standing::Met => format!("within {limit}"),
            Standing::NotMet => format!("above {limit}"),
            _ => format!("which does not exclude the limit of {limit}"),
        };
        format!("{b} has {shown} times the {name} of {a}, {judged}")
    }

    fn judgement(&self, [a, b]: [&str; 2]) -> Judgement {
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

impl Analysis {
    /// The decision to which the comparison leads.
    pub fn decision(&self, limits: &[RatioLimit]) -> Decision {
        let labels = self.sides.each_ref().map(|side| side.label.as_str());
        let judged: Vec<Judged> = limits.iter().map(|limit| Judged::new(self, limit)).collect();
        let standings: Vec<Standing> = judged.iter().map(|one| one.standing).collect();
        let met = met(&standings);
        let critical =
            judged.iter().max_by(|a, b| b.standing.cmp(&a.standing).then(a.upper().total_cmp(&b.upper())));
        let requirement = match critical {
            None => "None is given.".to_owned(),
            Some(_) => {
                let told: Vec<String> = judged.iter().map(|one| one.told(labels)).collect();
                let begin = match met {
                    Some(true) => "Met",
                    Some(false) => "Not met",
                    None => "Not decided",
                };
                format!("{begin}: {}.", told.join("; "))
            }
        };
        let (margin, what_limits, lever) = match critical {
            Some(critical) => self.held(critical, &judged),
            None => self.unlimited(),
        };
        let sentences = [requirement, self.best(labels), margin, what_limits, lever];
        let judgements = judged.iter().map(|one| one.judgement(labels)).collect();
        Decision { lines: Lines { met, sentences }, judgements }
    }

    /// Which log has the less noise.
    fn best(&self, [a, b]: [&str; 2]) -> String {
        if self.is_one_record {
            return "Neither; both logs are one record.".to_owned();
        }
        let Ok(rows) = &self.rows else {
            return "Not known, because there are no coefficients.".to_owned();
        };
        let names = |verdict: Verdict| -> Vec<&str> {
            let is_noise = |row: &&Row| Term::ALL.iter().any(|term| term.symbol() == row.name);
            let found = rows.iter().filter(|row| row.verdict() == verdict && row.described == [true; 2]);
            found.filter(is_noise).map(|row| row.name).collect()
        };
        let (lower, higher) = (names(Verdict::Lower), names(Verdict::Higher));
        let of = |label: &str, names: &[&str]| format!("{label} has less {}", listed(names));
        match (&lower[..], &higher[..]) {
            ([], []) => "Neither; no coefficient differs significantly.".to_owned(),
            (lower, []) => format!("{}; no coefficient is significantly higher.", of(b, lower)),
            ([], higher) => format!("{}; no coefficient is significantly higher.", of(a, higher)),
            (lower, higher) => format!("It depends on the coefficient: {}, {}.", of(b, lower), of(a, higher)),
        }
    }

    /// The last three lines without limits.
    fn unlimited(&self) -> (String, String, String) {
        let rows = self.rows.iter().flatten().filter(|_| !self.is_one_record);
        let open =
            rows.clone().find(|row| row.verdict() == Verdict::NotToldApart && row.length != Length::Unknown);
        let known = rows.into_iter().find_map(|row| Some((row, row.found.ratio?)));
        let width = match known {
            Some((Row { name, found, .. }, ratio)) => match found.ratio_interval {
                [Some(low), Some(high)] => format!(
                    "Without a limit there is none; the 95 % interval of the ratio of {name} is {} to +{} of its value.",
                    percent(low / ratio - 1.0),
                    percent(high / ratio - 1.0)
                ),
                _ => "Without a limit there is none.".to_owned(),
            },
            None => "Without a limit there is none.".to_owned(),
        };
        let lengths = self.lengths();
        match open {
            Some(row) => {
                let needed = match row.length {
                    Length::Needed(s) => format!("of {}", duration(s)),
                    Length::Beyond(s) => format!("of more than {}", duration(s)),
                    Length::Unknown => String::new(),
                };
                (
                    width,
                    format!("The records of {lengths} do not tell {} of the two apart.", row.name),
                    format!(
                        "Records {needed} each would show a difference in {} such as the one found in 9 of 10 cases.",
                        row.name
                    ),
                )
            }
            None => (
                width,
                format!("No coefficient is known to need longer records than these of {lengths}."),
                "Without a limit nothing has to change.".to_owned(),
            ),
        }
    }

    fn lengths(&self) -> String {
        let [a, b] = self.sides.each_ref().map(|side| duration(side.length_s()));
        if a == b { format!("{a} each") } else { format!("{a} and {b}") }
    }

    /// The last three lines with limits, of which one decides.
    fn held(&self, critical: &Judged, judged: &[Judged]) -> (String, String, String) {
        let name = critical.limit.term.symbol();
        let tightest =
            judged.iter().filter(|one| one.why.is_none()).max_by(|a, b| a.upper().total_cmp(&b.upper()));
        let margin = match tightest.map(|one| (one, one.ratio, one.ends)) {
            Some((one, Some(ratio), [Some(low), Some(high)])) => {
                let left = |ratio: f64| 1.0 - ratio / one.limit.most;
                let told = margin_in_words(
                    Figure { value: left(ratio), interval: Some((left(high), left(low))) },
                    LEVEL,
                );
                match judged.len() {
                    1 => told,
                    _ => format!("The least is that of {}. {told}", one.limit.term.symbol()),
                }
            }
            Some(_) => "Unknown, because only one end of the ratio is known.".to_owned(),
            None => "Unknown, because no limit can be judged.".to_owned(),
        };
        let lengths = self.lengths();
        let what_limits = match (critical.standing, &critical.why) {
            (Standing::NotMet, _) => format!(
                "{name}: even the lower end of the interval is above the limit, so the length of the records, {lengths}, is not \
                 what limits."
            ),
            (Standing::Open, _) => {
                format!("{name}: the interval from records of {lengths} is too wide to decide.")
            }
            (_, Some(why)) => capitalised(&format!("{why}.")),
            _ => format!("{name}, whose interval is that of records of {lengths}."),
        };
        (margin, what_limits, lever(critical, &self.sides[1].label))
    }
}

/// What to change so that the ratio meets its limit, or the records decide it.
fn lever(critical: &Judged, label: &str) -> String {
    /// How many times as long records may be to be proposed.
    const LONGEST: f64 = 1000.0;
    let (name, most) = (critical.limit.term.symbol(), critical.limit.most);
    match (critical.standing, critical.ratio, critical.ends) {
        (Standing::Met, ..) => "Nothing has to change; every limit is met.".to_owned(),
        (Standing::NotMet, Some(ratio), _) => format!(
            "{name} of {} has to fall to {} % of its value.",
            label,
            significant(100.0 * most / ratio, 3)
        ),
        (Standing::Open, Some(ratio), [Some(low), Some(high)])
            if matches!(critical.limit.term, Term::AngleRandomWalk | Term::Quantisation) =>
        {
            let end = if ratio < most { libm::log(high / ratio) } else { libm::log(ratio / low) };
            let times = end / libm::log(most / ratio);
            match times * times {
                factor if factor <= LONGEST => format!(
                    "Records {} times as long, if the ratio of {name} stays: the interval of white noise narrows as 1/√T.",
                    significant(factor, 2)
                ),
                _ => format!(
                    "The ratio of {name} is so close to the limit that records {LONGEST} times as long would not decide it, if the \
                     interval narrows as 1/√T."
                ),
            }
        }
        (Standing::Open, ..) => format!(
            "Longer records narrow the interval of the ratio of {name}; by how much does not follow from these."
        ),
        _ => "No step follows from these records.".to_owned(),
    }
}
