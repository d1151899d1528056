//! The exact mean and deviation of angles of runs, for the lowered parameters.
//!
//! The drift is summed interval by interval, the residual of a switch is that of the
//! [physical theory](crate::kinds::gap_fill::lower::physical_theory) of gap-fill, and phases are in `f64`.

use core::f64::consts::{LOG2_E, PI};
use std::sync::Arc;

use crate::drift::{End, Schedule};
use crate::key::Unrepresentable;
use crate::kinds::gap_fill::lower::fixed::{ANGLE_UNITS, SIGMA_UNITS};
use crate::kinds::gap_fill::lower::physical_theory::Switch;
use crate::kinds::relock::lower::{FixedRelock, MAX_LEFT, PILOT, method};
use crate::kinds::relock::{Compensation, Relock};
use crate::kinds::switched_run::lower::{Fixed, FixedRow, FixedTime, FixedTone};
use crate::kinds::switched_run::point::{Point as RunPoint, Relocking};
use crate::kinds::switched_run::{Angle, Angle as RunAngle, FirstMode, SwitchedRun, Timing};
use crate::motion::Frequency;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Trials;
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock::{self, WEIGHT_BITS};
use sagnac_kernel::relock_ticks::{self, Shape};
use sagnac_kernel::width::Width;
use sagnac_theory::drift::{signed_decay, signed_time, switches};

/// Mean and standard deviation of an angle, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunTheory {
    /// Mean over runs, signed.
    pub mean: f64,
    /// Standard deviation from run to run.
    pub deviation: f64,
    /// Bound of the deviation of a sampled mean or rms due to rounding in the kernel.
    pub rounding: f64,
}

impl RunTheory {
    /// √(mean² + deviation²), ″.
    pub fn rms(&self) -> f64 {
        libm::hypot(self.mean, self.deviation)
    }
}

impl Fixed {
    /// The theory of an angle of the study with index `place`; `None` where a compensated relock has no closed form.
    pub(crate) fn theory(&self, angle: RunAngle, place: usize) -> Option<RunTheory> {
        if self.relock.as_ref().is_some_and(|relock| !relock.exact) {
            return None;
        }
        self.about(angle, place)
    }

    /// The theory of an angle; for a compensated relock it is approximated by the first trials.
    fn about(&self, angle: RunAngle, place: usize) -> Option<RunTheory> {
        match angle {
            RunAngle::Largest => None,
            RunAngle::End if !self.drawn.is_empty() => {
                Some(averaged(self.drawn.iter().map(|end| self.within(end))))
            }
            RunAngle::End => {
                let [whole, last] = self.walk.map(square);
                let walk = (self.ends.len() - 1) as f64 * whole + last;
                self.ends.last().map(|row| self.at(row, walk))
            }
            RunAngle::At(_) => {
                place.checked_sub(2).and_then(|time| self.times.get(time)).map(|time| self.within(time))
            }
        }
    }

    /// Mean and deviation at a time within an interval.
    fn within(&self, time: &FixedTime) -> RunTheory {
        let walk = time.row.switches as f64 * square(self.walk[0]) + square(time.walk) + square(time.bridge);
        self.at(&time.row, walk)
    }

    /// Mean and deviation at the drift `row`, with the variance `walk` of the random walk, LSB².
    fn at(&self, row: &FixedRow, walk: f64) -> RunTheory {
        let switches = row.switches as f64;
        let constant = self.constant as f64 / libm::exp2(32.0);
        let deviations: f64 = row.deviations.iter().map(|&word| square(word.unsigned_abs())).sum();
        let mut variance = walk + deviations + switches * square(self.noise);
        let mut relocked = 0.0;
        let mut rounded = 0.0;
        if let Some(relock) = &self.relock {
            let deviation = relock.deviation / self.lsb_arcsec;
            let alike = switches * relock.alike / self.lsb_arcsec;
            variance += switches * deviation * deviation + alike * alike;
            relocked = switches * relock.mean / self.lsb_arcsec;
            // Each switch is rounded to the LSB once more.
            rounded = switches * (relock.rounding + 0.5 * self.lsb_arcsec);
        }
        for tone in &self.tones {
            let amplitude = f64::from(tone.amplitude) / ANGLE_UNITS;
            let times = if tone.each { switches } else { in_phase(tone.step, row.switches) };
            variance += 0.5 * amplitude * amplitude * times;
        }
        let [heated, spread, rounding] = match &self.warm_up {
            Some(warm_up) => {
                let [mean, variance] = warm_up.moments(row.time_s, row.held_s);
                let lsb = self.lsb_arcsec;
                [mean / lsb, variance / (lsb * lsb), warm_up.rounding()]
            }
            None => [0.0; 3],
        };
        // Where the first mode is drawn, the magnetic part has either sign.
        let magnetic = f64::from(row.magnetic) + heated;
        let (mean, drawn) = if self.mode { (0.0, magnetic) } else { (heated, 0.0) };
        RunTheory {
            mean: (f64::from(row.angle) + mean + relocked + switches * constant) * self.lsb_arcsec,
            deviation: libm::sqrt(variance + spread + drawn * drawn) * self.lsb_arcsec,
            rounding: 2.0 * self.lsb_arcsec + rounding + rounded,
        }
    }

