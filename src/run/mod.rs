//! Running a study: what is missing in the store is sampled and added, then all that is held becomes tables.

pub mod keep;

use std::collections::HashSet;

use crate::device::Device;
use crate::progress::{Progress, Silent};
pub use crate::run::keep::{KeepError, keep};
use crate::sampling::plan;
pub use crate::sampling::plan::{Done, RunError};
pub use crate::sampling::tables::Tables;
use crate::sampling::worker::Worker;
use crate::source::diagnose::StudyError;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::store::{Identity, Store};
use crate::study::Study;
use crate::table::Table;
use crate::tally::id::Id;
use crate::tally::share::Share;

/// A study whose every point is proven to fit.
#[derive(Debug)]
pub struct Plan<'a> {
    study: &'a Study,
    work: Box<dyn plan::Plan + 'a>,
}

/// The name of the study that stands beside its results: run it to repeat the run.
pub const RESOLVED: &str = "resolved_study.toml";

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub fn new(study: &'a Study) -> Result<Plan<'a>, StudyError> {
        Ok(Plan { study, work: study.subject().plan(study)? })
    }

    /// Whether there is anything to sample, for which a device is needed.
    pub fn is_sampled(&self) -> bool {
        self.work.is_sampled()
    }

    /// What makes the results those of this study.
    pub fn identity(&self) -> Identity {
        Identity {
            kind: self.study.kind().name.to_owned(),
            seed: self.study.seed,
            streams: self.study.streams.name().to_owned(),
            kernels: (self.study.kind().kernels)(),
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
        let done = self.work.run(store, &mut worker, share, progress)?;
        Ok(Done { degraded: worker.into_notes(), ..done })
    }

    /// Whether so many sampled trials are more than all points have: estimates of a point that are not sampled together count each.
    pub fn counts_again(&self, sampled: u64) -> bool {
        sampled > self.work.all_trials()
    }

    /// Trials that the store still lacks of a share, over all points.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        self.work.lacks(store, share)
    }

    /// The tables before anything is sampled: all rows, without estimates.
    pub fn blank_tables(&self) -> Tables {
        let nothing = Tables::of_points(Table::default());
        self.work.tables(None, &Silent).unwrap_or(nothing)
    }

    /// All estimates held; `progress` hears of fits.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn tables(&self, store: &Store, progress: &dyn Progress) -> Result<Tables, RunError> {
        self.work.tables(Some(store), progress)
    }

    /// Trials that a study has which repeats this one: what all points have, where they have the same number and that is more
    /// than was asked for.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn held(&self, index: &Index) -> Result<u64, StoreError> {
        Ok(self.work.held(index)?.unwrap_or(0).max(self.study.trials))
    }

    /// What should be known besides the results, each in a sentence, of a store that holds what `index` says, and so many trials as
    /// [`Plan::held`] does.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn notes(&self, store: &Store, index: &Index, held: u64) -> Result<Vec<String>, StoreError> {
        let mut notes = self.study.notes().to_vec();
        notes.extend(self.work.notes(store)?);
        if held > self.study.trials {
            let why = self.work.surplus();
            notes.push(format!("{held} trials a point, not {}: {why}", self.study.trials));
        }
        let points = index.points();
        let asked: HashSet<Id> = self.work.ids().into_iter().collect();
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
