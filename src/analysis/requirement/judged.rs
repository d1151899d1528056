//! Records checked against limits, and `limits.csv`.

use crate::analysis::data_sheet::Row;
use crate::analysis::log::tables::text;
use crate::analysis::requirement::limit::{Limit, Limited};
use crate::analysis::requirement::subject::{Gap, Subject};
use sagnac_base::table::{Cell, ColumnOf, Role, Unit};
use sagnac_report::answer::Reading;

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

    /// The standing as the status of a limit.
    pub fn name(self) -> &'static str {
        match self {
            Standing::NotMet => "not met",
            Standing::Open => "inconclusive",
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

/// The columns of `limits.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns() -> Vec<ColumnOf<Judgement>> {
    type Of = ColumnOf<Judgement>;
    vec![
        Of::new("record", Unit::NONE, "record", |row| text(&row.record))
            .is(Role::Key, "Record: the column of a log, the unit of a batch, or the ratio of two logs."),
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.coefficient))
            .is(Role::Key, "What is limited: a coefficient, `in_run_bias_stability` or `floor`."),
        Of::new("limit", Unit::NONE, "limit", |row| Cell::Number(row.limit))
            .is(Role::Estimate, "Largest accepted value, in `unit`."),
        Of::new("value", Unit::NONE, "value", |row| row.value.into())
            .is(Role::Estimate, "What the record shows, in `unit`; blank for a bound, and where it shows nothing."),
        Of::new("lower", Unit::NONE, "lower", |row| row.interval.map(|ends| ends[0]).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.interval.map(|ends| ends[1]).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`, or the bound."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of the numbers; empty for ratios and plain numbers."),
        Of::new("status", Unit::NONE, "status", |row| text(row.standing.name()))
            .is(Role::Note, "`met`, `not met`, `inconclusive` where the interval contains the limit, or `unknown` where the record shows nothing."),
    ]
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

    /// The limit as a value.
    pub(crate) fn limit(&self) -> Reading {
        self.in_unit(self.limit.value, None)
    }

    /// The value with its interval; `None` of a bound, and where nothing is known.
    pub(crate) fn reading(&self) -> Option<Reading> {
        let Shown { value, ends } = *self.shown.as_ref().ok()?;
        Some(self.in_unit(value?, Some(ends)))
    }

    fn in_unit(&self, value: f64, interval: Option<[f64; 2]>) -> Reading {
        let (_, symbol) = self.limit.of.unit(self.limit.unit);
        Reading::in_unit(self.limit.of.name(), value, symbol, interval)
    }

    /// Whether this is the row that is limited.
    pub(crate) fn is_of(&self, row: &Row) -> bool {
        let name = if self.of() == Limited::Floor { None } else { Some(self.of().name()) };
        name == Some(row.name)
            || self.subject.floor.is_some_and(|floor| name.is_none() && std::ptr::eq(floor, row))
    }

    /// Whether the limit is met, in a sentence of one value.
    pub(crate) fn headline(&self) -> String {
        let (name, limit) = (self.of().told(), self.limit().text());
        let verb = match self.standing() {
            Standing::Met => "meets",
            Standing::NotMet => "misses",
            _ => "may miss",
        };
        match (&self.shown, self.reading()) {
            (_, Some(reading)) => {
                format!("{name} {} {verb} the {limit} limit{}", reading.text(), reading.in_brackets())
            }
            (Ok(Shown { ends: [_, most], .. }), None) => {
                format!("{name} ≤ {} {verb} the {limit} limit", self.in_unit(*most, None).text())
            }
            (Err(_), None) => format!("{name} is unknown, limit {limit}"),
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
