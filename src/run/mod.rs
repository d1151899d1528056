//! Running a study: what is missing in the store is sampled and added, then all that is held becomes tables.

pub mod keep;

use std::collections::HashSet;

use crate::chart::file::Source;
use crate::device::Device;
use crate::device::gpu::GpuError;
use crate::kernel::{
    allan as allan_kernel, gap_fill as gap_fill_kernel, relock_ticks, switched_run as run_kernel,
};
use crate::key::setting::Swept;
use crate::kinds::allan::lower::refusal::RecordsError;
use crate::progress::Progress;
pub use crate::run::keep::{KeepError, keep};
use crate::sampling::worker::Worker;
use crate::source::diagnose::StudyError;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::store::{Identity, Store};
use crate::study::{Study, Subject};
use crate::table::{Column, Table, Unit};
use crate::tally::id::Id;
use crate::tally::share::Share;

/// Why a run ended early. What was computed before is in the store.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The results folder failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The device failed, and nothing could take its place.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// Of a point that was lowered before: not on the same machine.
    #[error(transparent)]
    Records(#[from] RecordsError),
}

/// A study whose every point is proven to fit.
#[derive(Debug)]
pub struct Plan<'a> {
    study: &'a Study,
    work: Work<'a>,
}

#[derive(Debug)]
enum Work<'a> {
    GapFill(crate::kinds::gap_fill::run::Plan<'a>),
    Allan(crate::kinds::allan::run::Plan<'a>),
    SwitchedRun(crate::kinds::switched_run::run::Plan<'a>),
    Relock(crate::kinds::relock::run::Plan<'a>),
    /// Closed forms: the table is all there is.
    Exact(Table),
}

/// What a run did.
#[derive(Debug, Clone, PartialEq)]
pub struct Done {
    /// Trials sampled, over all points.
    pub trials: u64,
    /// It took, s.
    pub seconds: f64,
    /// Whether it ended before all was done, as [`Progress::stops`] asked for.
    pub stopped: bool,
    /// Why some of it was not done as asked, each in a sentence.
    pub degraded: Vec<String>,
}

/// The results of a study, each a table of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// points.csv
    pub points: Table,
    /// coefficients.csv, where coefficients are fitted.
    pub coefficients: Option<Table>,
    /// trajectories.csv, where some are kept.
    pub trajectories: Option<Table>,
}

/// The name of the study that stands beside its results: run it to repeat the run.
pub const RESOLVED: &str = "resolved_study.toml";

impl Tables {
    /// All tables, each with what it is.
    pub fn all(&self) -> impl Iterator<Item = (Source, &Table)> {
        let coefficients = self.coefficients.as_ref().map(|table| (Source::Coefficients, table));
        let trajectories = self.trajectories.as_ref().map(|table| (Source::Trajectories, table));
        std::iter::once((Source::Points, &self.points)).chain(coefficients).chain(trajectories)
    }

    /// All of them, that of the study's first chart before the others.
    pub fn as_charted(&self, study: &Study) -> Vec<(Source, &Table)> {
        let first = study.charts.first().map_or(Source::Points, |chart| chart.source);
        let mut all: Vec<_> = self.all().collect();
        all.sort_by_key(|(source, _)| *source != first);
        all
    }

    /// Only that of the points.
    pub(crate) fn of_points(points: Table) -> Tables {
        Tables { points, coefficients: None, trajectories: None }
    }

    /// The table that a chart is drawn from.
    pub fn of(&self, source: Source) -> &Table {
        let other = match source {
            Source::Points => None,
            Source::Coefficients => self.coefficients.as_ref(),
            Source::Trajectories => self.trajectories.as_ref(),
        };
        other.unwrap_or(&self.points)
    }
}

/// Half the width of a 95 % interval in standard errors.
pub(crate) const NORMAL_95: f64 = 1.959_963_985;

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub fn new(study: &'a Study) -> Result<Plan<'a>, StudyError> {
        let work = match &study.subject {
            Subject::GapFill(gap_fill) => {
                Work::GapFill(crate::kinds::gap_fill::run::Plan::new(study, gap_fill)?)
            }
            Subject::Allan(allan) => Work::Allan(crate::kinds::allan::run::Plan::new(study, allan)?),
            Subject::SwitchedRun(runs) => {
                Work::SwitchedRun(crate::kinds::switched_run::run::Plan::new(study, runs)?)
            }
            Subject::Relock(relock) => Work::Relock(crate::kinds::relock::run::Plan::new(study, relock)?),
            Subject::DriftBudget(budget) => Work::Exact(crate::kinds::exact::of_budget(study, budget)),
            Subject::Suspension(suspension) => {
                Work::Exact(crate::kinds::exact::of_suspension(study, suspension))
            }
        };
        Ok(Plan { study, work })
    }

    /// Whether there is anything to sample, for which a device is needed.
    pub fn is_sampled(&self) -> bool {
        !matches!(self.work, Work::Exact(_))
    }

    /// What makes the results those of this study.
    pub fn identity(&self) -> Identity {
        Identity {
            kind: self.study.kind().name().to_owned(),
            seed: self.study.seed,
            streams: self.study.streams.name().to_owned(),
            kernels: self.kernels(),
        }
    }

    /// The kernels that sample it, with their versions.
    fn kernels(&self) -> String {
        let relock = format!("relock {}", relock_ticks::VERSION);
        match &self.work {
            Work::GapFill(_) => format!("gap_fill {}", gap_fill_kernel::VERSION),
            Work::Allan(_) => format!("allan {}", allan_kernel::VERSION),
            Work::SwitchedRun(_) => format!("switched_run {}, {relock}", run_kernel::VERSION),
            Work::Relock(_) => relock,
            Work::Exact(_) => "none".to_owned(),
        }
    }

    /// Samples what the store lacks of a share. `progress` hears how much there is in all and, as it comes, what is done; what
    /// earlier runs left is done already.
    ///
    /// A GPU that fails ends no run: it takes smaller tiles when memory runs out, is opened again when it is lost, and where
    /// neither helps `device` becomes the CPU. The results are the same bits; [`Done::degraded`] says what happened.
    ///
    /// # Errors
    /// The disk fails, or the device, and there are no threads for the CPU to take its place; what was sampled before is in the
    /// store.
    pub fn run(
        &self,
        store: &mut Store,
        device: &mut Device,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let mut worker = Worker::new(device, progress);
        let done = match &self.work {
            Work::GapFill(plan) => plan.run(store, &mut worker, share, progress)?,
            Work::Allan(plan) => plan.run(store, &mut worker, share, progress)?,
            Work::SwitchedRun(plan) => plan.run(store, &mut worker, share, progress)?,
            Work::Relock(plan) => plan.run(store, &mut worker, share, progress)?,
            Work::Exact(_) => Done { trials: 0, seconds: 0.0, stopped: false, degraded: vec![] },
        };
        Ok(Done { degraded: worker.into_notes(), ..done })
    }

    /// Whether so many sampled trials are more than all points have: estimates of a point that are not sampled together count each.
    pub fn counts_again(&self, sampled: u64) -> bool {
        let all = match &self.work {
            Work::GapFill(plan) => plan.most_trials().iter().sum(),
            Work::SwitchedRun(plan) => self.study.trials.saturating_mul(plan.ids().len() as u64),
            Work::Relock(plan) => self.study.trials.saturating_mul(plan.ids().len() as u64),
            Work::Allan(_) | Work::Exact(_) => u64::MAX,
        };
        sampled > all
    }

    /// Trials that the store still lacks of a share, over all points.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        match &self.work {
            Work::GapFill(plan) => plan.lacks(store, share),
            Work::Allan(plan) => plan.lacks(store, share),
            Work::SwitchedRun(plan) => plan.lacks(store, share),
            Work::Relock(plan) => plan.lacks(store, share),
            Work::Exact(_) => Ok(0),
        }
    }

    /// The tables before anything is sampled: all rows, without estimates.
    pub fn blank_tables(&self) -> Tables {
        match &self.work {
            Work::GapFill(plan) => Tables::of_points(plan.blank_table()),
            Work::Allan(plan) => plan.blank_tables(),
            Work::SwitchedRun(plan) => plan.blank_tables(),
            Work::Exact(table) => Tables::of_points(table.clone()),
            Work::Relock(plan) => Tables::of_points(plan.blank_table()),
        }
    }

    /// All estimates held; `progress` hears of fits.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn tables(&self, store: &Store, progress: &dyn Progress) -> Result<Tables, RunError> {
        Ok(match &self.work {
            Work::GapFill(plan) => Tables::of_points(plan.table(store)?),
            Work::Allan(plan) => plan.tables(store, progress)?,
            Work::SwitchedRun(plan) => plan.tables(store)?,
            Work::Exact(table) => Tables::of_points(table.clone()),
            Work::Relock(plan) => Tables::of_points(plan.table(store)?),
        })
    }

    /// Trials that a study has which repeats this one: what all points have, where they have the same number and that is more
    /// than was asked for.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn held(&self, index: &Index) -> Result<u64, StoreError> {
        let held = match &self.work {
            Work::GapFill(plan) => plan.held(index)?,
            Work::Allan(plan) => plan.held(index)?,
            Work::SwitchedRun(plan) => plan.held(index)?,
            Work::Relock(plan) => plan.held(index)?,
            Work::Exact(_) => None,
        };
        Ok(held.unwrap_or(0).max(self.study.trials))
    }

    /// What should be known besides the results, each in a sentence, of a store that holds what `index` says, and so many trials as
    /// [`Plan::held`] does.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn notes(&self, store: &Store, index: &Index, held: u64) -> Result<Vec<String>, StoreError> {
        let mut notes = self.study.notes().to_vec();
        notes.extend(match &self.work {
            Work::GapFill(plan) => plan.notes(store)?,
            Work::Allan(plan) => plan.notes(),
            Work::SwitchedRun(plan) => plan.notes(),
            Work::Relock(plan) => plan.notes(),
            Work::Exact(_) => {
                vec!["all values are closed forms: trials, seed and device have no use here".to_owned()]
            }
        });
        if held > self.study.trials {
            let why = match &self.work {
                Work::GapFill(plan) if plan.replays() => "whole replays of the record",
                _ => "the folder holds them already",
            };
            notes.push(format!("{held} trials a point, not {}: {why}", self.study.trials));
        }
        let points = index.points();
        let asked = match &self.work {
            Work::GapFill(plan) => plan.ids(),
            Work::Allan(plan) => plan.ids(),
            Work::SwitchedRun(plan) => plan.ids(),
            Work::Relock(plan) => plan.ids(),
            Work::Exact(_) => vec![],
        };
        let asked: HashSet<Id> = asked.into_iter().collect();
        match points.iter().filter(|id| !asked.contains(id)).count() {
            0 => {}
            1 => notes.push(
                "1 point of earlier runs is kept but not shown: the study no longer asks for it".to_owned(),
            ),
            n => notes.push(format!(
                "{n} points of earlier runs are kept but not shown: the study no longer asks for them"
            )),
        }
        Ok(notes)
    }
}

/// The error of a point that cannot be sampled, at the `key` of the study that has to change.
pub(crate) fn refused(
    study: &Study,
    swept: &[(&'static str, Swept)],
    key: &str,
    message: &str,
    help: &str,
) -> StudyError {
    let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
    study.error_at(study.place_of(key), format!("{message}{place}"), help)
}

/// An empty column.
pub(crate) fn column(name: &str, label: &str, unit: Unit) -> Column {
    Column { name: name.to_owned(), label: label.to_owned(), unit, cells: vec![], band: None }
}

/// Empty columns of the swept keys.
pub(crate) fn swept_columns(study: &Study) -> Vec<Column> {
    let of_sweep = |sweep: &crate::key::sweep::Sweep| {
        let unit = sweep.values.first().map_or(Unit::NONE, Swept::unit);
        column(sweep.key.name, sweep.key.label, unit)
    };
    study.sweeps.iter().map(of_sweep).collect()
}
