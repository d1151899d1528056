//! The decision sheet of a study: whether its requirement is met, by which option, with which margin, what limits it, and
//! which single input to change next.
//!
//! ```text
//! tables ─ choice ─▶ best option, where it is worst ─┬─ without each part of its error ─▶ error budget
//!                                                    └─ each input a quarter up or down ─▶ next lever ─ bisection ─▶ needed value
//! ```
//!
//! Budget and lever are sampled anew on the processor, all with the same random numbers, so that a difference is that of
//! the inputs; closed forms are used where there are some. Their intervals come from the scatter of 16 parts of the
//! trials.

pub(crate) mod best_option;
pub(crate) mod evaluate;
mod one_at_a_time;
#[cfg(test)]
mod tests;

use crate::analysis::decision::best_option::BestOption;
use crate::analysis::decision::evaluate::{Evaluator, MAX_TRIALS, budget};
use crate::analysis::decision::one_at_a_time::lever;
use sagnac_base::diagnostics::{StudyError, listed};
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::{ColumnError, Unit};
use sagnac_engine::chart::{Limit, Source};
use sagnac_engine::device::{Cpu, Device};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::run::{Plan, RunError, Tables};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;
use sagnac_kernel::width::Width;
use sagnac_report::answer as fact;
use sagnac_report::answer::{Fact, Reading, Status};

pub use crate::analysis::decision::evaluate::Part;
pub use crate::analysis::decision::one_at_a_time::{InputChange, Lever};

/// Why there is no decision sheet.
#[derive(Debug, thiserror::Error)]
pub enum DecisionError {
    /// A point cannot be represented.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Sampling failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The table lacks a column.
    #[error(transparent)]
    Column(#[from] ColumnError),
    /// No threads can be started.
    #[error("no threads can be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// Value.
    pub value: f64,
    /// 95 % interval; absent for closed forms and for too few trials.
    pub interval: Option<(f64, f64)>,
}

impl From<(f64, Option<(f64, f64)>)> for Figure {
    fn from((value, interval): (f64, Option<(f64, f64)>)) -> Figure {
        Figure { value, interval }
    }
}

/// The decision sheet of a study without what has to be sampled for it, the error budget and the change of an input; `None`
/// where the study judges no error.
///
/// # Errors
/// The table lacks a column.
pub fn judge(study: &Study, tables: &Tables) -> Result<Option<Sheet>, DecisionError> {
    Ok(BestOption::new(study, tables)?.map(|choice| Sheet::new(&choice)))
}

/// The whole decision sheet of a study; `None` where it judges no error. `progress` receives the evaluations.
///
/// # Errors
/// A row of the tables cannot be evaluated again, or no threads can be started.
pub fn decide(
    study: &Study,
    tables: &Tables,
    progress: &dyn Progress,
) -> Result<Option<Sheet>, DecisionError> {
    let Some(choice) = BestOption::new(study, tables)? else { return Ok(None) };
    let sheet = Sheet::new(&choice);
    if choice.source != Source::Points {
        return Ok(Some(sheet));
    }
    let mut device = processor()?;
    let (row, count) = (choice.row_of_point, [0, 0]);
    let mut evaluator = Evaluator { device: &mut device, row, progress, count };
    evaluator.expect(1);
    let budget = budget(study, &tables.points, &choice, &mut evaluator)?;
    // Nothing has to change where the limit is met.
    let lever = match sheet.is_met() {
        Some(true) => None,
        _ => lever(study, &tables.points, &choice, &mut evaluator)?,
    };
    Ok(Some(Sheet { budget, lever, is_partial: false, ..sheet }))
}

/// The decision sheet of a study at a single point, which has these values of keys that a sweep may vary and is sampled on
/// the processor; `None` where it judges no error.
///
/// # Errors
/// The point is not a valid one or cannot be represented, or no threads can be started.
pub(crate) fn decide_at(
    study: &Study,
    swept: &[(&'static Key, SweepValue)],
) -> Result<Option<Sheet>, DecisionError> {
    let (keys, point): (Vec<&'static Key>, Vec<SweepValue>) = swept.iter().cloned().unzip();
    let mut study = study.at_points(&keys, &[point])?;
    study.trials = study.trials.min(MAX_TRIALS);
    let plan = Plan::new(&study)?;
    let mut store = Store::in_memory(&plan.identity());
    plan.run(&mut store, &mut processor()?, Share::WHOLE, &Silent)?;
    decide(&study, &plan.tables(&store, &Silent)?, &Silent)
}

fn processor() -> Result<Device, DecisionError> {
    Ok(Device::Cpu(Cpu::new(Width::widest(), 0)?))
}

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
    /// The change of an input that helps most; none where the limit is met.
    pub lever: Option<Lever>,
    /// Whether budget and change are still to be sampled.
    pub is_partial: bool,
}

impl Sheet {
    fn new(choice: &BestOption) -> Sheet {
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
            budget: vec![],
            lever: None,
            is_partial: choice.source == Source::Points,
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
            let option = (self.options > 1).then(|| format!("with {}", self.option));
            let condition = Some(self.condition.clone()).filter(|condition| !condition.is_empty());
            let at = condition.into_iter().chain(option).collect::<Vec<_>>().join(", ");
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
        facts.extend(self.lever.as_ref().map(Lever::fact));
        if !self.left_out.is_empty() {
            let names = listed(&self.left_out);
            facts.push(Fact::Caveat {
                text: format!("{names}: designed for exactly this motion, which firmware does not know"),
            });
        }
        facts
    }
}

/// A quantity with this many digits; a time below a tenth of a second in milliseconds.
pub(crate) fn short(quantity: Quantity, digits: usize) -> String {
    // In the unit that is shown.
    let shown = quantity.read();
    let part = significant(shown, digits).parse().map_or(1.0, |rounded: f64| rounded / shown);
    let value = if shown == 0.0 { 0.0 } else { quantity.value * part };
    match quantity.dimension {
        Dimension::Time if value.abs() < 0.1 => format!("{} ms", significant(1000.0 * value, digits)),
        _ => Quantity { value, ..quantity }.to_string(),
    }
}