    /// Bound of the rms of the difference between an angle of these words and that of the inputs, ″, with `of_switch` as
    /// that of a switch: each word is within half its unit of what it stands for.
    pub(crate) fn representation(&self, switches: f64, of_switch: f64) -> f64 {
        // Drift and its three deviations; walk, noise and sines of each switch; their common part.
        let once = 1.0 + 3.0 * 0.5 / SIGMA_UNITS;
        let each = libm::sqrt(switches) * 2.0 * 0.5 / SIGMA_UNITS + switches / libm::exp2(33.0);
        let sine = |tone: &FixedTone| {
            let times = if tone.each { libm::sqrt(switches) } else { switches };
            // The phase advances by up to 2^−33 turns more or less at each switch, which adds up over the run.
            let advance = if tone.each { 0.0 } else { PI * libm::exp2(-33.0) * switches * switches };
            (0.5 * times + advance * f64::from(tone.amplitude)) / ANGLE_UNITS
        };
        let sines: f64 = self.tones.iter().map(sine).sum();
        let ends = self.ends.iter().chain(self.drawn.iter().map(|end| &end.row));
        let largest = ends.map(|row| row.angle.unsigned_abs().max(row.magnetic.unsigned_abs())).max();
        // Inputs have 12 digits.
        let digits = 1e-11 * f64::from(largest.unwrap_or(0));
        (once + each + sines + digits) * self.lsb_arcsec + switches * of_switch
    }

    /// Approximate rms of an angle, LSB; where it is unknown, the largest one at the end of any interval.
    pub(crate) fn expected_rms(&self, angle: RunAngle, place: usize) -> f64 {
        match self.about(angle, place) {
            Some(theory) => theory.rms() / self.lsb_arcsec,
            None => {
                let walk = |row: &FixedRow| (row.switches + 1) as f64 * square(self.walk[0]);
                let heated = |row: &FixedRow| {
                    let usual = self.warm_up.as_ref().map(|warm_up| warm_up.usual(row.time_s, row.held_s));
                    usual.unwrap_or(0.0).abs() / self.lsb_arcsec
                };
                let unheated =
                    Fixed { warm_up: None, ends: vec![], times: vec![], drawn: vec![], ..self.clone() };
                let rms = |row: &FixedRow| unheated.at(row, walk(row)).rms() / self.lsb_arcsec + heated(row);
                self.ends.iter().map(rms).fold(0.0, f64::max)
            }
        }
    }
}

/// Mean and deviation over angles that are equally likely.
fn averaged(angles: impl ExactSizeIterator<Item = RunTheory>) -> RunTheory {
    let n = angles.len() as f64;
    let (mut mean, mut square, mut rounding) = (0.0, 0.0, 0.0_f64);
    for angle in angles {
        mean += angle.mean / n;
        square += angle.rms() * angle.rms() / n;
        rounding = rounding.max(angle.rounding);
    }
    RunTheory { mean, deviation: libm::sqrt((square - mean * mean).max(0.0)), rounding }
}

/// The square of a standard deviation in 2^−4 LSB, LSB².
fn square(word: u32) -> f64 {
    let sigma = f64::from(word) / SIGMA_UNITS;
    sigma * sigma
}

/// |Σ_{j<n} e^{2πi·j·step}|².
fn in_phase(step: u32, n: usize) -> f64 {
    let half = PI * f64::from(step) / libm::exp2(32.0);
    let n = n as f64;
    if step == 0 {
        return n * n;
    }
    let ratio = libm::sin(n * half) / libm::sin(half);
    ratio * ratio
}

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

/// The angle of the drift at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) time_s: f64,
    /// Number of switches before that time.
    pub(crate) switches: usize,
    /// Part that does not change its sign with the mode.
    pub(crate) non_magnetic: f64,
    /// Magnetic part, without the warm-up where its time constant is drawn.
    pub(crate) magnetic: f64,
    /// ∫ s dt with s = +1 in the first interval, s.
    pub(crate) held_s: f64,
    /// Effects of one standard deviation of A, Ω_m0 and Ω_nm.
    pub(crate) deviations: [f64; 3],
}

