//! The report of a batch: answer, tables and charts.

use std::cmp::Ordering;

use crate::analysis::batch::random_effects::Pooled;
use crate::analysis::batch::{Batch, Coefficient, Found, Outlier};
use crate::analysis::compare::answer::duration;
use crate::analysis::compare::report::of_ratios;
use crate::analysis::log;
use crate::analysis::log::figures::points;
use crate::analysis::log::report::{Record, text};
use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::{probability, significant};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::Deviation;
use sagnac_report::answer::reading::number;
use sagnac_report::answer::{AnswerCell, AnswerTable, Fact, Kind, Reading};
use sagnac_report::chart::figure::{self, Axis, Entry, Figure, Grouping, Law, LawLine, Series, SeriesPoint};

/// Most units that a caveat names.
const MAX_NAMED: usize = 3;

impl Batch {
    /// The answer of the batch: with limits whether its units meet them, else which unit is an outlier.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let units = self.units().zip(&self.labels);
        let subjects: Vec<Subject> = units
            .map(|((log, column), label)| Subject { label, ..Subject::of_column(log, column, None) })
            .collect();
        let mut decision = decide(&subjects, limits, "unit");
        let answer = &mut decision.answer;
        let Some(one) = self.shown(limits) else { return decision };
        if limits.is_empty() {
            answer.kind = Kind::Choice;
            (answer.headline, answer.value) = self.headline(one);
            answer.table = self.table(one);
        }
        answer.facts.extend(self.facts(one));
        decision
    }

    /// The coefficient that the answer shows: the first limited one, else the first with an outlier, else the first that the most
    /// units show.
    fn shown(&self, limits: &[Limit]) -> Option<&Coefficient> {
        let named = |name: &str| self.coefficients.iter().find(|one| one.name == name);
        let limited = limits.iter().find_map(|limit| named(limit.of.name()));
        let outlying = || self.coefficients.iter().find(|one| one.outliers().next().is_some());
        let usual = || named("N").filter(|one| one.pooled.is_some());
        let most = || {
            let pooled = self.coefficients.iter().rev().filter(|one| one.pooled.is_some());
            pooled.max_by_key(|one| one.estimates().len())
        };
        limited.or_else(outlying).or_else(usual).or_else(most)
    }

    fn headline(&self, one: &Coefficient) -> (String, Option<Reading>) {
        if let Some((unit, found, outlier)) = one.outliers().max_by(|a, b| by_size(a.1, b.1)) {
            let (label, name, reading) = (&self.labels[unit], one.title(), found.row.reading());
            let value = reading.as_ref().map(Reading::text).unwrap_or_default();
            let result = match (outlier, self.rest(one).map(|rest| rest.value), found.row.value) {
                (Outlier::Higher | Outlier::Lower, Some(median), Some(value)) => {
                    let p = found.p.map(|p| format!(" ({})", probability(p))).unwrap_or_default();
                    format!("{name} {} × the median{p}", number(value / median))
                }
                _ => format!("{name} {value}, above all others"),
            };
            return (format!("{label} is an outlier: {result}"), reading);
        }
        let units = self.labels.len();
        let Some(median) = one.pooled.map(|pooled| median(one, &pooled)) else {
            return (format!("No coefficient is estimated in two of {units} units"), None);
        };
        let of =
            if self.tests == 0 { format!("{units} units") } else { format!("No outlier in {units} units") };
        (format!("{of}: median {} {}", one.title(), median.with_interval()), Some(median))
    }

    /// The batch without its outliers, where enough units remain.
    fn rest(&self, one: &Coefficient) -> Option<Pooled> {
        one.without_outliers.or(one.pooled)
    }

    /// A row for each unit, outliers first and then by falling value.
    fn table(&self, one: &Coefficient) -> AnswerTable {
        let mut units: Vec<usize> = (0..self.labels.len()).collect();
        let found = |unit: usize| one.found[unit].as_ref();
        let is_outlier = |unit: usize| found(unit).is_some_and(|found| found.outlier.is_some());
        units.sort_by(|&a, &b| {
            let by_value = || match (found(a), found(b)) {
                (Some(a), Some(b)) => by_size(b, a),
                (a, b) => b.is_some().cmp(&a.is_some()),
            };
            is_outlier(b).cmp(&is_outlier(a)).then_with(by_value)
        });
        let median = self.rest(one).map(|rest| rest.value);
        let row = |&unit: &usize| -> Vec<AnswerCell> {
            let label = &*self.labels[unit];
            let Some(Found { row, outlier, .. }) = found(unit) else {
                return [label, "—", "", "", ""].map(AnswerCell::from).into();
            };
            let interval = row.reading().and_then(|reading| reading.ends_text()).unwrap_or_default();
            let ratio = row.value.zip(median).map(|(value, median)| number(value / median));
            let status = if outlier.is_some() { "outlier" } else { "" };
            vec![label.into(), row.cell(), interval.into(), ratio.unwrap_or_default().into(), status.into()]
        };
        let heads = ["unit", &one.title(), "95 % interval", "× median", "status"];
        let best = units.first().filter(|&&unit| is_outlier(unit)).map(|_| 0);
        AnswerTable { best, ..AnswerTable::new(heads, units.iter().map(row)) }
    }

    fn facts(&self, one: &Coefficient) -> Vec<Fact> {
        let mut facts = Vec::new();
        let fact = |name: String, value: Reading, at: &str| Fact::Value { name, value, at: at.to_owned() };
        if let Some(pooled) = self.rest(one) {
            let is_rest = one.without_outliers.is_some();
            let name = if is_rest { "Without outliers" } else { "Batch" };
            facts.push(fact(format!("{name}, {}", one.title()), median(one, &pooled), "median"));
            let percent = |part: f64| 100.0 * part;
            let ends = Some(pooled.spread_interval.map(percent));
            let spread = Reading::in_unit("spread", percent(pooled.spread), "%", ends);
            facts.push(fact("Between units".to_owned(), spread, "SD"));
            if pooled.next.iter().all(|end| end.is_finite()) {
                let next = Reading { interval: Some(pooled.next), ..median(one, &pooled) };
                facts.push(fact("Next unit, 95 %".to_owned(), next, ""));
            }
        }
        facts.extend(self.left_out(one).map(|text| Fact::Caveat { text }));
        facts
    }

    /// The units that are not pooled, for which the median may be too high and the scatter too small.
    fn left_out(&self, one: &Coefficient) -> Option<String> {
        let (shown, all) = (one.estimates().len(), one.found.len());
        let has_value: Vec<usize> = one.estimates().into_iter().map(|(unit, _)| unit).collect();
        let mut others: Vec<String> =
            (0..all).filter(|unit| !has_value.contains(unit)).map(|unit| self.labels[unit].clone()).collect();
        let more = others.len().saturating_sub(MAX_NAMED);
        others.truncate(MAX_NAMED);
        others.extend((more > 0).then(|| format!("{more} more")));
        (shown > 0 && shown < all).then(|| {
            format!("{} is estimated in {shown} of {all} units, not in {}", one.title(), listed(&others))
        })
    }
}

