//! The candidate intervals for each filler.

use crate::analysis::design::DesignError;
use crate::drift::schedule::Schedule;
use crate::key::common::Streams;
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::lower::{FilledRun, LoweredRun};
use crate::kinds::switched_run::point::Point as RunPoint;

/// Number of candidate intervals where the study names none.
const CANDIDATES: usize = 17;

/// Candidates extend as far as the rms drift in closed form is at most this many times its minimum.
const REACH: f64 = 2.0;

/// Number of intervals examined to find the candidates.
const LOOKED_AT: usize = 150;

/// Runs with one interval and one filler, ready to be sampled.
pub(crate) struct Candidate {
    pub(crate) schedule: Schedule,
    pub(crate) switches: u64,
    pub(crate) filled: FilledRun,
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
        let mut points = if self.swept { even(&self.runs.points) } else { spread(&self.runs.points[0]) };
        points.sort_by(|a, b| a.schedule.interval_s.total_cmp(&b.schedule.interval_s));
        let all = points.into_iter().map(|point| self.lowered(point)).collect::<Result<Vec<_>, _>>()?;
        if all.is_empty() {
            return Err(DesignError::NoCandidate(self.runs.points[0].schedule.duration_s));
        }
        (0..self.runs.fillers().len().max(1)).map(|place| self.of_filler(&all, place)).collect()
    }

    /// The runs of one filler at an interval rounded to ticks; `None` where it is too short or too long.
    pub(crate) fn at(&self, interval_s: f64, place: usize) -> Result<Option<Candidate>, DesignError> {
        let Some(point) = self.runs.points[0].with_interval(interval_s) else { return Ok(None) };
        self.lowered(point).map(|lowered| Some(candidate(&lowered, place)))
    }

    fn lowered(&self, mut point: RunPoint) -> Result<(RunPoint, LoweredRun), DesignError> {
        point.drift.non_magnetic = 0.0;
        // All intervals use the same random numbers.
        let lowered = LoweredRun::new(&point, self.runs, self.seed, Streams::Common)?;
        Ok((point, lowered))
    }

    fn of_filler(&self, all: &[(RunPoint, LoweredRun)], place: usize) -> Result<Vec<Candidate>, DesignError> {
        let rms = |(point, lowered): &(RunPoint, LoweredRun)| {
            lowered.fillers[place].expected_rms(0) / point.schedule.duration_s
        };
        let least = all.iter().map(rms).fold(f64::INFINITY, f64::min);
        if all.iter().all(|lowered| rms(lowered) == 0.0) {
            return Err(DesignError::Nothing);
        }
        if self.swept {
            return Ok(all.iter().map(|lowered| candidate(lowered, place)).collect());
        }
        let near: Vec<_> = all.iter().filter(|lowered| rms(lowered) <= REACH * least).collect();
        Ok(thinned(&near).into_iter().map(|lowered| candidate(lowered, place)).collect())
    }
}

fn candidate((point, lowered): &(RunPoint, LoweredRun), place: usize) -> Candidate {
    let filled = lowered.fillers[place].clone();
    Candidate { schedule: point.schedule, switches: point.switches(), filled }
}

/// Largest relative deviation of the length of a run with an even number of intervals from that in the study, because a
/// lower drift of a longer run says nothing about the interval.
const MOST_OFF: f64 = 0.1;

/// Points whose runs have even numbers of their own intervals, without those for which no such run has about the
/// requested length.
pub(crate) fn even(points: &[RunPoint]) -> Vec<RunPoint> {
    let of = |point: &RunPoint| {
        let even = point.with_interval(point.schedule.interval_s)?;
        let off = (even.schedule.duration_s / point.schedule.duration_s - 1.0).abs();
        (off <= MOST_OFF).then_some(even)
    };
    points.iter().filter_map(of).collect()
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
