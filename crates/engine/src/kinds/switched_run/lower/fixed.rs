//! A run in fixed point: the words of the kernel before they are arranged.

use crate::drift::End;
use crate::kinds::gap_fill::lower::fixed::{ANGLE_UNITS, SIGMA_UNITS, long_words};
use crate::kinds::gap_fill::lower::residual::Residual;
use crate::kinds::switched_run::lower::drift::{Drift, Row};
use crate::kinds::switched_run::lower::relocking::Coupled;
use crate::kinds::switched_run::lower::warm_up::{INTERVALS, WarmUp};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::{FirstMode, SwitchedRun, Timing};
use crate::motion::Frequency;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::normal::REACH;

/// Number of standard deviations of the sum of many switches and the random walk for which there is room; not one run
/// in 10^27 exceeds it.
const ROOM: f64 = 16.0;

/// log2 of the finest unit of 2^−24 ″.
const FINEST: i32 = 24;

/// The runs of a point with one filler, with angles in LSB.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fixed {
    pub(crate) lsb_arcsec: f64,
    /// Drift at the end of each interval.
    pub(crate) ends: Vec<FixedRow>,
    pub(crate) times: Vec<FixedTime>,
    /// Ends that are equally likely; none where the end is that of the last interval.
    pub(crate) drawn: Vec<FixedTime>,
    /// Standard deviation of the random walk over an interval and over the last one, 2^−4 LSB.
    pub(crate) walk: [u32; 2],
    /// Standard deviation of the normal part of a residual, 2^−4 LSB.
    pub(crate) noise: u32,
    /// Part common to all residuals, 2^−32 LSB.
    pub(crate) constant: i64,
    pub(crate) tones: Vec<FixedTone>,
    /// Whether the first mode is drawn.
    pub(crate) mode: bool,
    /// Warm-up, where its time constant is drawn.
    pub(crate) warm_up: Option<WarmUp>,
    pub(crate) relock: Option<Coupled>,
}

/// The drift at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedRow {
    pub(crate) switches: usize,
    /// The whole drift, or its non-magnetic part where the first mode is drawn.
    pub(crate) angle: i32,
    /// The magnetic part where the first mode is drawn.
    pub(crate) magnetic: i32,
    /// Effects of one standard deviation of A, Ω_m0 and Ω_nm, 2^−4 LSB.
    pub(crate) deviations: [i32; 3],
    /// ∫ s dt and halvings as words, for a warm-up whose time constant is drawn; then the time, s, and the integral as
    /// numbers.
    pub(crate) heating: [i32; 2],
    pub(crate) time_s: f64,
    pub(crate) held_s: f64,
}

/// A time within an interval, with the parts of its random walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedTime {
    pub(crate) row: FixedRow,
    /// Standard deviation of the random walk up to the time, 2^−4 LSB.
    pub(crate) walk: u32,
    pub(crate) bridge: u32,
}

/// The part of the residual from a tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedTone {
    /// Amplitude, 2^−2 LSB.
    pub(crate) amplitude: u32,
    /// Phase advance from switch to switch, 2^−32 turns.
    pub(crate) step: u32,
    /// Whether its phase is drawn at each switch instead of once for the run.
    pub(crate) each: bool,
}

impl Fixed {
    pub(crate) fn new(
        drift: &Drift,
        residual: &Residual,
        relock: Option<Coupled>,
        point: &RunPoint,
        study: &SwitchedRun,
    ) -> Fixed {
        let mode = study.first_mode == FirstMode::Random;
        let lsb_arcsec = lsb(drift, residual, relock.as_ref(), point, study.timing);
        let sigma = |arcsec: f64| libm::round(arcsec / lsb_arcsec * SIGMA_UNITS) as u32;
        let warm_up = WarmUp::of(point, study, lsb_arcsec);
        let row = |row: &Row| fixed_row(row, mode, lsb_arcsec, warm_up.as_ref());
        let walk = point.drift.angle_random_walk;
        // The last interval, and its length.
        let last = drift.ends.len() - 1;
        let last_s = match point.schedule.end {
            End::Any => point.schedule.interval_s,
            End::Exact => point.schedule.duration_s - last as f64 * point.schedule.interval_s,
        };
        let time = |row_at: &Row| {
            // Elapsed time of the interval.
            let from = row_at.switches as f64 * point.schedule.interval_s;
            let length = if row_at.switches < last { point.schedule.interval_s } else { last_s };
            let part = ((row_at.time_s - from) / length).clamp(0.0, 1.0);
            let whole = walk * libm::sqrt(length);
            FixedTime {
                row: row(row_at),
                walk: sigma(whole * part),
                bridge: sigma(whole * libm::sqrt(part * (1.0 - part))),
            }
        };
        let tones = residual.tones.iter().map(|tone| FixedTone {
            amplitude: libm::round(tone.amplitude_arcsec / lsb_arcsec * ANGLE_UNITS) as u32,
            step: step(point, tone.tone, study.timing),
            each: study.timing == Timing::Random,
        });
        Fixed {
            lsb_arcsec,
            ends: drift.ends.iter().map(row).collect(),
            times: drift.times.iter().map(time).collect(),
            drawn: drift.drawn.iter().map(time).collect(),
            walk: [point.schedule.interval_s, last_s].map(|length| sigma(walk * libm::sqrt(length))),
            noise: sigma(libm::sqrt(residual.variance_arcsec2)),
            constant: libm::round(residual.constant_arcsec / lsb_arcsec * libm::exp2(32.0)) as i64,
            tones: tones.collect(),
            mode,
            warm_up,
            relock,
        }
    }

