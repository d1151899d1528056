//! The trend removed from a record before its deviations are computed.

/// The trend removed from the rate in addition to its mean, which affects no deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trend {
    /// Nothing more: the rate ramp R and the rate random walk K are those of the record.
    None,
    /// The least-squares straight line. It removes the rate ramp R and the part of the slowest rate random walk that
    /// resembles a line. For rate random walk alone, the deviation and K are then 8 % too low at a tenth of the record,
    /// 21 % at a fifth and 84 % at half (400 simulated records).
    Linear,
}

/// A straight line over the increments 0, 1, … of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The mean of the increments.
    pub mean: f64,
    /// Change from increment to increment.
    pub slope: f64,
    /// Position at which the line passes through the mean.
    middle: f64,
}

impl Line {
    /// The mean, and with [`Trend::Linear`] the slope, of the finite ones of `count` increments.
    pub(crate) fn of(trend: Trend, count: usize, increment: impl Fn(usize) -> f64) -> Line {
        let known = || (0..count).map(|i| (i as f64, increment(i))).filter(|(_, y)| y.is_finite());
        let (number, sum) = known().fold((0_usize, 0.0), |(number, sum), (_, y)| (number + 1, sum + y));
        let mean = if number == 0 { 0.0 } else { sum / number as f64 };
        if number == 0 || trend == Trend::None {
            return Line { mean, slope: 0.0, middle: 0.0 };
        }
        let middle = known().map(|(i, _)| i).sum::<f64>() / number as f64;
        let (mut product, mut square) = (0.0, 0.0);
        for (i, y) in known() {
            product += (i - middle) * (y - mean);
            square += (i - middle) * (i - middle);
        }
        Line { mean, slope: if square > 0.0 { product / square } else { 0.0 }, middle }
    }

    /// The value at increment `i`.
    pub(crate) fn at(&self, i: usize) -> f64 {
        self.mean + self.slope * (i as f64 - self.middle)
    }

    /// The sum over the first `k` increments.
    pub(crate) fn sum(&self, k: usize) -> f64 {
        let k = k as f64;
        k * (self.mean + self.slope * (0.5 * (k - 1.0) - self.middle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_that_of_least_squares_over_the_known_increments() {
        // By hand: places 0, 1, 3 and values 1, 2, 6; means 4/3 and 3, slope (8/3 + 1/3 + 5) / (14/3).
        let values = [1.0, 2.0, f64::NAN, 6.0];
        let line = Line::of(Trend::Linear, 4, |i| values[i]);
        assert!((line.mean - 3.0).abs() < 1e-15 && (line.slope - 12.0 / 7.0).abs() < 1e-15, "{line:?}");
        let sum: f64 = (0..4).map(|i| line.at(i)).sum();
        assert!((line.sum(4) - sum).abs() < 1e-14);
        assert_eq!(Line::of(Trend::None, 4, |i| values[i]).slope, 0.0);
    }
}
