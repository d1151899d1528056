//! Running a study of whole runs: missing trials are sampled, and the first runs are kept as trajectories.

pub mod rows;
pub mod trajectories;

use std::time::Instant;

use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::lower::{FilledRun, LoweredRun};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::progress::Progress;
use crate::sampling::batches::{Work, held_by_all, lacking, sample};
use crate::sampling::plan;
use crate::sampling::plan::{Done, RunError};
use crate::sampling::tables::Tables;
use crate::sampling::worker::Worker;
use crate::source::diagnose::StudyError;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::study::Study;
use crate::tally::block::row_log2;
use crate::tally::id::Id;
use crate::tally::share::Share;

/// A study whose points are all proven to fit.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    study: &'a Study,
    runs: &'a SwitchedRun,
    points: Vec<LoweredRun>,
}

impl<'a> Plan<'a> {
    /// Lowers every point.
    pub(crate) fn new(study: &'a Study, runs: &'a SwitchedRun) -> Result<Plan<'a>, StudyError> {
        let lower = |point: &RunPoint| {
            LoweredRun::new(point, runs, study.seed, study.streams)
                .map_err(|refusal| study.refused(&point.swept, &refusal))
        };
        let points = runs.points.iter().map(lower).collect::<Result<_, _>>()?;
        Ok(Plan { study, runs, points })
    }

    /// The work that the store lacks of a share.
    fn missing(&self, store: &Store, share: Share) -> Result<Vec<Work>, StoreError> {
        let index = store.index()?;
        let mut all = Vec::new();
        for (turn, point) in self.points.iter().enumerate() {
            let trials = share.trials(self.study.trials, turn);
            for filled in &point.fillers {
                for (launch, places) in filled.launches() {
                    let addresses: Vec<_> =
                        places.iter().map(|&place| filled.estimates[place].address).collect();
                    let log2 = row_log2(self.study.trials, launch.steps());
                    let blocks = lacking(&index, &addresses, trials.clone(), log2)?;
                    if !blocks.is_empty() {
                        all.push(Work { launch, addresses, blocks });
                    }
                }
            }
        }
        Ok(all)
    }

    /// The runs of all points and fillers.
    fn filled(&self) -> impl Iterator<Item = &FilledRun> {
        self.points.iter().flat_map(|point| &point.fillers)
    }

    /// A note that some runs of a sweep over the interval end with an interval that no other cancels.
    fn uneven(&self) -> Option<String> {
        let is_even = |point: &&RunPoint| {
            let pairs = 0.5 * point.schedule.duration_s / point.schedule.interval_s;
            (pairs - libm::round(pairs)).abs() <= 1e-9 * pairs
        };
        let points = &self.runs.points;
        let uneven = points.len() - points.iter().filter(is_even).count();
        let swept = self.study.sweeps.iter().any(|sweep| sweep.key.name == "switching.interval");
        (swept && uneven > 0).then(|| {
            format!(
                "{uneven} of {} points have an odd or fractional number of intervals: nothing cancels the magnetic drift of the last, which \
                 can count for more than the interval",
                points.len()
            )
        })
    }
}

impl plan::Plan for Plan<'_> {
    fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let started = Instant::now();
        let work = self.missing(store, share)?;
        let left: u64 = work.iter().map(Work::trials).sum();
        let of_point = |(turn, point): (usize, &LoweredRun)| {
            let trials = share.trials(self.study.trials, turn);
            let launches: usize = point.fillers.iter().map(|filled| filled.launches().len()).sum();
            launches as u64 * (trials.end - trials.start)
        };
        let all: u64 = self.points.iter().enumerate().map(of_point).sum();
        progress.start("trials", all.saturating_sub(left), all.max(left));
        let trials = sample(&work, 0, store, worker, progress, started)?;
        let stopped = trials < left;
        if !stopped && makes_trajectories(share) {
            trajectories::keep(self, store)?;
        }
        Ok(Done { trials, seconds: started.elapsed().as_secs_f64(), stopped, degraded: vec![] })
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        let sampled: u64 = self.missing(store, share)?.iter().map(Work::trials).sum();
        let kept = if makes_trajectories(share) { trajectories::lacks(self, store)? } else { 0 };
        Ok(sampled + kept)
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        let estimates = self.filled().flat_map(|filled| &filled.estimates);
        held_by_all(index, estimates.map(|estimate| &estimate.address))
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|point| point.id).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(late(self.runs).into_iter().chain(trajectories::thinned(self)).chain(self.uneven()).collect())
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        let keeps = self.runs.trajectories > 0;
        let (points, trajectories) = match store {
            Some(store) => (self.table(store)?, keeps.then(|| trajectories::table(self, store)).transpose()?),
            None => (self.blank_table(), keeps.then(|| trajectories::blank(self))),
        };
        Ok(Tables { trajectories, ..Tables::of_points(points) })
    }

    fn all_trials(&self) -> u64 {
        self.study.trials.saturating_mul(self.points.len() as u64)
    }
}

/// Whether a share makes the trajectories. They are few, so the first share makes them all.
fn makes_trajectories(share: Share) -> bool {
    share.number() == 1
}

/// A note that ticks of the relock after the last one followed would still count.
pub(crate) fn late(runs: &SwitchedRun) -> Option<String> {
    let relocks = runs.points.iter().filter_map(|point| {
        let (relocking, fill) = point.relock.as_ref().zip(point.fill.as_ref())?;
        Some((&relocking.relock, fill.inputs.tick_s))
    });
    crate::kinds::relock::run::late(relocks)
}
