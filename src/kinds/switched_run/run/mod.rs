//! Running a study of whole runs: missing trials are sampled, and the first runs are kept as trajectories.

pub(crate) mod rows;
pub(crate) mod trajectories;

use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::lower::{FilledRun, LoweredRun};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::sampling::plan::RunError;
use crate::sampling::tables::Tables;
use crate::sampling::trials::{Addressed, Trials};
use crate::source::diagnose::StudyError;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::study::Study;
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

impl Trials for Plan<'_> {
    fn trials(&self) -> u64 {
        self.study.trials
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|point| point.id).collect()
    }

    fn launches(&self, point: usize) -> Vec<Addressed> {
        let addressed = |filled: &FilledRun, places: Vec<usize>| -> Vec<_> {
            places.into_iter().map(|place| filled.estimates[place].address).collect()
        };
        let of = |filled: &FilledRun| -> Vec<Addressed> {
            let launches = filled.launches().into_iter();
            launches.map(|(launch, places)| (launch, addressed(filled, places))).collect()
        };
        self.points[point].fillers.iter().flat_map(of).collect()
    }

    fn keep(&self, store: &mut Store, share: Share) -> Result<(), RunError> {
        if makes_trajectories(share) {
            trajectories::keep(self, store)?;
        }
        Ok(())
    }

    fn lacks_kept(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        if makes_trajectories(share) { trajectories::lacks(self, store) } else { Ok(0) }
    }

    fn notes(&self) -> Vec<String> {
        late(self.runs).into_iter().chain(trajectories::thinned(self)).chain(self.uneven()).collect()
    }

    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let keeps = self.runs.trajectories > 0;
        let kept = |store| match store {
            Some(store) => trajectories::table(self, store),
            None => Ok(trajectories::blank(self)),
        };
        let trajectories = keeps.then(|| kept(store)).transpose()?;
        Ok(Tables { trajectories, ..Tables::of_points(self.table(store)?) })
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
