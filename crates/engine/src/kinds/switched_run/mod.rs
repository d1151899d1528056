//! Studies of whole runs of a gyro that switches modes.

pub(crate) mod columns;
pub(crate) mod kind;
pub mod lower;
pub(crate) mod parts;
pub mod point;
pub(crate) mod relock;
pub mod run;
pub mod verify;

pub use crate::kinds::switched_run::point::Point;
pub use crate::kinds::switched_run::relock::Relocking;

use crate::drift::{self, DRIFT, Drift, END, End, RESIDUAL_MAX, Schedule};
use crate::filler::Filler;
use crate::filler::read::{EXTRAPOLATION_TICKS, FILLERS, FIT_TICKS, GAP_TICKS};
use crate::key::document::{Given, Places};
use crate::key::row::{Holds, Key, Reading, keys, unlimited, words};
use crate::key::sweep;
use crate::kinds::gap_fill::{self, GapFill};
use crate::motion::keys::MOTION;
use crate::noise::NOISE;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::{Fault, Wrong};

words! {
    /// Sign of the magnetic drift in the first interval of a run.
    pub enum FirstMode {
        /// Nominal sign: a magnetic drift above 0 adds to the angle.
        Positive = "positive",
        /// The opposite sign.
        Negative = "negative",
        /// A random sign in each run.
        Random = "random",
    }
}

words! {
    /// The phase of the motion at the switches of a run; where the motion has a fixed phase, it is always that one.
    pub enum Timing {
        /// Random phases, independent of each other.
        Random = "random",
        /// Switches exactly one interval apart, so that the phase advances equally from switch to switch; the first
        /// phase is random.
        Periodic = "periodic",
    }
}

keys! {
    /// The keys specific to this kind.
    static KEYS;
    /// Sign of the magnetic drift in the first interval; positive if absent.
    FIRST_MODE = "switching.first_mode", "", Fixed, Holds::Word(FirstMode::WORDS), r#"first_mode = "positive""#;
    /// Phase of the motion at the switches; random if absent. If the motion has a fixed phase, every switch has that
    /// phase.
    TIMING = "switching.timing", "", Fixed, Holds::Word(Timing::WORDS), r#"timing = "random""#;
    /// Times at which the angle is estimated in addition to the end: ["10 min", "30 min"].
    pub TIMES = "run.times", "", Fixed, Holds::List(&unlimited(&[Dimension::Time])), r#"times = ["10 min", "30 min"]"#;
    /// Number of runs that are kept as trajectories; none if absent.
    TRAJECTORIES = "run.trajectories", "", Fixed, Holds::Whole(0, 1000), "trajectories = 20";
}

/// The part of a study that is specific to whole runs.
#[derive(Debug, Clone)]
pub struct SwitchedRun {
    /// The switch and its fillers; absent where the residual is given by its largest value, or is zero.
    pub fill: Option<GapFill>,
    /// Initial sign of the magnetic drift.
    pub first_mode: FirstMode,
    /// Phases of the motion from switch to switch.
    pub timing: Timing,
    /// Times at which the angle is estimated in addition to the end, s, each once.
    pub times: Vec<f64>,
    /// Number of runs of each point and filler that are kept as trajectories.
    pub trajectories: u64,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
}

/// An angle of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Angle {
    /// The angle at the end, which [`End`] defines.
    End,
    /// The largest angle, just before or after a switch or at the end.
    Largest,
    /// The angle at a time, s.
    At(f64),
}

impl Angle {
    /// Name in tables.
    pub fn name(&self) -> String {
        match self {
            Angle::End => "end".to_owned(),
            Angle::Largest => "largest".to_owned(),
            Angle::At(time_s) => format!("at {} s", significant(*time_s, 12)),
        }
    }
}

impl SwitchedRun {
    /// The estimated angles, in the order of tables.
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

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    let run = [drift::SCHEDULE_KEYS, drift::KEYS, drift::SPREAD_KEYS, KEYS].concat();
    [&run[..], &gap_fill::keys_of_fill(), &relock::keys()].concat()
}

