//! Running a relock study: launches for what the store lacks.

pub(crate) mod rows;

use crate::kernel::moments::MAX_ESTIMATES;
use crate::kinds::relock::RelockStudy;
use crate::kinds::relock::inputs::{Compensation, Relock};
use crate::kinds::relock::lower::{LoweredRelock, RelockEstimate};
use crate::quantity::number::significant;
use crate::sampling::plan::RunError;
use crate::sampling::tables::Tables;
use crate::sampling::trials::{Addressed, Trials};
use crate::source::diagnose::StudyError;
use crate::store::Store;
use crate::study::Study;
use crate::tally::id::Id;

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
}

impl Trials for Plan<'_> {
    fn trials(&self) -> u64 {
        self.study.trials
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|point| point.id).collect()
    }

    fn launches(&self, point: usize) -> Vec<Addressed> {
        let point = &self.points[point];
        let addressed = |estimates: Vec<&RelockEstimate>| {
            (point.launch(&estimates), estimates.iter().map(|estimate| estimate.address).collect())
        };
        launched(point).map(addressed).collect()
    }

    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        Ok(Tables::of_points(self.table(store)?))
    }

    fn notes(&self) -> Vec<String> {
        let relocks = self.relock.points.iter().map(|point| (&point.inputs.relock, point.inputs.tick_s));
        late(relocks).into_iter().collect()
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
