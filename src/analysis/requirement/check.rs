//! Checks of limits: what a record shows, the status of each limit, and what would meet it.

use crate::analysis::compare::answer::duration;
use crate::analysis::compare::equality_test::expected;
use crate::analysis::data_sheet::{DataSheet, Row};
use crate::analysis::log::report::{in_run_bias_stability, text};
use crate::analysis::log::{self, Column, Curve};
use crate::analysis::requirement::{Limit, Limited};
use sagnac_base::quantity::number::with_unit;
use sagnac_base::table::{Cell, ColumnOf, Role, Unit};
use sagnac_records::allan::{Minimum, Overdispersion, Unit as Curves};
use sagnac_records::fit::{Fit, Quantity, Term, Terms};
use sagnac_report::answer::{Alternative, Fact, Reading};

/// A record that is checked against limits: a column of a log, or a unit of a batch.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// Name of the log or of its column.
    pub label: &'a str,
    /// Unit of its curves.
    pub unit: Curves,
    /// Its coefficients; absent where none were requested, or why there are none.
    pub noise: Result<Option<&'a DataSheet>, &'a str>,
    /// The minimum of its curve up to an eighth of the record; without a value where the curve still falls there.
    pub stability: Option<Row>,
    /// Averaging time of that minimum, s.
    pub stability_tau_s: Option<f64>,
    /// N of the flat part of its density.
    pub floor: Option<&'a Row>,
    /// Number of samples.
    pub samples: usize,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Deviations of its estimates beyond those of Gaussian noise.
    pub spread: &'a Overdispersion,
}

impl<'a> Subject<'a> {
    /// A column of a log, with N of its density where that is flat.
    pub(crate) fn of_column(log: &log::Analysis, column: &'a Column, floor: Option<&'a Row>) -> Subject<'a> {
        let least = column.minimum();
        let row =
            |(curve, least): (&Curve, &Minimum)| in_run_bias_stability(column.unit, curve.deviation, least);
        let tau_s = |(_, least): (&Curve, &Minimum)| (!least.at_end).then_some(least.point.tau_s);
        Subject {
            label: &column.name,
            unit: column.unit,
            noise: column.noise.as_ref().map(Option::as_ref).map_err(String::as_str),
            stability: least.map(row),
            stability_tau_s: least.and_then(tau_s),
            floor,
            samples: log.samples,
            step_s: log.step_s,
            spread: &column.spread,
        }
    }

    /// Length of the record, s.
    pub(crate) fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    /// The fit, where it describes a range of the curve.
    pub(crate) fn fit(&self) -> Option<&'a Fit> {
        self.noise.ok().flatten().map(|sheet| &sheet.fit).filter(|fit| fit.is_described())
    }

    /// What the record shows of this: a row with an interval; or why it says nothing of it.
    pub(crate) fn shown(&self, of: Limited) -> Result<&Row, String> {
        let name = of.told();
        let row = match of {
            Limited::Coefficient(term) => {
                let sheet = self.noise.map_err(|why| format!("there are no coefficients: {why}"))?;
                let sheet = sheet.ok_or("no coefficients were fitted")?;
                self.fit().ok_or_else(|| {
                    format!("the fit describes no range of τ and says nothing about {name}")
                })?;
                let row = sheet.rows.iter().find(|row| row.name == term.symbol());
                Some(row.ok_or_else(|| format!("the fit does not contain {name}"))?)
            }
            Limited::Stability => self.stability.as_ref(),
            Limited::Floor => self.floor,
        };
        row.filter(|row| row.interval.is_some()).ok_or_else(|| match of {
            Limited::Coefficient(_) => format!("the record gives neither a value nor a bound of {name}"),
            Limited::Stability => "no curve has a minimum with an interval".to_owned(),
            Limited::Floor => "no octave of the density is flat".to_owned(),
        })
    }
}

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
    pub(crate) fn new([low, high]: [f64; 2]) -> Standing {
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
    pub(crate) shown: Result<Shown, String>,
}

/// A value, absent of a bound, and the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shown {
    pub(crate) value: Option<f64>,
    pub(crate) ends: [f64; 2],
}