/// The keys that can be swept.
pub fn sweepable() -> Vec<&'static Key> {
    let run = sweep::keys(&drift::SCHEDULE_SETTINGS).chain(sweep::keys(&drift::SETTINGS));
    run.chain(gap_fill::sweepable()).chain(relock::sweepable()).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<SwitchedRun, Wrong> {
    let (mut drift, mut schedule) = (Drift::default(), Schedule::default());
    reading.set(&mut schedule, &drift::SCHEDULE_SETTINGS)?;
    schedule.end = End::of(reading.get(&END));
    reading.set(&mut drift, &drift::SETTINGS)?;
    reading.note(&[&DRIFT]);
    let fill = read_fill(reading, &drift)?;
    let relock = relock::read(reading, fill.as_ref())?;
    let times = read_times(reading)?;
    let trajectories = match reading.get(&TRAJECTORIES) {
        Some(given) => given.whole()?.cast_unsigned(),
        None => 0,
    };
    let (places, sweeps) = (&reading.places, reading.sweeps);
    let base = point::Base { drift, schedule, fill: fill.as_ref(), relock, times: &times, places, sweeps };
    let (points, rounded) = base.points()?;
    check_moves(&points, places)?;
    let timing = Timing::of(reading.get(&TIMING));
    // The points need the switch, whose notes are there already; what is rounded comes before them.
    reading.notes.splice(0..0, rounded);
    reading.notes.extend(fill.iter().flat_map(|fill| of_residuals(fill, timing)));
    let first_mode = FirstMode::of(reading.get(&FIRST_MODE));
    Ok(SwitchedRun { first_mode, timing, fill, times, trajectories, points })
}

/// Refuses runs whose angle stays at 0 at every point.
fn check_moves(points: &[Point], places: &Places) -> Result<(), Fault> {
    let still = |point: &Point| {
        let filled = point.fill.as_ref().is_some_and(|fill| !fill.inputs.is_nothing());
        point.drift.is_nothing() && !filled && point.relock.is_none()
    };
    if !points.iter().all(still) {
        return Ok(());
    }
    let message = "there is no drift and no residual of a switch: all runs would stay at 0";
    let help = "add a part of it as in\n[drift]\nmagnetic = \"14 arcsec/s\"\nresidual_max = \"10 arcsec\"";
    places.refuse(&["drift", "kind"], message, "no drift", help)
}

/// Reads the switch, where fillers are given.
fn read_fill(reading: &mut Reading, drift: &Drift) -> Result<Option<GapFill>, Wrong> {
    if reading.get(&FILLERS).is_some() {
        if drift.residual_max != 0.0 || reading.sweep(&RESIDUAL_MAX).is_some() {
            let message = "drift.residual_max conflicts with switching.fillers, which give the residual";
            let help = "leave drift.residual_max out, or take [gyro], [motion] and fillers out";
            let place = reading.places.blame(&[RESIDUAL_MAX.name]);
            return Err(Fault::new(place, message, "a second residual", help).into());
        }
        return Ok(Some(gap_fill::read(reading)?));
    }
    let of_fill = [&gap_fill::keys::GYRO, &MOTION, &NOISE, &GAP_TICKS, &FIT_TICKS, &EXTRAPOLATION_TICKS];
    if let Some(written) = of_fill.into_iter().find_map(|key| reading.get(key)) {
        let name = written.key.name;
        let name = if written.key.holds.is_table() { format!("[{name}]") } else { name.to_owned() };
        let message = format!("{name} determines the residuals, but switching.fillers is missing");
        let help = "add fillers = [\"const\", \"quadratic\"] to [switching], or leave it out and give drift.residual_max";
        return Err(written.fault(message, "no effect without fillers", help).into());
    }
    for sweep in reading.sweeps {
        if gap_fill::sweepable().iter().any(|key| key.name == sweep.key.name) {
            let message = format!("{} is swept, but there are no fillers", sweep.key.name);
            let help =
                "add [gyro], [motion] and switching.fillers, or sweep a key of [drift], [run] or [switching]";
            return Err(sweep.fault(message, "not in this study", help).into());
        }
    }
    Ok(None)
}

/// Notes on assumptions about the residuals of some motions.
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

/// Most times of a study.
const MAX_TIMES: usize = 100;

/// Reads the times in s, each once.
fn read_times(reading: &mut Reading) -> Result<Vec<f64>, Fault> {
    reading.note(&[&TIMES]);
    let Some(list) = reading.get(&TIMES) else { return Ok(vec![]) };
    let items = list.items();
    if items.len() > MAX_TIMES {
        let message = format!("run.times lists {} times", items.len());
        let help = format!("accepted: up to {MAX_TIMES}; trajectories show all of a run");
        return Err(list.fault(message, "too many", help));
    }
    let time = |given: Given| match given.quantity()? {
        time if time.value > 0.0 => Ok((time.to_string(), time.value)),
        time => {
            Err(given.fault(format!("run.times lists {time}"), "not above 0", "give times after the start"))
        }
    };
    list.distinct(time, "leave it out here")
}
