//! Several units of a production lot: the coefficients of each, the values of the batch, and the outlier.
//!
//! ```text
//! Logs ─ log::Analysis ─▶ units ─▶ Estimates ─┬─ pool ─▶ Pooled: median, spread, next unit
//!                                             └─ place ─▶ p of each unit among the others
//! ```
//!
//! Each unit has the coefficients of its own [analysis](crate::analysis::log), with intervals in closed form. What the units
//! show of a coefficient is [pooled](random_effects::pool) in logarithms. A unit is an outlier if its estimate is improbable for a batch
//! like the others ([`random_effects::place`]), with p multiplied by the number of such tests in the batch (Bonferroni), so that equal or
//! log-normal batches show an outlier in at most 5 % of cases. Two outliers of equal size hide each other in this test.
//!
//! A record that does not show a coefficient gives an upper bound or nothing. Such units are not pooled: the median is then that
//! of the units that show the coefficient, which is too high for the batch, and the spread is too low. Where fewer than three
//! units show a coefficient, no spread tells whether one is an outlier. A unit is then one if its interval lies
//! above the bounds of all others.

pub mod random_effects;
pub mod report;

use std::collections::HashSet;
use std::path::Path;

use crate::analysis::batch::random_effects::{Estimate, Pooled};
use crate::analysis::data_sheet::{Row, each_once};
use crate::analysis::log::report::in_run_bias_stability;
use crate::analysis::log::{self, Column, Treatment};
use sagnac_records::allan::Unit as Curves;

/// Probability of an outlier in a batch without one.
pub const FALSE_ALARM: f64 = 0.05;

/// Fewest units of which one can be an outlier.
const MIN_WITH_OUTLIER: usize = random_effects::MIN_UNITS + 1;

/// Why some logs are no batch.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// There are too few units.
    #[error(
        "a batch needs at least two units, found {0}\ngive several logs, or several columns of a log, as in `column = gx,gy`"
    )]
    TooFew(usize),
    /// The units have different quantities.
    #[error(
        "{first} has {}, {other} has {}: they are no batch\nselect columns of one kind with `column = NAME`, and give their units with \
         `unit = UNIT`",
        units[0].content(), units[1].content()
    )]
    Units {
        /// Label of the first unit.
        first: String,
        /// Label of a unit that differs.
        other: String,
        /// Units of their curves.
        units: [Curves; 2],
    },
    /// A record is given twice, under one name, two names, or as a copy.
    #[error(
        "{0} and {1} are the same record\ngive each unit once, because equal records make the batch look too even"
    )]
    Twice(String, String),
}

/// A batch of units with its coefficients and outliers.
#[derive(Debug)]
pub struct Batch {
    /// The logs.
    pub logs: Vec<log::Analysis>,
    /// Labels of the units, which are the columns of the logs in order.
    pub labels: Vec<String>,
    /// Coefficients in the order of the data sheet, then the minimum of the curve.
    pub coefficients: Vec<Coefficient>,
    /// Number of tests by which each p was multiplied.
    pub tests: usize,
}

/// A coefficient of all units.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficient {
    /// Name in files.
    pub name: &'static str,
    /// Unit in files.
    pub unit: &'static str,
    /// Unit for the user.
    pub symbol: &'static str,
    /// What each unit shows; absent where its fit does not include the term.
    pub found: Vec<Option<Found>>,
    /// The batch of the units that show it; absent where fewer than two do.
    pub pooled: Option<Pooled>,
    /// The batch without the outliers; absent without any, and where fewer than two remain.
    pub without_outliers: Option<Pooled>,
}

/// A coefficient of one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Value, interval and verdict.
    pub row: Row,
    /// Probability of an estimate at least as far from the others in any of the tests, if all units are alike; absent where
    /// fewer than three units show the coefficient.
    pub p: Option<f64>,
    /// Why the unit is an outlier; absent if it is none.
    pub outlier: Option<Outlier>,
}

/// How an outlier differs from the other units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outlier {
    /// Higher than the others.
    Higher,
    /// Lower than the others.
    Lower,
    /// Above the bounds of all others, of which at most one shows the coefficient.
    Alone,
}

impl Outlier {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Outlier::Higher => "higher",
            Outlier::Lower => "lower",
            Outlier::Alone => "above the bounds of the others",
        }
    }
}

impl Found {
    /// The estimate that is pooled; `None` where the unit shows only a bound, or nothing.
    pub fn estimate(&self) -> Option<Estimate> {
        Estimate::new(self.row.value?, self.row.interval?)
    }

    /// The upper bound of a unit that does not show the coefficient.
    pub fn bound(&self) -> Option<f64> {
        let [_, upper] = self.row.interval.filter(|_| self.estimate().is_none())?;
        Some(upper)
    }
}