    /// The words that determine all runs.
    pub(crate) fn words(&self) -> Vec<u32> {
        let tones = self.tones.iter().flat_map(|tone| [tone.amplitude, tone.step, u32::from(tone.each)]);
        let fixed = [self.walk[0], self.walk[1], self.noise, u32::from(self.mode)];
        let words = fixed.into_iter().chain(long_words(self.constant)).chain(tones);
        let warm_up = self.warm_up.iter().flat_map(|warm_up| {
            let [a, spread] = warm_up.heated().map(|word| word as u32);
            let bits = [warm_up.halving_bits, warm_up.time_bits];
            [warm_up.spread_word(), warm_up.interval_halvings(), a, spread, bits[0], bits[1]]
        });
        let relock = self.relock.iter().flat_map(|relock| relock.identity(self.lsb_arcsec));
        let drawn = self.drawn.iter().flat_map(FixedTime::words);
        words
            .chain(warm_up)
            .chain(relock)
            .chain(self.ends.iter().flat_map(FixedRow::words))
            .chain(drawn)
            .collect()
    }

    /// The further words that determine one of the study's angles.
    pub(crate) fn time_words(&self, place: usize) -> Vec<u32> {
        let time = place.checked_sub(2).and_then(|time| self.times.get(time));
        time.map(|time| time.words().collect()).unwrap_or_default()
    }
}

impl FixedTime {
    /// The words that determine the angle at the time.
    fn words(&self) -> impl Iterator<Item = u32> {
        self.row.words().into_iter().chain([self.row.switches as u32, self.walk, self.bridge])
    }
}

impl FixedRow {
    /// The drift as words of the kernel.
    pub(crate) fn words(&self) -> [u32; 7] {
        let ([a, b, c], [d, e]) = (self.deviations, self.heating);
        [self.angle, self.magnetic, a, b, c, d, e].map(|word| word as u32)
    }
}

fn fixed_row(row: &Row, mode: bool, lsb_arcsec: f64, warm_up: Option<&WarmUp>) -> FixedRow {
    let angle = |arcsec: f64| libm::round(arcsec / lsb_arcsec) as i32;
    let (angle, magnetic) = if mode {
        (angle(row.non_magnetic), angle(row.magnetic))
    } else {
        (angle(row.non_magnetic + row.magnetic), 0)
    };
    let deviations = row.deviations.map(|deviation| libm::round(deviation / lsb_arcsec * SIGMA_UNITS) as i32);
    let heating = warm_up.map_or([0, 0], |w| [w.held(row), w.halvings(row.time_s) as i32]);
    let (switches, time_s, held_s) = (row.switches, row.time_s, row.held_s);
    FixedRow { switches, angle, magnetic, deviations, heating, time_s, held_s }
}

/// The unit of angle, ″: a power of two that leaves room for every run.
fn lsb(
    drift: &Drift,
    residual: &Residual,
    relock: Option<&Coupled>,
    point: &RunPoint,
    timing: Timing,
) -> f64 {
    let squares = residual.tones.iter().map(|tone| 0.5 * tone.amplitude_arcsec * tone.amplitude_arcsec);
    let each = residual.variance_arcsec2 + squares.sum::<f64>();
    let amplitudes: f64 = residual.tones.iter().map(|tone| tone.amplitude_arcsec).sum();
    let walk = point.drift.angle_random_walk;
    // The parts of the warm-up are larger than their sum.
    let warm_up = if point.drift.warm_up_spread > 0.0 {
        let rate = point.drift.magnetic.abs() + REACH * point.drift.magnetic_spread;
        INTERVALS * point.schedule.interval_s * rate
    } else {
        0.0
    };
    let most = |row: &Row| {
        // Includes the switch that follows.
        let switches = row.switches as f64 + 1.0;
        let added = libm::sqrt(switches * each + walk * walk * row.time_s);
        // Residuals of tones that are in phase with each other add up in full.
        let in_phase = if timing == Timing::Random { 0.0 } else { switches * amplitudes };
        row.non_magnetic.abs()
            + row.magnetic.abs()
            + REACH * row.deviations.iter().map(|deviation| deviation.abs()).sum::<f64>()
            + switches * residual.constant_arcsec.abs()
            + ROOM * added
            + in_phase
            + amplitudes
            + warm_up
            + relock.map_or(0.0, |relock| relock.most(switches, ROOM))
    };
    let bound = drift.ends.iter().map(most).fold(0.0, f64::max);
    // A few units are reserved for rounding.
    let bits = libm::floor(libm::log2((LIMIT - 16) as f64 / bound));
    libm::exp2(-bits.min(f64::from(FINEST)))
}

/// The phase advance of a tone from switch to switch, 2^−32 turns. A residual without a motion has the same phase at
/// every switch.
fn step(point: &RunPoint, tone: usize, timing: Timing) -> u32 {
    let tones = point.fill.as_ref().map_or(&[][..], |fill| &fill.inputs.motion.tones);
    match tones.get(tone).map(|tone| tone.frequency) {
        Some(Frequency::Fixed(frequency_hz)) if timing == Timing::Periodic => {
            let turns = frequency_hz * point.schedule.interval_s;
            // A fraction that rounds up to a whole turn becomes 0.
            libm::round((turns - libm::floor(turns)) * libm::exp2(32.0)) as u64 as u32
        }
        _ => 0,
    }
}
