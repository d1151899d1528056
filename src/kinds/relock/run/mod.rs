//! Running a relock study: launches for what the store lacks.

pub mod rows;

use std::time::Instant;

use crate::kernel::moments::MAX_ESTIMATES;
use crate::kinds::relock::RelockStudy;
use crate::kinds::relock::inputs::{Compensation, Relock};
use crate::kinds::relock::lower::{LoweredRelock, RelockEstimate};
use crate::progress::Progress;
use crate::quantity::number::significant;
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
    relock: &'a RelockStudy,
    points: Vec<LoweredRelock>,
}

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub(crate) fn new(study: &'a Study, relock: &'a RelockStudy) -> Result<Plan<'a>, StudyError> {
        let mut points = Vec::new();
        for point in &relock.points {
            let lowered = LoweredRelock::new(point, study.seed, study.streams)
                .map_err(|refusal| study.refused(&point.swept, &refusal))?;
            points.push(lowered);
        }
        Ok(Plan { study, relock, points })
    }

    /// The work that the store lacks of a share.
    fn missing(&self, store: &Store, share: Share) -> Result<Vec<Work>, StoreError> {
        let index = store.index()?;
        let mut all = Vec::new();
        for (turn, point) in self.points.iter().enumerate() {
            let trials = share.trials(self.study.trials, turn);
            for estimates in launched(point) {
                let addresses: Vec<_> = estimates.iter().map(|estimate| estimate.address).collect();
                let launch = point.launch(&estimates);
                let log2 = row_log2(self.study.trials, launch.steps());
                let blocks = lacking(&index, &addresses, trials.clone(), log2)?;
                if !blocks.is_empty() {
                    all.push(Work { launch, addresses, blocks });
                }
            }
        }
        Ok(all)
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
        let of_point = |(turn, point)| {
            let trials = share.trials(self.study.trials, turn);
            launched(point).count() as u64 * (trials.end - trials.start)
        };
        let all: u64 = self.points.iter().enumerate().map(of_point).sum();
        progress.start("trials", all.saturating_sub(left), all.max(left));
        let trials = sample(&work, 0, store, worker, progress, started)?;
        let seconds = started.elapsed().as_secs_f64();
        Ok(Done { trials, seconds, stopped: trials < left, degraded: vec![] })
    }

    fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        Ok(self.missing(store, share)?.iter().map(Work::trials).sum())
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        let estimates = self.points.iter().flat_map(|point| &point.estimates);
        held_by_all(index, estimates.map(|estimate| &estimate.address))
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|point| point.id).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        let relocks = self.relock.points.iter().map(|point| (&point.inputs.relock, point.inputs.tick_s));
        Ok(late(relocks).into_iter().collect())
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Ok(Tables::of_points(match store {
            Some(store) => self.table(store)?,
            None => self.blank_table(),
        }))
    }

    fn all_trials(&self) -> u64 {
        self.study.trials.saturating_mul(self.points.len() as u64)
    }
}

/// A note that ticks after the last one followed would still count, for some relocks with their ticks in s.
pub(crate) fn late<'a>(relocks: impl Iterator<Item = (&'a Relock, f64)>) -> Option<String> {
    let slow = |(relock, tick_s): &(&Relock, f64)| relock.loop_s / tick_s;
    let (relock, tick_s) = relocks.max_by(|a, b| slow(a).total_cmp(&slow(b)))?;
    let (late, ticks) = (relock.late(tick_s), relock.ticks);
    let (percent, arcsec) = (libm::round(100.0 * late), significant(late * relock.whole_angle(tick_s), 2));
    (late >= LATE).then(|| {
        format!("up to {percent} % of the apparent angle, {arcsec} ″ per switch, comes after tick {ticks} and is not counted")
    })
}

/// Fraction of the angle after the last tick from which on a note is given.
const LATE: f64 = 0.01;

/// The estimates of each launch: those of one compensation, as many as a launch can have.
fn launched(point: &LoweredRelock) -> impl Iterator<Item = Vec<&RelockEstimate>> {
    Compensation::ALL.into_iter().flat_map(|compensation| {
        let of = point.estimates.iter().filter(move |estimate| estimate.compensation == compensation);
        let of: Vec<&RelockEstimate> = of.collect();
        of.chunks(MAX_ESTIMATES).map(<[_]>::to_vec).collect::<Vec<_>>()
    })
}
