//! Estimates of the difference and of the ratio of two coefficients.

use crate::analysis::compare::MIN_P;
use crate::analysis::compare::logs::Verdict;
use sagnac_records::allan::{Deviation, Point, distributions};
use sagnac_records::fit::uncertainty::Evidence;

/// Number of grid points, and of golden sections of one grid step on either side.
const GRID: u32 = 16;
const SECTIONS: usize = 24;

/// An estimate, which is more or less rare depending on the true value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Estimate {
    /// An estimate of the square of a coefficient.
    Square(Evidence),
    /// An estimate of a correlation time or a frequency: its value and the standard error of its logarithm.
    Logarithm { value: f64, error: f64 },
}

impl Estimate {
    /// The coefficient or shape for which the estimate has the deviate `deviate`; see [`Evidence::square_at`].
    pub(crate) fn at(&self, deviate: f64) -> Option<f64> {
        match self {
            Estimate::Square(evidence) => evidence.square_at(deviate).map(libm::sqrt),
            Estimate::Logarithm { value, error } => Some(value * libm::exp(-deviate * error)),
        }
    }

    /// The estimated value, in the same unit.
    pub(crate) fn found(&self) -> f64 {
        match self {
            Estimate::Square(evidence) => libm::sqrt(evidence.estimate()),
            Estimate::Logarithm { value, .. } => *value,
        }
    }

    fn deviate(&self, value: f64) -> f64 {
        match self {
            Estimate::Square(evidence) => evidence.deviate(value * value),
            Estimate::Logarithm { value: found, error } => (libm::log(*found) - libm::log(value)) / error,
        }
    }
}

/// Two estimates of the same quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Two {
    pub a: Estimate,
    pub b: Estimate,
}

impl Two {
    /// The distance between them, in standard deviations of a normal number, and the common value with that distance.
    pub(crate) fn distance(&self) -> (f64, f64) {
        let middle = |estimate: &Estimate| estimate.at(0.0).unwrap_or(estimate.found());
        let (a, b) = (middle(&self.a), middle(&self.b));
        let (low, high) = (a.min(b), a.max(b));
        let square = |value: f64| {
            let (a, b) = (self.a.deviate(value), self.b.deviate(value));
            a * a + b * b
        };
        if low == high {
            return (0.0, low);
        }
        let (value, least) = least(low, high, square);
        (libm::sqrt(least), value)
    }

    /// The 95 % interval of `of`, a function that falls with the first value and rises with the second.
    ///
    /// `of` receives `None` for a value without a bound.
    pub(crate) fn interval(&self, distance: f64, of: impl Fn(Option<f64>, Option<f64>) -> f64) -> [f64; 2] {
        let quarter = core::f64::consts::FRAC_PI_2;
        let at = |turn: f64, sign: f64| {
            // The exact quarter avoids the rounding of cos π/2, which would request a value beyond every bound.
            let (a, b) = if turn >= quarter { (1.0, 0.0) } else { (libm::sin(turn), libm::cos(turn)) };
            of(self.a.at(sign * distance * a), self.b.at(-sign * distance * b))
        };
        let (_, highest) = least(0.0, quarter, |turn| -at(turn, 1.0));
        let (_, lowest) = least(0.0, quarter, |turn| at(turn, -1.0));
        [lowest, -highest]
    }
}

/// The minimum of a function and its value, by a grid and golden sections around its best point.
fn least(low: f64, high: f64, of: impl Fn(f64) -> f64) -> (f64, f64) {
    let step = (high - low) / f64::from(GRID);
    let at = |i: u32| if i == GRID { high } else { low + f64::from(i) * step };
    let grid = (0..=GRID).map(|i| (at(i), of(at(i)))).min_by(|x, y| x.1.total_cmp(&y.1));
    let (start, mut best) = grid.unwrap_or((low, of(low)));
    if !best.is_finite() {
        return (start, best);
    }
    let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
    let (mut from, mut to) = ((start - step).max(low), (start + step).min(high));
    let mut inner = [to - golden * (to - from), from + golden * (to - from)];
    let mut values = inner.map(&of);
    let mut place = start;
    for _ in 0..SECTIONS {
        let better = usize::from(values[1] < values[0]);
        if values[better] < best {
            (place, best) = (inner[better], values[better]);
        }
        if better == 0 {
            to = inner[1];
            inner = [to - golden * (to - from), inner[0]];
            values = [of(inner[0]), values[0]];
        } else {
            from = inner[0];
            inner = [inner[1], from + golden * (to - from)];
            values = [values[1], of(inner[1])];
        }
    }
    (place, best)
}