/// The drift of a point at the end of each interval, at each of the study's times, and at each end that is drawn, which
/// there are none of where the end is exact.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drift {
    pub(crate) ends: Vec<Row>,
    pub(crate) times: Vec<Row>,
    pub(crate) drawn: Vec<Row>,
}

impl Drift {
    pub(crate) fn new(point: &RunPoint, study: &SwitchedRun) -> Drift {
        let Schedule { interval_s, duration_s, end } = point.schedule;
        let intervals = point.intervals();
        let ends = (1..=intervals).map(|k| match end {
            // A run of whole intervals ends with the last one, whatever the rounding of interval times number.
            End::Exact if k == intervals => duration_s,
            _ => k as f64 * interval_s,
        });
        let ends = ends.enumerate().map(|(k, time_s)| row(point, study.first_mode, time_s, k));
        let at = |&time_s: &f64| row(point, study.first_mode, time_s, switches(interval_s, time_s) as usize);
        // The non-magnetic drift acts for the whole run time, whatever the phase of switching.
        let of_whole = |drawn: Row| {
            let whole = row(point, study.first_mode, duration_s, 0);
            let [magnetic, initial, _] = drawn.deviations;
            Row {
                non_magnetic: whole.non_magnetic,
                deviations: [magnetic, initial, whole.deviations[2]],
                ..drawn
            }
        };
        let drawn = match end {
            End::Any => point.schedule.ends().iter().map(at).map(of_whole).collect(),
            End::Exact => vec![],
        };
        Drift { ends: ends.collect(), times: study.times.iter().map(at).collect(), drawn }
    }
}

fn row(point: &RunPoint, first_mode: FirstMode, time_s: f64, switches: usize) -> Row {
    let drift = &point.drift;
    let interval_s = point.schedule.interval_s;
    let sign = if first_mode == FirstMode::Negative { -1.0 } else { 1.0 };
    let held = sign * signed_time(interval_s, time_s);
    // Without a warm-up, all of A is present from the start.
    let warmed = if drift.warm_up_s > 0.0 {
        held - sign * signed_decay(interval_s, drift.warm_up_s, time_s)
    } else {
        held
    };
    let drawn = drift.warm_up_spread > 0.0;
    let amplitude = if drawn { 0.0 } else { drift.magnetic };
    Row {
        time_s,
        switches,
        non_magnetic: drift.non_magnetic * time_s,
        magnetic: amplitude * warmed + drift.initial_magnetic * held,
        held_s: sign * held,
        deviations: [
            if drawn { 0.0 } else { drift.magnetic_spread * warmed },
            drift.initial_magnetic_spread * held,
            drift.non_magnetic_spread * time_s,
        ],
    }
}

/// Bound of all times of the kernel, in intervals: ∫ s dt, τ tanh(MT/2τ) (1 + e^{−t/τ}) and the rest of an interval are
/// at most one interval each, and their sum is doubled for headroom.
pub(crate) const INTERVALS: f64 = 6.0;

/// The warm-up in fixed point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WarmUp {
    interval_s: f64,
    time_s: f64,
    spread: f64,
    /// A in the first mode, ″/s, followed by its standard deviation.
    amplitude: f64,
    amplitude_spread: f64,
    /// Unit of the kernel's times, s.
    unit_s: f64,
    pub(crate) time_bits: u32,
    pub(crate) halving_bits: u32,
    lsb_arcsec: f64,
}

impl WarmUp {
    /// The warm-up of a point, where its time constant is drawn.
    pub(crate) fn new(point: &RunPoint, study: &SwitchedRun, lsb_arcsec: f64) -> Option<WarmUp> {
        let drift = &point.drift;
        let (interval_s, time_s) = (point.schedule.interval_s, drift.warm_up_s);
        let halvings = point.schedule.longest_s() / time_s * LOG2_E;
        let time_bits = libm::floor(4.0 - libm::log2(0.5 * INTERVALS * interval_s / time_s)).clamp(0.0, 29.0);
        let sign = if study.first_mode == FirstMode::Negative { -1.0 } else { 1.0 };
        (drift.warm_up_spread > 0.0).then(|| WarmUp {
            interval_s,
            time_s,
            spread: drift.warm_up_spread,
            amplitude: sign * drift.magnetic,
            amplitude_spread: drift.magnetic_spread,
            unit_s: time_s / libm::exp2(26.0 + time_bits),
            time_bits: time_bits as u32,
            halving_bits: libm::floor(30.0 - libm::log2(halvings)).clamp(10.0, 26.0) as u32,
            lsb_arcsec,
        })
    }

