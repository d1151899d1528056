//! Design: the best switching interval and filler, from whole runs over candidate intervals with the same random
//! numbers.
//!
//! ```text
//! study ─ variants ─▶ candidates ─▶ runs of each filler and interval ─ jackknife ─▶ best interval with its uncertainty
//!       ─ least ─▶ best variant and filler ─ report ─▶ recommendation, front of drift, latency and memory
//! ```
//!
//! Every candidate runs for the run time of the study and ends as the study says, so that a study with the chosen
//! interval gives the same drift. The choice leaves out the non-magnetic drift: no interval changes it, and an interval
//! whose magnetic drift happens to cancel it would look better than it is. Where a study asks for exact ends, the tried
//! intervals are those of which an even number makes the run: the end would otherwise matter more than the interval.
//!
//! Other swept keys are choices too: each combination of their values is a variant with a best interval and filler of its
//! own, and the variant with the least drift wins. All variants have the same random numbers.
//!
//! ```
//! use sagnac::analysis::design::{Constraints, Design, DesignRequest, Measure};
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
//! let request = DesignRequest { measure: Measure::DriftRms, constraints: Constraints::default(), search: None };
//! let found = Design::compute(&study, &request, &mut device, &Silent)?;
//! let best = found.best().best();
//! // In closed form 22.4 s, and 0.0304 °/h rms.
//! assert!((20.0..25.0).contains(&best.interval_s), "{} s", best.interval_s);
//! assert!((best.drift.value - 0.0304).abs() < 0.001, "{} °/h", best.drift.value);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod candidates;
pub mod filler_search;
pub(crate) mod optimum;
pub mod report;
pub mod result;

use crate::analysis::decision::DecisionError;
use crate::analysis::design::candidates::{Chosen, LeftOut, Maker, Runner, constrained, work};
use crate::analysis::design::filler_search::with_searched;
use crate::analysis::design::optimum::{PARTS, least_of};
use crate::analysis::design::result::deciding;
use crate::analysis::page;
use crate::use_cases::Outcome;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::short;
use sagnac_engine::device::{Device, GpuError, Job};
use sagnac_engine::drift::{End, INTERVAL};
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::switched_run::lower::FilledRun;
use sagnac_engine::kinds::switched_run::point::Point as RunPoint;
use sagnac_engine::kinds::switched_run::run::late;
use sagnac_engine::kinds::switched_run::{SwitchedRun, Timing};
use sagnac_engine::sampling::Worker;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Block;
use sagnac_kernel::moments::Moments;
use sagnac_report::chart::{ChartError, Picture};
use sagnac_report::page::Provenance;
use sagnac_theory::drift::budget::{Budget, Optimum};

pub use crate::analysis::design::candidates::{Constraints, Cost, Measure};
pub use crate::analysis::design::filler_search::Search;
pub use crate::analysis::design::result::{Design, Filler, Found, Tried, Variant};

/// Number of switches from which the effort is said before the runs: a minute or more on most processors.
const MANY: u64 = 20_000_000_000;

/// The request for a design, beside its study, which has the trials and the seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignRequest {
    /// Quantity to minimize.
    pub measure: Measure,
    /// What fillers must meet.
    pub constraints: Constraints,
    /// Search for further fillers; none without it.
    pub search: Option<Search>,
}

/// The best switching interval and filler of a study: a page with the drift at all candidates, the fillers at their best intervals
/// and what latency and memory cost. `progress` counts the switches of the runs.
///
/// # Errors
/// It fails where [`Design::compute`] does, and where the decision at the best interval cannot be made.
pub fn design(
    study: &Study,
    request: &DesignRequest,
    device: &mut Device,
    progress: &dyn Progress,
) -> Result<Outcome, DesignError> {
    let found = Design::compute(study, request, device, progress)?;
    let (sheet, figure) = (found.sheet()?, report::figure(&found)?);
    let page = page::of_design(&found, sheet.as_ref(), Picture::Curves(figure));
    let candidates: usize = found.fillers().map(|(_, filler)| filler.tried.len()).sum();
    let (runs, after) = (short(found.trials as f64), report::duration(found.variant().duration_s));
    let heading = format!("{} · {candidates} candidates × {runs} runs of {after}", study.title);
    let name = match request.measure {
        Measure::DriftP9973 => "design".to_owned(),
        other => format!("design_{}", other.name()),
    };
    let provenance = Some(Provenance::new(study.seed, found.trials));
    let outcome = Outcome::new(heading, page).among(["pareto.csv", "design", "pareto"]);
    Ok(Outcome { name, provenance, ..outcome })
}