/// The median of a batch with its interval.
fn median(one: &Coefficient, pooled: &Pooled) -> Reading {
    Reading::in_unit(one.name, pooled.value, one.symbol, Some(pooled.interval))
}

/// The order of two units by value, those with only an upper limit below others.
fn by_size(a: &Found, b: &Found) -> Ordering {
    let size = |found: &Found| found.row.value.unwrap_or(0.0);
    size(a).total_cmp(&size(b))
}

/// Notes attached to the results, each with the path of its log.
pub fn notes(batch: &Batch) -> Vec<String> {
    let of_log = |log: &crate::analysis::log::Analysis| {
        let notes = crate::analysis::log::report::notes(log).into_iter();
        notes.map(|note| format!("{}: {note}", log.path.display())).collect::<Vec<_>>()
    };
    let tests = (batch.tests > 0).then(|| {
        format!(
            "each p is corrected for {} tests (Bonferroni): at most {} % of batches without an outlier show one",
            batch.tests,
            significant(100.0 * super::FALSE_ALARM, 2)
        )
    });
    batch.logs.iter().flat_map(of_log).chain(tests).collect()
}

/// Meaning of the column that names coefficients.
const COEFFICIENT: &str = "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, L, and `in_run_bias_stability`, the \
     minimum up to an eighth of the record.";