impl<'a> Judged<'a> {
    pub(crate) fn new(subject: &'a Subject<'a>, limit: &'a Limit) -> Judged<'a> {
        let shown = subject
            .shown(limit.of)
            .map(|row| Shown { value: row.value, ends: row.interval.unwrap_or([0.0, f64::INFINITY]) });
        Judged { subject, limit, shown }
    }

    /// A value in parts of the limit.
    fn part(&self, value: f64) -> f64 {
        value / self.limit.value
    }

    pub(crate) fn standing(&self) -> Standing {
        let standing = |shown: &Shown| Standing::new(shown.ends.map(|end| self.part(end)));
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
                format!("{name} {} {verb} the {limit} limit", reading.with_interval())
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

/// Most sensors whose mean is proposed.
const MAX_SENSORS: f64 = 100.0;
/// How many times as long a record may be to be proposed.
const MAX_FACTOR: f64 = 1000.0;
/// How many times longer records are tried by their expected curve.
const LONGER: [f64; 4] = [2.0, 4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MAX_SAMPLES: f64 = 6e7;

fn alternative(key: &str, label: &str, from: String, to: String) -> Alternative {
    Alternative { key: key.to_owned(), label: label.to_owned(), from, to }
}

/// Sensors whose mean is within the limit, and the pulse of a quantizing readout that is.
pub(super) fn to_meet(judged: &Judged, value: f64) -> Option<Fact> {
    let limit = judged.limit.value;
    // A limit in decimals may be off by a rounding.
    let sensors = libm::ceil(value / limit * (value / limit) * (1.0 - 1e-9));
    let is_noise = match judged.of() {
        Limited::Coefficient(term) => !matches!(term, Term::RateRamp | Term::Sine),
        Limited::Floor => true,
        // The minimum of a mean need not lie at the same τ.
        Limited::Stability => false,
    };
    let mean = (is_noise && sensors <= MAX_SENSORS)
        .then(|| alternative("sensors", "sensors averaged", "1".to_owned(), sensors.to_string()));
    let pulse = (judged.of() == Limited::Coefficient(Term::Quantization)).then(|| {
        let (_, _, symbol) = Quantity::Coefficient(Term::Quantization).unit(judged.limit.unit);
        let pulse = |q: f64| with_unit(libm::sqrt(12.0) * q, 3, symbol);
        alternative("readout_lsb", "pulse", pulse(value), pulse(limit))
    });
    let alternatives: Vec<Alternative> = mean.into_iter().chain(pulse).collect();
    (!alternatives.is_empty()).then_some(Fact::ChangeToMeet { alternatives })
}

/// The length of a record that decides the limit if the value stays.
pub(super) fn to_decide(judged: &Judged, value: f64, [low, high]: [f64; 2]) -> Option<Fact> {
    // A curve that was read is of no record that could be longer.
    if judged.subject.samples == 0 {
        return None;
    }
    let limit = judged.limit.value;
    let factor = match judged.of() {
        Limited::Coefficient(Term::Quantization | Term::AngleRandomWalk) | Limited::Floor => {
            // The interval of white noise narrows as 1/√T: its end on the side of the limit, and the limit, in logarithms of the
            // value.
            let end = if value < limit { libm::log(high / value) } else { libm::log(value / low) };
            let times = end / libm::log(limit / value);
            Some(times * times).filter(|factor| *factor <= MAX_FACTOR)
        }
        Limited::Coefficient(term) => LONGER
            .into_iter()
            .filter(|times| times * judged.subject.samples as f64 <= MAX_SAMPLES)
            .find(|times| decides(judged.subject, term, limit, judged, *times)),
        // The minimum of a longer record may move.
        Limited::Stability => None,
    }?;
    let length_s = judged.subject.length_s();
    let record = alternative("length", "record", duration(length_s), duration(factor * length_s));
    Some(Fact::ChangeToDecide { alternatives: vec![record] })
}

/// Whether the interval of the mean curve of records that are so many times as long does not contain the limit.
fn decides(subject: &Subject, term: Term, limit: f64, judged: &Judged, times: f64) -> bool {
    let Some(fit) = subject.fit() else { return false };
    let terms = Terms::Auto(fit.coefficients.iter().map(|found| found.term).collect());
    let samples = (times * subject.samples as f64) as u64;
    let longer = expected(&fit.process, samples, subject.spread.over(times), fit.tau_range[0], &terms);
    let (factor, _, _) = Quantity::Coefficient(term).unit(judged.limit.unit);
    let found = longer.as_ref().and_then(|fit| fit.coefficient(term)).filter(|found| found.value.is_some());
    let ends = found.and_then(|found| found.interval).map(|ends| ends.map(|end| factor * end / limit));
    ends.is_some_and(|ends| Standing::new(ends) != Standing::Open)
}
