//! Stationary motion as spectral lines: sines of random phase whose powers add up to the integral over its spectrum.
//!
//! From the lines follow the [`structure`] of their angles by lag, in twice the precision of `f64` because sums over it
//! cancel, and [`rows`](crate::minimum_variance) of ticks whose products are the covariance.
//!
//! [`Double`] is a number of twice the precision, for sums whose terms cancel: the unevaluated sum of two `f64`. Sums and
//! products are those of Dekker (1971) and Knuth, without fused operations, so the bits are the same on every machine. A sum is
//! wrong by at most 2^−103 of its larger term, a product by 2^−102 of itself, unless numbers underflow.

use core::ops::{Add, Mul, Sub};

use crate::gap::tick_amplitude;

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

/// Half the mean square by which angles differ, ″², at distances of 0 … `lags` − 1 ticks: their variance less their
/// covariance, without the cancellation of the two at low frequencies.
///
/// Rounding moves the frequency of a line by 1e-16 of itself, and the structure of that line is then exact to 28 digits.
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

/// Covariance of angles, ″², at distances of 0 … `lags` − 1 ticks, right to rounding of their variance.
#[cfg(test)]
pub fn covariance(lines: &[TickLine], lags: usize) -> Vec<f64> {
    let variance: f64 = lines.iter().map(|line| line.rms * line.rms).sum();
    structure(lines, lags).into_iter().map(|part| variance - part.value()).collect()
}

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Double {
    hi: f64,
    lo: f64,
}

/// 2^27 + 1, which splits the 53 bits of an `f64` into halves.
const SPLIT: f64 = 134_217_729.0;

impl Double {
    /// The exact product of two numbers below 2^996 in magnitude.
    pub fn product(a: f64, b: f64) -> Double {
        let hi = a * b;
        let ([a1, a2], [b1, b2]) = (halves(a), halves(b));
        Double { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    /// The nearest `f64`.
    pub fn value(self) -> f64 {
        self.hi
    }

    /// hi + lo for |hi| ≥ |lo|.
    fn of_sorted(hi: f64, lo: f64) -> Double {
        let sum = hi + lo;
        Double { hi: sum, lo: lo - (sum - hi) }
    }
}

/// The upper and lower half of the bits of a number.
fn halves(x: f64) -> [f64; 2] {
    let scaled = SPLIT * x;
    let upper = scaled - (scaled - x);
    [upper, x - upper]
}

impl From<f64> for Double {
    fn from(hi: f64) -> Double {
        Double { hi, lo: 0.0 }
    }
}

impl From<i128> for Double {
    /// The nearest number; exact up to 2^106.
    fn from(x: i128) -> Double {
        let hi = x as f64;
        Double { hi, lo: (x - hi as i128) as f64 }
    }
}

impl Add for Double {
    type Output = Double;

    fn add(self, other: Double) -> Double {
        let sum = self.hi + other.hi;
        let part = sum - self.hi;
        let lost = (self.hi - (sum - part)) + (other.hi - part);
        Double::of_sorted(sum, lost + self.lo + other.lo)
    }
}

impl Sub for Double {
    type Output = Double;

    fn sub(self, other: Double) -> Double {
        self + Double { hi: -other.hi, lo: -other.lo }
    }
}

impl Mul for Double {
    type Output = Double;

    fn mul(self, other: Double) -> Double {
        let Double { hi, lo } = Double::product(self.hi, other.hi);
        Double::of_sorted(hi, lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_structure_of_a_line_is_one_less_a_cosine() {
        for nu_t in [1e-7, 0.013, 0.1, 0.25, 0.499, 0.5, 1.0, 3.7] {
            let line = TickLine { nu_t, rms: 3.0 };
            for (lag, found) in structure(&[line], 200).into_iter().enumerate() {
                let expected = 9.0 * (1.0 - libm::cos(core::f64::consts::TAU * nu_t * lag as f64));
                assert!((found.value() - expected).abs() < 1e-10, "{nu_t}, {lag}: {found:?}, not {expected}");
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
        // A second difference with the weights 1, −2cos 2πνT, 1 takes a sine away. The difference of two of them has weights
        // that add up to 0, so that its variance is −Σ r_l D(l) with the autocorrelation r of the weights.
        let d = structure(&[TickLine { nu_t: 0.037, rms: 1.0 }], 4);
        let [one, two] = [1.0, 2.0].map(Double::from);
        let middle = one + two - two * d[1];
        let outer = [two * (two * middle + middle * middle), two * two * middle];
        let variance = outer[0] * d[1] - outer[1] * d[2] + two * d[3];
        assert!(variance.value().abs() < 1e-29, "{variance:?}");
    }

    #[test]
    fn sums_and_products_keep_thirty_digits() {
        // (1 + 2^−40)(1 − 2^−40) = 1 − 2^−80.
        let tiny = libm::exp2(-40.0);
        let product = Double::product(1.0 + tiny, 1.0 - tiny);
        assert_eq!((product - Double::from(1.0)).value(), -libm::exp2(-80.0));
        let third = Double::from(1.0 / 3.0);
        let rest = Double::from(1.0) - third * Double::from(3.0);
        // The f64 nearest to a third is too small by 2^−54/3.
        assert_eq!(rest.value(), libm::exp2(-54.0));
        let large = (1_i128 << 100) + 1;
        assert_eq!((Double::from(large) - Double::from(1_i128 << 100)).value(), 1.0);
        let square = (third + Double::from(tiny)) * (third - Double::from(tiny));
        let expected = third * third - Double::from(tiny) * Double::from(tiny);
        assert!((square - expected).value().abs() < libm::exp2(-102.0));
    }
}
