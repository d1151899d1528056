//! Design: the best switching interval and filler, from whole runs over candidate intervals with the same random
//! numbers.
//!
//! ```text
//! study ─ candidates ─▶ runs of each filler and interval ─ jackknife ─▶ best interval with its uncertainty ─▶ recommendation
//! ```
//!
//! Every candidate runs for the run time of the study and ends as the study says, so that a study with the chosen
//! interval gives the same drift. The choice leaves out the non-magnetic drift: no interval changes it, and an interval
//! whose magnetic drift happens to cancel it would look better than it is. Where a study asks for exact ends, the tried
//! intervals are those of which an even number makes the run: the end would otherwise matter more than the interval.
//!
//! ```
//! use sagnac::analysis::design::{Measure, design};
//! use sagnac::verify::select;
//! use sagnac::study::Study;
//! use sagnac::progress::Silent;
//!
//! let study = Study::parse("hour.toml", r#"
//!     title = "The paper's hour"
//!     kind = "switched-run"
//!     trials = 8192
//!     streams = "common"
//!     [drift]
//!     magnetic = "14 arcsec/s"
//!     warm_up_time = "3000 s"
//!     residual_max = "10 arcsec"
//!     [switching]
//!     interval = "40 s"
//!     [run]
//!     duration = "1 h"
//! "#)?;
//! let mut device = select("cpu", 2)?.device;
//! let found = design(&study, Measure::DriftRms, &mut device, &Silent)?;
//! let best = found.best().best();
//! // In closed form 22.4 s, and 0.0304 °/h rms.
//! assert!((20.0..25.0).contains(&best.interval_s), "{} s", best.interval_s);
//! assert!((best.drift.value - 0.0304).abs() < 0.001, "{} °/h", best.drift.value);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod candidates;
pub(crate) mod measure;
pub(crate) mod optimum;
pub(crate) mod paper;
pub mod report;
pub(crate) mod sampling;

pub use crate::analysis::design::measure::Measure;
pub use crate::analysis::design::paper::PapersRule;

use crate::analysis::decision::{DecisionError, Sheet, decide_at};
use crate::analysis::design::candidates::{Candidate, Maker};
use crate::analysis::design::optimum::least_of;
use crate::analysis::jackknife::{T_95, jackknife};
use crate::device::Device;
use crate::device::error::GpuError;
use crate::drift::schedule::{End, INTERVAL};
use crate::kernel::moments::Moments;
use crate::key::refusal::Refusal;
use crate::key::setting::Swept;
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::Timing;
use crate::kinds::switched_run::lower::FilledRun;
use crate::kinds::switched_run::run::late;
use crate::progress::Progress;
use crate::quantity::units::{Dimension, Quantity};
use crate::sampling::worker::Worker;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::tally::stats::{Estimates, NORMAL_95};
use crate::theory::drift::budget::Optimum;

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Value, in the unit of the measure.
    pub value: f64,
    /// 95 % interval; absent for too few runs.
    pub interval: Option<(f64, f64)>,
}

/// The result of the runs at one interval with one filler.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// Switching interval MT, s.
    pub interval_s: f64,
    /// Number of switches in a run.
    pub switches: u64,
    /// Drift, ″/s.
    pub drift: Found,
    /// Rms drift in closed form, ″/s; absent for the largest angle.
    pub closed_form: Option<f64>,
    /// Drift without each part of the trials in turn.
    replicates: Vec<f64>,
    /// Drift without its non-magnetic part, ″/s, by which the interval is chosen.
    pub switched: Found,
    /// Drift without its non-magnetic part, once for each part of the trials that is left out.
    switched_replicates: Vec<f64>,
}

