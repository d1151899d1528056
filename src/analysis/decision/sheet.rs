//! The decision sheet and its facts.

use crate::analysis::decision::Figure;
use crate::analysis::decision::budget::Part;
use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::lever::Lever;
use sagnac_base::quantity::list::listed;
use sagnac_base::table::Unit;
use sagnac_engine::chart::Limit;
use sagnac_report::answer::{self as fact, Fact, Reading, Status};

/// The decision sheet of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Label of the judged estimate.
    pub label: String,
    /// Its unit.
    pub unit: Unit,
    /// The limit, where there is one.
    pub limit: Option<Limit>,
    /// The best option; empty where there is only one.
    pub option: String,
    /// Number of options.
    pub options: usize,
    /// The condition under which the best option is worst; empty where there is only one.
    pub condition: String,
    /// Number of conditions under which it is within the limit, and of all conditions.
    pub met: [usize; 2],
    /// The estimate of the best option under that condition.
    pub value: Figure,
    /// The estimate in the unit in which it is shown.
    pub reading: Reading,
    /// Fillers that are no options, because firmware cannot have them.
    pub left_out: Vec<String>,
    /// The error budget, the largest part first; empty where there is none.
    pub budget: Vec<Part>,
    /// The next lever.
    pub lever: Option<Lever>,
}

impl Sheet {
    pub(crate) fn new(choice: &Choice, budget: Vec<Part>, lever: Option<Lever>) -> Sheet {
        Sheet {
            label: choice.column.label.clone(),
            unit: choice.column.unit,
            limit: choice.limit,
            option: choice.option.clone(),
            options: choice.options,
            condition: choice.condition.clone(),
            met: choice.met,
            value: (choice.value(), choice.interval()).into(),
            reading: choice.reading(),
            left_out: choice.left_out.clone(),
            budget,
            lever,
        }
    }

    /// Whether the best option meets the limit under all conditions; `None` without a limit, and where the 95 % interval
    /// contains it.
    pub fn is_met(&self) -> Option<bool> {
        let limit = self.limit?.value;
        (!self.is_open(limit)).then_some(self.value.value <= limit)
    }

    fn is_open(&self, limit: f64) -> bool {
        self.value.interval.is_some_and(|(low, high)| low <= limit && limit < high)
    }

    /// The state of the limit.
    pub fn status(&self) -> Status {
        match (self.limit, self.is_met(), self.met) {
            (None, ..) => Status::NoLimit,
            (_, None, _) => Status::Inconclusive,
            (_, Some(true), _) => Status::Met,
            (_, _, [0, _]) => Status::NotMet,
            (_, _, [met, of]) => Status::PartlyMet { met, of },
        }
    }

    /// The facts of the sheet.
    pub fn facts(&self) -> Vec<Fact> {
        let mut facts = Vec::new();
        if self.met[1] > 1 && self.value.value.is_finite() {
            let ratio = self.limit.map(|limit| self.value.value / limit.value).filter(|ratio| *ratio > 1.0);
            let option = (self.options > 1).then_some(self.option.as_str());
            let parts = [&self.condition, option.unwrap_or_default()];
            let at = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
            facts.push(Fact::WorstCase { value: self.reading.clone(), at, ratio_to_limit: ratio });
        }
        if self.budget.len() > 1 {
            let part = |part: &Part| fact::Part {
                name: part.name.to_owned(),
                share: part.share.value,
                interval: part.share.interval.map(|(low, high)| [low, high]),
            };
            let parts = self.budget.iter().map(part).collect();
            facts.push(Fact::ErrorBudget { parts, at: String::new() });
        }
        facts.extend(self.lever.as_ref().filter(|_| self.is_met() != Some(true)).map(Lever::fact));
        if !self.left_out.is_empty() {
            let names = listed(&self.left_out);
            facts.push(Fact::Caveat {
                text: format!("{names}: designed for exactly this motion, which firmware does not know"),
            });
        }
        facts
    }
}
