//! Points of a study of whole runs, each checked as a whole, with the relock of each switch.

use crate::drift::{self, Drift, End, Schedule};
use crate::key::document::SpanMap;
use crate::key::sweep::{Sweep, Sweepable, SweepValue};
use crate::key::{Key, ParseContext, ValueType, keys};
use crate::kinds::gap_fill::{self, GapFill};
use crate::kinds::relock::{self, Compensation, RELOCK_TABLE, Relock};
use sagnac_base::diagnostics::Fault;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::round_12;
use sagnac_kernel::switched_run::shape::MAX_INTERVALS;
use sagnac_theory::drift::switches;

/// Relative deviation of an interval from a whole number of ticks that counts as rounding, since not all decimal
/// fractions are exact.
const WHOLE: f64 = 1e-9;

/// Least product of interval and run, in warm-up times, for which the remainder of the warm-up is accurate to 0.2 %.
const MIN_LEFT: f64 = 1e-5;

/// Largest fraction of the apparent angle of a relock that may come after the ticks followed.
const MAX_LATE: f64 = 0.2;

/// Time constants after which a loop counts as closed: e^−5 of the initial detuning and e^−10 of the apparent rotation are left.
const SETTLED: f64 = 5.0;

/// One combination of swept values, with everything derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// The parts of the drift, with their spreads.
    pub drift: Drift,
    /// Schedule in whole ticks.
    pub schedule: Schedule,
    /// The switch; absent where the residual is given by its largest value.
    pub fill: Option<gap_fill::inputs::Point>,
    /// The relock after each switch.
    pub relock: Option<Relocking>,
}

impl Point {
    /// Number of switches in a run of exactly the run time.
    pub fn switches(&self) -> u64 {
        switches(self.schedule.interval_s, self.schedule.duration_s) as u64
    }

    /// Number of intervals of the longest run, the last of which may be incomplete.
    pub(crate) fn intervals(&self) -> u64 {
        let ends = self.schedule.ends();
        let last_s = ends.last().copied().unwrap_or(self.schedule.duration_s);
        switches(self.schedule.interval_s, last_s) as u64 + 1
    }

    /// The shortest possible interval, s, which is limited by the number of switches and by the ticks around a switch.
    pub fn shortest_s(&self) -> f64 {
        let most = self.schedule.duration_s / (MAX_INTERVALS - 1) as f64;
        let Some(fill) = &self.fill else { return most };
        let settled = self.relock.as_ref().map_or(0.0, |relocking| settled_s(relocking, fill));
        most.max(ticks_round_a_switch(fill) * fill.inputs.tick_s).max(settled)
    }

    /// This point with another interval, rounded to whole ticks; where the end is exact, with the nearest interval of
    /// which an even number makes the run, because a switch more or less would count for more than the interval. `None`
    /// for an interval that is too short, or longer than half the run.
    pub fn with_interval(&self, interval_s: f64) -> Option<Point> {
        let duration_s = self.schedule.duration_s;
        let interval_s = match self.schedule.end {
            End::Any => interval_s,
            End::Exact => 0.5 * duration_s / libm::round(0.5 * duration_s / interval_s).max(1.0),
        };
        let tick_s = self.fill.as_ref().map(|fill| fill.inputs.tick_s);
        let interval_s =
            round_12(tick_s.map_or(interval_s, |tick_s| libm::round(interval_s / tick_s) * tick_s));
        let schedule = Schedule { interval_s, ..self.schedule };
        let fits = (self.shortest_s()..=0.5 * duration_s).contains(&interval_s);
        fits.then(|| Point { schedule, ..self.clone() })
    }
}

/// Time after a switch at which its loop is closed, s.
fn settled_s(relocking: &Relocking, fill: &gap_fill::inputs::Point) -> f64 {
    let gap_s = f64::from(fill.inputs.gap_ticks) * fill.inputs.tick_s;
    let ticks_s = f64::from(relocking.relock.ticks) * fill.inputs.tick_s;
    gap_s + ticks_s.max(SETTLED * relocking.relock.loop_s)
}

/// Number of ticks from the first to the last that a filler reads.
fn ticks_round_a_switch(fill: &gap_fill::inputs::Point) -> f64 {
    let ends = [0, fill.inputs.gap_ticks as i32];
    let ticks = fill.fills.iter().flat_map(|fill| &fill.fit_ticks);
    let [first, last] = ticks.fold(ends, |[first, last], &tick| [first.min(tick), last.max(tick)]);
    f64::from(last - first + 1)
}

