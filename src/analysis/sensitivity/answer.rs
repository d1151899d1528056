//! The answer of a sensitivity analysis: which input drives how much of the variance.

use crate::analysis::design::Found;
use crate::analysis::sensitivity::{Input, Sensitivity};
use sagnac_base::quantity::number::with_unit;
use sagnac_report::answer::reading::{begun, joined, number, percent_of, range};
use sagnac_report::answer::{Alternative, Answer, AnswerCell, AnswerTable, Fact, Kind, Reading, Status};

/// A part of the variance in percent, which sampling may have left outside 0 to 100.
fn share(found: Found) -> Reading {
    let percent = |part: f64| libm::round(100.0 * part.clamp(0.0, 1.0));
    let ends = found.interval.map(|(low, high)| [percent(low), percent(high)]);
    Reading::in_unit("share", percent(found.value), "%", ends)
}

/// The ends of the interval of a share, in whole percent.
fn ends_of(share: &Reading) -> Option<String> {
    let [low, high] = share.interval?.map(number);
    (low != high).then(|| range(&low, &high))
}

impl Sensitivity {
    /// The answer. 95 % of answers count for the limit.
    pub fn answer(&self) -> Answer {
        let decisive = self.decisive();
        let value = share(decisive.index.total);
        let ends = ends_of(&value).map(|ends| format!(" ({ends} %)")).unwrap_or_default();
        let [_, _, most] = self.quantiles.map(f64::abs);
        Answer {
            kind: Kind::Estimate,
            status: match &self.within {
                None => Status::NoLimit,
                Some((limit, _)) if most <= limit.value => Status::Met,
                Some(_) => Status::NotMet,
            },
            headline: begun(&format!("{} drives {} of the variance{ends}", decisive.label, value.text())),
            value: Some(value),
            limit: self.within.as_ref().map(|(limit, _)| self.reading(limit.value, None)),
            table: self.table(),
            facts: self.facts(),
            checks: vec![],
        }
    }

    /// A value of the answer of the study.
    fn reading(&self, value: f64, ends: Option<(f64, f64)>) -> Reading {
        Reading::new(&self.answer, value, ends)
    }

    /// A row for each input, by falling total index.
    fn table(&self) -> AnswerTable {
        let row = |input: &&Input| -> Vec<AnswerCell> {
            let [from, to] = input.range.map(number);
            let index = |found: Found| {
                let reading = share(found);
                let ends = ends_of(&reading).map(|ends| format!(" ({ends})")).unwrap_or_default();
                AnswerCell::with_text(reading.text() + &ends, reading)
            };
            let [least, greatest] = input.swing.map(|value| self.reading(value, None));
            let swing = match least.unit == greatest.unit {
                true => joined(&range(&number(least.value), &number(greatest.value)), &least.unit),
                false => format!("{} to {}", least.text(), greatest.text()),
            };
            vec![
                input.label.to_owned().into(),
                index(input.index.total),
                index(input.index.first),
                joined(&range(&from, &to), input.unit.symbol).into(),
                swing.into(),
            ]
        };
        let inputs = self.by_total();
        let heads = ["input", "total S_T", "first-order S₁", "5 % to 95 %", &self.answer.label];
        AnswerTable { best: Some(0), ..AnswerTable::new(heads, inputs.iter().map(row)) }
    }

    fn facts(&self) -> Vec<Fact> {
        let value = |name: &str, value: Reading, at: &str| Fact::Value {
            name: name.to_owned(),
            value,
            at: at.to_owned(),
        };
        let [least, median, most] = self.quantiles;
        let mut facts = vec![
            value("Nominal", self.reading(self.nominal, None), ""),
            value("Median", self.reading(median, Some((least, most))), "5 % to 95 % of answers"),
        ];
        if let Some((_, part)) = &self.within {
            let part = Reading { interval: None, ..share(*part) };
            facts.push(value("Within the limit", part, "of answers"));
        }
        let unexplained = 1.0 - self.inputs.iter().map(|input| input.index.first.value).sum::<f64>();
        if percent_of(unexplained.max(0.0)) != percent_of(0.0) {
            let interval = None;
            facts.push(value(
                "Interactions",
                share(Found { value: unexplained, interval }),
                "of the variance",
            ));
        }
        facts.extend(self.most_effective());
        if !self.rows.is_empty() {
            let rows: Vec<String> =
                self.rows.iter().map(|(column, value)| format!("{column} = {value}")).collect();
            facts.push(Fact::Caveat { text: format!("only rows with {}", rows.join(", ")) });
        }
        facts
    }

    /// The input whose value between its 5 % and its 95 % quantile lowers the answer most.
    fn most_effective(&self) -> Option<Fact> {
        let ends = |input: &Input| [0, 1].map(|end| (input.range[end], input.ends[end].abs()));
        let lowest =
            |input: &Input| ends(input).into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let input = self.inputs.iter().min_by(|a, b| lowest(a).1.total_cmp(&lowest(b).1))?;
        let (at, left) = lowest(input);
        let gain = 1.0 - left / self.nominal.abs();
        let shown = |value: f64| with_unit(value, 4, input.unit.symbol);
        let (key, label) = (input.key.to_owned(), input.label.to_owned());
        let change = Alternative { key, label, from: shown(input.nominal), to: shown(at) };
        (gain > 0.0).then_some(Fact::MostEffectiveChange { change, gain, interval: None })
    }
}
