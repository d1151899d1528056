//! First-order Gauss–Markov rate, sampled: r_k = a·r_{k−1} + σ√(1 − a²)·g_k, held over t0.
//!
//! With x = t0/T_c and a = e^{−x}, the sum of n rates of unit variance has the variance V(n) = [n(1 − a²) − 2a(1 −
//! a^n)]/(1 − a)². Differences are written without the powers of x that cancel in them; for the sampled noise they are
//! those of the continuous noise plus a term in sinh x − x. All lengths are in samples, all variances for σ = 1 and t0
//! = 1.

use crate::allan::estimator::Difference;
use crate::allan::exponential::{beyond_square, sinh_beyond_linear};

/// Product of lag and decay rate below which forms without the leading powers are used.
const SHORT: f64 = 0.5;

/// V(n), the variance of the sum of n rates.
pub fn summed(x: f64, n: f64) -> f64 {
    let (a, z) = (libm::exp(-x), n * x);
    let less = libm::expm1(-x);
    // n(1 − a²) − 2a(1 − a^n), in which the linear terms cancel for long correlations.
    let numerator = match z < SHORT {
        true => 2.0 * (n * sinh_beyond_linear(x) + a * (beyond_square(z) + 0.5 * z * z)),
        false => -n * libm::expm1(-2.0 * x) + 2.0 * a * libm::expm1(-z),
    };
    numerator / (less * less)
}

/// Variance of a difference of the angle at `m`.
pub fn mean_square(difference: Difference, x: f64, m: f64) -> f64 {
    let (a, z) = (libm::exp(-x), m * x);
    let less = libm::expm1(-x);
    let discrete = m * sinh_beyond_linear(x);
    let continuous = match (difference, z < SHORT) {
        (Difference::Second, true) => 4.0 * beyond_square(z) - beyond_square(2.0 * z),
        (Difference::Second, false) => 2.0 * z - 3.0 + 4.0 * libm::exp(-z) - libm::exp(-2.0 * z),
        (Difference::Third, true) => {
            30.0 * beyond_square(z) - 12.0 * beyond_square(2.0 * z) + 2.0 * beyond_square(3.0 * z)
        }
        (Difference::Third, false) => {
            12.0 * z - 20.0 + 30.0 * libm::exp(-z) - 12.0 * libm::exp(-2.0 * z) + 2.0 * libm::exp(-3.0 * z)
        }
    };
    match difference {
        Difference::Second => 2.0 * (a * continuous + 2.0 * discrete) / (less * less),
        Difference::Third => (a * continuous + 12.0 * discrete) / (less * less),
    }
}

/// Second difference of −V/2, m apart around the lag n ≥ 0, up to a constant for every m;
/// [`crate::allan::gaussian`] builds covariances from it.
pub fn kernel(x: f64, m: f64, n: f64) -> f64 {
    let a = libm::exp(-x);
    let less = libm::expm1(-x);
    // Second differences of the linear and of the exponential part of V(1 − a)²/2.
    let (linear, exponential) = if m * x < SHORT {
        let bend = 2.0 * libm::sinh(0.5 * m * x);
        match n >= m {
            true => {
                let square = m * m * x * x;
                (0.0, square * libm::expm1(-n * x) + libm::exp(-n * x) * (bend * bend - square))
            }
            false => {
                let around =
                    beyond_square((n + m) * x) - 2.0 * beyond_square(n * x) + beyond_square((m - n) * x);
                (2.0 * (m - n) * sinh_beyond_linear(x), around)
            }
        }
    } else {
        let around = libm::exp(-(n + m) * x) - 2.0 * libm::exp(-n * x) + libm::exp(-(n - m).abs() * x);
        (-(m - n).max(0.0) * libm::expm1(-2.0 * x), around)
    };
    -(linear + a * exponential) / (less * less)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance by definition: ΣΣ over rates with the covariance a^|lag|.
    fn by_definition(signs: &[f64], x: f64, m: usize) -> f64 {
        let weights: Vec<f64> = signs.iter().flat_map(|&sign| vec![sign; m]).collect();
        let row = |i: usize| {
            let term = |(j, w): (usize, &f64)| w * libm::expm1(-x * i.abs_diff(j) as f64);
            weights.iter().enumerate().map(term).sum::<f64>()
        };
        let total: f64 = weights.iter().sum();
        // Σw is 0 in differences, so subtracting 1 from the covariance changes nothing and preserves digits.
        total * total + weights.iter().enumerate().map(|(i, w)| w * row(i)).sum::<f64>()
    }

    #[test]
    fn the_closed_forms_are_the_double_sums() {
        for x in [1e-9, 1e-6, 1e-3, 0.02, 0.3, 0.6, 2.0, 50.0, 800.0] {
            for m in [1, 2, 3, 7, 20, 50, 120] {
                let table = [
                    (mean_square(Difference::Second, x, m as f64), by_definition(&[-1.0, 1.0], x, m)),
                    (mean_square(Difference::Third, x, m as f64), by_definition(&[1.0, -2.0, 1.0], x, m)),
                    (summed(x, m as f64), by_definition(&[1.0], x, m)),
                ];
                for (which, (found, expected)) in table.into_iter().enumerate() {
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "form {which}, x = {x}, m = {m}: {found}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn slow_markov_noise_is_a_random_walk_and_fast_is_white() {
        // Steps of variance 2x: (2m³ + m)/3 and m³ + m times that.
        for m in [1.0, 5.0, 1000.0] {
            let x = 1e-10;
            let second = mean_square(Difference::Second, x, m) / (2.0 * x);
            let third = mean_square(Difference::Third, x, m) / (2.0 * x);
            assert!((second / ((2.0 * m * m * m + m) / 3.0) - 1.0).abs() < 1e-6, "m = {m}: {second}");
            assert!((third / (m * m * m + m) - 1.0).abs() < 1e-6, "m = {m}: {third}");
            assert_eq!(mean_square(Difference::Second, 800.0, m), 2.0 * m);
            assert_eq!(mean_square(Difference::Third, 800.0, m), 6.0 * m);
        }
    }
}
