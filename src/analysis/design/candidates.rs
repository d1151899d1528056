//! The candidate intervals for each filler.

use crate::analysis::design::DesignError;
use sagnac_engine::key::Streams;
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::kinds::switched_run::lower::{FilledRun, LoweredRun};
use sagnac_engine::kinds::switched_run::point::Point as RunPoint;

/// Number of candidate intervals where the study names none.
const CANDIDATES: usize = 17;

/// Candidates extend as far as the rms drift in closed form is at most this many times its minimum.
const REACH: f64 = 2.0;

/// Number of intervals examined to find the candidates.
const LOOKED_AT: usize = 150;

/// Runs with one interval and one filler, ready to be sampled.
pub(crate) struct Candidate {
    pub(crate) interval_s: f64,
    pub(crate) switches: u64,
    pub(crate) filled: FilledRun,
    /// These runs without the non-magnetic drift, where there is one.
    pub(crate) switched: Option<FilledRun>,
}

/// Makes the candidates of a study.
pub(crate) struct Maker<'a> {
    pub(crate) runs: &'a SwitchedRun,
    pub(crate) seed: u64,
    /// Whether the study sweeps the interval.
    pub(crate) swept: bool,
}

impl Maker<'_> {
    /// The candidates of each filler, in the order of the intervals; no list is empty.
    pub(crate) fn choose(&self) -> Result<Vec<Vec<Candidate>>, DesignError> {
        let mut points = if self.swept { self.runs.points.clone() } else { spread(&self.runs.points[0]) };
        points.sort_by(|a, b| a.schedule.interval_s.total_cmp(&b.schedule.interval_s));
        let all: Vec<(RunPoint, LoweredRun)> = points
            .into_iter()
            .map(|point| self.lowered(&switched(&point)).map(|lowered| (point, lowered)))
            .collect::<Result<_, _>>()?;
        if all.is_empty() {
            return Err(DesignError::NoCandidate(self.runs.points[0].schedule.duration_s));
        }
        (0..self.runs.fillers().len().max(1)).map(|place| self.of_filler(&all, place)).collect()
    }

    /// The runs of one filler at an interval rounded to ticks; `None` where it is too short or too long.
    pub(crate) fn at(&self, interval_s: f64, place: usize) -> Result<Option<Candidate>, DesignError> {
        let Some(point) = self.runs.points[0].with_interval(interval_s) else { return Ok(None) };
        let lowered = self.lowered(&switched(&point))?;
        self.candidate(&point, &lowered, place).map(Some)
    }

    fn lowered(&self, point: &RunPoint) -> Result<LoweredRun, DesignError> {
        // All intervals use the same random numbers.
        Ok(LoweredRun::new(point, self.runs, self.seed, Streams::Common)?)
    }

    fn of_filler(&self, all: &[(RunPoint, LoweredRun)], place: usize) -> Result<Vec<Candidate>, DesignError> {
        let rms = |(_, lowered): &(RunPoint, LoweredRun)| lowered.fillers[place].expected_rms(0);
        let least = all.iter().map(rms).fold(f64::INFINITY, f64::min);
        if all.iter().all(|lowered| rms(lowered) == 0.0) {
            return Err(DesignError::Nothing);
        }
        let near: Vec<_> = all.iter().filter(|lowered| self.swept || rms(lowered) <= REACH * least).collect();
        let chosen = if self.swept { near } else { thinned(&near) };
        chosen.into_iter().map(|(point, lowered)| self.candidate(point, lowered, place)).collect()
    }

    /// The runs of a point, which is lowered without its non-magnetic drift.
    fn candidate(
        &self,
        point: &RunPoint,
        lowered: &LoweredRun,
        place: usize,
    ) -> Result<Candidate, DesignError> {
        let without = lowered.fillers[place].clone();
        let (filled, switched) = match point.drift.non_magnetic {
            0.0 => (without, None),
            _ => (self.lowered(point)?.fillers.swap_remove(place), Some(without)),
        };
        let (interval_s, switches) = (point.schedule.interval_s, point.switches());
        Ok(Candidate { interval_s, switches, filled, switched })
    }
}

/// The point of a gyro without non-magnetic drift.
fn switched(point: &RunPoint) -> RunPoint {
    let mut point = point.clone();
    point.drift.non_magnetic = 0.0;
    point
}

/// Points with intervals evenly spaced in their logarithm, from the shortest to half the run.
fn spread(point: &RunPoint) -> Vec<RunPoint> {
    let [first, last] = [point.shortest_s(), 0.5 * point.schedule.duration_s].map(libm::log);
    let at = |k: usize| libm::exp(first + (last - first) * k as f64 / (LOOKED_AT - 1) as f64);
    let mut points: Vec<RunPoint> = (0..LOOKED_AT).filter_map(|k| point.with_interval(at(k))).collect();
    points.dedup_by(|a, b| a.schedule == b.schedule);
    points
}

/// A limited number of points, evenly spaced and including both ends.
fn thinned<'a, T>(near: &[&'a T]) -> Vec<&'a T> {
    let last = near.len().saturating_sub(1);
    let mut places: Vec<usize> = (0..CANDIDATES).map(|i| i * last / (CANDIDATES - 1)).collect();
    places.dedup();
    places.into_iter().filter_map(|place| near.get(place).copied()).collect()
}
