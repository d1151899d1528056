//! The intervals that are tried with each filler.

use super::DesignError;
use crate::lower::{FilledRun, LoweredRun};
use crate::study::{RunPoint, Streams, Study, SwitchedRun};

/// Intervals that are tried where the study names none.
const CANDIDATES: usize = 25;

/// They reach as far as the rms drift is at most this many times its least, in closed form.
const REACH: f64 = 2.5;

/// Even numbers of intervals that are looked at to find those.
const LOOKED_AT: usize = 200;

/// Runs with one interval and one filler, ready to be sampled.
pub(super) struct Candidate {
    pub(super) interval_s: f64,
    pub(super) switches: u64,
    pub(super) filled: FilledRun,
}

/// What is tried with one filler; not empty, in the order of the intervals.
pub(super) struct OfFiller {
    pub(super) candidates: Vec<Candidate>,
}

/// The candidates of each filler.
pub(super) fn choose(study: &Study, runs: &SwitchedRun) -> Result<Vec<OfFiller>, DesignError> {
    let fillers = runs.fillers().len().max(1);
    let lowered = |point: RunPoint| -> Result<(RunPoint, LoweredRun), DesignError> {
        // On the same random numbers, whatever the interval.
        let lowered = LoweredRun::new(&point, runs, study.seed, Streams::Common)?;
        Ok((point, lowered))
    };
    let swept = !study.sweeps.is_empty();
    let points: Vec<RunPoint> = if swept { runs.points.clone() } else { even(&runs.points[0]) };
    let mut points: Vec<RunPoint> = points.into_iter().map(without_non_magnetic).collect();
    points.sort_by(|a, b| a.schedule.interval_s.total_cmp(&b.schedule.interval_s));
    let all = points.into_iter().map(lowered).collect::<Result<Vec<_>, _>>()?;
    let duration_s = runs.points[0].schedule.duration_s;
    if all.is_empty() {
        return Err(DesignError::NoCandidate { duration_s });
    }
    let of_filler = |place: usize| {
        let rms: Vec<f64> = all
            .iter()
            .map(|(_, lowered)| lowered.fillers[place].estimates[0].oracle.map_or(0.0, |oracle| oracle.rms()))
            .collect();
        let least = rms.iter().copied().fold(f64::INFINITY, f64::min);
        if rms.iter().all(|rms| *rms == 0.0) {
            return Err(DesignError::Nothing);
        }
        let near: Vec<usize> = (0..all.len()).filter(|&k| swept || rms[k] <= REACH * least).collect();
        let taken = if swept { near } else { thinned(&near, &all) };
        let candidates = taken.into_iter().map(|k| {
            let (point, lowered) = &all[k];
            Candidate {
                interval_s: point.schedule.interval_s,
                switches: point.switches(),
                filled: lowered.fillers[place].clone(),
            }
        });
        Ok(OfFiller { candidates: candidates.collect() })
    };
    (0..fillers).map(of_filler).collect()
}

/// The runs of one filler with an even number of intervals near `interval_s`; none where those are too short.
pub(super) fn near(
    interval_s: f64,
    study: &Study,
    runs: &SwitchedRun,
    place: usize,
) -> Result<Option<Candidate>, DesignError> {
    let point = without_non_magnetic(runs.points[0].clone());
    let duration_s = point.schedule.duration_s;
    let pairs = libm::round(duration_s / (2.0 * interval_s)).max(1.0);
    let Some(point) = point.with_interval(duration_s / (2.0 * pairs)) else { return Ok(None) };
    let mut lowered = LoweredRun::new(&point, runs, study.seed, Streams::Common)?;
    let (interval_s, switches) = (point.schedule.interval_s, point.switches());
    Ok(Some(Candidate { interval_s, switches, filled: lowered.fillers.swap_remove(place) }))
}

/// Points with intervals of which an even number makes the run, evenly spread in their logarithm.
fn even(point: &RunPoint) -> Vec<RunPoint> {
    let duration_s = point.schedule.duration_s;
    let most = (duration_s / point.shortest_s() / 2.0).max(0.0);
    let pairs = |k: usize| libm::round(libm::exp(libm::log(most) * k as f64 / (LOOKED_AT - 1) as f64)) as u64;
    let mut pairs: Vec<u64> = (0..LOOKED_AT).map(pairs).filter(|pairs| *pairs as f64 <= most).collect();
    pairs.dedup();
    let with = |pairs: u64| point.with_interval(duration_s / (2 * pairs) as f64);
    pairs.into_iter().filter(|pairs| *pairs > 0).filter_map(with).collect()
}

/// So many of some places, evenly spread in the logarithm of their intervals, the ends among them.
fn thinned(near: &[usize], all: &[(RunPoint, LoweredRun)]) -> Vec<usize> {
    let log = |k: usize| libm::log(all[k].0.schedule.interval_s);
    let (Some(&first), Some(&last)) = (near.first(), near.last()) else { return vec![] };
    let step = (log(last) - log(first)) / (CANDIDATES - 1) as f64;
    let nearest =
        |at: f64| near.iter().copied().min_by(|&a, &b| (log(a) - at).abs().total_cmp(&(log(b) - at).abs()));
    let mut taken: Vec<usize> =
        (0..CANDIDATES).filter_map(|i| nearest(log(first) + step * i as f64)).collect();
    taken.dedup();
    taken
}

fn without_non_magnetic(mut point: RunPoint) -> RunPoint {
    point.drift.non_magnetic = 0.0;
    point
}
