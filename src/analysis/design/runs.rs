//! Runs of candidates, and the estimate by which they are compared.

use crate::analysis::design::candidates::{Candidate, Cost, Maker};
use crate::analysis::design::result::{Filler, Found, Tried};
use crate::analysis::design::{self, DesignError, PapersRule, optimum};
use crate::analysis::jackknife::halves;
use sagnac_base::progress::Progress;
use sagnac_engine::key::names;
use sagnac_engine::kinds::switched_run::lower::FilledRun;
use sagnac_engine::sampling::Worker;
use sagnac_engine::tally::{Estimates, NORMAL_95};
use sagnac_kernel::moments::Moments;
use sagnac_theory::drift::budget::Optimum;

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
    pub(crate) fn fillers(&mut self, chosen: &Chosen) -> Result<Vec<Filler>, DesignError> {
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
            fillers.push(Filler {
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
