//! The effect of switching modes every M samples on the angle of a gyro: a sawtooth and jumps.
//!
//! The magnetic drift Ω_m reverses its sign with every switch, so its angle rises and falls, the same in every record.
//! The residual of the filler at each switch is a jump, drawn independently each time. With independent J_j of variance
//! σ_J² = D²/2 + σ² after the samples M, 2M, …, a second difference is ΣJ over its later half minus ΣJ over its earlier
//! one. Over many intervals this is an angle random walk of N² = σ_J²/MT.

use crate::allan::estimator::{Difference, Estimator};
use crate::drift::magnetic::Magnetic;

/// A gyro that switches modes, for the first time after the first M samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switching {
    /// Switching interval M in samples, at least 1.
    pub interval: u64,
    /// Magnetic drift Ω_m, with its own sign in the first mode.
    pub magnetic: Magnetic,
    /// Amplitude D of the part D sin φ of a residual with random φ, ″.
    pub residual: f64,
    /// Standard deviation of the rest of the residual, ″.
    pub residual_noise: f64,
}

impl Switching {
    /// The same switching with times in samples of `sample_s` and rates per sample.
    pub fn per_sample(self, sample_s: f64) -> Switching {
        let Magnetic { amplitude, time_s, initial } = self.magnetic;
        let magnetic = Magnetic {
            amplitude: amplitude * sample_s,
            time_s: time_s / sample_s,
            initial: initial * sample_s,
        };
        Switching { magnetic, ..self }
    }

    /// Whether there is a magnetic drift.
    pub fn drifts(&self) -> bool {
        self.magnetic.amplitude != 0.0 || self.magnetic.initial != 0.0
    }

    /// The jumps left by its fillers; `None` where there are none.
    pub fn jumps(&self) -> Option<Jumps> {
        let variance = 0.5 * self.residual * self.residual + self.residual_noise * self.residual_noise;
        (variance > 0.0).then_some(Jumps { interval: self.interval, variance })
    }

    /// The range of the sawtooth of angles in a record, ″; times are in samples.
    ///
    /// Its extremes are at switches, at the ends and where the drift itself changes its sign.
    pub fn sawtooth_range(&self, samples: u64) -> f64 {
        if !self.drifts() {
            return 0.0;
        }
        let Switching { interval, magnetic, .. } = *self;
        let turn = -magnetic.time_s * libm::log1p(magnetic.initial / magnetic.amplitude);
        let turn = (magnetic.amplitude != 0.0 && turn > 0.0).then_some(libm::fmin(turn, samples as f64));
        let switches = (0..=samples / interval).map(|switch| (switch * interval) as f64);
        let angles = switches.chain([samples as f64]).chain(turn);
        let angles = angles.map(|k| magnetic.signed_integral(interval as f64, k));
        let [low, high] = angles.fold([0.0_f64; 2], |[low, high], angle| [low.min(angle), high.max(angle)]);
        high - low
    }
}

/// Independent jumps of the angle after the samples M, 2M, ….
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jumps {
    /// Switching interval M in samples, at least 1.
    pub interval: u64,
    /// Variance σ_J², ″².
    pub variance: f64,
}

impl Jumps {
    /// Coefficient N of the angle random walk that many jumps form, ″/√s.
    pub fn angle_random_walk(self, sample_s: f64) -> f64 {
        libm::sqrt(self.variance / (self.interval as f64 * sample_s))
    }

    /// Mean square of a difference at `m` with an arbitrary start, ″².
    pub fn variance(self, difference: Difference, m: u64) -> f64 {
        self.variance * difference.divisor() * m as f64 / self.interval as f64
    }

    /// Bound of that mean square for a difference with any given start, ″².
    pub fn largest_variance(self, difference: Difference, m: u64) -> f64 {
        self.variance * difference.divisor() * (m / self.interval + 1) as f64
    }

