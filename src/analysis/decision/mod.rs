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

pub(crate) mod budget;
pub(crate) mod choice;
mod compared;
pub(crate) mod evaluate;
pub(crate) mod lever;
mod place;
pub(crate) mod sheet;
pub(crate) mod words;

pub use crate::analysis::decision::budget::Part;
pub use crate::analysis::decision::lever::{InputChange, Lever};
pub use crate::analysis::decision::sheet::Sheet;

use crate::analysis::decision::budget::budget;
use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::evaluate::{Evaluator, MAX_TRIALS};
use crate::analysis::decision::lever::lever;
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::source::diagnose::StudyError;
use sagnac_base::table::ColumnError;
use sagnac_engine::chart::Source;
use sagnac_engine::device::{Cpu, Device};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::Swept;
use sagnac_engine::run::{Plan, RunError, Tables};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;
use sagnac_kernel::width::Width;

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

/// The decision sheet of a study; `None` where it judges no error. `progress` receives the evaluations for budget and lever.
///
/// # Errors
/// A row of the tables cannot be evaluated again, or no threads can be started.
pub fn decide(
    study: &Study,
    tables: &Tables,
    progress: &dyn Progress,
) -> Result<Option<Sheet>, DecisionError> {
    let Some(choice) = Choice::of(study, tables)? else { return Ok(None) };
    let mut device = processor()?;
    let (row, count) = (choice.row_of_point, [0, 0]);
    let mut evaluator = Evaluator { device: &mut device, row, progress, count };
    if choice.source != Source::Points {
        return Ok(Some(Sheet::new(&choice, vec![], None)));
    }
    evaluator.expect(1);
    let parts = budget(study, &tables.points, &choice, &mut evaluator)?;
    let found = lever(study, &tables.points, &choice, &mut evaluator)?;
    Ok(Some(Sheet::new(&choice, parts, found)))
}

/// The decision sheet of a study at a single point, which has these values of keys that a sweep may vary and is sampled on
/// the processor; `None` where it judges no error.
///
/// # Errors
/// The point is not a valid one or cannot be represented, or no threads can be started.
pub(crate) fn decide_at(
    study: &Study,
    swept: &[(&'static Key, Swept)],
) -> Result<Option<Sheet>, DecisionError> {
    let (keys, point): (Vec<&'static Key>, Vec<Swept>) = swept.iter().cloned().unzip();
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

#[cfg(test)]
mod tests;
