//! The covariance of a recorded motion, estimated from its ticks.

/// Covariance of `ticks` at lags 0 … `lags` − 1, in the square of their unit. The mean is removed, and the sum over all
/// pairs is divided by the number of ticks instead of pairs.
///
/// For N ticks this biased estimate shrinks the covariance at lag l by the factor 1 − l/N, and all lags by the variance
/// of the mean. In return the covariance matrix is positive semidefinite, as a minimum-variance filler needs; that of
/// the unbiased estimate need not be. The covariance is 0 at lags from N on, and everywhere without ticks. The
/// computation takes N · `lags` steps.
///
/// ```
/// # use sagnac::theory::autocovariance::autocovariance;
/// assert_eq!(autocovariance(&[1.0, 2.0, 3.0, 4.0], 2), [1.25, 0.3125]);
/// ```
pub fn autocovariance(ticks: &[f64], lags: usize) -> Vec<f64> {
    let count = ticks.len().max(1) as f64;
    let mean = ticks.iter().sum::<f64>() / count;
    let deviations: Vec<f64> = ticks.iter().map(|x| x - mean).collect();
    let at = |lag: usize| {
        let later = deviations.get(lag..).unwrap_or_default();
        deviations.iter().zip(later).map(|(a, b)| a * b).sum::<f64>() / count
    };
    (0..lags).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::minimum_variance::{Band, minimum_variance_weights};

    #[test]
    fn small_cases_are_those_by_hand() {
        // Deviations −1.5, −0.5, 0.5, 1.5: Σ of products 5, 1.25, −1.5, −2.25, over 4.
        assert_eq!(autocovariance(&[1.0, 2.0, 3.0, 4.0], 6), [1.25, 0.3125, -0.375, -0.5625, 0.0, 0.0]);
        assert_eq!(autocovariance(&[7.0], 2), [0.0, 0.0]);
        assert_eq!(autocovariance(&[], 2), [0.0, 0.0]);
    }

    #[test]
    fn a_long_tone_has_the_covariance_of_its_closed_form() {
        // 20 Hz at ticks of 5 ms is ten ticks per turn, so 100 000 ticks hold whole turns only.
        let exact = Band { low_hz: 20.0, high_hz: 20.0 }.covariance(12000.0, 0.005, 40);
        let peak = libm::sqrt(2.0 * exact[0]);
        let tick = |k: usize| 3.0 + peak * libm::sin(core::f64::consts::TAU * (k as f64 / 10.0 + 0.123));
        let found = autocovariance(&(0..100_000).map(tick).collect::<Vec<f64>>(), 40);
        for (lag, (found, exact_at)) in found.iter().zip(&exact).enumerate() {
            // The bias, plus the error from the missing pairs of a turn.
            let bound = (lag + 10) as f64 / 100_000.0 * exact[0];
            assert!((found - exact_at).abs() <= bound, "lag {lag}: {found}, not {exact_at} within {bound}");
        }
    }

    #[test]
    fn the_matrix_is_positive_definite_even_for_few_ticks() {
        // For these ticks the unbiased estimate at the last lag, the product of the two ends, exceeds the variance.
        let ticks = [5.0, -1.0, 0.5, -2.0, 0.25, -1.5, 1.0, -3.0, 5.0];
        let covariance = autocovariance(&ticks, 9);
        assert!(9.0 * covariance[8] > covariance[0], "{covariance:?}");
        let weights = minimum_variance_weights(&[-3, -2, -1, 0, 4, 5], 3, &covariance, &[]);
        assert!(weights.is_some(), "{covariance:?}");
    }
}
