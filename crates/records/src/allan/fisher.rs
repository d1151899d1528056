//! The F distribution for any real numbers of degrees of freedom.
//!
//! It uses the incomplete beta function of statrs, which compared with SciPy is accurate to 3e-8 up to 1e7 degrees of
//! freedom. Near the middle, however, one of the two numbers must be below 1e5: for 1e7 and 1e7 the median comes out as
//! 0.37. In that range the cube root of F is taken as normal (Paulson), which is accurate to 2e-5 from 1e5 degrees on.
//! The inverse in statrs is off by 0.6 % for 1e7 and 6 degrees and is not used.

use statrs::function::beta::checked_beta_reg;

/// Number of both degrees of freedom from which on the cube root is used.
const MANY: f64 = 1e5;
/// Halvings of a bracket of the logarithm of a quantile.
const HALVINGS: usize = 100;
/// Quantiles are searched within e^±700.
const FARTHEST: f64 = 700.0;

/// The probabilities that F with these degrees of freedom, both above 0, is less and greater than `x` > 0.
pub fn tails(x: f64, numerator: f64, denominator: f64) -> Option<[f64; 2]> {
    let sensible = |degrees: f64| degrees > 0.0 && degrees.is_finite();
    if !(sensible(numerator) && sensible(denominator) && x > 0.0 && x.is_finite()) {
        return None;
    }
    if numerator.min(denominator) > MANY {
        let [a, b] = [numerator, denominator].map(|degrees| 2.0 / (9.0 * degrees));
        let root = libm::cbrt(x);
        let deviate = ((1.0 - b) * root - (1.0 - a)) / libm::sqrt(b * root * root + a);
        return Some([-deviate, deviate].map(|z| 0.5 * libm::erfc(z / core::f64::consts::SQRT_2)));
    }
    let part = |own: f64, of: f64, other: f64| checked_beta_reg(0.5 * of, 0.5 * other, own).ok();
    let whole = numerator * x + denominator;
    let below = part(numerator * x / whole, numerator, denominator)?;
    let above = part(denominator / whole, denominator, numerator)?;
    Some([below, above])
}

/// The value below which F lies with `probability`, accurate to 1e-7 for probabilities from 1e-6 to 1 − 1e-6.
pub fn quantile(probability: f64, numerator: f64, denominator: f64) -> Option<f64> {
    let is_below = |log: f64| {
        let [below, above] = tails(libm::exp(log), numerator, denominator)?;
        // This form avoids the loss of digits in 1 − p near 1.
        Some(if probability < 0.5 { below < probability } else { above > 1.0 - probability })
    };
    let (mut low, mut high) = (-FARTHEST, FARTHEST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if is_below(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(libm::exp(0.5 * (low + high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees of freedom, probability and quantile from scipy.stats.f.ppf, SciPy 1.17.
    const TABLE: &[(f64, f64, f64, f64)] = &[
        (0.9, 0.9, 0.025, 0.0008171473242102984),
        (0.9, 0.9, 0.5, 1.0),
        (0.9, 0.9, 0.975, 1223.769533806417),
        (0.9, 300.0, 0.025, 0.00046809162472292575),
        (0.9, 300.0, 0.5, 0.41285205105272155),
        (0.9, 300.0, 0.975, 5.322797205720454),
        (1.3, 4.2, 0.025, 0.004877835841232246),
        (1.3, 4.2, 0.5, 0.6613065263161256),
        (1.3, 4.2, 0.975, 10.979364395939637),
        (5.5, 5.5, 0.025, 0.15635102619082072),
        (5.5, 5.5, 0.5, 0.9999999999999999),
        (5.5, 5.5, 0.975, 6.395864641013204),
        (5.5, 80.2, 0.025, 0.18406479680781634),
        (5.5, 80.2, 0.5, 0.8892101042713698),
        (5.5, 80.2, 0.975, 2.6438334582514567),
        (30.7, 12.1, 0.025, 0.4173087539213163),
        (30.7, 12.1, 0.5, 1.0347376972609292),
        (30.7, 12.1, 0.975, 2.944407774557055),
        (300.3, 310.7, 0.025, 0.7985639425161908),
        (300.3, 310.7, 0.5, 0.9999255958358878),
        (300.3, 310.7, 0.975, 1.25170267411555),
        (20000.0, 21000.0, 0.025, 0.9729802352334453),
        (20000.0, 21000.0, 0.5, 0.9999984126686816),
        (20000.0, 21000.0, 0.975, 1.027760576454101),
        (200000.0, 300000.0, 0.025, 0.9920271686837865),
        (200000.0, 300000.0, 0.5, 0.999998888887649),
        (200000.0, 300000.0, 0.975, 1.0080303655509175),
        (100000.0, 10000000.0, 0.025, 0.9912105922838336),
        (100000.0, 10000000.0, 0.5, 0.9999934000074991),
        (100000.0, 10000000.0, 0.975, 1.0088284515063919),
        (10000000.0, 10000000.0, 0.025, 0.9987611778392136),
        (10000000.0, 10000000.0, 0.5, 1.0),
        (10000000.0, 10000000.0, 0.975, 1.0012403587446868),
        (10000000.0, 6.0, 0.025, 0.41524264725556737),
        (10000000.0, 6.0, 0.5, 1.121889353948225),
        (10000000.0, 6.0, 0.975, 4.849095835056013),
        (6.0, 10000000.0, 0.025, 0.2062240124789055),
        (6.0, 10000000.0, 0.5, 0.8913534979904532),
        (6.0, 10000000.0, 0.975, 2.408230480682141),
        (300.0, 10000000.0, 0.025, 0.8463725429579328),
        (300.0, 10000000.0, 0.5, 0.9977787243624782),
        (300.0, 10000000.0, 0.975, 1.1662512543416965),
    ];

    #[test]
    fn quantiles_and_probabilities_are_those_of_scipy() {
        for &(numerator, denominator, probability, expected) in TABLE {
            let found = quantile(probability, numerator, denominator).unwrap();
            let what = format!("F({numerator}, {denominator}), p = {probability}");
            assert!((found / expected - 1.0).abs() < 1e-7, "{what}: {found}, not {expected}");
            let [below, above] = tails(expected, numerator, denominator).unwrap();
            assert!((below / probability - 1.0).abs() < 2e-5, "{what}: {below}");
            assert!((above / (1.0 - probability) - 1.0).abs() < 2e-5, "{what}: {above} above");
        }
    }

    #[test]
    fn what_has_no_probability_is_absent() {
        for (x, numerator, denominator) in
            [(0.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, f64::NAN), (f64::NAN, 1.0, 1.0)]
        {
            assert_eq!(tails(x, numerator, denominator), None, "{x}, {numerator}, {denominator}");
        }
        assert_eq!(quantile(0.5, 1.0, -1.0), None);
    }
}