/// Largest relative difference between two averaging times that count as one.
pub const NEAREST: f64 = 0.02;
/// Relative difference below which averaging times are the same, given the agreement of clocks.
pub(crate) const SAME: f64 = 1e-4;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// The averaging factors of two records at common times.
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// Factors of the first and of the second record, rising; empty where a curve is of no record.
    pub factors: Vec<[usize; 2]>,
    /// Octaves of the longer step, or points of a curve, for which the other has no time within [`NEAREST`].
    pub left_out: usize,
    /// The largest relative difference between two times that count as one; 0 where all are the same.
    pub farthest: f64,
}

/// A step, s, with the number of samples.
pub(crate) type Sampling = (f64, usize);

impl Common {
    /// Common times of curves of which one is of no record, so that they have no factors.
    pub(crate) fn new_of(left_out: usize, farthest: f64) -> Common {
        Common { factors: vec![], left_out, farthest: if farthest > SAME { farthest } else { 0.0 } }
    }

    /// The octaves of the record with the longer step, as far as both records extend.
    pub(crate) fn new(a: Sampling, b: Sampling) -> Common {
        let swapped = a.0 < b.0;
        let ((long, samples), (short, others)) = if swapped { (b, a) } else { (a, b) };
        let longest = |samples: usize| Deviation::Oadev.largest_factor(samples + 1);
        let mut common = Common { factors: vec![], left_out: 0, farthest: 0.0 };
        for m in (0..usize::BITS - 1).map(|octave| 1_usize << octave).take_while(|&m| m <= longest(samples)) {
            let exact = m as f64 * long / short;
            let nearest = libm::round(exact);
            if nearest > longest(others) as f64 {
                break;
            }
            let apart = (nearest / exact - 1.0).abs();
            if apart > NEAREST {
                common.left_out += 1;
                continue;
            }
            common.farthest = common.farthest.max(if apart > SAME { apart } else { 0.0 });
            common.factors.push(if swapped { [nearest as usize, m] } else { [m, nearest as usize] });
        }
        common
    }
}

/// Two deviations at one averaging time, and the ratio of the second to the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// Points of the first and of the second record, whose times differ by at most [`NEAREST`].
    pub points: [Point; 2],
    /// Ratio; absent where a deviation is absent or 0.
    pub value: Option<f64>,
    /// 95 % interval of the ratio of the true deviations.
    pub interval: Option<[f64; 2]>,
    /// Probability of a ratio at least as far from 1, on either side, if the true deviations are equal.
    pub p: Option<f64>,
}

impl Ratio {
    /// The ratio of the variances of Gaussian noise has the F distribution with their equivalent degrees of freedom.
    pub(crate) fn new(a: Point, b: Point) -> Ratio {
        let positive = |point: &Point| point.value.filter(|value| *value > 0.0);
        let value = positive(&a).zip(positive(&b)).map(|(a, b)| b / a);
        let degrees = b.edf.zip(a.edf);
        let known = value.zip(degrees);
        let tail = 0.5 * (1.0 - CONFIDENCE);
        let interval = known.and_then(|(value, (numerator, denominator))| {
            let end =
                |probability| distributions::f_quantile(probability, numerator, denominator).map(libm::sqrt);
            Some([value / end(1.0 - tail)?, value / end(tail)?])
        });
        let p = known.and_then(|(value, (numerator, denominator))| {
            let [below, above] = distributions::f_tails(value * value, numerator, denominator)?;
            Some((2.0 * below.min(above)).clamp(MIN_P, 1.0))
        });
        Ratio { points: [a, b], value, interval, p }
    }

    /// Averaging time of the first record, s.
    pub fn tau_s(&self) -> f64 {
        self.points[0].tau_s
    }

    /// Whether the interval lies above 1, below 1 or contains it; `None` without an interval.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(match self.interval? {
            [low, _] if low > 1.0 => Verdict::Higher,
            [_, high] if high < 1.0 => Verdict::Lower,
            _ => Verdict::Consistent,
        })
    }
}

#[cfg(test)]
mod estimate_tests {
    use super::*;
    use sagnac_records::fit::uncertainty::{Variance, WITHIN_95};

    fn square(estimate: f64, variance: [f64; 3]) -> Estimate {
        Estimate::Square(Evidence::new(estimate, Variance(variance)))
    }

    fn difference(a: Option<f64>, b: Option<f64>) -> f64 {
        b.unwrap_or(f64::INFINITY) - a.unwrap_or(f64::INFINITY)
    }

