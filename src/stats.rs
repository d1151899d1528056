//! From exact tallies to estimates with uncertainties.

use crate::kernel::moments::{BINS, Moments, level_edge};

/// The probability whose quantile is reported: 99.73 %, three standard deviations of a normal distribution.
pub const LEVEL: f64 = 0.9973;

/// What a tally says about an error, in the unit of its scale. Absent where the trials do not say it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimates {
    pub mean: f64,
    pub rms: f64,
    /// Standard error of `rms`, from the fourth moment that the histogram gives.
    pub rms_se: Option<f64>,
    /// Largest |error| seen.
    pub max: f64,
    pub q9973: Option<Quantile>,
}

/// A quantile of |error| and its 95 % interval from order statistics, widened to the edges of bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    pub value: f64,
    /// Absent where the trials are too few to bound it.
    pub low: Option<f64>,
    pub high: Option<f64>,
}

impl Estimates {
    /// The estimates of a tally whose histogram starts at level `bin_base`; one unit of the tally is `scale`.
    ///
    /// `None` without a trial.
    pub fn of(tally: &Moments, bin_base: u32, scale: f64) -> Option<Estimates> {
        if tally.count == 0 {
            return None;
        }
        let n = tally.count as f64;
        let second = tally.square as f64 / n;
        let rms = libm::sqrt(second);
        let max = f64::from(tally.least.unsigned_abs().max(tally.greatest.unsigned_abs()));
        let edges = Edges { base: bin_base, max };
        let variance = (fourth_moment(tally, edges) - second * second).max(0.0);
        let rms_se = (tally.count > 1 && rms > 0.0).then(|| libm::sqrt(variance / n) / (2.0 * rms));
        Some(Estimates {
            mean: tally.sum as f64 / n * scale,
            rms: rms * scale,
            rms_se: rms_se.map(|se| se * scale),
            max: max * scale,
            q9973: quantile(tally, edges).map(|q| Quantile {
                value: q.value * scale,
                low: q.low.map(|x| x * scale),
                high: q.high.map(|x| x * scale),
            }),
        })
    }
}

/// Where the bins of a tally begin and end.
#[derive(Clone, Copy)]
struct Edges {
    base: u32,
    max: f64,
}

impl Edges {
    /// Lower and upper edge of a bin; the last one ends at the largest |error|.
    fn of(self, bin: usize) -> (f64, f64) {
        let edge = |bin: usize| level_edge(self.base + bin as u32 - 1) as f64;
        let low = if bin == 0 { 0.0 } else { edge(bin) };
        let high = if bin == BINS - 1 { self.max } else { edge(bin + 1) };
        (low.min(self.max), high.min(self.max))
    }
}

/// Mean of error⁴, each bin taken as filled evenly (bins are below 1 % wide).
fn fourth_moment(tally: &Moments, edges: Edges) -> f64 {
    let sum: f64 = filled(tally)
        .map(|(bin, count)| {
            let (a, b) = edges.of(bin);
            let mean = [a * a * a * a, a * a * a * b, a * a * b * b, a * b * b * b, b * b * b * b];
            count as f64 * mean.iter().sum::<f64>() / 5.0
        })
        .sum();
    sum / tally.count as f64
}

fn filled(tally: &Moments) -> impl Iterator<Item = (usize, u64)> + '_ {
    tally.bins.iter().copied().enumerate().filter(|&(_, count)| count > 0)
}

/// The quantile at [`LEVEL`]; `None` without a histogram.
fn quantile(tally: &Moments, edges: Edges) -> Option<Quantile> {
    let n = tally.count;
    let value = {
        let rank = LEVEL * n as f64;
        let (bin, within) = bin_of_rank(tally, rank)?;
        let (a, b) = edges.of(bin);
        a + (b - a) * within
    };
    // Of n trials about n (1 − level) lie above the quantile; these many at least and at most, in 95 % of all cases.
    let (fewest, most) = binomial_interval(n, 1.0 - LEVEL);
    let low = bin_of_rank(tally, n.saturating_sub(most) as f64)
        .filter(|_| most < n)
        .map(|(bin, _)| edges.of(bin).0);
    let high = (fewest > 0)
        .then(|| bin_of_rank(tally, (n - fewest + 1) as f64))
        .flatten()
        .map(|(bin, _)| edges.of(bin).1);
    Some(Quantile { value, low, high })
}

/// The bin that holds the `rank`-th smallest |error|, and how far into the bin it lies.
fn bin_of_rank(tally: &Moments, rank: f64) -> Option<(usize, f64)> {
    let mut below = 0.0;
    for (bin, count) in filled(tally) {
        let count = count as f64;
        if below + count >= rank {
            return Some((bin, ((rank - below) / count).clamp(0.0, 1.0)));
        }
        below += count;
    }
    None
}

