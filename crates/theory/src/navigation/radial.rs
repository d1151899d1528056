//! Levels of the size of normally distributed errors in one or two directions.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

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
pub fn quantile(distributions: &[Radial], level: f64) -> f64 {
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

    fn level(mean: [f64; 2], covariance: [f64; 3], level: f64) -> f64 {
        quantile(&[Radial { mean, covariance }], level)
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
        near(quantile(&two, 0.95), 100.0 * 1.644_853_627);
    }
}