/// A row of `units.csv`.
pub(crate) struct UnitRow<'a> {
    label: &'a str,
    file: String,
    column: &'a log::Column,
    found: &'a Found,
}

/// The columns of `units.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn unit_columns<'a>() -> Vec<ColumnOf<UnitRow<'a>>> {
    type Of<'a> = ColumnOf<UnitRow<'a>>;
    vec![
        Of::new("label", Unit::NONE, "label", |row| text(row.label))
            .is(Role::Key, "Label of the unit of the batch: the name of its file, of its column, or both."),
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.found.row.name))
            .is(Role::Key, COEFFICIENT),
        Of::new("value", Unit::NONE, "value", |row| row.found.row.value.into())
            .is(Role::Estimate, "The coefficient in `unit`; blank where the record does not show it."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.row.interval.map(|ends| ends[0]).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.row.interval.map(|ends| ends[1]).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval; if `value` is blank, an upper bound on the coefficient."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.found.row.unit))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
        Of::new("status", Unit::NONE, "status", |row| text(row.found.row.verdict))
            .is(Role::Note, "Whether the record identifies the coefficient, in words."),
        Of::new("p", Unit::NONE, "p", |row| row.found.p.into())
            .is(Role::Estimate, "Probability that any test of the batch finds a unit at least as far from the others by chance if all are \
                alike; blank where fewer than three units show the coefficient."),
        Of::new("outlier", Unit::NONE, "outlier", |row| text(row.found.outlier.map_or("", Outlier::name)))
            .is(Role::Note, "`higher` or `lower` than the others where p < 5 %, or `above the bounds of the others`; blank for a unit like \
                the others."),
        Of::new("file", Unit::NONE, "file", |row| text(&row.file))
            .is(Role::Note, "The log of the unit."),
        Of::new("column", Unit::NONE, "column", |row| text(&row.column.name))
            .is(Role::Note, "The column of the log."),
        Of::new("fit_from", Unit::S, "fit_from", |row| row.column.noise().map(|noise| noise.fit.tau_range[0]).into())
            .is(Role::Coordinate, "Shortest τ of the fit, s: the shortest from which its terms describe the curve."),
    ]
}

/// The coefficients of all units: `units.csv`.
pub fn units(batch: &Batch) -> Table {
    let mut rows = Vec::new();
    for (unit, (log, column)) in batch.units().enumerate() {
        for one in &batch.coefficients {
            let Some(found) = &one.found[unit] else { continue };
            rows.push(UnitRow {
                label: &batch.labels[unit],
                file: log.path.display().to_string(),
                column,
                found,
            });
        }
    }
    Table { columns: columns_of(&unit_columns(), &rows) }
}

/// A row of `batch.csv`.
pub(crate) struct BatchRow<'a> {
    one: &'a Coefficient,
    of: &'static str,
    pooled: Option<Pooled>,
}

impl BatchRow<'_> {
    /// A number of the batch that the units determine.
    fn finite(&self, of: impl Fn(&Pooled) -> f64) -> Cell {
        self.pooled.as_ref().map(of).filter(|number| number.is_finite()).into()
    }
}

