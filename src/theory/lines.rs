//! Stationary motion as spectral lines: sines of random phase whose powers add up to the integral over its spectrum.
//!
//! From the lines follow the covariance of ticks by lag, in twice the precision of `f64` because sums over it cancel, and
//! [`rows`](crate::theory::rows) whose products are that covariance.

use crate::theory::double::Double;
use crate::theory::gap::tick_amplitude;

/// A rate that is a sine of random phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Mean square of the rate, (″/s)².
    pub power: f64,
}

/// What a line is at the ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickLine {
    /// Frequency, turns per tick.
    pub nu_t: f64,
    /// Standard deviation of the angle, ″, with a sign.
    pub rms: f64,
}

/// The angles through which a motion turns in each tick.
pub fn of_ticks(lines: &[Line], tick_s: f64) -> Vec<TickLine> {
    let of = |line: &Line| {
        let nu_t = line.frequency_hz * tick_s;
        TickLine { nu_t, rms: libm::sqrt(line.power) * tick_amplitude(tick_s, nu_t) }
    };
    lines.iter().map(of).collect()
}

/// The angles of a motion at the ends of the ticks.
pub fn of_angles(lines: &[Line], tick_s: f64) -> Vec<TickLine> {
    let of = |line: &Line| {
        let turns = core::f64::consts::TAU * line.frequency_hz;
        TickLine { nu_t: line.frequency_hz * tick_s, rms: libm::sqrt(line.power) / turns }
    };
    lines.iter().map(of).collect()
}

/// Covariance of angles, ″², at distances of 0 … `lags` − 1 ticks.
///
/// cos 2πν·lag·T follows from its second difference, −4 sin²πνT times itself. Rounding moves the frequency of a line by
/// 1e-16 of itself, and the covariance of that line is then exact to 28 digits.
pub fn covariance(lines: &[TickLine], lags: usize) -> Vec<Double> {
    let mut sums = vec![Double::default(); lags];
    for line in lines {
        let from_whole = line.nu_t - libm::round(line.nu_t);
        let chord = 2.0 * libm::sin(core::f64::consts::PI * from_whole);
        let curvature = Double::product(chord, chord);
        let mut now = Double::product(line.rms, line.rms);
        // The change from lag −1 to 0, which is minus that from 0 to 1: half of the second difference.
        let mut change = now * curvature * Double::from(0.5);
        for sum in &mut sums {
            *sum = *sum + now;
            change = change - now * curvature;
            now = now + change;
        }
    }
    sums
}

/// Half the mean square by which angles differ, ″², at distances of 0 … `lags` − 1 ticks: their variance less their
/// covariance, without the cancellation of the two at low frequencies.
pub fn structure(lines: &[TickLine], lags: usize) -> Vec<Double> {
    let mut sums = vec![Double::default(); lags];
    for line in lines {
        let from_whole = line.nu_t - libm::round(line.nu_t);
        let chord = 2.0 * libm::sin(core::f64::consts::PI * from_whole);
        let curvature = Double::product(chord, chord);
        let variance = Double::product(line.rms, line.rms);
        // 1 − cos 2πν·lag·T, whose second difference is 4 sin²πνT (1 − itself).
        let mut now = Double::default();
        let mut change = Double::default() - curvature * Double::from(0.5);
        for sum in &mut sums {
            *sum = *sum + variance * now;
            change = change + curvature * (Double::from(1.0) - now);
            now = now + change;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_covariance_of_a_line_is_a_cosine() {
        for nu_t in [1e-7, 0.013, 0.1, 0.25, 0.499, 0.5, 1.0, 3.7] {
            let line = TickLine { nu_t, rms: 3.0 };
            for (lag, found) in covariance(&[line], 200).into_iter().enumerate() {
                let expected = 9.0 * libm::cos(core::f64::consts::TAU * nu_t * lag as f64);
                assert!((found.value() - expected).abs() < 1e-10, "{nu_t}, {lag}: {found:?}, not {expected}");
            }
        }
    }

    #[test]
    fn the_structure_is_the_variance_less_the_covariance_even_where_these_are_equal_to_rounding() {
        for nu_t in [0.013, 0.1, 0.25, 0.499, 1.3] {
            let lines = [TickLine { nu_t, rms: 3.0 }];
            let all = covariance(&lines, 100);
            for (lag, found) in structure(&lines, 100).into_iter().enumerate() {
                let expected = (all[0] - all[lag]).value();
                assert!((found.value() - expected).abs() < 1e-13, "{nu_t}, {lag}: {found:?}, not {expected}");
            }
        }
        let slow = structure(&[TickLine { nu_t: 5e-12, rms: 1e10 }], 10);
        for (lag, found) in slow.into_iter().enumerate() {
            let half_turn = core::f64::consts::PI * 5e-12 * lag as f64;
            let expected = 2e20 * half_turn * half_turn;
            assert!((found.value() - expected).abs() <= 1e-14 * expected, "{lag}: {found:?}, not {expected}");
        }
    }

    #[test]
    fn sums_that_vanish_for_every_line_cancel_to_28_digits() {
        // The second difference less −4 sin²πνT times the middle vanishes at any phase. Without the rounding of the last
        // factor it does so exactly; with it, 1e-16 of the rms is left.
        let line = TickLine { nu_t: 0.037, rms: 1.0 };
        let k = covariance(&[line], 5);
        let two_cosines = k[1] * Double::from(2.0);
        // Variance of θ₁ − 2cos(ω) θ₀ + θ₋₁, by products of covariances with the same 2cos ω.
        let variance = Double::from(2.0) * (k[0] + k[2]) - Double::from(2.0) * two_cosines * two_cosines
            + two_cosines * two_cosines * k[0];
        assert!(variance.value().abs() < 1e-29, "{variance:?}");
    }
}
