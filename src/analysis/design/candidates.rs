//! The candidates of a design, the constraints that they have to meet, their runs and the estimate by which they are compared.

use crate::analysis::design::optimum::halves;
use crate::analysis::design::result::{self, Found, Tried};
use crate::analysis::design::{self, DesignError, PapersRule, optimum};
use crate::analysis::firmware::fixed_point_filter::Memory;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_engine::filler::{Fill, Filler, latency_ticks};
use sagnac_engine::key::{Streams, names};
use sagnac_engine::kinds::gap_fill::inputs::Inputs;
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::kinds::switched_run::lower::{FilledRun, LoweredRun};
use sagnac_engine::kinds::switched_run::point::Point as RunPoint;
use sagnac_engine::sampling::Worker;
use sagnac_engine::tally::{Estimates, NORMAL_95};
use sagnac_kernel::moments::Moments;
use sagnac_theory::drift::budget::Optimum;

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

/// What a filler must meet to be tried.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Constraints {
    /// Longest time from the end of the gap to the correction, s.
    pub latency_s: Option<f64>,
    /// Largest memory of its tables and its state, bytes; see [`Memory`].
    pub memory_bytes: Option<u64>,
}

/// What a filler takes in firmware.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Time from the end of the gap to the correction, s: as many ticks as the filler reads after the gap.
    pub latency_s: f64,
    /// Memory of its tables and its state.
    pub memory: Memory,
}

impl Cost {
    /// The cost of a filler that reads these ticks.
    pub(crate) fn new(filler: &Filler, fill: &Fill, inputs: &Inputs) -> Cost {
        Cost {
            latency_s: f64::from(latency_ticks(&fill.fit_ticks, inputs.gap_ticks)) * inputs.tick_s,
            memory: Memory::of_filler(filler, fill, inputs.gap_ticks),
        }
    }
}

/// Excess of a latency that counts as rounding, as times are rounded to 12 digits.
const ROUNDING: f64 = 1e-11;

impl Constraints {
    /// Whether there are any.
    pub fn are_given(&self) -> bool {
        *self != Constraints::default()
    }

    /// The constraints as sentences have them, such as `a latency of at most 5 ms`.
    pub(crate) fn told(&self) -> String {
        let latency =
            self.latency_s.map(|latency_s| format!("a latency of at most {}", milliseconds(latency_s)));
        let memory = self.memory_bytes.map(|bytes| format!("at most {bytes} bytes of memory"));
        latency.into_iter().chain(memory).collect::<Vec<_>>().join(" and ")
    }

    /// The reasons why a filler is left out; empty where it meets the constraints.
    fn broken_by(&self, cost: Cost) -> Vec<String> {
        let late = self.latency_s.is_some_and(|most| cost.latency_s > most * (1.0 + ROUNDING));
        let large = self.memory_bytes.is_some_and(|most| cost.memory.bytes() > most);
        let late = late.then(|| format!("a latency of {}", milliseconds(cost.latency_s)));
        late.into_iter().chain(large.then(|| format!("{} bytes", cost.memory.bytes()))).collect()
    }

    /// Whether a filler of this cost meets them.
    pub(crate) fn meets(&self, cost: Cost) -> bool {
        self.broken_by(cost).is_empty()
    }

    /// How far a filler is from meeting the constraints, as the largest ratio to one of them.
    fn excess(&self, cost: Cost) -> f64 {
        let latency = self.latency_s.map_or(0.0, |most| ratio(cost.latency_s, most));
        let memory = self.memory_bytes.map_or(0.0, |most| ratio(cost.memory.bytes() as f64, most as f64));
        latency.max(memory)
    }
}

/// The ratio to a constraint, which may be 0.
fn ratio(value: f64, most: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / most }
}

/// A time in milliseconds.
pub(crate) fn milliseconds(time_s: f64) -> String {
    format!("{} ms", significant(1e3 * time_s, 6))
}

/// A filler that breaks a constraint.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LeftOut {
    /// Its name.
    pub filler: String,
    /// The reason, such as `a latency of 10 ms`.
    pub why: String,
    /// Number of variants without it.
    pub variants: usize,
}