/// The columns of `batch.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn batch_columns<'a>() -> Vec<ColumnOf<BatchRow<'a>>> {
    type Of<'a> = ColumnOf<BatchRow<'a>>;
    vec![
        Of::new("coefficient", Unit::NONE, "coefficient", |row| text(row.one.name))
            .is(Role::Key, COEFFICIENT),
        Of::new("of", Unit::NONE, "of", |row| text(row.of))
            .is(Role::Key, "`all` units, or `those that show it` where some do not; or the same units `without outliers` ones."),
        Of::new("units", Unit::NONE, "units", |row| Cell::Integer(row.pooled.map_or(row.one.estimates().len(), |pooled| pooled.units) as i64))
            .is(Role::Count, "Number of units in the row, those that show the coefficient."),
        Of::new("bounded", Unit::NONE, "bounded", |row| Cell::Integer(row.one.bounds().len() as i64))
            .is(Role::Count, "Number of units left out because they have only an upper bound: the value is too high for the batch."),
        Of::new("missing", Unit::NONE, "missing", |row| Cell::Integer(row.one.silent().count() as i64))
            .is(Role::Count, "Number of units left out because they say nothing of the coefficient."),
        Of::new("value", Unit::NONE, "value", |row| row.finite(|pooled| pooled.value))
            .is(Role::Estimate, "Median of the batch in `unit`; blank for fewer than two units."),
        Of::new("lower", Unit::NONE, "lower", |row| row.finite(|pooled| pooled.interval[0]))
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.finite(|pooled| pooled.interval[1]))
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.one.unit))
            .is(Role::Note, "Unit of `value`, its interval and that of the next unit."),
        Of::new("unit_sd", Unit::NONE, "unit_sd", |row| row.finite(|pooled| pooled.spread))
            .is(Role::Estimate, "Standard deviation between units as a part of their mean, without the errors of the records."),
        Of::new("unit_sd_lower", Unit::NONE, "unit_sd_lower", |row| row.finite(|pooled| pooled.spread_interval[0]))
            .is_of("unit_sd", Role::Lower, "Lower end of the 95 % interval of `unit_sd`."),
        Of::new("unit_sd_upper", Unit::NONE, "unit_sd_upper", |row| row.finite(|pooled| pooled.spread_interval[1]))
            .is_of("unit_sd", Role::Upper, "Upper end of the 95 % interval of `unit_sd`; a bound where `unit_sd` is 0."),
        Of::new("prediction_lower", Unit::NONE, "prediction_lower", |row| row.finite(|pooled| pooled.next[0]))
            .is(Role::Estimate, "Lower end of the 95 % prediction interval for a new unit."),
        Of::new("prediction_upper", Unit::NONE, "prediction_upper", |row| row.finite(|pooled| pooled.next[1]))
            .is(Role::Estimate, "Upper end of the 95 % prediction interval for a new unit."),
        Of::new("p_equal", Unit::NONE, "p_equal", |row| row.finite(|pooled| pooled.p_equal))
            .is(Role::Estimate, "Probability that equal units are at least as far apart by chance."),
    ]
}

/// The values of the batch, with and without outliers: `batch.csv`.
pub fn batch(batch: &Batch) -> Table {
    let mut rows = Vec::new();
    for one in &batch.coefficients {
        let of = if one.estimates().len() == one.found.len() { "all" } else { "those that show it" };
        rows.push(BatchRow { one, of, pooled: one.pooled });
        rows.extend(one.without_outliers.map(|rest| BatchRow {
            one,
            of: "without outliers",
            pooled: Some(rest),
        }));
    }
    Table { columns: columns_of(&batch_columns(), &rows) }
}

/// The records of all units: `records.csv`.
pub fn records(batch: &Batch) -> Table {
    let units = batch.units().zip(&batch.labels);
    log::report::records(units.map(|((log, column), label)| Record::new(log, column, label)))
}

/// Distance of neighbouring coefficients of a unit, where units are 1 apart, and the most that all of them take.
const APART: f64 = 0.12;
const WIDEST: f64 = 0.7;

/// The chart of the curves of all units, with the outliers in colours of their own.
pub fn curves(batch: &Batch) -> Figure {
    let outliers = batch.outliers();
    let colour = |unit: usize| outliers.iter().position(|other| *other == unit).map_or(0, |place| place + 1);
    let mut series = Vec::new();
    for (unit, (_, column)) in batch.units().enumerate() {
        let points = column.curves.iter().take(1).flat_map(|curve| points(&curve.points));
        let points = points.map(|point| SeriesPoint { band: None, ..point });
        series.push(Series { colour: colour(unit), dash: 0, points: points.collect(), law: vec![] });
    }
    // Outliers are drawn over the others.
    series.sort_by_key(|series| series.colour);
    let like = batch.labels.len() - outliers.len();
    let others = match outliers.len() {
        0 => format!("{like} units"),
        _ => format!("{like} other units"),
    };
    let others = (like > 0).then_some(Entry { style: 0, name: others });
    let named = outliers
        .iter()
        .map(|&unit| Entry { style: colour(unit), name: format!("{}, outlier", batch.labels[unit]) });
    let unit = batch.units().next().map_or("", |(_, column)| column.unit.symbol(Deviation::Oadev));
    Figure {
        title: format!("Overlapping Allan deviations of a batch of {} units", batch.labels.len()),
        subtitle: Some(subtitle(batch)),
        x: Axis::new("averaging time τ", "s"),
        y: Axis::new("deviation σ(τ)", unit),
        colours: Grouping { title: "units".to_owned(), entries: others.into_iter().chain(named).collect() },
        series,
        ..Figure::default()
    }
}