impl Coefficient {
    /// Name for the user, such as `N` or `in-run bias stability`.
    pub fn title(&self) -> String {
        self.name.replace("in_run", "in-run").replace('_', " ")
    }

    /// What the units show, with their places in the batch.
    fn shown(&self) -> impl Iterator<Item = (usize, &Found)> {
        self.found.iter().enumerate().filter_map(|(unit, found)| Some((unit, found.as_ref()?)))
    }

    /// The units that show the coefficient, with their estimates.
    pub(crate) fn estimates(&self) -> Vec<(usize, Estimate)> {
        self.shown().filter_map(|(unit, found)| Some((unit, found.estimate()?))).collect()
    }

    /// The units that have only an upper bound, with it.
    pub(crate) fn bounds(&self) -> Vec<(usize, f64)> {
        self.shown().filter_map(|(unit, found)| Some((unit, found.bound()?))).collect()
    }

    /// The units that say nothing of it.
    pub(crate) fn silent(&self) -> impl Iterator<Item = usize> {
        let says = |found: &Found| found.estimate().is_some() || found.bound().is_some();
        let is_silent = move |unit: &usize| !self.found[*unit].as_ref().is_some_and(says);
        (0..self.found.len()).filter(is_silent)
    }

    /// The outliers.
    pub fn outliers(&self) -> impl Iterator<Item = (usize, &Found, Outlier)> {
        self.shown().filter_map(|(unit, found)| Some((unit, found, found.outlier?)))
    }

    /// The probability of a lower estimate among units like the others, for each unit that shows the coefficient beside enough
    /// others.
    fn places(&self) -> Vec<(usize, f64)> {
        let estimates = self.estimates();
        let place = |(unit, one): &(usize, Estimate)| {
            let others = estimates.iter().filter(|(other, _)| other != unit).map(|(_, other)| *other);
            Some((*unit, random_effects::place(one, &others.collect::<Vec<_>>())?))
        };
        estimates.iter().filter_map(place).collect()
    }

    /// Names the outliers by their `places`, where each p counts `tests` times, and pools all and the others.
    fn judge(&mut self, places: &[(usize, f64)], tests: usize) {
        for &(unit, below) in places {
            let Some(found) = &mut self.found[unit] else { continue };
            let p = (2.0 * below.min(1.0 - below) * tests as f64).clamp(0.0, 1.0);
            let side = if below > 0.5 { Outlier::Higher } else { Outlier::Lower };
            (found.p, found.outlier) = (Some(p), (p < FALSE_ALARM).then_some(side));
        }
        if let Some(found) = self.alone().and_then(|unit| self.found[unit].as_mut()) {
            found.outlier = Some(Outlier::Alone);
        }
        let mut all = Vec::new();
        let mut rest = Vec::new();
        for (_, found) in self.shown() {
            all.extend(found.estimate());
            rest.extend(found.estimate().filter(|_| found.outlier.is_none()));
        }
        self.without_outliers = random_effects::pool(&rest).filter(|_| rest.len() < all.len());
        self.pooled = random_effects::pool(&all);
    }

    /// The unit whose interval is above those of all others, each of which has an upper end, where too few show the
    /// coefficient for a test.
    fn alone(&self) -> Option<usize> {
        let ends = |found: &Option<Found>| found.as_ref().and_then(|found| found.row.interval);
        let is_above_others = |unit: &usize| {
            let lower = ends(&self.found[*unit]).map_or(0.0, |[lower, _]| lower);
            let mut others = self.found.iter().enumerate().filter(|(other, _)| other != unit);
            others.all(|(_, found)| ends(found).is_some_and(|[_, upper]| upper < lower))
        };
        let estimates = self.estimates();
        let is_untested = estimates.len() < MIN_WITH_OUTLIER && self.found.len() >= MIN_WITH_OUTLIER;
        estimates.into_iter().map(|(unit, _)| unit).filter(|_| is_untested).find(is_above_others)
    }
}

