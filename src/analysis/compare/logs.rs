//! The compared logs, their rows, and their limits.

use std::path::{Path, PathBuf};

use crate::analysis::batch::labels;
use crate::analysis::compare::answer::{duration, times};
use crate::analysis::compare::curves::{self, compare_sides};
use crate::analysis::compare::{Comparison, Difference, Length, NoCommonTime, SIGNIFICANT, Stated, compare};
use crate::analysis::given_curve;
use crate::analysis::log::events::{Row as Shown, of_record};
use crate::analysis::log::{self, Column, Treatment};
use crate::analysis::requirement::{Judgement, LimitError, Limited, Standing, is_fitted, named, twice};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_records::events::Events;
use sagnac_records::fit::{Fitting, Term};
use sagnac_records::record::curve_file::CurveFile;
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
    /// Both sides are noise files, of which nothing is estimated.
    #[error(
        "both sides state coefficients, and nothing is estimated\ncompare a log or a curve with a noise file"
    )]
    NothingEstimated,
    /// A noise file has coefficients alone, and none are asked for.
    #[error("a noise file has coefficients alone\ngive the terms of a fit, as in `fit = auto`")]
    NoFit,
}

/// A side of a comparison, as it was read.
#[derive(Debug, Clone, Copy)]
pub enum Compared<'a> {
    /// A log with one column.
    Log(&'a Log),
    /// A curve.
    Curve(&'a CurveFile),
    /// Stated coefficients, such as those of a data sheet.
    Stated(&'a Stated),
}

/// The complete comparison of two logs, of which one or both may be curves, and one stated coefficients.
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

/// A log, or what stands for one.
#[derive(Debug)]
pub struct Side {
    /// What it is.
    pub subject: Subject,
    /// Label that distinguishes it from the other log.
    pub label: String,
}

/// The kind of a side of a comparison.
#[derive(Debug)]
pub enum Subject {
    /// A log with its compared column, without curves and coefficients.
    Log(log::Analysis),
    /// A curve with its own fit.
    Curve(Box<given_curve::Analysis>),
    /// Stated coefficients.
    Stated(Stated),
}

impl Subject {
    /// The path of the file.
    pub fn path(&self) -> &Path {
        match self {
            Subject::Log(log) => &log.path,
            Subject::Curve(curve) => &curve.path,
            Subject::Stated(stated) => &stated.path,
        }
    }

    /// The compared column; a noise file has none.
    pub fn column(&self) -> Option<&Column> {
        match self {
            Subject::Log(log) => log.columns.first(),
            Subject::Curve(curve) => Some(&curve.column),
            Subject::Stated(_) => None,
        }
    }

    fn unit(&self) -> Unit {
        self.column().map_or(Unit::Angular, |column| column.unit)
    }
}

impl Side {
    /// A heading such as `lgv1.csv: 32400 samples at 1 Hz, 9 h`.
    pub fn heading(&self) -> String {
        match &self.subject {
            Subject::Log(log) => format!(
                "{}, {}: {} samples at {} Hz, {}",
                log.path.display(),
                log.columns[0].name,
                log.samples,
                significant(1.0 / log.step_s, 7),
                duration(log.length_s())
            ),
            Subject::Curve(curve) => curve.heading(),
            Subject::Stated(stated) => {
                format!("{}: stated {}", stated.path.display(), stated.symbols().join(", "))
            }
        }
    }

    /// The log, if it is one.
    pub fn log(&self) -> Option<&log::Analysis> {
        if let Subject::Log(log) = &self.subject { Some(log) } else { None }
    }

    /// The curve, if it is one.
    pub fn curve(&self) -> Option<&given_curve::Analysis> {
        if let Subject::Curve(curve) = &self.subject { Some(curve) } else { None }
    }

    /// The side in a few words, such as `9 h` of a record.
    pub(super) fn extent(&self) -> String {
        match &self.subject {
            Subject::Log(log) => duration(log.length_s()),
            Subject::Curve(curve) => format!("{} points of a curve", curve.file.points.len()),
            Subject::Stated(_) => "stated".to_owned(),
        }
    }

    /// The side of `compared`, with the record of a log without its events; of several columns, `proposed` names one of each log.
    fn new(
        (path, compared): (&Path, Compared),
        proposed: &str,
        treatment: &Treatment,
        fitting: Option<&Fitting>,
    ) -> Result<(Side, Option<Events<'static>>), CompareError> {
        let (subject, events) = match compared {
            Compared::Log(log) => {
                let [channel] = &log.channels[..] else {
                    let (path, columns) = (path.to_owned(), names(log).join(", "));
                    return Err(CompareError::Columns { path, columns, proposed: proposed.to_owned() });
                };
                let (log, events) = log::Analysis::of_record(log, channel, path, treatment);
                (Subject::Log(log), Some(events))
            }
            Compared::Curve(file) => {
                (Subject::Curve(Box::new(given_curve::Analysis::new(file.clone(), path, fitting))), None)
            }
            Compared::Stated(stated) => (Subject::Stated(stated.clone()), None),
        };
        Ok((Side { subject, label: String::new() }, events))
    }

    /// The side of its comparison, of a log with its record.
    fn compared<'a>(&'a self, record: &'a Option<Events>) -> Option<curves::Side<'a>> {
        Some(match &self.subject {
            Subject::Log(_) => curves::Side::Record(record.as_ref()?),
            Subject::Curve(curve) => curves::Side::Curve(curve),
            Subject::Stated(stated) => curves::Side::Stated(stated),
        })
    }
}

impl Analysis {
    /// Compares the columns of two logs, which were read from these paths with this treatment. Without a
    /// `fitting`, only the curves are compared.
    ///
    /// # Errors
    /// The logs have nothing in common to compare.
    pub fn of(
        sides: [(&Path, Compared); 2],
        treatment: &Treatment,
        fitting: Option<&Fitting>,
    ) -> Result<Analysis, CompareError> {
        if fitting.is_none() && sides.iter().any(|(_, compared)| matches!(compared, Compared::Stated(_))) {
            return Err(CompareError::NoFit);
        }
        let mut firsts: Vec<&str> = sides.iter().filter_map(|(_, compared)| first_name(compared)).collect();
        firsts.dedup();
        let proposed = firsts.join(",");
        let (mut a, of_a) = Side::new(sides[0], &proposed, treatment, fitting)?;
        let (mut b, of_b) = Side::new(sides[1], &proposed, treatment, fitting)?;
        let unit = a.subject.unit();
        if unit != b.subject.unit() {
            let units = [unit, b.subject.unit()];
            return Err(CompareError::Units {
                units,
                paths: [a, b].map(|side| side.subject.path().to_owned()),
            });
        }
        let named = [&a, &b].map(|side| {
            (side.subject.path(), side.subject.column().map_or("noise", |column| column.name.as_str()))
        });
        let [label_a, label_b] = match labels(&named, 2).as_deref() {
            Some([a, b]) => [a.clone(), b.clone()],
            _ => ["A", "B"].map(str::to_owned),
        };
        (a.label, b.label) = (label_a, label_b);
        let comparison = match [a.compared(&of_a), b.compared(&of_b)] {
            [Some(curves::Side::Record(a)), Some(curves::Side::Record(b))] => compare(a, b, fitting)?,
            [Some(curves::Side::Stated(_)), Some(curves::Side::Stated(_))] | [None, _] | [_, None] => {
                return Err(CompareError::NothingEstimated);
            }
            [Some(a), Some(b)] => compare_sides([a, b], fitting),
        };
        let rows = rows(&comparison, unit);
        let is_one_record = is_one_record(&a, &b);
        let mut sides = [a, b];
        let first = sides[0].label.clone();
        for (record, side) in sides.iter_mut().enumerate() {
            let Subject::Log(log) = &mut side.subject else { continue };
            log.columns[0].events.extend_from_slice(comparison.shown(record));
            log.columns[0].same_as = (record == 1 && is_one_record).then(|| first.clone());
        }
        Ok(Analysis { unit, is_one_record, comparison, rows, sides })
    }

    /// What each record shows besides noise, under its label.
    pub fn events(&self) -> Vec<Shown> {
        let of = |side: &Side| Some(of_record(side.log()?, side.subject.column()?, &side.label));
        self.sides.iter().filter_map(of).flatten().collect()
    }

    /// The labels of both logs.
    pub fn labels(&self) -> [&str; 2] {
        self.sides.each_ref().map(|side| &*side.label)
    }

    /// The logs among the sides, with their labels.
    pub fn logs(&self) -> impl Iterator<Item = (&log::Analysis, &str)> {
        self.sides.iter().filter_map(|side| Some((side.log()?, &*side.label)))
    }

    /// The treatment of the records; `None` where no side is a log.
    pub fn treatment(&self) -> Option<Treatment> {
        self.logs().map(|(log, _)| log.treatment).reduce(Treatment::common)
    }

    /// Whether both sides are logs, so that their samples say how long records must be.
    pub fn is_of_logs(&self) -> bool {
        self.logs().count() == 2
    }

    /// Length of the shorter record, s; infinite without records.
    pub fn shorter_s(&self) -> f64 {
        self.logs().map(|(log, _)| log.length_s()).fold(f64::INFINITY, f64::min)
    }
}

/// The names of the columns of samples.
fn names(log: &Log) -> Vec<&str> {
    log.channels.iter().map(|channel| channel.name.as_str()).collect()
}

/// The name of the first column of a log.
fn first_name<'a>(compared: &Compared<'a>) -> Option<&'a str> {
    if let Compared::Log(log) = compared { names(log).first().copied() } else { None }
}

fn is_one_record(a: &Side, b: &Side) -> bool {
    let file = |side: &Side| side.subject.path().canonicalize().ok();
    let is_one_file = || file(a).is_some_and(|path| Some(path) == file(b));
    match (&a.subject, &b.subject) {
        (Subject::Log(_), Subject::Log(_)) => {
            let [a, b] = [a, b].map(|side| side.subject.column());
            a.zip(b).is_some_and(|(a, b)| a.digest == b.digest || (a.name == b.name && is_one_file()))
        }
        (Subject::Curve(a), Subject::Curve(b)) => a.file.points == b.file.points,
        _ => false,
    }
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
    /// An event of a record explains the quantity as well, or the fit of a curve or a noise file does not have it.
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