/// The chart of all coefficients of all units as parts of the values of the batch without outliers; `None` where nothing is pooled.
pub fn coefficients(batch: &Batch) -> Option<Figure> {
    let shown: Vec<(&Coefficient, f64, [f64; 2])> = batch
        .coefficients
        .iter()
        .filter_map(|one| one.without_outliers.or(one.pooled).map(|batch| (one, batch.value, batch.next)))
        .collect();
    if shown.is_empty() {
        return None;
    }
    let apart = APART.min(WIDEST / shown.len() as f64);
    let across = |unit: usize, place: usize| {
        (unit + 1) as f64 + apart * (place as f64 - 0.5 * (shown.len() - 1) as f64)
    };
    let series = shown.iter().enumerate().map(|(place, (one, value, _))| {
        let point = |(unit, found): (usize, &Found)| {
            let band = found.row.interval.map(|[lower, upper]| (lower / value, upper / value));
            found.estimate()?;
            Some(SeriesPoint { x: across(unit, place), y: found.row.value? / value, band, key: None })
        };
        Series { colour: place, dash: 0, points: one.shown().filter_map(point).collect(), law: vec![] }
    });
    let series: Vec<Series> = series.collect();
    let ends = [0.5, batch.labels.len() as f64 + 0.5];
    let lines = shown.iter().enumerate().flat_map(|(place, (_, value, next))| {
        next.map(|end| LawLine { colours: vec![place], points: ends.map(|x| (x, end / value)).into() })
    });
    let values = series.iter().flat_map(|series| &series.points).map(|point| point.y);
    let y = of_ratios("value over that of the batch", values);
    Some(Figure {
        title: format!("Coefficients of {} units over those of the batch", batch.labels.len()),
        subtitle: Some(found(batch)),
        x: Axis { scale: Scale::Linear, whole: true, names: batch.labels.clone(), ..Axis::new("unit", "") },
        y,
        colours: Grouping::new("coefficients", shown.iter().map(|(one, ..)| one.title())),
        bands: "95 % intervals".to_owned(),
        laws: vec![Law {
            label: "95 % prediction interval".to_owned(),
            lines: lines.collect(),
            is_area: false,
        }],
        limit: Some(figure::Limit { value: 1.0, label: "the batch".to_owned() }),
        series,
        ..Figure::default()
    })
}

/// The lengths of the records and their treatment.
pub(crate) fn subtitle(batch: &Batch) -> String {
    let lengths = batch.logs.iter().map(log::Analysis::length_s);
    let (shortest, longest) =
        lengths.fold((f64::INFINITY, 0.0_f64), |(low, high), s| (low.min(s), high.max(s)));
    let of = if longest > 1.01 * shortest { format!(" to {}", duration(longest)) } else { String::new() };
    let treatment = batch.treatment();
    format!("records of {}{of}; {treatment}", duration(shortest))
}

/// The outliers in a few words.
fn found(batch: &Batch) -> String {
    let of = |one: &Coefficient| {
        let outliers = one.outliers().map(|(unit, found, outliers)| {
            let p = found.p.map_or_else(String::new, |p| format!(" ({})", probability(p)));
            format!("{}: {} {}{p}", batch.labels[unit], one.title(), outliers.name())
        });
        outliers.collect::<Vec<_>>()
    };
    let outliers: Vec<String> = batch.coefficients.iter().flat_map(of).collect();
    if outliers.is_empty() { "no unit is an outlier".to_owned() } else { outliers.join("; ") }
}
