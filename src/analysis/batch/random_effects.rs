//! Values of several units of a batch as one: a random-effects model of their logarithms.
//!
//! The logarithm y_i of unit i is that of the batch, μ, plus a deviation of the unit with variance τ², plus the error of its
//! record with the known variance v_i. Batches are small, so τ² is uncertain, and a single estimate of it would make every
//! interval too narrow. Q(τ²) = Σ (y_i − μ(τ²))²/(v_i + τ²) with the weighted mean μ(τ²) falls with τ², and at the true τ² it is a
//! χ² with k − 1 degrees of freedom. This gives a confidence distribution of τ²: for each probability the τ² whose Q is that
//! quantile. Its ends at 2.5 and 97.5 % are the interval of the spread (Q-profile: W. Viechtbauer, Stat. Med. 26, 37, 2007). The
//! batch and its next unit are normal numbers for each τ², and their intervals are those of the mixture over that distribution (as
//! K. Nagashima et al., Stat. Methods Med. Res. 28, 1689, 2019). If the records are exact, these are the intervals of Student. The
//! estimate of τ² has Q = k − 1 (R. C. Paule and J. Mandel, J. Res. NBS 87, 377, 1982).
//!
//! Units that happen to be closer than the errors of their records have a small Q even for τ² = 0, and the profile would end near
//! 0, or at 0. Its upper end is therefore at least the bound that equal units with these errors have on average, where the
//! expected Q(τ²) of such units is the 2.5 % quantile (a power-constrained limit: G. Cowan et al., arXiv:1105.3166).

use sagnac_records::allan::distributions;
use sagnac_records::fit::survival;
use sagnac_records::fit::uncertainty::WITHIN_95;

/// Fewest units that have a spread.
pub const MIN_UNITS: usize = 2;

/// Ends of the deviates at which the distribution of the spread is known, and their number; quantiles of χ² are accurate up to there.
const FARTHEST: f64 = 4.75;
const DEVIATES: u32 = 77;
/// Halvings of a bracket, down to rounding.
const HALVINGS: usize = 60;
/// Probability below an interval.
const TAIL: f64 = 0.025;

/// The logarithm of a quantity of one unit, from its record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Natural logarithm of the value.
    pub log: f64,
    /// Variance of that logarithm, of the record alone.
    pub variance: f64,
}

impl Estimate {
    /// A value with its 95 % interval; `None` where these are not the value and the ends of a positive quantity. A lower end of 0
    /// says nothing of the logarithm, which then has the error above the value on both sides.
    pub fn new(value: f64, [lower, upper]: [f64; 2]) -> Option<Estimate> {
        let width = match lower > 0.0 {
            true => 0.5 * libm::log(upper / lower),
            false => libm::log(upper / value),
        };
        let error = width / WITHIN_95;
        let is_known = value > 0.0 && error.is_finite() && error >= 0.0;
        is_known.then(|| Estimate { log: libm::log(value), variance: error * error })
    }
}

/// Several units as one batch, in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Number of units.
    pub units: usize,
    /// Median of the batch.
    pub value: f64,
    /// 95 % interval of the median.
    pub interval: [f64; 2],
    /// Standard deviation between units as a part of their mean, that of a log-normal distribution: √(e^τ² − 1).
    pub spread: f64,
    /// 95 % interval of the spread, from 0 where units may be equal.
    pub spread_interval: [f64; 2],
    /// Interval that contains the true value of the next unit with a probability of 95 %.
    pub next: [f64; 2],
    /// Probability of values at least as far apart if all units are equal.
    pub p_equal: f64,
}

/// Pools the estimates of units; `None` for fewer than [`MIN_UNITS`].
///
/// ```
/// use sagnac::analysis::batch::random_effects::{Estimate, pool};
///
/// let exact = [3.0, 3.1, 3.3, 2.8, 2.9].map(|n: f64| Estimate { log: n.ln(), variance: 1e-12 });
/// let batch = pool(&exact).unwrap();
/// assert!((batch.spread - 0.063).abs() < 1e-3 && batch.p_equal < 1e-6);
/// assert!(batch.next[0] < 2.8 && 3.3 < batch.next[1]);
/// ```
pub fn pool(estimates: &[Estimate]) -> Option<Pooled> {
    let mixture = Mixture::new(estimates)?;
    let freedom = estimates.len() - 1;
    let middle = Part::at(estimates, freedom as f64);
    let spread = |square: f64| libm::sqrt(libm::expm1(square));
    let ends = |of: &dyn Fn(f64) -> f64| [of(TAIL), of(1.0 - TAIL)];
    let target = |deviate: f64| distributions::chi_squared_quantile(normal(-deviate), freedom as f64);
    let lowest = Part::at(estimates, target(-WITHIN_95)?).square;
    let least = target(WITHIN_95)?;
    let highest = Part::at(estimates, least).square.max(bound(estimates, least));
    Some(Pooled {
        units: estimates.len(),
        value: libm::exp(middle.mean),
        interval: ends(&|p| libm::exp(mixture.quantile(p, |part| part.variance))),
        spread: spread(middle.square),
        spread_interval: [lowest, highest].map(spread),
        next: ends(&|p| libm::exp(mixture.quantile(p, |part| part.variance + part.square))),
        p_equal: survival(scatter(estimates, 0.0).0, freedom),
    })
}

