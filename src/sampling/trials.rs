//! Plans of kinds whose points all take the same number of trials.

use std::time::Instant;

use crate::kernel::launch::Launch;
use crate::progress::Progress;
use crate::sampling::batches::{Work, held_by_all, lacking, sample};
use crate::sampling::plan::{Done, Plan, RunError};
use crate::sampling::tables::Tables;
use crate::sampling::worker::Worker;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::store::{Address, Store};
use crate::tally::block::row_log2;
use crate::tally::id::Id;
use crate::tally::share::Share;

/// A launch of a point, with the address of each of its estimates.
pub(crate) type Addressed = (Launch, Vec<Address>);

/// The plan of a study whose points all take the same number of trials.
pub(crate) trait Trials: std::fmt::Debug {
    /// Number of trials of each point.
    fn trials(&self) -> u64;

    /// The identities of all points.
    fn ids(&self) -> Vec<Id>;

    /// The launches of a point.
    fn launches(&self, point: usize) -> Vec<Addressed>;

    /// The tables of all that the store holds; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError>;

    /// Notes on the results, each a sentence.
    fn notes(&self) -> Vec<String>;

    /// Stores what a share keeps besides tallies, after its trials.
    ///
    /// # Errors
    /// The disk fails.
    fn keep(&self, _store: &mut Store, _share: Share) -> Result<(), RunError> {
        Ok(())
    }

    /// The amount of missing results that [`keep`](Trials::keep) would store.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn lacks_kept(&self, _store: &Store, _share: Share) -> Result<u64, StoreError> {
        Ok(0)
    }
}

/// The work of a share that the store lacks, and the trials of all its launches.
fn missing(plan: &impl Trials, store: &Store, share: Share) -> Result<(Vec<Work>, u64), StoreError> {
    let index = store.index()?;
    let (mut lacks, mut all) = (Vec::new(), 0);
    for point in 0..plan.ids().len() {
        let trials = share.trials(plan.trials(), point);
        for (launch, addresses) in plan.launches(point) {
            all += trials.end - trials.start;
            let log2 = row_log2(plan.trials(), launch.steps());
            let blocks = lacking(&index, &addresses, trials.clone(), log2)?;
            if !blocks.is_empty() {
                lacks.push(Work { launch, addresses, blocks });
            }
        }
    }
    Ok((lacks, all))
}

impl<T: Trials> Plan for T {
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let started = Instant::now();
        let (work, all) = missing(self, store, share)?;
        let left: u64 = work.iter().map(Work::trials).sum();
        progress.start("trials", all.saturating_sub(left), all.max(left));
        let trials = sample(&work, 0, store, worker, progress, started)?;
        let stopped = trials < left;
        if !stopped {
            self.keep(store, share)?;
        }
        Ok(Done { trials, seconds: started.elapsed().as_secs_f64(), stopped, degraded: vec![] })
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        let (work, _) = missing(self, store, share)?;
        Ok(work.iter().map(Work::trials).sum::<u64>() + self.lacks_kept(store, share)?)
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Trials::tables(self, store)
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        let points = 0..Trials::ids(self).len();
        let launches: Vec<Addressed> = points.flat_map(|point| self.launches(point)).collect();
        held_by_all(index, launches.iter().flat_map(|(_, addresses)| addresses))
    }

    fn ids(&self) -> Vec<Id> {
        Trials::ids(self)
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(Trials::notes(self))
    }

    fn all_trials(&self) -> u64 {
        self.trials().saturating_mul(Trials::ids(self).len() as u64)
    }
}