    #[test]
    fn normal_squares_are_apart_by_their_difference_over_its_standard_error() {
        let two = Two { a: square(40.0, [1.0, 0.0, 0.0]), b: square(44.0, [3.0, 0.0, 0.0]) };
        let (distance, value) = two.distance();
        assert!((distance - 2.0).abs() < 1e-9, "{distance}");
        // The mean weighted by the inverse variances.
        assert!((value * value - 41.0).abs() < 1e-4, "{value}");
    }

    #[test]
    fn the_interval_ends_at_0_where_both_are_1_96_apart() {
        for variance in [[1.0, 0.0, 0.0], [0.5, 0.1, 0.02], [0.0, 0.01, 0.1]] {
            for apart in [WITHIN_95 * 0.98, WITHIN_95 * 1.02] {
                // The second estimate at which both have this distance.
                let (mut low, mut high) = (10.0, 1e4);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let two = Two { a: square(10.0, variance), b: square(middle, variance) };
                    if two.distance().0 < apart { low = middle } else { high = middle }
                }
                let two = Two { a: square(10.0, variance), b: square(low, variance) };
                let [lower, upper] = two.interval(WITHIN_95, difference);
                assert_eq!(lower > 0.0, apart > WITHIN_95, "{variance:?}, {apart}: {lower} … {upper}");
                assert!(lower.abs() < 0.2 * upper, "{variance:?}: {lower} … {upper}");
            }
        }
    }

    #[test]
    fn the_same_estimate_twice_is_not_apart_and_its_interval_is_about_0() {
        let one = square(2.0, [0.1, 0.1, 0.05]);
        let two = Two { a: one, b: one };
        assert_eq!(two.distance().0, 0.0);
        let [low, high] = two.interval(WITHIN_95, difference);
        assert!(low < 0.0 && (low + high).abs() < 1e-9, "{low} … {high}");
    }

    #[test]
    fn what_scatters_without_bound_has_no_end() {
        // With three degrees of freedom nothing is left 1.96 standard deviations below the middle.
        let two = Two { a: square(1.0, [0.01, 0.0, 0.0]), b: square(1.0, [0.0, 0.0, 2.0]) };
        let [low, high] = two.interval(WITHIN_95, difference);
        assert!(low.is_finite() && high == f64::INFINITY, "{low} … {high}");
    }

    #[test]
    fn logarithms_are_apart_by_their_ratio() {
        let two = Two {
            a: Estimate::Logarithm { value: 100.0, error: 0.3 },
            b: Estimate::Logarithm { value: 100.0 * libm::exp(1.0), error: 0.4 },
        };
        assert!((two.distance().0 - 2.0).abs() < 1e-9, "{:?}", two.distance());
        let [low, high] = two.interval(WITHIN_95, |a, b| b.unwrap_or(f64::NAN) / a.unwrap_or(f64::NAN));
        assert!((libm::log(high) - 1.0 - 0.5 * WITHIN_95).abs() < 1e-9, "{high}");
        assert!((libm::log(low) - 1.0 + 0.5 * WITHIN_95).abs() < 1e-9, "{low}");
    }
}

#[cfg(test)]
mod ratio_tests {
    use super::*;

    #[test]
    fn equal_steps_have_the_octaves_of_the_shorter_record() {
        let common = Common::new((1.0, 1000), (1.0, 100));
        assert_eq!(common.factors, [[1, 1], [2, 2], [4, 4], [8, 8], [16, 16], [32, 32]]);
        assert_eq!((common.left_out, common.farthest), (0, 0.0));
    }

    #[test]
    fn a_multiple_of_a_step_has_its_octaves_whichever_record_comes_first() {
        let common = Common::new((0.01, 1000), (0.1, 64));
        assert_eq!(common.factors, [[10, 1], [20, 2], [40, 4], [80, 8], [160, 16], [320, 32]]);
        assert_eq!(Common::new((0.1, 64), (0.01, 1000)).factors[1], [2, 20]);
        // Steps of two clocks that differ by 20 ppm.
        assert_eq!(Common::new((0.01, 1000), (0.100_002, 64)).farthest, 0.0);
    }

    #[test]
    fn other_rates_meet_within_two_percent_or_not_at_all() {
        let common = Common::new((1.0, 4096), (1.3, 4096));
        assert!(common.left_out > 0 && common.farthest > SAME, "{common:?}");
        for [a, b] in &common.factors {
            let apart = (*a as f64 / (1.3 * *b as f64) - 1.0).abs();
            assert!(apart <= NEAREST && b.is_power_of_two(), "{a} and {b}");
        }
        assert!(Common::new((1.0, 100), (64.0, 100)).factors.is_empty());
    }
}