impl Batch {
    /// The batch of all columns of some logs.
    ///
    /// # Errors
    /// There are fewer than two columns, their quantities differ, or two of them are the same record.
    pub fn new(logs: Vec<log::Analysis>) -> Result<Batch, BatchError> {
        let units: Vec<UnitColumn<'_>> = units(&logs).collect();
        let [(_, first), _, ..] = units[..] else { return Err(BatchError::TooFew(units.len())) };
        let names: Vec<(&Path, &str)> =
            units.iter().map(|(log, column)| (&*log.path, &*column.name)).collect();
        let labels = labels(&names, logs.len())
            .unwrap_or_else(|| (1..=units.len()).map(|place| format!("unit {place}")).collect());
        if let Some(other) = units.iter().position(|(_, column)| column.unit != first.unit) {
            let units = [first.unit, units[other].1.unit];
            return Err(BatchError::Units { first: labels[0].clone(), other: labels[other].clone(), units });
        }
        if let Some([first, again]) = twice(&units) {
            let whole = |unit: usize| format!("{} {}", names[unit].0.display(), names[unit].1);
            return Err(BatchError::Twice(whole(first), whole(again)));
        }
        let mut coefficients = coefficients(&units);
        let places: Vec<Vec<(usize, f64)>> = coefficients.iter().map(Coefficient::places).collect();
        let tests = places.iter().map(Vec::len).sum();
        for (one, places) in coefficients.iter_mut().zip(&places) {
            one.judge(places, tests);
        }
        Ok(Batch { labels, coefficients, tests, logs })
    }

    /// The treatment of the logs.
    pub(crate) fn treatment(&self) -> String {
        let all = self.logs.iter().map(|log| log.treatment);
        all.reduce(Treatment::common).map_or_else(String::new, |common| common.summary())
    }

    /// The units: each column of each log.
    pub fn units(&self) -> impl Iterator<Item = UnitColumn<'_>> {
        units(&self.logs)
    }

    /// The outliers, each once.
    pub fn outliers(&self) -> Vec<usize> {
        let is_outlier = |unit: &usize| {
            let found =
                |one: &Coefficient| one.found[*unit].as_ref().is_some_and(|found| found.outlier.is_some());
            self.coefficients.iter().any(found)
        };
        (0..self.labels.len()).filter(is_outlier).collect()
    }
}

/// The coefficients of all units, each under its name.
fn coefficients(units: &[UnitColumn<'_>]) -> Vec<Coefficient> {
    let rows: Vec<Vec<Row>> = units.iter().map(|(_, column)| rows(column)).collect();
    let of_kind = |kind: &&Row| {
        let of_unit = |rows: &Vec<Row>| {
            let row = rows.iter().find(|row| row.name == kind.name)?.clone();
            Some(Found { row, p: None, outlier: None })
        };
        let found = rows.iter().map(of_unit).collect();
        let (name, unit, symbol) = (kind.name, kind.unit, kind.symbol);
        Coefficient { name, unit, symbol, found, pooled: None, without_outliers: None }
    };
    each_once(rows.iter().flatten()).iter().map(of_kind).collect()
}

/// The coefficients of a column and the minimum of its curve.
fn rows(column: &Column) -> Vec<Row> {
    let stability =
        column.minimum().map(|(curve, least)| in_run_bias_stability(column.unit, curve.deviation, least));
    column.coefficients().iter().cloned().chain(stability).collect()
}

/// A unit of a batch: a column of a log.
type UnitColumn<'a> = (&'a log::Analysis, &'a Column);

/// The units of some logs, in their order.
fn units(logs: &[log::Analysis]) -> impl Iterator<Item = UnitColumn<'_>> {
    logs.iter().flat_map(|log| log.columns.iter().map(move |column| (log, column)))
}

/// Labels of columns of logs, as short as possible: columns of a single log, else names of files, then both, then paths, then paths
/// with columns. `None` where even those are equal.
pub(crate) fn labels(units: &[(&Path, &str)], logs: usize) -> Option<Vec<String>> {
    let names: [fn(&Path, &str) -> String; 5] = [
        |_, column| column.to_owned(),
        |path, _| stem(path),
        |path, column| format!("{} {column}", stem(path)),
        |path, _| path.display().to_string(),
        |path, column| format!("{} {column}", path.display()),
    ];
    let all = |name: &fn(&Path, &str) -> String| -> Vec<String> {
        units.iter().map(|(path, column)| name(path, column)).collect()
    };
    let mut labels = names[usize::from(logs > 1)..].iter().map(all);
    labels.find(|labels| labels.iter().collect::<HashSet<_>>().len() == labels.len())
}

/// Two units that are one record.
fn twice(units: &[UnitColumn<'_>]) -> Option<[usize; 2]> {
    let digest = |unit: usize| units[unit].1.digest;
    (1..units.len()).find_map(|again| {
        let first = (0..again).find(|&first| digest(first) == digest(again))?;
        Some([first, again])
    })
}

/// The name of a log without the ending of its file; a record that is no file may have a name with a dot.
fn stem(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let is_file = ["txt", "toml"].contains(&&*ending) || log::ENDINGS.contains(&ending.as_str());
    let name = if is_file { path.file_stem() } else { path.file_name() };
    name.unwrap_or_default().to_string_lossy().into_owned()
}
