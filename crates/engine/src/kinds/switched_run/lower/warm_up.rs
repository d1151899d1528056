//! A warm-up whose time constant differs from run to run: its parameters, and its average effect.

use core::f64::consts::LOG2_E;

use crate::kinds::switched_run::FirstMode;
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::lower::drift::Row;
use crate::kinds::switched_run::point::Point as RunPoint;
use sagnac_kernel::normal::REACH;
use sagnac_theory::drift::magnetic::signed_decay;

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
    pub(crate) fn of(point: &RunPoint, study: &SwitchedRun, lsb_arcsec: f64) -> Option<WarmUp> {
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
