//! Quantiles of the magnitude of errors: of a sine of random phase with normal noise, and of normally distributed errors in one
//! or two directions.

use std::f64::consts::{FRAC_PI_2, SQRT_2};

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::quadrature::means;

/// Halvings of the range of the level, which leave nine digits.
const STEPS: usize = 32;

/// The level below which |a sin θ + σ z| stays with a probability, in the unit of a and σ: θ is uniform, z standard normal,
/// and a one of the amplitudes, each given with its probability.
///
/// The distribution is averaged over θ by sixteen-point quadrature and its level found by bisection, to nine digits.
pub fn of_sine(amplitudes: &[(f64, f64)], sigma: f64, probability: f64) -> f64 {
    let largest = amplitudes.iter().map(|(amplitude, _)| amplitude.abs()).fold(0.0, f64::max);
    let share = |level: f64| {
        amplitudes.iter().map(|(amplitude, share)| share * within(level, *amplitude, sigma)).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, largest + 10.0 * sigma);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if share(middle) < probability { low = middle } else { high = middle }
    }
    high
}

/// The probability that |a sin θ + σ z| is within a level.
fn within(level: f64, amplitude: f64, sigma: f64) -> f64 {
    if sigma == 0.0 {
        return if level < amplitude { libm::asin(level / amplitude) / FRAC_PI_2 } else { 1.0 };
    }
    let erf = |x: f64| libm::erf(x / (SQRT_2 * sigma));
    let at = |phase: f64, within: &mut [f64]| {
        let sine = amplitude * libm::sin(phase);
        within[0] = 0.5 * (erf(level - sine) + erf(level + sine));
    };
    means(0.0, FRAC_PI_2, 1.0, 1, at)[0]
}

/// Intervals of Simpson's rule over the wider of two directions.
const INTERVALS: usize = 400;

/// Standard deviations beyond which nothing is left.
const REACH: f64 = 9.0;

/// Bisections of a level, after which it is known to rounding.
const BISECTIONS: usize = 60;

/// The normal distribution of an error in two directions. An error in one direction has neither mean nor variance in the
/// second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radial {
    /// Mean in each direction.
    pub mean: [f64; 2],
    /// Variance in the first direction, covariance, and variance in the second direction.
    pub covariance: [f64; 3],
}

impl Radial {
    /// Mean square of the size.
    pub fn mean_square(&self) -> f64 {
        let ([x, y], [xx, _, yy]) = (self.mean, self.covariance);
        x * x + y * y + xx + yy
    }

    /// Probability of a size up to `size`.
    pub fn below(&self, size: f64) -> f64 {
        let [[wide, wide_sd], [narrow, narrow_sd]] = self.axes();
        if wide_sd == 0.0 {
            return f64::from(u8::from(libm::hypot(wide, narrow) <= size));
        }
        let normal = Normal::standard();
        let of_narrow = |half: f64| match narrow_sd > 0.0 {
            true => normal.cdf((half - narrow) / narrow_sd) - normal.cdf((-half - narrow) / narrow_sd),
            false => f64::from(u8::from(narrow.abs() <= half)),
        };
        // Over the angle, half chords have no singularity.
        let angle = |x: f64| libm::asin((x / size).clamp(-1.0, 1.0));
        let (from, to) = (angle(wide - REACH * wide_sd), angle(wide + REACH * wide_sd));
        let step = (to - from) / INTERVALS as f64;
        let density = |place: usize| {
            let at = from + step * place as f64;
            let (x, half) = (size * libm::sin(at), size * libm::cos(at));
            normal.pdf((x - wide) / wide_sd) / wide_sd * of_narrow(half) * half
        };
        let weight = |place: usize| match place {
            0 | INTERVALS => 1.0,
            place if place % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=INTERVALS).map(|place| weight(place) * density(place)).sum();
        sum * step / 3.0
    }

    /// Mean and standard deviation along the wider principal axis, and along the other.
    fn axes(&self) -> [[f64; 2]; 2] {
        let ([x, y], [xx, xy, yy]) = (self.mean, self.covariance);
        let angle = 0.5 * libm::atan2(2.0 * xy, xx - yy);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let (middle, half) = (0.5 * (xx + yy), libm::hypot(0.5 * (xx - yy), xy));
        let sd = |variance: f64| libm::sqrt(variance.max(0.0));
        [[cos * x + sin * y, sd(middle + half)], [cos * y - sin * x, sd(middle - half)]]
    }
}

