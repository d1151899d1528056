//! First-order Gauss–Markov rate, sampled: r_k = a·r_{k−1} + σ√(1 − a²)·g_k, held over t0.
//!
//! With x = t0/T_c and a = e^{−x}, the sum of n rates of unit variance has the variance V(n) = [n(1 − a²) − 2a(1 −
//! a^n)]/(1 − a)². Differences are written without the powers of x that cancel in them; for the sampled noise they are
//! those of the continuous noise plus a term in sinh x − x. All lengths are in samples, all variances for σ = 1 and t0
//! = 1.
//!
//! Besides, the exponentials without their leading powers, accurate to rounding even for small arguments, and the exact [`Step`]
//! of a random walk and of a Markov state of the rate, with the angle that they accumulate.

use crate::allan::Difference;

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

/// Argument below which the series is summed, because e^{−z} minus its powers would lose digits.
const SERIES_BELOW: f64 = 0.5;

/// e^{−z} − 1 + z − z²/2, which is −z³/6 and so on.
pub(crate) fn beyond_square(z: f64) -> f64 {
    if z.abs() >= SERIES_BELOW {
        return libm::exp(-z) - 1.0 + z - 0.5 * z * z;
    }
    // Summed from the last term inwards; 0.5^17/17! is below rounding.
    let inner = (4..18).rev().fold(1.0, |sum, k| 1.0 - z / f64::from(k) * sum);
    -z * z * z / 6.0 * inner
}

/// e^{−z} − 1 + z for z ≥ 0, the deficit of a decay relative to its initial slope.
pub fn settling(z: f64) -> f64 {
    beyond_square(z) + 0.5 * z * z
}

/// e^{−x}(sinh x − x), x ≥ 0.
fn sinh_beyond_linear(x: f64) -> f64 {
    if x >= SERIES_BELOW {
        return -0.5 * libm::expm1(-2.0 * x) - x * libm::exp(-x);
    }
    let inner =
        [110.0, 72.0, 42.0, 20.0].into_iter().fold(1.0 + x * x / 156.0, |sum, k| 1.0 + x * x / k * sum);
    libm::exp(-x) * x * x * x / 6.0 * inner
}

/// Mean of e^{−x·s·k} over k = 0 … `terms` − 1, for the step s and x ≥ 0.
pub fn mean_of_decay(x: f64, step: f64, terms: u64) -> f64 {
    let count = terms as f64;
    match x * step == 0.0 {
        true => 1.0,
        false => libm::expm1(-x * step * count) / (count * libm::expm1(-x * step)),
    }
}

/// A state of the rate over a step Δ beside the angle: F = [1 `onto_angle`; 0 `own`], and what Q adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The angle that a state of one accumulates over the step.
    pub onto_angle: f64,
    /// The part of the state that remains after the step.
    pub own: f64,
    /// Variance that the step adds to the angle, covariance of both, and variance that it adds to the state.
    pub added: [f64; 3],
}

impl Step {
    /// A random walk of the rate with the square K² of its coefficient.
    pub fn walk(k: f64, d: f64) -> Step {
        Step { onto_angle: d, own: 1.0, added: [k * d * d * d / 3.0, k * d * d / 2.0, k * d] }
    }

    /// A Markov state with a variance and a correlation time.
    pub fn markov(variance: f64, t: f64, d: f64) -> Step {
        let z = d / t;
        let (a, less) = (libm::exp(-z), -libm::expm1(-z));
        // z − 2(1 − a) + (1 − a²)/2, whose powers up to z² cancel.
        let bracket = 2.0 * beyond_square(z) - 0.5 * beyond_square(2.0 * z);
        let added = [2.0 * t * t * bracket, t * less * less, -libm::expm1(-2.0 * z)];
        Step { onto_angle: t * less, own: a, added: added.map(|part| variance * part) }
    }
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

    #[test]
    fn series_and_direct_forms_meet() {
        for z in [SERIES_BELOW, 0.4999] {
            let direct = libm::exp(-z) - 1.0 + z - 0.5 * z * z;
            let found = beyond_square(z);
            assert!((found / direct - 1.0).abs() < 2e-14, "{z}: {found}, not {direct}");
            let direct = libm::exp(-z) * (libm::sinh(z) - z);
            let found = sinh_beyond_linear(z);
            assert!((found / direct - 1.0).abs() < 2e-14, "{z}: {found}, not {direct}");
        }
        // Leading terms: −z³/6 + z⁴/24, and (1 − x)·x³/6.
        assert!((beyond_square(1e-6) / (-1e-18 / 6.0 * (1.0 - 0.25e-6)) - 1.0).abs() < 1e-12);
        assert!((sinh_beyond_linear(1e-6) / (1e-18 / 6.0 * (1.0 - 1e-6)) - 1.0).abs() < 1e-11);
        assert_eq!(mean_of_decay(0.0, 3.0, 10), 1.0);
        let sum: f64 = (0..10).map(|k| libm::exp(-0.6 * f64::from(k))).sum();
        assert!((mean_of_decay(0.2, 3.0, 10) - sum / 10.0).abs() < 1e-15);
    }
}