/// The results of one filler, in the order of the intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Filler {
    /// Name; absent where the study gives the residual by its largest value.
    pub name: Option<String>,
    /// Rms residual of one switch, ″.
    pub residual_rms: f64,
    /// Approximate largest residual δP_max, ″: sines at their peaks plus three standard deviations of the rest.
    pub residual_max: f64,
    /// Results, by ascending interval.
    pub tried: Vec<Tried>,
    /// Index of the best interval.
    pub best: usize,
    /// Best interval, s, with the uncertainty from a law fitted near the minimum, which is absent where the minimum is
    /// at an end of the tried range.
    pub optimum: Found,
    /// The interval of the paper's rule, with its result.
    pub papers_rule: Option<PapersRule>,
}

impl Filler {
    /// The result at the best interval.
    pub fn best(&self) -> &Tried {
        &self.tried[self.best]
    }

    /// Whether an interval shorter or longer than all that were tried may be better.
    pub fn is_at_edge(&self) -> bool {
        self.tried.len() > 1 && (self.best == 0 || self.best + 1 == self.tried.len())
    }
}

/// The result of a design.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Minimised quantity.
    pub measure: Measure,
    /// Number of runs for each filler and interval.
    pub trials: u64,
    /// Run time t, s.
    pub duration_s: f64,
    /// Non-magnetic drift, ″/s, which is part of the drift but not of the choice.
    pub non_magnetic: f64,
    /// Notes on the results, each a sentence.
    pub notes: Vec<String>,
    /// Results by filler, in the order of the study.
    pub fillers: Vec<Filler>,
    /// Index of the filler with the least drift.
    pub best: usize,
}

impl Design {
    /// The decision sheet of the study at the best interval; see [`decide`](crate::analysis::decision::decide).
    ///
    /// # Errors
    /// The point cannot be represented, or no threads can be started.
    pub fn sheet(&self, study: &Study) -> Result<Option<Sheet>, DecisionError> {
        let interval = Quantity::new(self.best().best().interval_s, Dimension::Time);
        decide_at(study, &[(&INTERVAL, Swept::Quantity(interval))])
    }

    /// The filler with the least drift.
    pub fn best(&self) -> &Filler {
        &self.fillers[self.best]
    }

    /// The angle that a drift adds up to in the run time, ″.
    pub fn angle(&self, drift: f64) -> f64 {
        drift * self.duration_s
    }

    /// The ratio of the drift of another filler at its own best interval to the least one, with its 95 % interval, from
    /// the same random numbers.
    pub fn worse_by(&self, filler: &Filler) -> Found {
        self.times_best(filler.best())
    }

    /// The same ratio for any runs.
    pub fn times_best(&self, other: &Tried) -> Found {
        let best = self.best().best();
        let ratio = |k: usize| other.replicates[k] / best.replicates[k];
        let value = other.drift.value / best.drift.value;
        let half = T_95 * jackknife(&(0..best.replicates.len()).map(ratio).collect::<Vec<f64>>());
        Found { value, interval: Some((value - half, value + half)) }
    }
}