/// The inputs common to all points, except the switch.
#[derive(Debug, Clone)]
pub struct Base {
    /// The parts of the drift, with their spreads.
    pub drift: Drift,
    /// Schedule as written.
    pub schedule: Schedule,
    /// The relock after each switch.
    pub relock: Option<Relocking>,
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Sweepable<Base> {
    let run = Sweepable::new()
        .part(&drift::SCHEDULE_SETTINGS, |base: &mut Base| Some(&mut base.schedule))
        .part(&drift::SETTINGS, |base| Some(&mut base.drift))
        .elsewhere(gap_fill::sweepable().keys());
    with_relock(run)
}

/// The keys of a relock that can be swept.
pub(crate) fn of_relock() -> Sweepable<Base> {
    with_relock(Sweepable::new())
}

fn with_relock(keys: Sweepable<Base>) -> Sweepable<Base> {
    let keys = keys.part(&relock::LOOP_SETTINGS, |base| Some(&mut base.relock.as_mut()?.relock));
    keys.name(&COMPENSATION, |base, name| {
        let named = Compensation::ALL.into_iter().find(|compensation| compensation.name() == name);
        if let (Some(relocking), Some(compensation)) = (&mut base.relock, named) {
            relocking.compensation = compensation;
        }
    })
}

impl Base {
    /// All points of some sweeps, in order, and a note on rounded intervals. `fill` is the switch at these points, and
    /// angles are estimated at some `times`.
    ///
    /// # Errors
    /// The first point that is invalid; or nothing moves at any point.
    pub(crate) fn points(
        &self,
        fill: Option<&GapFill>,
        times: &[f64],
        sweeps: &[Sweep],
        places: &SpanMap,
    ) -> Result<(Vec<Point>, Option<String>), Fault> {
        let (mut points, mut rounded) = (Vec::new(), Vec::new());
        let check = Check { times, places };
        for (index, (swept, base)) in sweepable().points(self, sweeps).enumerate() {
            let fill = fill.map(|fill| fill.points[index].clone());
            points.push(check.point(swept, base, fill, &mut rounded)?);
        }
        check.moves(&points)?;
        rounded.dedup();
        let note = rounded.first().map(|first| match rounded.len() - 1 {
            0 => format!("switching.interval is rounded to whole ticks: {first}"),
            1 => format!("switching.interval is rounded to whole ticks: {first}, and 1 other"),
            others => format!("switching.interval is rounded to whole ticks: {first}, and {others} others"),
        });
        Ok((points, note))
    }
}

/// The checks of points, with the places of the keys of the study.
struct Check<'a> {
    times: &'a [f64],
    places: &'a SpanMap,
}

