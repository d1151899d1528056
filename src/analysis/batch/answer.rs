//! The answer of a batch: its outliers, or whether its units meet limits.

use std::cmp::Ordering;

use crate::analysis::batch::random_effects::Pooled;
use crate::analysis::batch::{Batch, Coefficient, Found, Outlier};
use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use sagnac_base::quantity::list::listed;
use sagnac_base::quantity::number::probability;
use sagnac_base::quantity::number::significant;
use sagnac_report::answer::reading::number;
use sagnac_report::answer::{AnswerCell, AnswerTable, Fact, Kind, Reading};

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
        let notes = crate::analysis::log::notes::notes(log).into_iter();
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