/// The size that a fraction `level` of errors stay below, which are equally likely from each of some distributions. 0 for
/// no distribution.
pub fn of_radial_error(distributions: &[Radial], level: f64) -> f64 {
    let reach = |one: &Radial| {
        let [xx, _, yy] = one.covariance;
        libm::hypot(one.mean[0], one.mean[1]) + REACH * libm::sqrt(xx + yy)
    };
    let (mut low, mut high) = (0.0, distributions.iter().map(reach).fold(0.0, f64::max));
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let below: f64 = distributions.iter().map(|one| one.below(middle)).sum();
        if below < level * distributions.len() as f64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_alone_has_its_three_standard_deviations_and_a_sine_alone_nearly_its_amplitude() {
        let noise = of_sine(&[(0.0, 1.0)], 2.0, 0.9973);
        assert!((noise - 2.0 * 2.999_976_993).abs() < 1e-6, "{noise}");
        let sine = of_sine(&[(2.0, 1.0)], 0.0, 0.9973);
        assert!((sine - 2.0 * libm::sin(0.9973 * FRAC_PI_2)).abs() < 1e-8, "{sine}");
    }

    /// Counted over a fine grid of phases and of quantiles of the noise, which shares nothing with the quadrature.
    #[test]
    fn a_sine_with_noise_has_the_level_that_counting_gives() {
        for (amplitude, sigma) in [(1.0, 0.05), (1.0, 0.5), (1.0, 3.0)] {
            let level = of_sine(&[(amplitude, 0.5), (0.5 * amplitude, 0.5)], sigma, 0.9973);
            let (phases, parts) = (4000, 4000);
            let noise: Vec<f64> = (0..parts)
                .map(|part| (f64::from(part) + 0.5) / f64::from(parts))
                .map(|p| sigma * -SQRT_2 * statrs::function::erf::erfc_inv(2.0 * p))
                .collect();
            let mut inside = 0_u64;
            for phase in 0..phases {
                let sine = libm::sin(std::f64::consts::TAU * (f64::from(phase) + 0.5) / f64::from(phases));
                for amplitude in [amplitude, 0.5 * amplitude] {
                    inside += noise.iter().filter(|z| (amplitude * sine + **z).abs() <= level).count() as u64;
                }
            }
            let share = inside as f64 / (2.0 * f64::from(phases) * f64::from(parts));
            assert!((share - 0.9973).abs() < 5e-5, "{amplitude} {sigma}: {share} within {level}");
        }
    }

    fn level(mean: [f64; 2], covariance: [f64; 3], level: f64) -> f64 {
        of_radial_error(&[Radial { mean, covariance }], level)
    }

    #[test]
    fn levels_are_those_of_the_normal_and_the_rayleigh_distribution() {
        let near = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found}, not {expected}");
        };
        near(level([0.0; 2], [4.0, 0.0, 0.0], 0.95), 2.0 * 1.959_963_985);
        near(level([0.0; 2], [0.0, 0.0, 4.0], 0.5), 2.0 * 0.674_489_750);
        near(level([0.0; 2], [9.0, 0.0, 9.0], 0.95), 3.0 * 2.447_746_831);
        near(level([0.0; 2], [9.0, 0.0, 9.0], 0.5), 3.0 * 1.177_410_02);
        // Fully correlated: one direction of the variance of both.
        near(level([0.0; 2], [1.0, 1.0, 1.0], 0.95), libm::sqrt(2.0) * 1.959_963_985);
        // Far from zero against its spread, the size is the component along the mean.
        near(level([300.0, 400.0], [0.01, 0.0, 0.01], 0.5), 500.000_01);
        near(level([3.0, 0.0], [0.0; 3], 0.5), 3.0);
        // Of two equally likely distributions, the wider one has nearly all of the tail.
        let two = [1.0, 100.0].map(|sd| Radial { mean: [0.0; 2], covariance: [sd * sd, 0.0, 0.0] });
        near(of_radial_error(&two, 0.95), 100.0 * 1.644_853_627);
    }
}
