//! Studies of whole runs of a gyro that switches modes: their keys, the parts of the error, and the entry in the list of kinds.

pub mod lower;
pub mod point;
pub mod run;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Source, TableSchema, Text};
use crate::drift::{self, DRIFT, Drift, END, End, RESIDUAL_MAX, Schedule};
use crate::filler::Filler;
use crate::filler::read::{EXTRAPOLATION_TICKS, FILLERS, FIT_TICKS, GAP_TICKS};
use crate::key::document::{SpanMap, SpannedValue};
use crate::key::sweep::Sweep;
use crate::key::{Key, ParseContext, ValueType, keys, unlimited, words};
use crate::kinds::gap_fill::{self, GapFill};
use crate::kinds::plan::PointsPlan;
use crate::kinds::relock;
use crate::kinds::switched_run::lower::LoweredRun;
pub use crate::kinds::switched_run::point::{Point, Relocking};
use crate::kinds::switched_run::run::MAX_SHOWN;
use crate::motion::keys::MOTION;
use crate::noise::NOISE;
use crate::sampling::Planned;
use crate::study::{self, Ablation, Kind, Part, ROW, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::abouts;
use sagnac_kernel::switched_run::VERSION;

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
    FIRST_MODE = "switching.first_mode", "", Fixed, ValueType::Word(FirstMode::WORDS), r#"first_mode = "positive""#;
    /// Phase of the motion at the switches; random if absent. If the motion has a fixed phase, every switch has that
    /// phase.
    TIMING = "switching.timing", "", Fixed, ValueType::Word(Timing::WORDS), r#"timing = "random""#;
    /// Times at which the angle is estimated in addition to the end: ["10 min", "30 min"].
    pub TIMES = "run.times", "", Fixed, ValueType::List(&unlimited(&[Dimension::Time])), r#"times = ["10 min", "30 min"]"#;
    /// Number of runs that are kept as trajectories; none if absent.
    TRAJECTORIES = "run.trajectories", "", Fixed, ValueType::Whole(0, 1000), "trajectories = 20";
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
    /// The inputs that all points have in common.
    pub base: point::Base,
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
fn keys() -> Vec<&'static Key> {
    let run = [drift::SCHEDULE_KEYS, drift::KEYS, drift::SPREAD_KEYS, KEYS].concat();
    [&run[..], &gap_fill::keys_of_fill(), &point::keys()].concat()
}

/// Reads the part of a study that belongs to this kind.
fn read(reading: &mut ParseContext) -> Result<SwitchedRun, Wrong> {
    let (mut drift, mut schedule) = (Drift::default(), Schedule::default());
    reading.set(&mut schedule, &drift::SCHEDULE_SETTINGS)?;
    schedule.end = End::from_value(reading.get(&END));
    reading.set(&mut drift, &drift::SETTINGS)?;
    reading.note(&[&DRIFT]);
    let fill = read_fill(reading, &drift)?;
    let relock = point::read(reading, fill.as_ref())?;
    let base = point::Base { drift, schedule, relock };
    check_sweeps(&base, fill.as_ref(), reading.sweeps)?;
    let times = read_times(reading)?;
    let trajectories = match reading.get(&TRAJECTORIES) {
        Some(given) => given.whole()?.cast_unsigned(),
        None => 0,
    };
    let (points, rounded) = base.points(fill.as_ref(), &times, reading.sweeps, &reading.places)?;
    let timing = Timing::from_value(reading.get(&TIMING));
    // The points need the switch, whose notes are there already; what is rounded comes before them.
    reading.notes.splice(0..0, rounded);
    reading.notes.extend(fill.iter().flat_map(|fill| of_residuals(fill, timing)));
    let first_mode = FirstMode::from_value(reading.get(&FIRST_MODE));
    Ok(SwitchedRun { first_mode, timing, fill, times, trajectories, points, base })
}

/// The keys that can be swept.
pub fn sweepable() -> Vec<&'static Key> {
    point::sweepable().keys()
}