impl Design {
    /// Runs all candidates of all variants; `progress` counts the switches of their runs.
    ///
    /// # Errors
    /// The study is of another kind, has nothing to choose or no filler that meets the constraints, does not accept the band of
    /// the search, or the device fails.
    pub fn compute(
        study: &Study,
        request: &DesignRequest,
        device: &mut Device,
        progress: &dyn Progress,
    ) -> Result<Design, DesignError> {
        let DesignRequest { measure, constraints, search } = request;
        let extended = search.as_ref().map(|search| with_searched(study, constraints, search)).transpose()?;
        let study = extended.as_ref().unwrap_or(study);
        let Some(runs) = study.asked::<SwitchedRun>() else {
            return Err(DesignError::Kind(study.kind().name));
        };
        let mut left_out = Vec::new();
        let all = within(constraints, variants(runs), &mut left_out)?;
        let swept = study.sweeps.iter().any(|sweep| sweep.key.name == INTERVAL.name);
        let mut chosen = Vec::new();
        for (values, runs, costs) in &all {
            let maker = Maker { runs, seed: study.seed, swept };
            let candidates = maker.choose().map_err(|error| error.of_variant(values))?;
            chosen.push(Chosen { candidates, costs, maker });
        }
        let trials = trials_of(study.trials);
        let candidates = || chosen.iter().flat_map(|chosen| chosen.candidates.iter().flatten());
        // The optimum of each filler and the interval of the paper's rule are added when they are found.
        let total = candidates().map(|candidate| work(candidate, trials)).sum::<u64>();
        let mut effort = None;
        if chosen.len() > 1 && total >= MANY {
            let [candidates, trials, total] =
                [candidates().count() as u64, trials, total].map(|count| short(count as f64));
            let sentence = format!(
                "{} variants have {candidates} candidates of {trials} runs each, {total} switches together",
                chosen.len()
            );
            progress.note(&sentence);
            effort = Some(sentence);
        }
        progress.start("switches", 0, total);
        let worker = Worker::new(device, progress);
        let mut runner = Runner { worker, progress, measure: *measure, trials, total, done: 0 };
        let mut found: Vec<Variant> = Vec::new();
        for ((swept, runs, _), chosen) in all.iter().zip(&chosen) {
            let fillers = runner.fillers(chosen).map_err(|error| error.of_variant(swept))?;
            let drifts: Vec<f64> = fillers.iter().map(|filler| filler.best().switched.value).collect();
            let (best, swept, point) = (least_of(&drifts), swept.clone(), &runs.points[0]);
            let (duration_s, non_magnetic) = (point.schedule.duration_s, point.drift.non_magnetic);
            found.push(Variant { swept, duration_s, non_magnetic, fillers, best });
        }
        let drifts: Vec<f64> = found.iter().map(|variant| deciding(&found, variant.best().best())).collect();
        let best = least_of(&drifts);
        let of_fillers = candidates::note(constraints, &left_out, variants(runs).len());
        let notes =
            runner.worker.into_notes().into_iter().chain(notes(study, runs)).chain(of_fillers).chain(effort);
        Ok(Design {
            study: study.clone(),
            measure: *measure,
            constraints: *constraints,
            is_searched: search.is_some(),
            trials,
            notes: notes.collect(),
            variants: found,
            best,
        })
    }
}

