//! The compared logs, their rows, and their limits.

use std::path::{Path, PathBuf};

use crate::analysis::batch::labels;
use crate::analysis::compare::answer::{duration, times};
use crate::analysis::compare::{Comparison, Difference, Length, NoCommonTime, SIGNIFICANT, compare};
use crate::analysis::log::events::{Row as Shown, of_record};
use crate::analysis::log::{self, Column, Treatment};
use crate::analysis::requirement::{Judgement, LimitError, Limited, Standing, is_fitted, named, twice};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_records::events::Events;
use sagnac_records::fit::{Fitting, Term};
use sagnac_records::record::log::Log;
use sagnac_report::answer::reading::range;

/// Why two logs cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The logs measure different things.
    #[error(
        "{} has {}, {} has {}: they cannot be compared\nselect columns of one kind with `column = NAME`, and give their units \
         with `unit = UNIT`",
        paths[0].display(), units[0].content(), paths[1].display(), units[1].content()
    )]
    Units {
        /// The logs.
        paths: [PathBuf; 2],
        /// Their units.
        units: [Unit; 2],
    },
    /// A log has several columns, of which none was selected.
    #[error("{} has several columns of samples: {columns}\nselect one of each log, as in `column = {proposed}`", path.display())]
    Columns {
        /// The log.
        path: PathBuf,
        /// Names of its columns.
        columns: String,
        /// The first of each log, or of both if they are called alike.
        proposed: String,
    },
    /// The logs have no averaging time in common.
    #[error(transparent)]
    NoCommonTime(#[from] NoCommonTime),
}

/// The complete comparison of two logs.
#[derive(Debug)]
pub struct Analysis {
    /// The logs.
    pub sides: [Side; 2],
    /// Unit of both logs.
    pub unit: Unit,
    /// Whether both are the same record, so that nothing can differ.
    pub is_one_record: bool,
    /// Comparison of their records.
    pub comparison: Comparison,
    /// Coefficients in the units of data sheets, or why there are none.
    pub rows: Result<Vec<Row>, String>,
}

/// A log.
#[derive(Debug)]
pub struct Side {
    /// The log with its compared column, without curves and coefficients.
    pub log: log::Analysis,
    /// Label that distinguishes it from the other log.
    pub label: String,
}

impl Side {
    /// A heading such as `lgv1.csv: 32400 samples at 1 Hz, 9 h`.
    pub fn heading(&self) -> String {
        format!(
            "{}, {}: {} samples at {} Hz, {}",
            self.log.path.display(),
            self.column().name,
            self.log.samples,
            significant(1.0 / self.log.step_s, 7),
            duration(self.log.length_s())
        )
    }

    /// The compared column.
    pub fn column(&self) -> &Column {
        &self.log.columns[0]
    }

    /// The only column of `log`, and its record without events; of several columns, `proposed` names one of each log.
    fn new(
        (path, log): (&Path, &Log),
        proposed: &str,
        treatment: &Treatment,
    ) -> Result<(Side, Events<'static>), CompareError> {
        let [channel] = &log.channels[..] else {
            let (path, columns) = (path.to_owned(), names(log).join(", "));
            return Err(CompareError::Columns { path, columns, proposed: proposed.to_owned() });
        };
        let (log, events) = log::Analysis::of_record(log, channel, path, treatment);
        Ok((Side { log, label: String::new() }, events))
    }
}

impl Analysis {
    /// Compares the columns of two logs, which were read from these paths with this treatment. Without a
    /// `fitting`, only the curves are compared.
    ///
    /// # Errors
    /// The logs have nothing in common to compare.
    pub fn of(
        logs: [(&Path, &Log); 2],
        treatment: &Treatment,
        fitting: Option<&Fitting>,
    ) -> Result<Analysis, CompareError> {
        let mut firsts: Vec<&str> = logs.iter().filter_map(|(_, log)| names(log).first().copied()).collect();
        firsts.dedup();
        let proposed = firsts.join(",");
        let (mut a, of_a) = Side::new(logs[0], &proposed, treatment)?;
        let (mut b, of_b) = Side::new(logs[1], &proposed, treatment)?;
        let unit = a.column().unit;
        if unit != b.column().unit {
            let units = [unit, b.column().unit];
            return Err(CompareError::Units { units, paths: [a.log.path, b.log.path] });
        }
        let named = [(&*a.log.path, &*a.column().name), (&*b.log.path, &*b.column().name)];
        let [label_a, label_b] = match labels(&named, 2).as_deref() {
            Some([a, b]) => [a.clone(), b.clone()],
            _ => ["A", "B"].map(str::to_owned),
        };
        (a.label, b.label) = (label_a, label_b);
        let comparison = compare(&of_a, &of_b, fitting)?;
        let rows = rows(&comparison, unit);
        let is_one_record = is_one_record(&a, &b);
        let mut sides = [a, b];
        sides[1].log.columns[0].same_as = is_one_record.then(|| sides[0].label.clone());
        for (record, side) in sides.iter_mut().enumerate() {
            side.log.columns[0].events.extend_from_slice(comparison.shown(record));
        }
        Ok(Analysis { unit, is_one_record, comparison, rows, sides })
    }

