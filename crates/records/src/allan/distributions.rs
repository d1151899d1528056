//! The χ² and F distributions, for any real numbers of degrees of freedom.
//!
//! # χ²
//!
//! Quantiles of the χ² distribution for any real number of degrees of freedom.
//!
//! They are found by Newton's method on the incomplete gamma function of statrs, a statistics library maintained since
//! 2016. Compared with SciPy, that function is accurate to 1e-12 up to 1e3 degrees of freedom and to 4e-8 up to 2e7,
//! and takes at most 0.1 ms. Its inverse is not used, because it is wrong by orders of magnitude for small
//! probabilities and slow for many degrees of freedom. (The function of puruspe fails above 1e4.)
//!
//! # F
//!
//! The F distribution for any real numbers of degrees of freedom.
//!
//! It uses the incomplete beta function of statrs, which compared with SciPy is accurate to 3e-8 up to 1e7 degrees of
//! freedom. Near the middle, however, one of the two numbers must be below 1e5: for 1e7 and 1e7 the median comes out as
//! 0.37. In that range the cube root of F is taken as normal (Paulson), which is accurate to 2e-5 from 1e5 degrees on.
//! The inverse in statrs is off by 0.6 % for 1e7 and 6 degrees and is not used.

use statrs::function::beta::checked_beta_reg;
use statrs::function::gamma::{checked_gamma_lr, checked_gamma_ur};

/// Most steps of Newton's method, which takes four or five from its start.
const MAX_STEPS: usize = 60;

/// The value below which a χ² variable of `freedom` > 0 degrees lies with `probability`, 0 < p < 1.
///
/// The relative error is below 1e-8 for 1e-6 ≤ p ≤ 1 − 1e-6 and up to 1e7 degrees of freedom. `None` where the result
/// exceeds the range of f64.
pub fn chi_squared_quantile(probability: f64, freedom: f64) -> Option<f64> {
    let sensible = freedom > 0.0 && freedom.is_finite() && probability > 0.0 && probability < 1.0;
    if !sensible {
        return None;
    }
    let a = 0.5 * freedom;
    // As a function of ln x the distribution is smooth, and steps cannot pass 0.
    let mut log_x = start(probability, freedom);
    let log_gamma = libm::lgamma(a);
    for _ in 0..MAX_STEPS {
        let x = libm::exp(log_x);
        let excess = match probability < 0.5 {
            true => checked_gamma_lr(a, x).ok()? - probability,
            // This form avoids the loss of digits in 1 − p near 1.
            false => (1.0 - probability) - checked_gamma_ur(a, x).ok()?,
        };
        let density = libm::exp(a * log_x - x - log_gamma);
        if density <= 0.0 {
            return None;
        }
        let step = (excess / density).clamp(-1.0, 1.0);
        log_x -= step;
        if libm::fabs(step) < 1e-13 * (1.0 + libm::fabs(log_x)) {
            break;
        }
    }
    Some(2.0 * libm::exp(log_x)).filter(|x| x.is_finite() && *x > 0.0)
}

/// The logarithm of a first approximation of half the quantile.
fn start(probability: f64, freedom: f64) -> f64 {
    let a = 0.5 * freedom;
    // Wilson and Hilferty: the cube root is nearly normally distributed.
    let spread = 2.0 / (9.0 * freedom);
    let root = 1.0 - spread + libm::sqrt(spread) * normal_quantile(probability);
    if root > 0.1 {
        return libm::log(a * root * root * root);
    }
    // Near 0 the distribution function is x^a / Γ(a + 1).
    (libm::log(probability) + libm::lgamma(a + 1.0)) / a
}

/// A normal quantile to 5e-4, which suffices for a start. Abramowitz and Stegun 26.2.23.
pub(crate) fn normal_quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability);
    let t = libm::sqrt(-2.0 * libm::log(tail));
    let fraction =
        (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    if probability < 0.5 { fraction - t } else { t - fraction }
}

/// Number of both degrees of freedom from which on the cube root is used.
const MANY: f64 = 1e5;
/// Halvings of a bracket of the logarithm of a quantile.
const HALVINGS: usize = 100;
/// Quantiles are searched within e^±700.
const FARTHEST: f64 = 700.0;