    /// The exact mean square of the differences at `m` that an estimator takes from a record of `samples` rates, ″².
    /// Each spans whole jumps, whose number depends on its start. It is 0 where the estimator has no difference.
    pub fn mean_square(self, estimator: Estimator, samples: u64, m: u64) -> f64 {
        let terms = estimator.terms(samples, m);
        let Some(last) = terms.checked_sub(1) else { return 0.0 };
        // Squares of the coefficients of the increments.
        let weights: &[u64] = match estimator.difference {
            Difference::Second => &[1, 1],
            Difference::Third => &[1, 4, 1],
        };
        let before = |sample: u64| sample.saturating_sub(1) / self.interval;
        let mut jumps = 0;
        for start in (0..=last).map(|k| k * estimator.stride(m)) {
            let mut from = before(start);
            for (span, weight) in (1..).zip(weights) {
                let to = before(start + span * m);
                jumps += weight * (to - from);
                from = to;
            }
        }
        self.variance * jumps as f64 / terms as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::estimator::Stride;

    const JUMPS: Jumps = Jumps { interval: 7, variance: 3.0 };

    /// Each difference as a combination of jumps.
    fn summed(jumps: Jumps, estimator: Estimator, samples: u64, m: u64) -> f64 {
        let terms = estimator.terms(samples, m);
        let mut sum = 0.0;
        for start in (0..terms).map(|k| k * estimator.stride(m)) {
            for after in (1..).map(|j| j * jumps.interval).take_while(|&after| after < samples) {
                let coefficients = (0..).zip(estimator.difference.coefficients());
                let is_later = |place: u64| start + place * m > after;
                let factor: f64 = coefficients.map(|(place, c)| if is_later(place) { *c } else { 0.0 }).sum();
                sum += factor * factor;
            }
        }
        jumps.variance * sum / terms as f64
    }

    #[test]
    fn the_mean_square_is_that_of_every_jump_in_every_difference() {
        let thinned = Estimator { stride: Stride::Part(4), ..Estimator::OVERLAPPING };
        for estimator in [Estimator::OVERLAPPING, Estimator::NON_OVERLAPPING, Estimator::HADAMARD, thinned] {
            for interval in [1, 2, 7, 100, 199] {
                let jumps = Jumps { interval, ..JUMPS };
                for m in [1, 2, 6, 7, 8, 14, 35, 66] {
                    let (found, expected) =
                        (jumps.mean_square(estimator, 200, m), summed(jumps, estimator, 200, m));
                    assert!(
                        (found - expected).abs() <= 1e-12 * expected,
                        "{estimator:?}, M = {interval}, m = {m}: {found}, not {expected}"
                    );
                    assert!(found <= jumps.largest_variance(estimator.difference, m));
                }
            }
            assert_eq!(JUMPS.mean_square(estimator, 200, 201), 0.0);
        }
    }

    #[test]
    fn over_many_intervals_jumps_are_an_angle_random_walk() {
        for (estimator, m) in
            [(Estimator::OVERLAPPING, 3), (Estimator::OVERLAPPING, 500), (Estimator::HADAMARD, 70)]
        {
            let samples = 1_000_000;
            let expected = JUMPS.variance(estimator.difference, m);
            let found = JUMPS.mean_square(estimator, samples, m);
            assert!((found / expected - 1.0).abs() < 2e-3, "{estimator:?}, m = {m}: {found}, not {expected}");
            let n = JUMPS.angle_random_walk(0.5);
            let walk = n * n * 0.5 * m as f64 * estimator.difference.divisor();
            assert!((walk / expected - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_range_of_the_sawtooth_is_that_of_all_its_angles() {
        for (amplitude, initial) in [(0.0, 2.0), (14.0, 0.0), (-14.0, 3.0), (14.0, -14.5), (-1.0, 2.0)] {
            for (interval, samples) in [(1, 50), (13, 400), (90, 400), (399, 400), (40, 400)] {
                let magnetic = Magnetic { amplitude, time_s: 120.0, initial };
                let switching = Switching { interval, magnetic, residual: 0.0, residual_noise: 0.0 };
                // Extremes between samples count too.
                let angles =
                    (0..=8 * samples).map(|k| magnetic.signed_integral(interval as f64, k as f64 / 8.0));
                let [low, high] =
                    angles.fold([0.0_f64; 2], |[low, high], angle| [low.min(angle), high.max(angle)]);
                let (found, expected) = (switching.sawtooth_range(samples), high - low);
                assert!(
                    (found / expected - 1.0).abs() < 1e-2 && found > 0.999_999 * expected,
                    "A = {amplitude}, Ω_m0 = {initial}, M = {interval}: {found}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn nothing_left_at_switches_is_no_jump() {
        let magnetic = Magnetic { amplitude: 0.0, time_s: 1.0, initial: 0.0 };
        let switching = Switching { interval: 5, magnetic, residual: 0.0, residual_noise: 0.0 };
        assert_eq!(
            (switching.jumps(), switching.drifts(), switching.sawtooth_range(100)),
            (None, false, 0.0)
        );
        let switching = Switching { residual: 2.0, residual_noise: 3.0, ..switching };
        assert_eq!(switching.jumps(), Some(Jumps { interval: 5, variance: 11.0 }));
    }
}
