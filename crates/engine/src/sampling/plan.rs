//! A study whose points are all proven to fit, as every kind provides it to a run.

use std::fmt;

use crate::device::error::GpuError;
use crate::key::refusal::Refusal;
use crate::sampling::tables::Tables;
use crate::sampling::worker::Worker;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::tally::id::Id;
use crate::tally::share::Share;
use sagnac_base::progress::Progress;
use sagnac_base::source::diagnose::StudyError;

/// Why a run ended early. Results computed before are in the store.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The results folder failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The device failed and could not be replaced.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A point was refused that was lowered before, on another machine; or its closed form is not that of its inputs.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// The outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Done {
    /// Trials sampled over all points.
    pub trials: u64,
    /// Duration of the run, s.
    pub seconds: f64,
    /// Whether it ended early, as [`Progress::stops`] requested.
    pub stopped: bool,
    /// Deviations from the requested execution, each a sentence.
    pub degraded: Vec<String>,
}

/// The plan of a study; `None` if progress asked to stop before all points were lowered.
pub(crate) type Planned<'a> = Result<Option<Box<dyn Plan + 'a>>, StudyError>;

/// The plan of a study of any kind.
pub trait Plan: fmt::Debug {
    /// Samples the trials that the store lacks of a share. `progress` receives the total, and the work done as it
    /// completes.
    ///
    /// # Errors
    /// The device or the disk fails.
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError>;

    /// Number of trials that the store lacks of a share.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError>;

    /// The tables of everything that the store holds; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError>;

    /// Number of trials of every estimate, where it is the same for all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError>;

    /// The identities of all points.
    fn ids(&self) -> Vec<Id>;

    /// Notes attached to the results, each a sentence.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError>;

    /// Number of steps of one trial of every point, where trials are of any number; `None` where shares have whole records.
    fn steps_of_a_trial(&self) -> Option<u64> {
        None
    }

    /// Number of trials of all points together.
    fn all_trials(&self) -> u64;

    /// Why points have more trials than the study requests.
    fn surplus(&self) -> &'static str {
        "the folder holds them already"
    }
}
