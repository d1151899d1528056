//! The level below which the magnitude of a sine of random phase with normal noise stays.

use std::f64::consts::{FRAC_PI_2, SQRT_2};

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
}
