//! Studies of whole runs of a gyro that switches modes.

pub mod kind;
pub mod lower;
pub mod point;
pub mod relock;
pub mod run;
pub mod times;

use toml::Spanned;

pub use crate::kinds::switched_run::point::Point;
pub use crate::kinds::switched_run::relock::Relocking;

use crate::drift::{self, Drift};
use crate::filler::Filler;
use crate::key::file::StudyFile;
use crate::key::file::drift::DriftTable;
use crate::key::file::switching::SwitchingTable;
use crate::key::scalar;
use crate::key::setting::Key;
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::{self, GapFill};
use crate::quantity::number::significant;
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::source::text_file::Files;
use crate::study::{needed, needed_key};

pub use crate::key::file::switching::{FirstMode, Timing};

/// What a study of whole runs asks.
#[derive(Debug, Clone)]
pub struct SwitchedRun {
    /// The switch and its fillers; absent where the residual is given by its largest value, or there is none.
    pub fill: Option<GapFill>,
    /// The sign that the magnetic drift starts with.
    pub first_mode: FirstMode,
    /// How phases go on from switch to switch.
    pub timing: Timing,
    /// Times at which the angle is wanted besides the end, s, each once.
    pub times: Vec<f64>,
    /// Runs of each point and filler that are kept as trajectories.
    pub trajectories: u64,
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<Point>,
    /// What is rounded or left out, each in a sentence.
    pub notes: Vec<String>,
}

/// Which angle of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Angle {
    /// At the end.
    End,
    /// The largest, just before or after a switch or at the end.
    Largest,
    /// At a time, s.
    At(f64),
}

impl Angle {
    /// As tables call it.
    pub fn name(&self) -> String {
        match self {
            Angle::End => "end".to_owned(),
            Angle::Largest => "largest".to_owned(),
            Angle::At(time_s) => format!("at {} s", significant(*time_s, 12)),
        }
    }
}

impl SwitchedRun {
    /// The angles that are estimated, in the order of tables.
    pub fn angles(&self) -> Vec<Angle> {
        [Angle::End, Angle::Largest]
            .into_iter()
            .chain(self.times.iter().map(|&time| Angle::At(time)))
            .collect()
    }

    /// The fillers to compare; none where the residual is given by its largest value.
    pub fn fillers(&self) -> &[Filler] {
        self.fill.as_ref().map_or(&[], |fill| &fill.fillers)
    }
}

/// Most runs that are kept as trajectories.
const MOST_TRAJECTORIES: i64 = 1000;

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    let drift = drift::SETTINGS.iter().map(|setting| &setting.key);
    let schedule = drift::SCHEDULE_SETTINGS.iter().map(|setting| &setting.key);
    schedule.chain(drift).chain(gap_fill::keys()).chain(crate::kinds::switched_run::relock::keys()).collect()
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(
    file: &StudyFile,
    sweeps: &[Sweep],
    files: &Files,
    places: &mut Places,
) -> Result<SwitchedRun, Wrong> {
    let switching = needed(file.switching.as_ref(), "switching", file)?;
    let run = needed(file.run.as_ref(), "run", file)?;
    refuse_keys(file, switching.get_ref())?;
    let interval = needed_key(switching.get_ref().interval.as_ref(), "switching.interval", switching)?;
    let schedule = drift::read_schedule(Some(interval), &run.get_ref().duration, places)?;
    let nothing = DriftTable::default();
    let table = file.drift.as_ref().map_or(&nothing, Spanned::get_ref);
    let drift = drift::read(table, places)?;
    if let Some(table) = &file.drift {
        places.add("drift", table.span());
    }
    let fill = read_fill(file, switching, &drift, sweeps, files, places)?;
    let relock = crate::kinds::switched_run::relock::read(file, fill.as_ref(), sweeps, places)?;
    let times = crate::kinds::switched_run::times::read(run.get_ref().times.as_ref(), places)?;
    let trajectories = match &run.get_ref().trajectories {
        Some(given) => scalar::whole("run.trajectories", given, 0..=MOST_TRAJECTORIES)?.cast_unsigned(),
        None => 0,
    };
    let base = crate::kinds::switched_run::point::Base {
        drift,
        schedule,
        fill: fill.as_ref(),
        relock,
        times: &times,
        places,
        sweeps,
    };
    let (points, rounded) = base.points()?;
    check_size(&points, fill.as_ref(), sweeps)?;
    check_moves(&points, places, sweeps)?;
    let fill_notes = fill.as_ref().map_or(&[][..], |fill| &fill.notes);
    let timing = switching.get_ref().timing.as_ref().map(|timing| *timing.get_ref()).unwrap_or_default();
    let residuals = fill.as_ref().map_or(vec![], |fill| of_residuals(fill, timing));
    let notes = rounded.into_iter().chain(fill_notes.iter().cloned()).chain(residuals);
    Ok(SwitchedRun {
        first_mode: switching.get_ref().first_mode.as_ref().map(|mode| *mode.get_ref()).unwrap_or_default(),
        timing,
        notes: notes.collect(),
        fill,
        times,
        trajectories,
        points,
    })
}

/// Most intervals of all points and fillers together: each has a row in memory.
const MOST_ROWS: u64 = 20_000_000;