    /// What each record shows besides noise, under its label.
    pub fn events(&self) -> Vec<Shown> {
        self.sides.iter().flat_map(|side| of_record(&side.log, side.column(), &side.label)).collect()
    }

    /// The labels of both logs.
    pub fn labels(&self) -> [&str; 2] {
        self.sides.each_ref().map(|side| &*side.label)
    }

    /// The treatment of both records.
    pub fn treatment(&self) -> Treatment {
        let [a, b] = &self.sides;
        a.log.treatment.common(b.log.treatment)
    }

    /// Length of the shorter record, s.
    pub fn shorter_s(&self) -> f64 {
        self.sides[0].log.length_s().min(self.sides[1].log.length_s())
    }
}

/// The names of the columns of samples.
fn names(log: &Log) -> Vec<&str> {
    log.channels.iter().map(|channel| channel.name.as_str()).collect()
}

fn is_one_record(a: &Side, b: &Side) -> bool {
    let file = |side: &Side| side.log.path.canonicalize().ok();
    let is_one_file = || file(a).is_some_and(|path| Some(path) == file(b));
    a.column().digest == b.column().digest || (a.column().name == b.column().name && is_one_file())
}

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
                    let standing = Standing::new([part(ends[0], 0.0), part(ends[1], f64::INFINITY)]);
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
                format!("{name} ratio {} ({ends}) {verb} the limit {limit}", shown(ratio))
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

/// The result for one coefficient of two logs.
#[derive(Debug, Clone)]
pub struct Row {
    /// Name in files.
    pub name: &'static str,
    /// Unit in files.
    pub unit: &'static str,
    /// Unit for the user.
    pub symbol: &'static str,
    /// Result in this unit, except p and the ratio.
    pub found: Difference,
    /// Record length required to distinguish the values.
    pub length: Length,
    /// Whether the fit describes the curve of each log.
    pub described: [bool; 2],
}

/// The verdict on a quantity of two logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The second record has a significantly higher value.
    Higher,
    /// The second record has a significantly lower value.
    Lower,
    /// The records show no significant difference.
    Consistent,
    /// Both values are the same number.
    Equal,
    /// Neither record shows the quantity.
    Neither,
    /// An event of a record explains the quantity as well.
    Explained,
}

impl Verdict {
    /// The verdict in files, where the second log has the label `b`: `after higher`.
    pub fn text(self, b: &str) -> String {
        match self {
            Verdict::Higher => format!("{b} higher"),
            Verdict::Lower => format!("{b} lower"),
            Verdict::Consistent => "consistent".to_owned(),
            Verdict::Equal => "equal".to_owned(),
            Verdict::Neither => "in neither record".to_owned(),
            Verdict::Explained => "not compared".to_owned(),
        }
    }
}

impl Row {
    /// The verdict that follows from p.
    pub fn verdict(&self) -> Verdict {
        match self.found.p {
            None if self.found.values.iter().any(Option::is_some) => Verdict::Explained,
            None => Verdict::Neither,
            Some(p) if p < SIGNIFICANT => match self.found.interval[0] {
                Some(low) if low >= 0.0 => Verdict::Higher,
                _ => Verdict::Lower,
            },
            Some(_) if self.found.difference == Some(0.0) => Verdict::Equal,
            Some(_) => Verdict::Consistent,
        }
    }
}

/// The rows of a comparison, or the reason why there are none.
pub fn rows(comparison: &Comparison, unit: Unit) -> Result<Vec<Row>, String> {
    let differences = comparison.differences.as_ref().map_err(ToString::to_string)?;
    let row = |(found, length)| row(found, length, comparison.described(), unit);
    Ok(differences.iter().zip(comparison.lengths()).map(row).collect())
}

fn row(found: &Difference, length: Length, described: [bool; 2], unit: Unit) -> Row {
    let (factor, unit, symbol) = found.quantity.unit(unit);
    let scaled = |value: Option<f64>| value.map(|value| factor * value);
    let found = Difference {
        values: found.values.map(scaled),
        at_most: found.at_most.map(scaled),
        difference: scaled(found.difference),
        interval: found.interval.map(scaled),
        ..*found
    };
    Row { name: found.quantity.name(), unit, symbol, found, length, described }
}
