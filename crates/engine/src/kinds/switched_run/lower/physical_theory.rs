//! Mean and rms of the angle of runs from the physical inputs: theory that shares no computation with the kernel.
//!
//! The drift is summed interval by interval, the residual of a switch is that of the
//! [physical theory](crate::kinds::gap_fill::lower::physical_theory) of gap-fill, and phases are in `f64`.

use core::f64::consts::PI;

use crate::drift::{End, Schedule};
use crate::kinds::gap_fill::lower::physical_theory::Switch;
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::{Angle, FirstMode, SwitchedRun, Timing};
use crate::motion::Frequency;

/// Relative deviation from a whole number of intervals that counts as rounding.
const WHOLE: f64 = 1e-9;

/// What the drift does up to a time, ″ for each unit of its parts.
#[derive(Debug, Clone, Copy, Default)]
struct Drifted {
    /// The angle caused by A, ″ per ″/s.
    magnetic: f64,
    /// The angle caused by Ω_m0, ″ per ″/s.
    initial: f64,
}

/// The runs of a point.
pub(crate) struct PhysicalRun<'a> {
    point: &'a RunPoint,
    study: &'a SwitchedRun,
    /// The drift at the end of each interval, from that of none on.
    drifted: Vec<Drifted>,
}

impl PhysicalRun<'_> {
    pub(crate) fn new<'a>(point: &'a RunPoint, study: &'a SwitchedRun) -> PhysicalRun<'a> {
        let mut run = PhysicalRun { point, study, drifted: vec![Drifted::default()] };
        for k in 0..point.intervals() {
            let next = run.interval(k as usize, point.schedule.interval_s);
            run.drifted.push(next);
        }
        run
    }

    /// The rms of an angle with this error at a switch, ″; `None` where it has no closed form.
    pub(crate) fn rms(&self, switch: &Switch, angle: Angle) -> Option<f64> {
        let Schedule { duration_s, end, .. } = self.point.schedule;
        // The warm-up of a drawn time constant, and a relock, are computed from their inputs already.
        if self.point.drift.warm_up_spread > 0.0 || self.point.relock.is_some() {
            return None;
        }
        match angle {
            Angle::Largest => None,
            Angle::At(time_s) => Some(libm::sqrt(self.mean_square(switch, time_s, time_s))),
            Angle::End if end == End::Exact => {
                Some(libm::sqrt(self.mean_square(switch, duration_s, duration_s)))
            }
            Angle::End => {
                let ends = self.point.schedule.ends();
                let square = |&time_s: &f64| self.mean_square(switch, time_s, duration_s);
                Some(libm::sqrt(ends.iter().map(square).sum::<f64>() / ends.len() as f64))
            }
        }
    }

    /// Mean square of the angle at a time, with the non-magnetic drift of `acting_s`, ″².
    fn mean_square(&self, switch: &Switch, time_s: f64, acting_s: f64) -> f64 {
        let RunPoint { drift, schedule, .. } = self.point;
        let sign = if self.study.first_mode == FirstMode::Negative { -1.0 } else { 1.0 };
        let intervals = time_s / schedule.interval_s;
        // Before the time: a switch at the time itself comes after it.
        let switches = (libm::ceil(intervals * (1.0 - WHOLE)) - 1.0).max(0.0);
        let whole = libm::floor(intervals * (1.0 + WHOLE)).min((self.drifted.len() - 1) as f64);
        let rest_s = (time_s - whole * schedule.interval_s).max(0.0);
        let Drifted { magnetic, initial } = self.interval(whole as usize, rest_s);
        let held = sign * (drift.magnetic * magnetic + drift.initial_magnetic * initial);
        let mut mean = drift.non_magnetic * acting_s + switches * switch.mean;
        let mut variance =
            switches * switch.variance + drift.angle_random_walk * drift.angle_random_walk * time_s;
        // Where the first mode is drawn, the magnetic part has either sign.
        if self.study.first_mode == FirstMode::Random {
            variance += held * held;
        } else {
            mean += held;
        }
        for deviation in [
            drift.magnetic_spread * magnetic,
            drift.initial_magnetic_spread * initial,
            drift.non_magnetic_spread * acting_s,
        ] {
            variance += deviation * deviation;
        }
        for &(tone, amplitude) in &switch.sines {
            variance += 0.5 * amplitude * amplitude * self.added(tone, switches);
        }
        mean * mean + variance
    }

    /// Squared size of the sum of as many sines of a tone as there are switches, relative to that of one: their number at
    /// random phases.
    fn added(&self, tone: usize, switches: f64) -> f64 {
        if self.study.timing == Timing::Random {
            return switches;
        }
        let tones = self.point.fill.as_ref().map_or(&[][..], |fill| &fill.inputs.motion.tones);
        let turns = match tones.get(tone).map(|tone| tone.frequency) {
            Some(Frequency::Fixed(frequency_hz)) => frequency_hz * self.point.schedule.interval_s,
            _ => 0.0,
        };
        let part = turns - libm::round(turns);
        if part == 0.0 {
            return switches * switches;
        }
        let ratio = libm::sin(PI * switches * part) / libm::sin(PI * part);
        ratio * ratio
    }

    /// The drift after so many intervals and a part of the next one.
    fn interval(&self, whole: usize, length_s: f64) -> Drifted {
        let (interval_s, warm_up_s) = (self.point.schedule.interval_s, self.point.drift.warm_up_s);
        let from_s = whole as f64 * interval_s;
        // ∫ 1 − e^{−t/τ}.
        let warmed = match warm_up_s {
            0.0 => length_s,
            tau => length_s + tau * libm::exp(-from_s / tau) * libm::expm1(-length_s / tau),
        };
        let sign = if whole.is_multiple_of(2) { 1.0 } else { -1.0 };
        let Drifted { magnetic, initial } = self.drifted[whole];
        Drifted { magnetic: magnetic + sign * warmed, initial: initial + sign * length_s }
    }
}