/// Takes the fillers that break a constraint out of the runs of a variant, and notes them in `left_out`. The cost of each
/// remaining filler, in the order of the study; none where the study has no fillers.
///
/// # Errors
/// No filler remains: the error names the one that is nearest.
pub(crate) fn constrained(
    runs: &mut SwitchedRun,
    constraints: &Constraints,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<Cost>, DesignError> {
    let Some(fill) = &runs.points[0].fill else {
        return if constraints.are_given() { Err(DesignError::NoFillers) } else { Ok(vec![]) };
    };
    let cost = |(filler, own): (&Filler, &Fill)| Cost::new(filler, own, &fill.inputs);
    let costs: Vec<Cost> = runs.fillers().iter().zip(fill.fills.iter()).map(cost).collect();
    let broken: Vec<String> = costs.iter().map(|cost| constraints.broken_by(*cost).join(" and ")).collect();
    for (filler, why) in runs.fillers().iter().zip(&broken).filter(|(_, why)| !why.is_empty()) {
        match left_out.iter_mut().find(|known| known.filler == filler.name) {
            Some(known) => known.variants += 1,
            None => left_out.push(LeftOut { filler: filler.name.clone(), why: why.clone(), variants: 1 }),
        }
    }
    if broken.iter().all(|why| !why.is_empty()) {
        let excess = |place: usize| constraints.excess(costs[place]);
        let nearest = (0..costs.len()).min_by(|a, b| excess(*a).total_cmp(&excess(*b))).unwrap_or(0);
        return Err(DesignError::NoneLeft {
            asked: constraints.told(),
            nearest: runs.fillers()[nearest].name.clone(),
            why: broken[nearest].clone(),
            excess: excess(nearest),
        });
    }
    let is_kept = |place: usize| broken[place].is_empty();
    for point in runs.points.iter_mut().filter_map(|point| point.fill.as_mut()) {
        let mut fills = point.fills.to_vec();
        keep(&mut fills, is_kept);
        point.fills = fills.into();
    }
    if let Some(fill) = &mut runs.fill {
        keep(&mut fill.fillers, is_kept);
    }
    let mut costs = costs;
    keep(&mut costs, is_kept);
    Ok(costs)
}

/// Keeps some items by their places.
pub(crate) fn keep<T>(items: &mut Vec<T>, is_kept: impl Fn(usize) -> bool) {
    let mut places = 0..;
    items.retain(|_| places.next().is_some_and(&is_kept));
}

/// A note on the fillers that break a constraint, in one line.
pub(crate) fn note(constraints: &Constraints, left_out: &[LeftOut], variants: usize) -> Option<String> {
    let one = |out: &LeftOut| {
        let part = if out.variants == variants {
            String::new()
        } else {
            format!(", in {} of {variants} variants", out.variants)
        };
        format!("{} ({}{part})", out.filler, out.why)
    };
    let all: Vec<String> = left_out.iter().map(one).collect();
    (!all.is_empty())
        .then(|| format!("left out, because {} is required: {}", constraints.told(), all.join(", ")))
}

/// The runs of a variant with its candidates.
pub(crate) struct Chosen<'a> {
    pub(crate) maker: Maker<'a>,
    /// Latency and memory of each filler; none where the study has no fillers.
    pub(crate) costs: &'a [Cost],
    /// The candidates of each filler.
    pub(crate) candidates: Vec<Vec<Candidate>>,
}

/// Samples candidates, and counts the switches of their runs.
pub(crate) struct Runner<'a> {
    pub(crate) worker: Worker<'a>,
    pub(crate) progress: &'a dyn Progress,
    pub(crate) measure: Measure,
    /// Number of runs of each candidate.
    pub(crate) trials: u64,
    /// Switches of all runs that are known to be needed, and of those that are done.
    pub(crate) total: u64,
    pub(crate) done: u64,
}

/// Number of switches in all runs of a candidate.
pub(crate) fn work(candidate: &Candidate, trials: u64) -> u64 {
    let launches = 1 + u64::from(candidate.switched.is_some());
    candidate.switches * trials * launches
}

impl Runner<'_> {
    /// The results of each filler of a variant.
    pub(crate) fn fillers(&mut self, chosen: &Chosen) -> Result<Vec<result::Filler>, DesignError> {
        let Chosen { maker, costs, candidates } = chosen;
        let (runs, duration_s) = (maker.runs, maker.runs.points[0].schedule.duration_s);
        let mut fillers = Vec::new();
        for (place, candidates) in candidates.iter().enumerate() {
            let tried = candidates.iter().map(|candidate| self.tried(candidate, duration_s));
            let mut tried = tried.collect::<Result<Vec<Tried>, DesignError>>()?;
            let fitted = optimum::of(&tried);
            if let Some(candidate) = maker.at(fitted.value, place)?.filter(|_| !maker.swept) {
                insert(&mut tried, self.joining(&candidate, duration_s)?);
            }
            let filled = &candidates[0].filled;
            let mut papers_rule = None;
            if let Some(Optimum { interval_s, bound }) = design::optimum(&runs.points[0], filled)
                && let Some(candidate) = maker.at(interval_s, place)?
            {
                let at_rule = self.joining(&candidate, duration_s)?;
                if !maker.swept {
                    insert(&mut tried, at_rule.clone());
                }
                papers_rule = Some(PapersRule { interval_s, bound, tried: at_rule });
            }
            let (best, optimum) = optimum::among(&tried, fitted);
            let name = runs.fillers().get(place).map(|filler| filler.name.clone());
            let (residual_rms, residual_max) = (filled.residual_rms(), filled.residual_max());
            let cost = costs.get(place).copied();
            fillers.push(result::Filler {
                name,
                cost,
                residual_rms,
                residual_max,
                tried,
                best,
                optimum,
                papers_rule,
            });
        }
        Ok(fillers)
    }

    /// Samples a candidate that is found on the way, such as the optimum or the interval of the paper's rule.
    fn joining(&mut self, candidate: &Candidate, duration_s: f64) -> Result<Tried, DesignError> {
        self.total += work(candidate, self.trials);
        self.progress.start("switches", self.done, self.total);
        self.tried(candidate, duration_s)
    }

    fn tried(&mut self, candidate: &Candidate, duration_s: f64) -> Result<Tried, DesignError> {
        let (measure, trials) = (self.measure, self.trials);
        self.done += work(candidate, trials);
        let Candidate { interval_s, switches, filled, .. } = candidate;
        let mut level = |filled: &FilledRun| {
            let parts = design::parts(filled, *switches, trials, &mut self.worker, self.progress)?;
            of_parts(filled, &parts, measure, trials, duration_s)
        };
        let (drift, halves) = level(filled)?;
        let (switched, switched_halves) = match &candidate.switched {
            Some(filled) => level(filled)?,
            None => (drift, halves.clone()),
        };
        let theory = filled.estimates[usize::from(measure.is_largest())].theory;
        let closed_form = theory.map(|theory| theory.rms() / duration_s);
        let (interval_s, switches) = (*interval_s, *switches);
        Ok(Tried { interval_s, switches, drift, closed_form, halves, switched, switched_halves })
    }
}

