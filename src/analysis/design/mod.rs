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
//! use sagnac::analysis::design::{Constraints, Measure, Request, design};
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
//! let request = Request { measure: Measure::DriftRms, constraints: Constraints::default(), search: None };
//! let found = design(&study, &request, &mut device, &Silent)?;
//! let best = found.best().best();
//! // In closed form 22.4 s, and 0.0304 °/h rms.
//! assert!((20.0..25.0).contains(&best.interval_s), "{} s", best.interval_s);
//! assert!((best.drift.value - 0.0304).abs() < 0.001, "{} °/h", best.drift.value);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answer;
pub(crate) mod candidates;
pub mod constraints;
pub(crate) mod error;
pub mod found;
pub(crate) mod measure;
pub(crate) mod optimum;
pub(crate) mod paper;
pub mod pareto;
pub mod report;
pub(crate) mod runs;
pub(crate) mod sampling;
pub mod searched;
pub(crate) mod variants;

pub use crate::analysis::design::constraints::{Constraints, Cost};
pub use crate::analysis::design::error::DesignError;
pub use crate::analysis::design::found::{Design, Filler, Found, Tried, Variant};
pub use crate::analysis::design::measure::Measure;
pub use crate::analysis::design::paper::PapersRule;
pub use crate::analysis::design::searched::Search;

use crate::analysis::design::candidates::Maker;
use crate::analysis::design::constraints::{LeftOut, constrained};
use crate::analysis::design::found::deciding;
use crate::analysis::design::optimum::least_of;
use crate::analysis::design::runs::{Chosen, Runner, work};
use crate::analysis::design::searched::with_searched;
use crate::analysis::design::variants::Values;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::short;
use sagnac_engine::device::Device;
use sagnac_engine::drift::{End, INTERVAL};
use sagnac_engine::kinds::switched_run::run::late;
use sagnac_engine::kinds::switched_run::{SwitchedRun, Timing};
use sagnac_engine::sampling::Worker;
use sagnac_engine::study::Study;

/// Number of switches from which the effort is said before the runs: a minute or more on most processors.
const MANY: u64 = 20_000_000_000;

/// What a design is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Quantity to minimize.
    pub measure: Measure,
    /// What fillers must meet.
    pub constraints: Constraints,
    /// Search for further fillers; none without it.
    pub search: Option<Search>,
}

/// Runs all candidates of all variants; `progress` counts the switches of their runs.
///
/// # Errors
/// The study is of another kind, has nothing to choose or no filler that meets the constraints, does not accept the band of
/// the search, or the device fails.
pub fn design(
    study: &Study,
    request: &Request,
    device: &mut Device,
    progress: &dyn Progress,
) -> Result<Design, DesignError> {
    let Request { measure, constraints, search } = request;
    let extended = search.as_ref().map(|search| with_searched(study, constraints, search)).transpose()?;
    let study = extended.as_ref().unwrap_or(study);
    let Some(runs) = study.asked::<SwitchedRun>() else {
        return Err(DesignError::Kind(study.kind().name));
    };
    let mut left_out = Vec::new();
    let all = within(constraints, variants::of(runs), &mut left_out)?;
    let swept = study.sweeps.iter().any(|sweep| sweep.key.name == INTERVAL.name);
    let mut chosen = Vec::new();
    for (values, runs, costs) in &all {
        let maker = Maker { runs, seed: study.seed, swept };
        let candidates = maker.choose().map_err(|error| error.of_variant(values))?;
        chosen.push(Chosen { candidates, costs, maker });
    }
    let trials = sampling::trials(study.trials);
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
    let of_fillers = constraints::note(constraints, &left_out, variants::of(runs).len());
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