/// The central 95 % of a binomial distribution: outside on either side lies at most 2.5 %.
fn binomial_interval(n: u64, p: f64) -> (u64, u64) {
    let mean = n as f64 * p;
    let sd = libm::sqrt(mean * (1.0 - p));
    if mean > 10_000.0 {
        let half = 1.959_963_985 * sd + 0.5;
        return (libm::floor(mean - half) as u64, (libm::ceil(mean + half) as u64).min(n));
    }
    let log_factorial = |k: u64| libm::lgamma(k as f64 + 1.0);
    let probability = |k: u64| {
        let choose = log_factorial(n) - log_factorial(k) - log_factorial(n - k);
        libm::exp(choose + k as f64 * libm::log(p) + (n - k) as f64 * libm::log1p(-p))
    };
    let (mut below, mut fewest) = (0.0, None);
    for k in 0..=n {
        below += probability(k);
        if fewest.is_none() && below > 0.025 {
            fewest = Some(k);
        }
        if below >= 0.975 {
            return (fewest.unwrap_or(0), k);
        }
    }
    (fewest.unwrap_or(0), n)
}

/// Deviation of an estimate from its closed form in standard errors: `proven` bounds what rounding adds.
pub fn z_score(value: f64, oracle: f64, se: f64, proven: f64) -> Option<f64> {
    let sigma = libm::hypot(se, proven);
    (sigma > 0.0).then(|| (value - oracle) / sigma)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::moments::{bin, level};
    use crate::kernel::word::Scalar;

    fn tally_of(errors: impl IntoIterator<Item = i32>, base: u32) -> Moments {
        let mut tally = Moments::empty(true);
        for error in errors {
            tally.count += 1;
            tally.sum += i128::from(error);
            tally.square += (i64::from(error) * i64::from(error)) as u128;
            tally.least = tally.least.min(error);
            tally.greatest = tally.greatest.max(error);
            tally.bins[bin(Scalar(error as u32), base).0 as usize] += 1;
        }
        tally
    }

    #[test]
    fn the_standard_error_of_the_rms_is_that_of_a_sine_and_not_of_a_normal_distribution() {
        let n = 100_000;
        let sine =
            (0..n).map(|k| (1e6 * libm::sin(f64::from(k) / f64::from(n) * core::f64::consts::TAU)) as i32);
        let base = level(176_776);
        let estimates = Estimates::of(&tally_of(sine, base), base, 0.5).unwrap();
        let rms = 1e6 / libm::sqrt(2.0) * 0.5;
        assert!((estimates.rms / rms - 1.0).abs() < 1e-5, "{estimates:?}");
        // E⁴ of a sine is 3/8, so se = rms √(1/2) / (2 √n); a normal law would say rms √2 / (2 √n).
        let expected = rms * libm::sqrt(0.5) / (2.0 * libm::sqrt(f64::from(n)));
        assert!((estimates.rms_se.unwrap() / expected - 1.0).abs() < 0.01, "{estimates:?}, not {expected}");
        assert_eq!(estimates.max, 5e5);
    }

    #[test]
    fn the_quantile_of_an_even_spread_is_found_within_its_bounds() {
        let n = 200_000;
        let base = level(n as u32 / 8);
        let q = Estimates::of(&tally_of(1..=n, base), base, 1.0).unwrap().q9973.unwrap();
        let exact = LEVEL * f64::from(n);
        assert!((q.value / exact - 1.0).abs() < 1e-3, "{q:?}");
        let (low, high) = (q.low.unwrap(), q.high.unwrap());
        assert!(low < exact && exact < high && high - low < 0.02 * exact, "{q:?}");
    }

    #[test]
    fn a_quantile_that_few_trials_cannot_bound_has_no_upper_end() {
        let q = Estimates::of(&tally_of(1..=100, 0), 0, 1.0).unwrap().q9973.unwrap();
        assert_eq!(q.high, None);
        assert!(q.low.is_some());
    }

    #[test]
    fn one_trial_and_no_trial_and_all_zero_are_answered_without_invention() {
        assert_eq!(Estimates::of(&Moments::empty(true), 0, 1.0), None);
        let one = Estimates::of(&tally_of([7], 0), 0, 1.0).unwrap();
        assert_eq!((one.rms, one.rms_se), (7.0, None));
        let zero = Estimates::of(&tally_of([0, 0, 0], 0), 0, 1.0).unwrap();
        assert_eq!((zero.rms, zero.rms_se, zero.max), (0.0, None, 0.0));
    }

    #[test]
    fn binomial_intervals_are_those_of_the_tables() {
        // scipy.stats.binom.ppf([0.025, 0.975], n, 0.0027)
        for (n, interval) in [(100, (0, 2)), (1000, (0, 6)), (100_000, (238, 303))] {
            assert_eq!(binomial_interval(n, 1.0 - LEVEL), interval, "n = {n}");
        }
    }
}