impl Check<'_> {
    fn point(
        &self,
        swept: Vec<(&'static str, SweepValue)>,
        base: Base,
        fill: Option<gap_fill::inputs::Point>,
        rounded: &mut Vec<String>,
    ) -> Result<Point, Fault> {
        let Base { drift, mut schedule, relock } = base;
        if let Some(fill) = &fill {
            schedule.interval_s = self.whole_ticks(schedule.interval_s, fill, rounded)?;
        }
        schedule.check(self.places)?;
        self.check_relock(relock.as_ref(), fill.as_ref(), schedule)?;
        self.check(&drift, schedule)?;
        Ok(Point { swept, drift, schedule, fill, relock })
    }

    /// Refuses runs whose angle stays at 0 at every point.
    fn moves(&self, points: &[Point]) -> Result<(), Fault> {
        let still = |point: &Point| {
            let filled = point.fill.as_ref().is_some_and(|fill| !fill.inputs.is_nothing());
            point.drift.is_nothing() && !filled && point.relock.is_none()
        };
        if !points.iter().all(still) {
            return Ok(());
        }
        let message = "there is no drift and no residual of a switch: all runs would stay at 0";
        let help =
            "add a part of it as in\n[drift]\nmagnetic = \"14 arcsec/s\"\nresidual_max = \"10 arcsec\"";
        self.places.refuse(&["drift", "kind"], message, "no drift", help)
    }

    /// The nearest interval of whole ticks.
    fn whole_ticks(
        &self,
        interval_s: f64,
        fill: &gap_fill::inputs::Point,
        rounded: &mut Vec<String>,
    ) -> Result<f64, Fault> {
        let tick_s = fill.inputs.tick_s;
        let ticks = libm::round(interval_s / tick_s);
        let whole_s = round_12(ticks * tick_s);
        if (whole_s - interval_s).abs() > WHOLE * interval_s {
            rounded.push(format!("{} s to {} s", significant(interval_s, 9), significant(whole_s, 9)));
        }
        let used = ticks_round_a_switch(fill);
        if ticks >= used {
            return Ok(whole_s);
        }
        let [interval, least] = [interval_s, used * tick_s].map(|time| significant(time, 6));
        let message =
            format!("a switching interval of {interval} s is shorter than the ticks round a switch");
        let help = format!("accepted: {least} s and more with these fit ticks");
        let names = ["switching.interval", "switching.fit_ticks"];
        self.places.refuse(&names, message, "too short", help)
    }

    /// Refuses a loop that does not settle before the next switch.
    fn check_relock(
        &self,
        relock: Option<&Relocking>,
        fill: Option<&gap_fill::inputs::Point>,
        schedule: Schedule,
    ) -> Result<(), Fault> {
        let (Some(relocking), Some(fill)) = (relock, fill) else { return Ok(()) };
        let (ticks, late) = (relocking.relock.ticks, relocking.relock.late(fill.inputs.tick_s));
        if late > MAX_LATE {
            let percent = libm::round(100.0 * late);
            let message = format!(
                "{percent} % of the apparent angle of the relock comes after tick {ticks}, which runs do not count"
            );
            let names = ["relock.ticks", "relock.loop_time", "relock"];
            let help = "accepted: up to 20 %; follow up to 8 ticks, or take a faster loop";
            return self.places.refuse(&names, message, "too few ticks", help);
        }
        let least_s = settled_s(relocking, fill);
        if schedule.interval_s >= least_s {
            return Ok(());
        }
        let [interval, loop_time] =
            [schedule.interval_s, relocking.relock.loop_s].map(|time| significant(time, 6));
        let message =
            format!("a loop of {loop_time} s does not settle within a switching interval of {interval} s");
        let names = ["relock.loop_time", "switching.interval", "relock.ticks"];
        let help = format!("accepted: an interval of at least {} s here", significant(least_s, 4));
        self.places.refuse(&names, message, "does not settle", help)
    }

    /// Checks limits that involve more than one value.
    fn check(&self, drift: &Drift, schedule: Schedule) -> Result<(), Fault> {
        let Schedule { interval_s, duration_s, .. } = schedule;
        let [interval, duration] = [interval_s, duration_s].map(|time| significant(time, 6));
        if switches(interval_s, duration_s) >= MAX_INTERVALS as f64 {
            let message =
                format!("a run of {duration} s with a switch every {interval} s has too many switches");
            let help = format!(
                "accepted: up to {} switches, so an interval of at least {} s here",
                MAX_INTERVALS - 1,
                significant(duration_s / MAX_INTERVALS as f64, 4)
            );
            let names = ["switching.interval", "run.duration"];
            return self.places.refuse(&names, message, "too many switches", help);
        }
        if let Some(late) = self.times.iter().find(|&&time| time > duration_s) {
            let message = format!(
                "run.times lists {} s, after the end of a run of {duration} s",
                significant(*late, 6)
            );
            let help = "leave it out, or lengthen run.duration";
            return self.places.refuse(&["run.times", "run.duration"], message, "after the end", help);
        }
        let [warm_ups, run] = [interval_s, duration_s].map(|time| time / drift.warm_up_s);
        // The remainder of the warm-up relative to the rounding of exponentials.
        let left = warm_ups * run.min(1.0);
        if drift.warm_up_spread > 0.0 && drift.warm_up_s > 0.0 && (left < MIN_LEFT || warm_ups > 4.0) {
            let message = format!(
                "drift.warm_up_time_spread with an interval of {} and a run of {} warm-up times",
                significant(warm_ups, 3),
                significant(run, 3)
            );
            let names = ["drift.warm_up_time_spread", "switching.interval", "drift.warm_up_time"];
            let help = "accepted with a spread: intervals up to 4 warm-up times, whose product with the run is 1e-5 at least; \
                        leave the spread out";
            return self.places.refuse(&names, message, "out of range", help);
        }
        if drift.warm_up_spread > 0.0 && drift.warm_up_s == 0.0 {
            let message = "drift.warm_up_time_spread is given without drift.warm_up_time";
            let help = "add warm_up_time = \"3000 s\", or leave the spread out";
            return self.places.refuse(&["drift.warm_up_time_spread"], message, "no time to spread", help);
        }
        Ok(())
    }
}

/// Relock after each switch, with the compensation of its ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Relocking {
    /// Relock after each switch.
    pub relock: Relock,
    /// Compensation applied before the filler reads the ticks.
    pub compensation: Compensation,
}

keys! {
    /// The key that a relock study does not have.
    static KEYS;
    /// Compensation of the ticks; "none" if absent. A study of kind = "relock" compares all compensations.
    COMPENSATION = "relock.compensation", "compensation", Choice, ValueType::Word(Compensation::WORDS), r#"compensation = "detuning""#;
}

/// Every key of a relock in a run.
pub(crate) fn keys() -> Vec<&'static Key> {
    [relock::KEYS, KEYS].concat()
}

/// Reads the relock, if there is one.
pub(crate) fn read(reading: &mut ParseContext, fill: Option<&GapFill>) -> Result<Option<Relocking>, Fault> {
    let Some(table) = reading.get(&RELOCK_TABLE) else { return Ok(None) };
    if fill.is_none() {
        let message = "[relock] needs fillers and ticks, and there are none";
        let help = "add [gyro], [motion] and switching.fillers, or leave [relock] out";
        return Err(table.fault(message, "without fillers", help));
    }
    if let Some(list) = reading.get(&gap_fill::inputs::RELOCK) {
        let message = "gyro.relock conflicts with [relock]";
        return Err(list.fault(message, "a second relock", "leave one of them out"));
    }
    let relock = relock::read_loop(reading)?;
    reading.note(&[&RELOCK_TABLE]);
    Ok(Some(Relocking { relock, compensation: Compensation::from_value(reading.get(&COMPENSATION)) }))
}