/// The probability that a unit like the `others`, with the error of `one`, is estimated lower than it; `None` for fewer than
/// [`MIN_UNITS`] others.
pub fn place(one: &Estimate, others: &[Estimate]) -> Option<f64> {
    Some(Mixture::new(others)?.below(one.log, |part| part.variance + part.square + one.variance))
}

/// The batch for one τ².
#[derive(Debug, Clone, Copy)]
struct Part {
    /// τ².
    square: f64,
    /// μ.
    mean: f64,
    /// Variance of μ.
    variance: f64,
}

impl Part {
    /// The batch whose Q is `target`, or less if it is less for every τ².
    fn at(estimates: &[Estimate], target: f64) -> Part {
        let count = estimates.len() as f64;
        let mean = estimates.iter().map(|one| one.log).sum::<f64>() / count;
        let squares: f64 = estimates.iter().map(|one| (one.log - mean) * (one.log - mean)).sum();
        // Q is below Σ(y − ȳ)²/τ².
        let square = falling(target, squares / target, |square| scatter(estimates, square).0);
        let (_, mean, variance) = scatter(estimates, square);
        Part { square, mean, variance }
    }
}

/// The τ² between 0 and `most` at which a Q that falls with τ² is `target`; 0 if it is less for every τ².
fn falling(target: f64, most: f64, q: impl Fn(f64) -> f64) -> f64 {
    if q(0.0) <= target {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if q(middle) > target { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The τ² for which the expected Q of equal units with the errors of `estimates` is `target`: Σ w_i v_i − Σ w_i² v_i/Σ w_i with
/// w_i = 1/(v_i + τ²).
fn bound(estimates: &[Estimate], target: f64) -> f64 {
    let expected = |square: f64| {
        let [mut all, mut first, mut second] = [0.0; 3];
        for Estimate { variance, .. } in estimates {
            let weight = 1.0 / (variance + square).max(f64::MIN_POSITIVE);
            all += weight;
            first += weight * variance;
            second += weight * (weight * variance);
        }
        first - second / all
    };
    let variances: f64 = estimates.iter().map(|one| one.variance).sum();
    falling(target, variances / target, expected)
}

/// Q, μ and the variance of μ for this τ².
fn scatter(estimates: &[Estimate], square: f64) -> (f64, f64, f64) {
    let weight = |one: &Estimate| 1.0 / (one.variance + square).max(f64::MIN_POSITIVE);
    let all: f64 = estimates.iter().map(weight).sum();
    let mean = estimates.iter().map(|one| weight(one) * one.log).sum::<f64>() / all;
    let q = estimates.iter().map(|one| weight(one) * (one.log - mean) * (one.log - mean)).sum();
    (q, mean, 1.0 / all)
}

/// The batch over the confidence distribution of τ², with weights that add up to 1.
struct Mixture(Vec<(f64, Part)>);

impl Mixture {
    fn new(estimates: &[Estimate]) -> Option<Mixture> {
        let freedom = estimates.len().checked_sub(1).filter(|freedom| freedom + 1 >= MIN_UNITS)? as f64;
        let step = 2.0 * FARTHEST / f64::from(DEVIATES - 1);
        let deviates = (0..DEVIATES).map(|i| f64::from(i) * step - FARTHEST);
        let part = |deviate: f64| {
            let target = distributions::chi_squared_quantile(normal(-deviate), freedom)?;
            Some((libm::exp(-0.5 * deviate * deviate), Part::at(estimates, target)))
        };
        let parts: Vec<(f64, Part)> = deviates.map(part).collect::<Option<_>>()?;
        let all: f64 = parts.iter().map(|(weight, _)| weight).sum();
        Some(Mixture(parts.into_iter().map(|(weight, part)| (weight / all, part)).collect()))
    }

    /// The probability of a logarithm below `log`, if it is normal with this variance for each τ².
    fn below(&self, log: f64, variance: impl Fn(&Part) -> f64) -> f64 {
        let of = |(weight, part): &(f64, Part)| {
            weight * normal((log - part.mean) / libm::sqrt(variance(part)).max(f64::MIN_POSITIVE))
        };
        self.0.iter().map(of).sum()
    }

    /// The logarithm below which this probability lies.
    fn quantile(&self, probability: f64, variance: impl Fn(&Part) -> f64) -> f64 {
        let reach = |(_, part): &(f64, Part)| 2.0 * FARTHEST * libm::sqrt(variance(part));
        let ends = self.0.iter().map(|part| [part.1.mean - reach(part), part.1.mean + reach(part)]);
        let (mut low, mut high) = ends
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| (low.min(end[0]), high.max(end[1])));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.below(middle, &variance) < probability { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// The probability of a standard normal number below `z`.
fn normal(z: f64) -> f64 {
    0.5 * libm::erfc(-z / core::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_records::allan::distributions;

    fn exact(logs: &[f64]) -> Vec<Estimate> {
        logs.iter().map(|&log| Estimate { log, variance: 1e-18 }).collect()
    }

    /// Two-sided 95 % quantile of Student's distribution.
    fn student(freedom: f64) -> f64 {
        libm::sqrt(distributions::f_quantile(0.95, 1.0, freedom).unwrap())
    }

    #[test]
    fn exact_values_have_the_intervals_of_student_and_of_chi_squared() {
        for logs in [&[0.0, 0.02, -0.05, 0.01, 0.03, -0.02, 0.04, 0.0][..], &[0.3, -0.2, 0.1], &[0.0, 0.1]] {
            let count = logs.len() as f64;
            let mean = logs.iter().sum::<f64>() / count;
            let squares: f64 = logs.iter().map(|log| (log - mean) * (log - mean)).sum();
            let deviation = libm::sqrt(squares / (count - 1.0));
            let found = pool(&exact(logs)).unwrap();
            let close = |found: f64, expected: f64| {
                assert!((found / expected - 1.0).abs() < 2e-3, "{count} units: {found}, not {expected}");
            };
            assert!((libm::log(found.value) - mean).abs() < 1e-9);
            close(libm::log1p(found.spread * found.spread), deviation * deviation);
            let half = student(count - 1.0) * deviation;
            close(libm::log(found.interval[1]) - mean, half / libm::sqrt(count));
            close(libm::log(found.next[1]) - mean, half * libm::sqrt(1.0 + 1.0 / count));
            for (end, p) in [(0, 0.975), (1, 0.025)] {
                let expected = squares / distributions::chi_squared_quantile(p, count - 1.0).unwrap();
                close(libm::log1p(found.spread_interval[end] * found.spread_interval[end]), expected);
            }
        }
    }

    #[test]
    fn a_unit_has_the_place_that_student_gives_it() {
        let others = [0.0, 0.02, -0.05, 0.01, 0.03, -0.02, 0.04];
        let mean = others.iter().sum::<f64>() / 7.0;
        let variance = others.iter().map(|log| (log - mean) * (log - mean)).sum::<f64>() / 6.0;
        for log in [0.1, -0.2, 0.3] {
            let t = (log - mean) / libm::sqrt(variance * (1.0 + 1.0 / 7.0));
            let [_, expected] = distributions::f_tails(t * t, 1.0, 6.0).unwrap();
            let below = place(&exact(&[log])[0], &exact(&others)).unwrap();
            let found = 2.0 * below.min(1.0 - below);
            assert!((found / expected - 1.0).abs() < 0.02, "{log}: {found}, not {expected}");
        }
        assert_eq!(place(&exact(&[0.0])[0], &exact(&[0.0])), None);
    }

    #[test]
    fn equal_units_have_no_spread_and_the_interval_of_their_weighted_mean() {
        let units = [0.1, 0.2, 0.1].map(|error: f64| Estimate { log: 1.0, variance: error * error });
        let found = pool(&units).unwrap();
        assert_eq!((found.spread, found.spread_interval[0], found.p_equal), (0.0, 0.0, 1.0));
        let error = 1.0 / libm::sqrt(225.0);
        assert!((libm::log(found.interval[1]) - 1.0 - WITHIN_95 * error).abs() < 1e-9, "{found:?}");
        assert_eq!(found.interval, found.next);
        assert_eq!(pool(&units[..1]), None);
    }

    #[test]
    fn the_spread_of_units_closer_than_their_errors_has_the_bound_of_equal_units() {
        // For equal errors v, the expected Q is 7v/(v + τ²), and 1.69 is the 2.5 % quantile of χ² with 7 degrees of freedom.
        let squared = 1e-4 * (7.0 / 1.689_869_180_677_357_9 - 1.0);
        let expected = libm::sqrt(libm::expm1(squared));
        for apart in [0.0, 1e-4, 1e-3] {
            let units: Vec<Estimate> =
                (0..8).map(|i| Estimate { log: apart * f64::from(i % 2), variance: 1e-4 }).collect();
            let [lower, upper] = pool(&units).unwrap().spread_interval;
            assert!(lower == 0.0 && (upper / expected - 1.0).abs() < 1e-6, "{apart}: {lower} … {upper}");
        }
    }

    #[test]
    fn an_interval_gives_the_error_of_a_logarithm() {
        let ends = [-WITHIN_95, WITHIN_95].map(|z| 3.0 * libm::exp(0.1 * z));
        for ends in [ends, [0.0, ends[1]]] {
            let found = Estimate::new(3.0, ends).unwrap();
            assert!((found.variance - 0.01).abs() < 1e-12 && found.log == libm::log(3.0), "{found:?}");
        }
        for (value, ends) in [(0.0, [0.0, 1.0]), (1.0, [0.5, f64::INFINITY]), (1.0, [0.0, 0.5])] {
            assert_eq!(Estimate::new(value, ends), None);
        }
    }
}