    /// Standard deviation of log2 τ, 2^−30.
    pub(crate) fn spread_word(&self) -> u32 {
        libm::round(self.spread * LOG2_E * libm::exp2(30.0)) as u32
    }

    /// Number of halvings until `time_s`; for a time so long that nothing is left, the largest number.
    pub(crate) fn halvings(&self, time_s: f64) -> u32 {
        let units = time_s / self.time_s * LOG2_E * libm::exp2(f64::from(self.halving_bits));
        libm::round(units).min(libm::exp2(31.0) - 1.0) as u32
    }

    pub(crate) fn interval_halvings(&self) -> u32 {
        self.halvings(self.interval_s)
    }

    /// A and its standard deviation, 2^−32 LSB per unit of time.
    pub(crate) fn heated(&self) -> [i32; 2] {
        let unit = self.unit_s / self.lsb_arcsec * libm::exp2(32.0);
        [self.amplitude, self.amplitude_spread].map(|rate| libm::round(rate * unit) as i32)
    }

    /// ∫ s dt at a row in the kernel's units.
    pub(crate) fn held(&self, row: &Row) -> i32 {
        libm::round(row.held_s / self.unit_s) as i32
    }

    /// Bound of the rounding of exponents and times, ″.
    pub(crate) fn rounding(&self) -> f64 {
        let rate = self.amplitude.abs() + REACH * self.amplitude_spread;
        let exponent = libm::exp2(-f64::from(self.halving_bits)) + libm::exp2(-25.0);
        rate * (self.time_s * exponent + 8.0 * self.unit_s)
    }

    /// Mean and variance at the time of a row, ″ and ″², where ∫ s dt is `held_s`.
    pub(crate) fn moments(&self, time_s: f64, held_s: f64) -> [f64; 2] {
        let (mut first, mut second, mut whole) = (0.0, 0.0, 0.0);
        // Normal weights at even steps integrate smooth functions to the last digit.
        for i in -STEPS..=STEPS {
            let z = f64::from(i) * REACH / f64::from(STEPS);
            let weight = libm::exp(-0.5 * z * z);
            let time = self.time_s * libm::exp(self.spread * z);
            let heating = held_s - signed_decay(self.interval_s, time, time_s);
            whole += weight;
            first += weight * heating;
            second += weight * heating * heating;
        }
        let (mean, square) = (first / whole, second / whole);
        let a = self.amplitude;
        let variance =
            a * a * (square - mean * mean).max(0.0) + self.amplitude_spread * self.amplitude_spread * square;
        [a * mean, variance]
    }

    /// The effect at the nominal time constant.
    pub(crate) fn usual(&self, time_s: f64, held_s: f64) -> f64 {
        self.amplitude * (held_s - signed_decay(self.interval_s, self.time_s, time_s))
    }
}

/// Steps on either side of the mean.
const STEPS: i32 = 200;

/// The relock of a point, for any filler.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FixedRelocking {
    fixed: FixedRelock,
    /// The relock as it would be if f0 were known exactly.
    right: FixedRelock,
    pub(crate) shape: Shape,
}

impl FixedRelocking {
    pub(crate) fn new(point: &RunPoint) -> Result<Option<FixedRelocking>, Unrepresentable> {
        let (Some(Relocking { relock, compensation }), Some(fill)) = (&point.relock, &point.fill) else {
            return Ok(None);
        };
        let fixed = FixedRelock::new(relock, fill.inputs.tick_s)?;
        let right = Relock { temperature_error: 0.0, ..relock.clone() };
        let right = FixedRelock::new(&right, fill.inputs.tick_s)?;
        let shape = Shape { ticks: relock.ticks as usize, method: method(*compensation) };
        Ok(Some(FixedRelocking { fixed, right, shape }))
    }