/// Refuses studies whose points have too many intervals together.
fn check_size(points: &[Point], fill: Option<&GapFill>, sweeps: &[Sweep]) -> Result<(), Fault> {
    let fillers = fill.map_or(1, |fill| fill.fillers.len() as u64);
    let rows: u64 = points.iter().map(|point| (point.switches() + 1) * fillers).sum();
    if rows <= MOST_ROWS {
        return Ok(());
    }
    let message = format!("the runs of all points and fillers have {rows} intervals together");
    let place = sweeps.first().map_or(0..0, |sweep| sweep.span.clone());
    let help = format!("accepted: up to {MOST_ROWS}; sweep fewer values, or take longer intervals");
    Err(Fault::new(place, message, "too many points", help))
}

/// Refuses runs whose angle stays at 0 at every point.
fn check_moves(points: &[Point], places: &Places, sweeps: &[Sweep]) -> Result<(), Fault> {
    let still = |point: &Point| {
        let filled = point.fill.as_ref().is_some_and(|fill| !fill.inputs.is_nothing());
        point.drift.is_nothing() && !filled && point.relock.is_none()
    };
    if !points.iter().all(still) {
        return Ok(());
    }
    let message = "there is no drift and nothing that a switch could leave: all runs would stay at 0";
    let help = "add a part of it as in\n[drift]\nmagnetic = \"14 arcsec/s\"\nresidual_max = \"10 arcsec\"";
    Err(Fault::new(places.blame(sweeps, &["drift", "kind"]), message, "no drift", help))
}

/// Refuses what only studies of one switch have.
fn refuse_keys(file: &StudyFile, switching: &SwitchingTable) -> Result<(), Fault> {
    let refuse = |place, key: &str, help: &str| {
        let message = format!("{key} is no key of a study of kind = \"switched-run\"");
        Err(Fault::new(place, message, "not of this kind", help))
    };
    if let Some(precision) = &file.precision {
        return refuse(precision.span(), "precision", "leave it out: trials says how many runs are made");
    }
    if let Some(errors) = &switching.errors {
        return refuse(errors.span(), "switching.errors", "leave it out: what adds up are residuals");
    }
    Ok(())
}

/// The switch, where fillers are given.
fn read_fill(
    file: &StudyFile,
    switching: &Spanned<SwitchingTable>,
    drift: &Drift,
    sweeps: &[Sweep],
    files: &Files,
    places: &mut Places,
) -> Result<Option<GapFill>, Wrong> {
    let SwitchingTable { gap_ticks, fit_ticks, extrapolation_ticks, fillers, .. } = switching.get_ref();
    if fillers.is_some() {
        if drift.residual_max != 0.0 || sweeps.iter().any(|sweep| sweep.key.name == "drift.residual_max") {
            let place = places.blame(sweeps, &["drift.residual_max"]);
            let message = "drift.residual_max stands beside switching.fillers, which give the residual";
            let help = "leave drift.residual_max out, or take [gyro], [motion] and fillers out";
            return Err(Fault::new(place, message, "a second residual", help).into());
        }
        return Ok(Some(gap_fill::read(file, sweeps, files, places)?));
    }
    let of_fill = [
        ("[gyro]", file.gyro.as_ref().map(Spanned::span)),
        ("[motion]", file.motion.as_ref().map(Spanned::span)),
        ("[noise]", file.noise.as_ref().map(Spanned::span)),
        ("switching.gap_ticks", gap_ticks.as_ref().map(Spanned::span)),
        ("switching.fit_ticks", fit_ticks.as_ref().map(Spanned::span)),
        ("switching.extrapolation_ticks", extrapolation_ticks.as_ref().map(Spanned::span)),
    ];
    if let Some((name, Some(place))) = of_fill.into_iter().find(|(_, place)| place.is_some()) {
        let message = format!("{name} says how residuals come about, but switching.fillers is missing");
        let help = "add fillers = [\"const\", \"quadratic\"] to [switching], or leave it out and give drift.residual_max";
        return Err(Fault::new(place, message, "of no use without fillers", help).into());
    }
    let of_gap_fill: Vec<&str> = gap_fill::keys().iter().map(|key| key.name).collect();
    for (sweep, table) in sweeps.iter().zip(&file.sweep) {
        if of_gap_fill.contains(&sweep.key.name) {
            let message = format!("{} is swept, but there are no fillers", sweep.key.name);
            let help =
                "add [gyro], [motion] and switching.fillers, or sweep a key of [drift], [run] or [switching]";
            return Err(Fault::new(table.key.span(), message, "not in this study", help).into());
        }
    }
    Ok(None)
}

/// What is taken for granted of the residuals of some motions.
fn of_residuals(fill: &GapFill, timing: Timing) -> Vec<String> {
    let motions = || fill.points.iter().map(|point| &point.inputs.motion);
    let drawn = motions().any(|motion| motion.tones.iter().any(|tone| !tone.is_plain()));
    let profile = motions().any(|motion| motion.profile.is_some());
    let gaussian = motions().any(|motion| motion.gaussian.is_some());
    let independent = "independent from switch to switch, whatever switching.timing says";
    let normal = |what: &str| {
        format!(
            "residuals of {what} are taken as normally distributed, with their own mean and variance, and as {independent}; \
             sweep what stays the same in a run"
        )
    };
    [
        drawn.then(|| normal("tones whose amplitude or frequency is drawn")),
        profile.then(|| normal("a recorded profile")),
        (gaussian && timing == Timing::Periodic)
            .then(|| format!("residuals of Gaussian motion are taken as {independent}")),
    ]
    .into_iter()
    .flatten()
    .collect()
}