/// Refuses sweeps over parts that the study does not have.
fn check_sweeps(base: &point::Base, fill: Option<&GapFill>, sweeps: &[Sweep]) -> Result<(), Fault> {
    let is_of = |keys: &[&'static Key], sweep: &Sweep| keys.iter().any(|key| key.name == sweep.key.name);
    let (of_fill, of_relock) = (gap_fill::sweepable().keys(), point::of_relock().keys());
    for sweep in sweeps {
        let name = sweep.key.name;
        if fill.is_none() && is_of(&of_fill, sweep) {
            let help =
                "add [gyro], [motion] and switching.fillers, or sweep a key of [drift], [run] or [switching]";
            let message = format!("{name} is swept, but there are no fillers");
            return Err(sweep.fault(message, "not in this study", help));
        }
        if fill.is_some() && std::ptr::eq(sweep.key, &RESIDUAL_MAX) {
            return Err(second_residual(sweep.span.clone()));
        }
        if base.relock.is_none() && is_of(&of_relock, sweep) {
            let message = format!("{name} is swept, but there is no [relock]");
            let help = "add the table [relock], or leave the sweep out";
            return Err(sweep.fault(message, "not in this study", help));
        }
    }
    Ok(())
}

/// The fault of a largest residual beside fillers.
fn second_residual(span: std::ops::Range<usize>) -> Fault {
    let message = "drift.residual_max conflicts with switching.fillers, which give the residual";
    let help = "leave drift.residual_max out, or take [gyro], [motion] and fillers out";
    Fault::new(span, message, "a second residual", help)
}

/// Reads the switch, where fillers are given.
fn read_fill(reading: &mut ParseContext, drift: &Drift) -> Result<Option<GapFill>, Wrong> {
    if reading.get(&FILLERS).is_some() {
        if drift.residual_max != 0.0 || reading.sweep(&RESIDUAL_MAX).is_some() {
            return Err(second_residual(reading.places.blame(&[RESIDUAL_MAX.name])).into());
        }
        return Ok(Some(gap_fill::read(reading)?));
    }
    let of_fill = [&gap_fill::inputs::GYRO, &MOTION, &NOISE, &GAP_TICKS, &FIT_TICKS, &EXTRAPOLATION_TICKS];
    if let Some(written) = of_fill.into_iter().find_map(|key| reading.get(key)) {
        let name = written.key.name;
        let name = if written.key.holds.is_table() { format!("[{name}]") } else { name.to_owned() };
        let message = format!("{name} determines the residuals, but switching.fillers is missing");
        let help = "add fillers = [\"const\", \"quadratic\"] to [switching], or leave it out and give drift.residual_max";
        return Err(written.fault(message, "no effect without fillers", help).into());
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
fn read_times(reading: &mut ParseContext) -> Result<Vec<f64>, Fault> {
    reading.note(&[&TIMES]);
    let Some(list) = reading.get(&TIMES) else { return Ok(vec![]) };
    let items = list.items();
    if items.len() > MAX_TIMES {
        let message = format!("run.times lists {} times", items.len());
        let help = format!("accepted: up to {MAX_TIMES}; trajectories show all of a run");
        return Err(list.fault(message, "too many", help));
    }
    let time = |given: SpannedValue| match given.quantity()? {
        time if time.value > 0.0 => Ok((time.to_string(), time.value)),
        time => {
            Err(given.fault(format!("run.times lists {time}"), "not above 0", "give times after the start"))
        }
    };
    list.distinct(time, "leave it out here")
}

/// Studies of the angles of whole runs.
pub(crate) static SWITCHED_RUN: Kind = Kind {
    name: "switched-run",
    subject: "The error of the angle after a whole run of a gyro that switches modes.",
    about: "Samples whole runs of a gyro that switches modes: the magnetic drift, whose sign every switch reverses, and the \
            residuals of the switches. points.csv has the error of the angle at the end and at earlier times, `rms` and `p99_73` in arcsec, and \
            the same divided by the time, `drift_rms` and `drift_p99_73` in °/h. `sagnac design` finds the best interval of such a study.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 100_000,
    needs: &["switching", "run"],
    keys,
    sweepable,
    columns: &[
        (Source::Points, || abouts(&run::columns(true))),
        (Source::Trajectories, || abouts(&run::trajectory_columns(true))),
    ],
    kernels: || format!("switched_run {VERSION}, {}", relock::kernels()),
    loads: crate::kinds::switched_run::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

/// Bytes of memory of a lowered point, and of it for each switch; of a row of trajectories.
const POINT: u64 = 5000;
const SWITCH: u64 = 110;
const MOMENT: u64 = 120;

impl Subject for SwitchedRun {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let lower = |point: &_| LoweredRun::new(point, self, study.seed, study.streams);
        let plan = PointsPlan::new(study, self, &self.points, |point| &point.swept, lower, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let (parts, points) = dissected(self.points.get(point)?);
        Some(Ablation { parts, subject: Arc::new(SwitchedRun { points, trajectories: 0, ..self.clone() }) })
    }

    fn only(&self, row: usize) -> Option<(Arc<dyn Subject>, usize)> {
        let angles = self.angles().len();
        let (filler, angle) = (row / angles, row % angles);
        let mut only = self.clone();
        let fill = only.fill.as_mut()?;
        fill.fillers = vec![fill.fillers.get(filler)?.clone()];
        for of_point in only.points.iter_mut().filter_map(|point| point.fill.as_mut()) {
            of_point.fills = [of_point.fills.get(filler)?.clone()].into();
        }
        Some((Arc::new(only), angle))
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        check_sweeps(&self.base, self.fill.as_ref(), sweeps)?;
        let fill = self.fill.as_ref().map(|fill| fill.at_points(sweeps, places)).transpose()?;
        let (points, _) = self.base.points(fill.as_ref(), &self.times, sweeps, places)?;
        Ok(Arc::new(SwitchedRun { fill, points, ..self.clone() }))
    }

    fn bytes(&self) -> u64 {
        let (fillers, angles) = (self.fillers().len().max(1) as u64, self.angles().len() as u64);
        let of_point = |point: &Point| {
            let shown = 2 * point.switches().min(MAX_SHOWN) + 1;
            POINT + ROW * angles + SWITCH * point.switches() + MOMENT * shown * self.trajectories
        };
        fillers * self.points.iter().map(of_point).sum::<u64>()
    }

    fn grounds(&self) -> Vec<TableSchema> {
        let fillers = self.fillers();
        let has_fillers = !fillers.is_empty();
        let fillers = || has_fillers.then(|| Text::new(fillers.iter().map(|filler| &filler.name))).into_iter();
        let angles = Text::new(self.angles().iter().map(Angle::name)).usual(Angle::End.name());
        let runs = Text::new((1..=self.trajectories).map(|number| number.to_string()));
        let none_kept =
            ("the chart is of trajectories, and none are kept", "add them as in\n[run]\ntrajectories = 20");
        let limits = &[Dimension::DriftRate, Dimension::Angle];
        let (points, trajectories) =
            (abouts(&run::columns(has_fillers)), abouts(&run::trajectory_columns(has_fillers)));
        let points = TableSchema::new(Source::Points, points, fillers().chain([angles]), limits);
        let trajectories = TableSchema {
            // Trajectories start at 0, and their angles have both signs.
            is_linear: true,
            absent: (self.trajectories == 0).then_some(none_kept),
            legend: ["single runs", points.legend[1]],
            ..TableSchema::new(Source::Trajectories, trajectories, fillers().chain([runs]), limits)
        };
        vec![points, trajectories]
    }
}

/// The parts of the drift.
static OF_DRIFT: [Part<Drift>; 4] = [
    Part {
        name: "magnetic drift",
        off: |drift| {
            (drift.magnetic, drift.magnetic_spread) = (0.0, 0.0);
            (drift.initial_magnetic, drift.initial_magnetic_spread) = (0.0, 0.0);
        },
    },
    Part {
        name: "non-magnetic drift with its spread",
        off: |drift| (drift.non_magnetic, drift.non_magnetic_spread) = (0.0, 0.0),
    },
    Part { name: "angle random walk", off: |drift| drift.angle_random_walk = 0.0 },
    Part { name: "residuals of the switches", off: |drift| drift.residual_max = 0.0 },
];

/// The relock after each switch.
static OF_RELOCK: [Part<Point>; 1] = [Part { name: "relock", off: |point| point.relock = None }];

/// A point as it is, and without each of its parts in turn; its fillers keep their weights.
fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let designed = |point: &Point| Point {
        fill: point.fill.as_ref().map(|fill| gap_fill::dissected(fill).1.swap_remove(0)),
        ..point.clone()
    };
    let point = designed(point);
    let (mut names, drifts) = study::points(&point.drift, &OF_DRIFT);
    let mut points: Vec<Point> = drifts.into_iter().map(|drift| Point { drift, ..point.clone() }).collect();
    if let Some(fill) = &point.fill {
        let (of_fill, fills) = gap_fill::dissected(fill);
        names.extend(of_fill);
        points.extend(fills.into_iter().skip(1).map(|fill| Point { fill: Some(fill), ..point.clone() }));
    }
    let (of_relock, relocked) = study::points(&point, &OF_RELOCK);
    names.extend(of_relock);
    points.extend(relocked.into_iter().skip(1));
    (names, points)
}