    /// Combines the relock with a filler whose weights on the ticks after the gap are `after`.
    pub(crate) fn with(&self, after: &[f64]) -> Coupled {
        let gain = |i: usize| 1.0 + after.get(i).copied().unwrap_or(0.0);
        let gains: Vec<f64> = (0..self.shape.ticks).map(gain).collect();
        let lsb = self.fixed.lsb_arcsec;
        let (faked_mean, faked_rms) = self.fixed.faked(&gains);
        let exact = self.shape.method == method(Compensation::None);
        let [mean, rms, alike] = if exact { [faked_mean, faked_rms, 0.0] } else { self.pilot(&gains) };
        let largest = gains.iter().fold(1.0, |most: f64, gain| most.max(gain.abs()));
        Coupled {
            words: self.fixed.words(self.shape),
            shape: self.shape,
            lsb_arcsec: lsb,
            rounding: self.fixed.rounding(&gains),
            gains,
            exact,
            mean,
            deviation: libm::sqrt((rms * rms - mean * mean - alike * alike).max(0.0)),
            alike,
            // A compensation that fails leaves about as much as no compensation.
            most_rms: rms.max(faked_rms),
            most: MAX_LEFT * lsb * largest,
        }
    }

    /// Mean and rms over the first trials of the relock kernel, and the standard deviation of the part caused by a
    /// wrong f0, which is the same at all switches of a run, ″.
    fn pilot(&self, gains: &[f64]) -> [f64; 3] {
        let [wrong, right] = [&self.fixed, &self.right].map(|fixed| self.launch(fixed, gains));
        let one = |launch: &Launch, fixed: &FixedRelock, first: u64| {
            let tallies = launch.tally(Width::PORTABLE, Trials { first, count: 1, histogram: false });
            tallies.first().map_or(0.0, |tally| tally.sum as f64) * fixed.lsb_arcsec
        };
        let (mut sum, mut squares, mut apart) = (0.0, 0.0, 0.0);
        for trial in 0..PILOT {
            let left = one(&wrong, &self.fixed, trial);
            let by_f0 = left - one(&right, &self.right, trial);
            sum += left;
            squares += left * left;
            apart += by_f0 * by_f0;
        }
        let n = PILOT as f64;
        [sum / n, libm::sqrt(squares / n), libm::sqrt(apart / n)]
    }

    fn launch(&self, fixed: &FixedRelock, gains: &[f64]) -> Launch {
        let weight: Vec<u32> = gains.iter().map(|gain| fixed_point(*gain, WEIGHT_BITS)).collect();
        let words = relock::Parameters {
            key: &[0, 0],
            relock: &fixed.words(self.shape),
            weight: &weight,
            bin_base: &[0],
        }
        .words();
        let shape = relock::Shape { ticks: self.shape, estimates: 1 };
        Launch::new(shape, words, Arc::new([])).expect("lowered words are those of the shape")
    }
}

fn fixed_point(x: f64, bits: u32) -> u32 {
    libm::round(x * libm::exp2(f64::from(bits))) as i32 as u32
}

/// A relock with a filler, ″.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coupled {
    pub(crate) words: Vec<u32>,
    pub(crate) shape: Shape,
    lsb_arcsec: f64,
    /// Effect of each tick, by itself and through the filler.
    gains: Vec<f64>,
    /// Whether mean and deviation of a switch are in closed form.
    pub(crate) exact: bool,
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
    /// Standard deviation of the part that is the same at all switches of a run.
    pub(crate) alike: f64,
    /// Bound of the deviation of the sum of a switch from exact arithmetic.
    pub(crate) rounding: f64,
    most_rms: f64,
    most: f64,
}

impl Coupled {
    /// Bound of the effect of `switches` switches, with `room` standard deviations.
    pub(crate) fn most(&self, switches: f64, room: f64) -> f64 {
        let alike = REACH * switches * self.alike;
        switches * self.mean.abs() + room * libm::sqrt(switches) * self.most_rms + alike + self.most
    }

    /// Weights of the ticks in LSB of a run, and their number of fractional bits.
    pub(crate) fn weights(&self, lsb_arcsec: f64) -> (Vec<u32>, u32) {
        let in_run = |gain: &f64| gain * self.lsb_arcsec / lsb_arcsec;
        let largest = self.gains.iter().map(in_run).fold(0.0, |most: f64, x| most.max(x.abs()));
        let bits = if largest > 0.0 { libm::floor(30.0 - libm::log2(largest)).clamp(1.0, 31.0) } else { 1.0 };
        let words = self.gains.iter().map(|gain| fixed_point(in_run(gain), bits as u32)).collect();
        (words, bits as u32)
    }

    /// The words that determine it in a run.
    pub(crate) fn identity(&self, lsb_arcsec: f64) -> Vec<u32> {
        let (weights, bits) = self.weights(lsb_arcsec);
        let shape = [relock_ticks::VERSION, self.shape.method as u32, self.shape.ticks as u32, bits];
        shape.into_iter().chain(self.words.clone()).chain(weights).collect()
    }
}