/// The probabilities that F with these degrees of freedom, both above 0, is less and greater than `x` > 0.
pub fn f_tails(x: f64, numerator: f64, denominator: f64) -> Option<[f64; 2]> {
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
pub fn f_quantile(probability: f64, numerator: f64, denominator: f64) -> Option<f64> {
    let is_below = |log: f64| {
        let [below, above] = f_tails(libm::exp(log), numerator, denominator)?;
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

/// The probability that χ² with `degrees` degrees of freedom is at least `x`; 1 for 0 degrees and x = 0.
///
/// It is the finite sum e^{−x/2} Σ (x/2)^k/Γ(k + 1) over k = 0, 1, … for even degrees, or over ½, 3/2, … plus erfc
/// √(x/2) for odd ones (Abramowitz and Stegun 26.4.4, 26.4.5), accurate to 1e-13 in `degrees`/2 steps.
pub fn survival(x: f64, degrees: usize) -> f64 {
    let half = 0.5 * x.max(0.0);
    if half == 0.0 || degrees == 0 {
        return if half == 0.0 { 1.0 } else { 0.0 };
    }
    let is_odd = degrees % 2 == 1;
    let (mut k, mut sum) = if is_odd { (0.5, libm::erfc(libm::sqrt(half))) } else { (0.0, 0.0) };
    while k < 0.5 * degrees as f64 - 0.25 {
        sum += libm::exp(k * libm::log(half) - half - libm::lgamma(k + 1.0));
        k += 1.0;
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_scipy() {
        // scipy.stats.chi2.ppf, SciPy 1.17
        let table: &[(f64, f64, f64)] = &[
            (0.005, 0.3, 5.756625776327617e-16),
            (0.025, 0.3, 2.6300743566293655e-11),
            (0.1585, 0.3, 5.8510101421034025e-06),
            (0.5, 0.3, 0.012469611517980431),
            (0.8415, 0.3, 0.4881082181331283),
            (0.975, 0.3, 2.545055437452546),
            (0.999, 0.3, 7.555207145560666),
            (0.005, 0.9, 1.17611257716909e-05),
            (0.025, 0.9, 0.00042051043921471627),
            (0.1585, 0.9, 0.025702570516051224),
            (0.5, 0.9, 0.37065676782559726),
            (0.8415, 0.9, 1.7983940594361811),
            (0.975, 0.9, 4.743976721674694),
            (0.999, 0.9, 10.4666464928115),
            (0.005, 1.0, 3.9270422220515944e-05),
            (0.025, 1.0, 0.0009820691171752555),
            (0.1585, 1.0, 0.03999006879561293),
            (0.5, 1.0, 0.454936423119572),
            (0.8415, 1.0, 1.9884790397914105),
            (0.975, 1.0, 5.023886187314888),
            (0.999, 1.0, 10.827566170662733),
            (0.005, 2.0, 0.010025083647088564),
            (0.025, 2.0, 0.05063561596857975),
            (0.1585, 2.0, 0.3451385307025527),
            (0.5, 2.0, 1.386294361119891),
            (0.8415, 2.0, 3.684001371329604),
            (0.975, 2.0, 7.377758908227871),
            (0.999, 2.0, 13.815510557964274),
            (0.005, 4.235, 0.24922031485932675),
            (0.025, 4.235, 0.55970108644751),
            (0.1585, 4.235, 1.5614620614868022),
            (0.5, 4.235, 3.590215589678987),
            (0.8415, 4.235, 6.924794649824054),
            (0.975, 4.235, 11.548166722482511),
            (0.999, 4.235, 18.95962457039633),
            (0.005, 9.551, 1.9633741564592977),
            (0.025, 9.551, 2.9986104913076668),
            (0.1585, 9.551, 5.334922393505242),
            (0.5, 9.551, 8.89324542465943),
            (0.8415, 9.551, 13.77518947635968),
            (0.975, 9.551, 19.83059312248446),
            (0.999, 9.551, 28.82470010252299),
            (0.005, 30.0, 13.78671985950272),
            (0.025, 30.0, 16.79077226556663),
            (0.1585, 30.0, 22.337158019276522),
            (0.5, 30.0, 29.336031516661585),
            (0.8415, 30.0, 37.66654973377068),
            (0.975, 30.0, 46.97924224367115),
            (0.999, 30.0, 59.70306430442994),
            (0.005, 782.03, 683.9187760288273),
            (0.025, 782.03, 706.4282963574327),
            (0.1585, 782.03, 742.4741776268512),
            (0.5, 782.03, 781.3634344626176),
            (0.8415, 782.03, 821.5876100715302),
            (0.975, 782.03, 861.4196181212797),
            (0.999, 782.03, 909.9629544718147),
            (0.005, 10000.0, 9639.479982193741),
            (0.025, 10000.0, 9724.718377389798),
            (0.1585, 10000.0, 9858.4934505555),
            (0.5, 10000.0, 9999.333341235144),
            (0.8415, 10000.0, 10141.508267446809),
            (0.975, 10000.0, 10279.07017988759),
            (0.999, 10000.0, 10442.730565410178),
            (0.005, 330000.0, 327911.14310534),
            (0.025, 330000.0, 328409.61288352497),
            (0.1585, 330000.0, 329187.0764124817),
            (0.5, 330000.0, 329999.3333335728),
            (0.8415, 330000.0, 330812.92529978993),
            (0.975, 330000.0, 331594.17572658503),
            (0.999, 330000.0, 332516.21735662874),
            (0.005, 10000000.0, 9988484.297778677),
            (0.025, 10000000.0, 9991236.669053895),
            (0.1585, 10000000.0, 9995524.9947047),
            (0.5, 10000000.0, 9999999.333333341),
            (0.8415, 10000000.0, 10004475.0070074),
            (0.975, 10000000.0, 10008767.119557811),
            (0.999, 10000000.0, 10013825.638891771),
            (1e-6, 1.0, 1.5707963267957187e-12),
        ];
        for &(probability, freedom, expected) in table {
            let found = chi_squared_quantile(probability, freedom).unwrap();
            let error = found / expected - 1.0;
            assert!(error.abs() < 1e-8, "p = {probability}, k = {freedom}: {found}, not {expected}");
        }
    }

    #[test]
    fn what_has_no_quantile_is_absent() {
        for (probability, freedom) in [(0.0, 3.0), (1.0, 3.0), (0.5, 0.0), (0.5, f64::NAN), (f64::NAN, 1.0)] {
            assert_eq!(chi_squared_quantile(probability, freedom), None, "p = {probability}, k = {freedom}");
        }
    }

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
            let found = f_quantile(probability, numerator, denominator).unwrap();
            let what = format!("F({numerator}, {denominator}), p = {probability}");
            assert!((found / expected - 1.0).abs() < 1e-7, "{what}: {found}, not {expected}");
            let [below, above] = f_tails(expected, numerator, denominator).unwrap();
            assert!((below / probability - 1.0).abs() < 2e-5, "{what}: {below}");
            assert!((above / (1.0 - probability) - 1.0).abs() < 2e-5, "{what}: {above} above");
        }
    }

    #[test]
    fn what_has_no_probability_is_absent() {
        for (x, numerator, denominator) in
            [(0.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, f64::NAN), (f64::NAN, 1.0, 1.0)]
        {
            assert_eq!(f_tails(x, numerator, denominator), None, "{x}, {numerator}, {denominator}");
        }
        assert_eq!(f_quantile(0.5, 1.0, -1.0), None);
    }

    #[test]
    fn it_is_the_distribution_of_the_tables() {
        // SciPy 1.17, chi2.sf.
        let table = [
            (3.841458820694124, 1, 0.05),
            (5.991464547107979, 2, 0.05),
            (18.307038053275146, 10, 0.05),
            (1.0, 3, 0.8012519569012009),
            (30.0, 11, 0.0015845952573066058),
            (100.0, 120, 0.907734948041067),
            (0.0, 4, 1.0),
        ];
        for (x, degrees, expected) in table {
            let found = survival(x, degrees);
            assert!((found - expected).abs() < 1e-12, "χ² = {x}, {degrees}: {found}, not {expected}");
        }
        assert_eq!((survival(0.0, 0), survival(1.0, 0)), (1.0, 0.0));
    }
}
