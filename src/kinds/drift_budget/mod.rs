//! Studies of the drift budget: the bound of the paper, its optimum, and what a run really adds up, in closed form.

pub mod kind;
pub mod table;

use toml::Spanned;

use crate::drift::schedule::{SETTINGS as SCHEDULE_SETTINGS, Schedule};
use crate::drift::{self, Drift};
use crate::key::file::StudyFile;
use crate::key::file::drift::{DriftTable, RunTable};
use crate::key::file::switching::SwitchingTable;
use crate::key::setting::{Key, Swept};
use crate::key::sweep::{self, Sweep};
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::study::{needed, needed_key};

/// What a study of the drift budget asks.
#[derive(Debug, Clone)]
pub struct DriftBudget {
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<Point>,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key, and its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// The parts of the drift.
    pub drift: Drift,
    /// Interval and duration.
    pub schedule: Schedule,
}

/// The parts of the drift that a budget has.
const PARTS: [&str; 5] = [
    "drift.magnetic",
    "drift.warm_up_time",
    "drift.non_magnetic",
    "drift.initial_magnetic",
    "drift.residual_max",
];

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    let drift = drift::SETTINGS.iter().map(|setting| &setting.key);
    let parts = drift.filter(|key| PARTS.contains(&key.name));
    parts.chain(SCHEDULE_SETTINGS.iter().map(|setting| &setting.key)).collect()
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(file: &StudyFile, sweeps: &[Sweep], places: &mut Places) -> Result<DriftBudget, Wrong> {
    let table = needed(file.drift.as_ref(), "drift", file)?;
    let switching = needed(file.switching.as_ref(), "switching", file)?;
    let run = needed(file.run.as_ref(), "run", file)?;
    check_keys(table.get_ref(), switching.get_ref(), run.get_ref())?;
    needed_key(table.get_ref().residual_max.as_ref(), "drift.residual_max", table)?;
    let interval = needed_key(switching.get_ref().interval.as_ref(), "switching.interval", switching)?;
    let drift = drift::read(table.get_ref(), places)?;
    let schedule = drift::read_schedule(Some(interval), &run.get_ref().duration, places)?;
    let point = |index: usize| {
        let swept = sweep::values_at(sweeps, index);
        let mut point = Point { swept: vec![], drift: drift.clone(), schedule };
        sweep::set(&mut point.drift, &drift::SETTINGS, &swept);
        sweep::set(&mut point.schedule, &SCHEDULE_SETTINGS, &swept);
        point.schedule.check(places, sweeps)?;
        Ok(Point { swept, ..point })
    };
    Ok(DriftBudget { points: (0..sweep::points(sweeps)).map(point).collect::<Result<_, Fault>>()? })
}

/// Refuses keys of these tables that a budget has no use for.
fn check_keys(drift: &DriftTable, switching: &SwitchingTable, run: &RunTable) -> Result<(), Fault> {
    let others = [
        ("drift.magnetic_spread", drift.magnetic_spread.as_ref().map(Spanned::span)),
        ("drift.warm_up_time_spread", drift.warm_up_time_spread.as_ref().map(Spanned::span)),
        ("drift.non_magnetic_spread", drift.non_magnetic_spread.as_ref().map(Spanned::span)),
        ("drift.initial_magnetic_spread", drift.initial_magnetic_spread.as_ref().map(Spanned::span)),
        ("drift.angle_random_walk", drift.angle_random_walk.as_ref().map(Spanned::span)),
        ("switching.first_mode", switching.first_mode.as_ref().map(Spanned::span)),
        ("switching.timing", switching.timing.as_ref().map(Spanned::span)),
        ("switching.gap_ticks", switching.gap_ticks.as_ref().map(Spanned::span)),
        ("switching.fit_ticks", switching.fit_ticks.as_ref().map(Spanned::span)),
        ("switching.extrapolation_ticks", switching.extrapolation_ticks.as_ref().map(Spanned::span)),
        ("switching.fillers", switching.fillers.as_ref().map(Spanned::span)),
        ("switching.errors", switching.errors.as_ref().map(Spanned::span)),
        ("run.times", run.times.as_ref().map(Spanned::span)),
        ("run.trajectories", run.trajectories.as_ref().map(Spanned::span)),
    ];
    match others.into_iter().find_map(|(key, span)| Some((key, span?))) {
        Some((key, span)) => {
            let message = format!("{key} is no key of a study of kind = \"drift-budget\"");
            Err(Fault::new(span, message, "not of this kind", "leave it out"))
        }
        None => Ok(()),
    }
}
