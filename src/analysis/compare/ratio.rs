//! Two curves at their common averaging times, and their ratio.

use crate::analysis::compare::MIN_P;
use crate::analysis::compare::rows::Verdict;
use sagnac_records::allan::{Deviation, Point, fisher};

/// Largest relative difference between two averaging times that count as one.
pub const NEAREST: f64 = 0.02;
/// Relative difference below which averaging times are the same, given the agreement of clocks.
const SAME: f64 = 1e-4;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// The averaging factors of two records at common times.
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// Factors of the first and of the second record, rising.
    pub factors: Vec<[usize; 2]>,
    /// Octaves of the longer step for which the other record has no time within [`NEAREST`].
    pub left_out: usize,
    /// The largest relative difference between two times that count as one; 0 where all are the same.
    pub farthest: f64,
}

/// A step, s, with the number of samples.
pub(crate) type Sampling = (f64, usize);

impl Common {
    /// The octaves of the record with the longer step, as far as both records extend.
    pub(crate) fn of(a: Sampling, b: Sampling) -> Common {
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
    pub(crate) fn of(a: Point, b: Point) -> Ratio {
        let positive = |point: &Point| point.value.filter(|value| *value > 0.0);
        let value = positive(&a).zip(positive(&b)).map(|(a, b)| b / a);
        let degrees = b.edf.zip(a.edf);
        let known = value.zip(degrees);
        let tail = 0.5 * (1.0 - CONFIDENCE);
        let interval = known.and_then(|(value, (numerator, denominator))| {
            let end = |probability| fisher::quantile(probability, numerator, denominator).map(libm::sqrt);
            Some([value / end(1.0 - tail)?, value / end(tail)?])
        });
        let p = known.and_then(|(value, (numerator, denominator))| {
            let [below, above] = fisher::tails(value * value, numerator, denominator)?;
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
mod tests {
    use super::*;

    #[test]
    fn equal_steps_have_the_octaves_of_the_shorter_record() {
        let common = Common::of((1.0, 1000), (1.0, 100));
        assert_eq!(common.factors, [[1, 1], [2, 2], [4, 4], [8, 8], [16, 16], [32, 32]]);
        assert_eq!((common.left_out, common.farthest), (0, 0.0));
    }

    #[test]
    fn a_multiple_of_a_step_has_its_octaves_whichever_record_comes_first() {
        let common = Common::of((0.01, 1000), (0.1, 64));
        assert_eq!(common.factors, [[10, 1], [20, 2], [40, 4], [80, 8], [160, 16], [320, 32]]);
        assert_eq!(Common::of((0.1, 64), (0.01, 1000)).factors[1], [2, 20]);
        // Steps of two clocks that differ by 20 ppm.
        assert_eq!(Common::of((0.01, 1000), (0.100_002, 64)).farthest, 0.0);
    }

    #[test]
    fn other_rates_meet_within_two_percent_or_not_at_all() {
        let common = Common::of((1.0, 4096), (1.3, 4096));
        assert!(common.left_out > 0 && common.farthest > SAME, "{common:?}");
        for [a, b] in &common.factors {
            let apart = (*a as f64 / (1.3 * *b as f64) - 1.0).abs();
            assert!(apart <= NEAREST && b.is_power_of_two(), "{a} and {b}");
        }
        assert!(Common::of((1.0, 100), (64.0, 100)).factors.is_empty());
    }
}
