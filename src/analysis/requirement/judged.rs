//! Records held against limits.

use serde_json::{Value as Json, json};

use crate::analysis::decision::Figure;
use crate::analysis::decision::words::{at_level, margin_in_words};
use crate::analysis::requirement::limit::{Limit, Limited};
use crate::analysis::requirement::subject::{Gap, Subject};
use crate::quantity::number::percent;
use crate::quantity::number::{significant, with_unit};

/// Significant digits of values.
const DIGITS: usize = 4;

/// How an interval lies to its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// All of it is above the limit.
    NotMet,
    /// It contains the limit.
    Open,
    /// The record says nothing.
    Unknown,
    /// All of it is within the limit.
    Met,
}

impl Standing {
    /// That of an interval whose ends are in parts of the limit.
    pub(crate) fn of([low, high]: [f64; 2]) -> Standing {
        match (low, high) {
            (_, ..=1.0) => Standing::Met,
            (low, _) if low > 1.0 => Standing::NotMet,
            _ => Standing::Open,
        }
    }

    /// Name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Standing::NotMet => "not met",
            Standing::Open => "not decided",
            Standing::Unknown => "unknown",
            Standing::Met => "met",
        }
    }
}

/// A limit with what a record shows of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Name of the record.
    pub record: String,
    /// Name of what is limited.
    pub coefficient: &'static str,
    /// Unit of the numbers in files; empty for ratios and plain numbers.
    pub unit: &'static str,
    /// Largest accepted value.
    pub limit: f64,
    /// What the record shows; absent of a bound, and where it shows nothing.
    pub value: Option<f64>,
    /// Ends of the interval; absent where the record shows nothing.
    pub interval: Option<[f64; 2]>,
    /// How the interval lies to the limit.
    pub standing: Standing,
}

impl Judgement {
    /// The judgement as JSON.
    pub(crate) fn json(&self) -> Json {
        json!({
            "record": self.record,
            "coefficient": self.coefficient,
            "unit": self.unit,
            "limit": self.limit,
            "value": self.value,
            "lower": self.interval.map(|ends| ends[0]),
            "upper": self.interval.map(|ends| ends[1]),
            "standing": self.standing.name(),
        })
    }
}

/// Whether all of some limits are met; `None` where a record does not decide it, and without limits.
pub(crate) fn met(standings: &[Standing]) -> Option<bool> {
    match standings.iter().min()? {
        Standing::NotMet => Some(false),
        Standing::Open | Standing::Unknown => None,
        Standing::Met => Some(true),
    }
}

/// A record and a limit that applies to it.
#[derive(Debug, Clone)]
pub(crate) struct Judged<'a> {
    pub(crate) subject: &'a Subject<'a>,
    pub(crate) limit: &'a Limit,
    /// What the record shows, in the unit of tables.
    pub(crate) shown: Result<Shown, Gap>,
}

/// A value, absent of a bound, and the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shown {
    pub(crate) value: Option<f64>,
    pub(crate) ends: [f64; 2],
}

impl<'a> Judged<'a> {
    pub(crate) fn new(subject: &'a Subject<'a>, limit: &'a Limit) -> Judged<'a> {
        let shown = subject.shown(limit.of).and_then(|row| {
            let ends = row.interval.ok_or(Gap::NoBound)?;
            Ok(Shown { value: row.value, ends })
        });
        Judged { subject, limit, shown }
    }

    /// A value in parts of the limit.
    fn part(&self, value: f64) -> f64 {
        value / self.limit.value
    }

    pub(crate) fn standing(&self) -> Standing {
        let standing = |shown: &Shown| Standing::of(shown.ends.map(|end| self.part(end)));
        self.shown.as_ref().map_or(Standing::Unknown, standing)
    }

    /// The upper end of the interval in parts of the limit; infinite where nothing is known.
    pub(crate) fn upper(&self) -> f64 {
        self.shown.as_ref().map_or(f64::INFINITY, |shown| self.part(shown.ends[1]))
    }

    pub(crate) fn of(&self) -> Limited {
        self.limit.of
    }

    fn level(&self) -> &str {
        self.subject.level_of(self.limit.of)
    }

    fn in_unit(&self, value: f64) -> String {
        let (_, symbol) = self.limit.of.unit(self.limit.unit);
        with_unit(value, DIGITS, symbol)
    }

    /// The whole statement, with the limit.
    pub(crate) fn told(&self) -> String {
        let (name, limit) = (self.limit.of.told(), self.in_unit(self.limit.value));
        let standing = self.standing();
        match &self.shown {
            Err(gap) => gap.told(self.limit.of),
            Ok(Shown { value: Some(value), ends: [low, high] }) => {
                let figure = Figure { value: *value, interval: Some((*low, *high)) };
                let value = at_level(figure, self.level(), |value| self.in_unit(value));
                match standing {
                    Standing::Met => format!("{name} is {value}, within {limit}"),
                    Standing::NotMet => format!("{name} is {value}, above {limit}"),
                    _ => format!("{name} is {value}, and the interval contains the limit of {limit}"),
                }
            }
            Ok(Shown { value: None, ends: [_, high] }) => {
                let most = self.in_unit(*high);
                match (self.limit.of, standing) {
                    (Limited::Stability, Standing::Met) => {
                        format!(
                            "{name} is at most {most}, as the curve still falls at an eighth of the record, within {limit}"
                        )
                    }
                    (Limited::Stability, _) => {
                        format!(
                            "{name} is at most {most}, as the curve still falls at an eighth of the record, and this bound is above {limit}"
                        )
                    }
                    (_, Standing::Met) => {
                        format!("{name} is not identified, but at most {most}, within {limit}")
                    }
                    (..) => {
                        format!("{name} is not identified, and its upper bound of {most} is above {limit}")
                    }
                }
            }
        }
    }

    /// The sentence tells how much of the limit is left; it is `None` where nothing is known.
    pub(crate) fn margin(&self) -> Option<String> {
        let Shown { value, ends } = *self.shown.as_ref().ok()?;
        let left = |value: f64| 1.0 - self.part(value);
        Some(match (value, left(ends[1])) {
            (Some(value), least) => {
                let margin = Figure { value: left(value), interval: Some((least, left(ends[0]))) };
                margin_in_words(margin, self.level())
            }
            (None, least) if least >= 0.0 => format!("At least {} of the limit is left.", percent(least)),
            (None, least) => format!("The upper bound is {} times the limit.", significant(1.0 - least, 3)),
        })
    }

    /// The value in parts of the limit, or its bound.
    pub(crate) fn times(&self) -> String {
        match &self.shown {
            Ok(Shown { value: Some(value), .. }) => {
                format!("{} times the limit", significant(self.part(*value), 3))
            }
            Ok(_) => format!("at most {} times the limit", significant(self.upper(), 3)),
            Err(_) => "unknown".to_owned(),
        }
    }

    pub(crate) fn judgement(&self) -> Judgement {
        let shown = self.shown.as_ref().ok();
        Judgement {
            record: self.subject.label.to_owned(),
            coefficient: self.limit.of.name(),
            unit: self.limit.of.unit(self.limit.unit).0,
            limit: self.limit.value,
            value: shown.and_then(|shown| shown.value),
            interval: shown.map(|shown| shown.ends),
            standing: self.standing(),
        }
    }
}