/// Why a design is not possible.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The study is of this other kind.
    #[error("a study of kind = \"{0}\" has no switching interval to choose")]
    Kind(&'static str),
    /// This swept key makes the study describe more than one gyro.
    #[error("{0} is swept: a design is for one gyro, and chooses the interval and the filler itself")]
    Swept(&'static str),
    /// Nothing depends on the interval.
    #[error("there is no drift and no residual: every interval is as good as any other")]
    Nothing,
    /// The run of this time t, in s, is too short for two intervals.
    #[error("a run of {0} s has no room for two of the shortest intervals, which have to hold the fit ticks")]
    NoCandidate(f64),
    /// A run at one of the intervals does not fit into fixed point.
    #[error(transparent)]
    Lower(#[from] Refusal),
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The runs do not say where 99.73 % of them lie.
    #[error("{trials} runs are too few for the {}", measure.label())]
    TooFew {
        /// Number of runs.
        trials: u64,
        /// Requested measure.
        measure: Measure,
    },
}

impl DesignError {
    /// The error at the place in the study that caused it.
    ///
    /// # Errors
    /// The device failed.
    pub fn in_study(self, study: &Study) -> Result<StudyError, GpuError> {
        let (key, help) = match &self {
            DesignError::Kind(_) => ("kind", "give a study of kind = \"switched-run\""),
            DesignError::Swept(key) => (*key, "give one value, or one study for each"),
            DesignError::Nothing => ("drift", "give drift.magnetic, and fillers or drift.residual_max"),
            DesignError::NoCandidate(_) => ("run.duration", "lengthen the run, or sweep switching.interval"),
            DesignError::TooFew { .. } => ("trials", "increase them; 100_000 is usual"),
            DesignError::Lower(lower) => (lower.key, lower.help),
            DesignError::Gpu(error) => return Err(error.clone()),
        };
        Ok(study.error_at(study.place_of(key), self.to_string(), help))
    }
}

/// Runs all candidates; `progress` counts the switches of their runs.
///
/// # Errors
/// The study is of another kind or sweeps more than the interval, has nothing to choose, or the device fails.
pub fn design(
    study: &Study,
    measure: Measure,
    device: &mut Device,
    progress: &dyn Progress,
) -> Result<Design, DesignError> {
    let Some(runs) = study.asked::<SwitchedRun>() else {
        return Err(DesignError::Kind(study.kind().name));
    };
    if let Some(sweep) = study.sweeps.iter().find(|sweep| sweep.key.name != INTERVAL.name) {
        return Err(DesignError::Swept(sweep.key.name));
    }
    // Further times and trajectories would cost runs and are not needed.
    let runs = SwitchedRun { times: vec![], trajectories: 0, ..runs.clone() };
    let maker = Maker { runs: &runs, seed: study.seed, swept: !study.sweeps.is_empty() };
    let chosen = maker.choose()?;
    let trials = sampling::trials(study.trials);
    let point = &runs.points[0];
    let duration_s = point.schedule.duration_s;
    // The optimum of each filler and the interval of the paper's rule are added when they are found.
    let work = |candidate: &Candidate| {
        let launches = 1 + u64::from(candidate.switched.is_some());
        candidate.switches * trials * launches
    };
    let mut total = chosen.iter().flatten().map(work).sum::<u64>();
    progress.start("switches", 0, total);
    let mut worker = Worker::new(device, progress);
    let mut done = 0;
    let mut sampled = |candidate: &Candidate, joins: bool| {
        if joins {
            total += work(candidate);
            progress.start("switches", done, total);
        }
        done += work(candidate);
        let Candidate { interval_s, switches, filled, .. } = candidate;
        let mut level = |filled: &FilledRun| {
            let parts = sampling::parts(filled, *switches, trials, &mut worker, progress)?;
            of_parts(filled, &parts, measure, trials, duration_s)
        };
        let (drift, replicates) = level(filled)?;
        let (switched, switched_replicates) = match &candidate.switched {
            Some(filled) => level(filled)?,
            None => (drift, replicates.clone()),
        };
        let oracle = filled.estimates[usize::from(measure.is_largest())].oracle;
        let closed_form = oracle.map(|oracle| oracle.rms() / duration_s);
        let (interval_s, switches) = (*interval_s, *switches);
        Ok(Tried { interval_s, switches, drift, closed_form, replicates, switched, switched_replicates })
    };
    let mut fillers = Vec::new();
    for (place, candidates) in chosen.iter().enumerate() {
        let tried = candidates.iter().map(|candidate| sampled(candidate, false));
        let mut tried = tried.collect::<Result<Vec<Tried>, DesignError>>()?;
        let fitted = optimum::of(&tried);
        if let Some(candidate) = maker.at(fitted.value, place)?.filter(|_| !maker.swept) {
            insert(&mut tried, sampled(&candidate, true)?);
        }
        let filled = &candidates[0].filled;
        let mut papers_rule = None;
        if let Some(Optimum { interval_s, bound }) = paper::optimum(point, filled)
            && let Some(candidate) = maker.at(interval_s, place)?
        {
            let at_rule = sampled(&candidate, true)?;
            if !maker.swept {
                insert(&mut tried, at_rule.clone());
            }
            papers_rule = Some(PapersRule { interval_s, bound, tried: at_rule });
        }
        let (best, optimum) = optimum::among(&tried, fitted);
        let name = runs.fillers().get(place).map(|filler| filler.name.clone());
        let (residual_rms, residual_max) = (filled.residual_rms(), filled.residual_max());
        fillers.push(Filler { name, residual_rms, residual_max, tried, best, optimum, papers_rule });
    }
    let drifts: Vec<f64> = fillers.iter().map(|filler| filler.best().switched.value).collect();
    let best = least_of(&drifts);
    Ok(Design {
        measure,
        trials,
        duration_s,
        non_magnetic: point.drift.non_magnetic,
        notes: worker.into_notes().into_iter().chain(notes(study, &runs)).collect(),
        fillers,
        best,
    })
}

/// Note on residuals whose phases follow each other.
const PHASES: &str = "with timing = \"periodic\" residuals add up or cancel by the phase of the vibration from switch to switch: the \
                      best interval holds for exactly this frequency and may be a coincidence, which timing = \"random\" \
                      avoids";

/// Note on ends that are exact.
const ENDS: &str = "with run.end = \"exact\" the drift holds for runs that end exactly then; an interval of which no even number \
                    makes the run has another";

/// Notes on the runs, and on a recommendation that depends on an exact frequency or an exact end.
fn notes(study: &Study, runs: &SwitchedRun) -> Vec<String> {
    let steady = runs.timing == Timing::Periodic
        && runs.points[0].fill.as_ref().is_some_and(|fill| !fill.inputs.motion.tones.is_empty());
    let exact = runs.points[0].schedule.end == End::Exact;
    let mut notes = study.notes.clone();
    notes.extend(late(runs));
    notes.extend(steady.then(|| PHASES.to_owned()));
    notes.extend(exact.then(|| ENDS.to_owned()));
    notes
}

/// Inserts a result in the order of the intervals, each interval once.
fn insert(all: &mut Vec<Tried>, tried: Tried) {
    let at = all.partition_point(|other| other.interval_s < tried.interval_s);
    if all.get(at).is_none_or(|other| other.interval_s != tried.interval_s) {
        all.insert(at, tried);
    }
}

/// The drift of all parts of the trials together, and without each of them, ″/s.
fn of_parts(
    filled: &FilledRun,
    parts: &[[Moments; 2]],
    measure: Measure,
    trials: u64,
    duration_s: f64,
) -> Result<(Found, Vec<f64>), DesignError> {
    let which = usize::from(measure.is_largest());
    let estimate = &filled.estimates[which];
    let value = |tally: &Moments| -> Option<Found> {
        let found = Estimates::of(tally, estimate.bin_base, estimate.unit_arcsec / duration_s)?;
        match measure {
            Measure::DriftRms | Measure::LargestRms => {
                let around = |se: f64| (found.rms - NORMAL_95 * se, found.rms + NORMAL_95 * se);
                Some(Found { value: found.rms, interval: found.rms_se.map(around) })
            }
            Measure::DriftQ9973 | Measure::LargestQ9973 => {
                let q = found.q9973?;
                Some(Found { value: q.value, interval: q.low.zip(q.high) })
            }
        }
    };
    let too_few = || DesignError::TooFew { trials, measure };
    let parts: Vec<&Moments> = parts.iter().map(|part| &part[which]).collect();
    let drift = value(&merged(parts.iter().copied())).ok_or_else(too_few)?;
    let replicate = |left_out: usize| {
        let rest = parts.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, part)| *part);
        value(&merged(rest)).map(|found| found.value).ok_or_else(too_few)
    };
    Ok((drift, (0..parts.len()).map(replicate).collect::<Result<_, _>>()?))
}

fn merged<'a>(parts: impl Iterator<Item = &'a Moments>) -> Moments {
    let mut total = Moments::empty(true);
    parts.for_each(|part| total.merge(part));
    total
}