/// The variants with the fillers that meet the constraints, and the costs of these. A variant without such a filler is
/// left out.
fn within(
    constraints: &Constraints,
    variants: Vec<(Values, SwitchedRun)>,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<(Values, SwitchedRun, Vec<Cost>)>, DesignError> {
    let (mut kept, mut misses) = (Vec::new(), Vec::new());
    for (swept, mut runs) in variants {
        match constrained(&mut runs, constraints, left_out).map_err(|error| error.of_variant(&swept)) {
            Ok(costs) => kept.push((swept, runs, costs)),
            Err(error) => misses.push(error),
        }
    }
    let excess = |error: &DesignError| error.excess().unwrap_or(0.0);
    match misses.into_iter().min_by(|a, b| excess(a).total_cmp(&excess(b))) {
        Some(nearest) if kept.is_empty() => Err(nearest),
        _ => Ok(kept),
    }
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

/// The number of trials, at least `asked`, for which all parts have the same power of two.
fn trials_of(asked: u64) -> u64 {
    asked.div_ceil(PARTS).max(32).next_power_of_two() * PARTS
}

/// The tallies of the angle at the end and of the largest angle, for each part.
pub(crate) fn parts(
    filled: &FilledRun,
    switches: u64,
    trials: u64,
    worker: &mut Worker,
    progress: &dyn Progress,
) -> Result<Vec<[Moments; 2]>, GpuError> {
    let of_part = trials / PARTS;
    let log2 = of_part.ilog2();
    let launches = filled.launches();
    let Some((launch, _)) = launches.first() else { return Ok(vec![]) };
    let block = |part: u64| Block { first: part * of_part, log2 };
    let jobs: Vec<Job> = (0..PARTS).map(|part| Job { launch, block: block(part) }).collect();
    let results = worker.tally(&jobs, &|trials| progress.advance(trials * switches))?;
    let of_part = |tallies: Vec<Moments>| {
        let mut tallies = tallies.into_iter();
        [0, 1].map(|_| tallies.next().unwrap_or_else(|| Moments::empty(true)))
    };
    Ok(results.into_iter().map(of_part).collect())
}

/// The values of the swept keys other than the interval, in the order of the sweeps.
pub(crate) type Values = Vec<(&'static str, SweepValue)>;

/// The runs of each variant, in the order of the sweeps; a single one where only the interval is swept. The points of a
/// variant differ in the interval alone.
fn variants(runs: &SwitchedRun) -> Vec<(Values, SwitchedRun)> {
    let mut variants: Vec<(Values, SwitchedRun)> = Vec::new();
    for point in &runs.points {
        let values: Values = point.swept.iter().filter(|(key, _)| *key != INTERVAL.name).cloned().collect();
        match variants.iter_mut().find(|(known, _)| *known == values) {
            Some((_, own)) => own.points.push(point.clone()),
            None => {
                // Further times and trajectories would cost runs and are not needed.
                let own = SwitchedRun {
                    points: vec![point.clone()],
                    times: vec![],
                    trajectories: 0,
                    ..runs.clone()
                };
                variants.push((values, own));
            }
        }
    }
    variants
}

/// The paper's choice.
#[derive(Debug, Clone, PartialEq)]
pub struct PapersRule {
    /// The interval at which the bound has its minimum, s.
    pub interval_s: f64,
    /// Z(7) at that interval, ″/s.
    pub bound: f64,
    /// The result at that interval.
    pub tried: Tried,
}

/// The minimum of the bound for a filler; `None` where switching costs nothing.
pub(crate) fn optimum(point: &RunPoint, filled: &FilledRun) -> Option<Optimum> {
    let residual_max = filled.residual_max();
    let drift = &point.drift;
    let budget = Budget { magnetic: drift.magnetic_drift(), non_magnetic: drift.non_magnetic, residual_max };
    budget.optimum(point.schedule.duration_s)
}

/// Why a design is not possible.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The study is of this other kind.
    #[error("a study of kind = \"{0}\" has no switching interval to choose")]
    Kind(&'static str),
    /// Nothing depends on the interval.
    #[error("there is no drift and no residual: every interval is as good as any other")]
    Nothing,
    /// The run of this time t, in s, is too short for two intervals.
    #[error("a run of {0} s has no room for two of the shortest intervals, which have to hold the fit ticks")]
    NoCandidate(f64),
    /// Constraints on fillers, where the study has none.
    #[error("latency and memory are those of fillers, and the study has none")]
    NoFillers,
    /// A band for searched fillers that reaches above half the tick rate.
    #[error("the band reaches {high_hz} Hz, above the Nyquist frequency of ticks of {tick_s} s")]
    Band {
        /// The upper end of the band, Hz.
        high_hz: f64,
        /// The tick, s.
        tick_s: f64,
    },
    /// The fillers of the search do not fit the study.
    #[error("{0}")]
    Study(#[from] StudyError),
    /// No filler meets the constraints.
    #[error("no filler has {asked}: the nearest, {nearest}, has {why}")]
    NoneLeft {
        /// The constraints.
        asked: String,
        /// The filler that is nearest to meeting them.
        nearest: String,
        /// How it breaks them.
        why: String,
        /// How far it is from that, as a ratio.
        excess: f64,
    },
    /// A run at one of the intervals does not fit into fixed point.
    #[error(transparent)]
    Lower(#[from] Unrepresentable),
    /// An error of one of several variants.
    #[error("{error}, at {at}")]
    At {
        /// The swept keys with their values.
        at: String,
        /// The error at these values.
        error: Box<DesignError>,
    },
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The decision at the best interval fails.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// The drift cannot be drawn.
    #[error(transparent)]
    Chart(#[from] ChartError),
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
    /// The error of a variant with these values of swept keys.
    pub(crate) fn of_variant(self, swept: &[(&'static str, SweepValue)]) -> DesignError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        match self {
            DesignError::Gpu(_) => self,
            _ if at.is_empty() => self,
            _ => DesignError::At { at: at.join(", "), error: Box::new(self) },
        }
    }

    /// How far fillers are from meeting the constraints, where none does.
    pub(crate) fn excess(&self) -> Option<f64> {
        match self {
            DesignError::NoneLeft { excess, .. } => Some(*excess),
            DesignError::At { error, .. } => error.excess(),
            _ => None,
        }
    }

    /// The error at the place in the study that caused it; the same error where the study did not.
    ///
    /// # Errors
    /// The device, the decision or a chart caused it.
    pub fn in_study(self, study: &Study) -> Result<StudyError, DesignError> {
        if let DesignError::Study(error) = self {
            return Ok(error);
        }
        match self.remedy() {
            Some((key, help)) => Ok(study.error_at(study.place_of(key), self.to_string(), help)),
            None => Err(self),
        }
    }

    /// The key to change, and how; `None` where the study did not cause the error.
    fn remedy(&self) -> Option<(&'static str, &'static str)> {
        Some(match self {
            DesignError::Kind(_) => ("kind", "give a study of kind = \"switched-run\""),
            DesignError::Nothing => ("drift", "give drift.magnetic, and fillers or drift.residual_max"),
            DesignError::NoCandidate(_) => ("run.duration", "lengthen the run, or sweep switching.interval"),
            DesignError::NoFillers => (
                "drift.residual_max",
                "leave the constraints out, or take fillers instead of drift.residual_max",
            ),
            DesignError::NoneLeft { .. } => {
                ("switching.fillers", "allow more, or add a filler that reads fewer ticks")
            }
            DesignError::Band { .. } => ("gyro.tick", "give a lower band, or a shorter gyro.tick"),
            DesignError::Study(_) => ("switching.fillers", "give other fillers"),
            DesignError::TooFew { .. } => ("trials", "increase them; 100_000 is usual"),
            DesignError::Lower(lower) => (lower.key, lower.help),
            DesignError::At { error, .. } => return error.remedy(),
            DesignError::Gpu(_) | DesignError::Decision(_) | DesignError::Chart(_) => return None,
        })
    }
}