/// Inserts a result in the order of the intervals, each interval once.
fn insert(all: &mut Vec<Tried>, tried: Tried) {
    let at = all.partition_point(|other| other.interval_s < tried.interval_s);
    if all.get(at).is_none_or(|other| other.interval_s != tried.interval_s) {
        all.insert(at, tried);
    }
}

/// The drift of all parts of the trials together, and in balanced halves of them, ″/s.
fn of_parts(
    filled: &FilledRun,
    parts: &[[Moments; 2]],
    measure: Measure,
    trials: u64,
    duration_s: f64,
) -> Result<(Found, Vec<[f64; 2]>), DesignError> {
    let which = usize::from(measure.is_largest());
    let estimate = &filled.estimates[which];
    let value = |tally: &Moments| -> Option<Found> {
        let found = Estimates::new(tally, estimate.bin_base, estimate.unit_arcsec / duration_s)?;
        match measure {
            Measure::DriftRms | Measure::LargestRms => {
                let around = |se: f64| (found.rms - NORMAL_95 * se, found.rms + NORMAL_95 * se);
                Some(Found { value: found.rms, interval: found.rms_se.map(around) })
            }
            Measure::DriftP9973 | Measure::LargestP9973 => {
                let q = found.p99_73?;
                Some(Found { value: q.value, interval: q.low.zip(q.high) })
            }
        }
    };
    let too_few = || DesignError::TooFew { trials, measure };
    let parts: Vec<&Moments> = parts.iter().map(|part| &part[which]).collect();
    let drift = value(&merged(parts.iter().copied())).ok_or_else(too_few)?;
    let half = |half: &[usize]| {
        let found = value(&merged(half.iter().map(|&part| parts[part])));
        found.map(|found| found.value).ok_or_else(too_few)
    };
    let pair = |[one, other]: [Vec<usize>; 2]| Ok::<_, DesignError>([half(&one)?, half(&other)?]);
    Ok((drift, halves().map(pair).collect::<Result<_, _>>()?))
}

fn merged<'a>(parts: impl Iterator<Item = &'a Moments>) -> Moments {
    let mut total = Moments::empty(true);
    parts.for_each(|part| total.merge(part));
    total
}

names! {
    /// The quantity to minimize, as listed by `--by`.
    pub enum Measure {
        /// The drift that 99.73 % of runs do not exceed.
        DriftP9973 = "drift_p99_73",
        /// The rms drift.
        DriftRms = "drift_rms",
        /// The largest angle of a run, divided by the run time, that 99.73 % of runs do not exceed.
        LargestP9973 = "largest_p99_73",
        /// The rms of the largest angle of a run, divided by the run time.
        LargestRms = "largest_rms",
    }
}

impl Measure {
    /// Meaning, as a sentence.
    pub fn meaning(self) -> &'static str {
        Measure::WORDS[self as usize].meaning.trim()
    }

    /// Label for axes and sentences.
    pub fn label(self) -> &'static str {
        match self {
            Measure::DriftP9973 => "99.73 % drift",
            Measure::DriftRms => "rms drift",
            Measure::LargestP9973 => "99.73 % largest angle over the run time",
            Measure::LargestRms => "rms largest angle over the run time",
        }
    }

    /// Whether it refers to the largest angle of a run instead of that at its end.
    pub(crate) fn is_largest(self) -> bool {
        matches!(self, Measure::LargestP9973 | Measure::LargestRms)
    }
}
