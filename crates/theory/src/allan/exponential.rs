//! Exponentials without their leading powers, accurate to rounding even for small arguments.

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
pub(crate) fn sinh_beyond_linear(x: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

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
