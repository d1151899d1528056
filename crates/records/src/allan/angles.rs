//! The record of angles, with its gaps, from which all deviations are computed, and the trend removed from it before.

use std::ops::Range;
use std::sync::OnceLock;

use crate::allan::Overdispersion;

/// Angles at evenly spaced times: the integral of a rate without its mean.
///
/// No deviation depends on the mean rate. It is subtracted before anything is summed, because the running sum of a rate
/// whose mean is a million times its noise would keep six digits less of the noise.
#[derive(Debug, Clone)]
pub struct Angles {
    /// Time from angle to angle, s.
    pub step_s: f64,
    /// The angles; NaN where one is unknown.
    values: Vec<f64>,
    /// Stretches of angles, in order, that were measured relative to each other; between two stretches increments are
    /// missing.
    runs: Vec<Range<usize>>,
    /// The line that was removed, in the original unit of the increments.
    removed: Line,
    missing: usize,
    /// Number of known increments before each angle; absent where none is missing.
    known: Option<Vec<u32>>,
    /// Computed when first asked for, since several results of a record need them.
    spread: OnceLock<Overdispersion>,
    bridged: OnceLock<Bridged>,
}

/// The angles with short gaps filled by straight lines, for estimates that need unbroken stretches.
#[derive(Debug, Clone)]
struct Bridged {
    values: Vec<f64>,
    runs: Vec<Range<usize>>,
    share: f64,
}

/// Most samples of a gap that is bridged, and the number of samples on each side whose means the line joins.
const BRIDGED: usize = 64;
const BESIDE: usize = 8;

/// Number of increments over which the scatter of a sample is taken.
const SCATTERED: usize = 16;
/// Most such stretches, which give the scatter to 0.2 %.
const MAX_SCATTERED: usize = 1 << 16;

impl Angles {
    /// The running sums of `increments`, each times `scale`; NaN stands for a missing one.
    ///
    /// For rates, `scale` is `step_s` times the size of their unit. Across a missing increment the change of the angle
    /// is unknown, so no term reaches across it.
    ///
    /// ```
    /// # use sagnac_records::allan::{Angles, Trend};
    /// let angles = Angles::from_increments(&[1.0, 2.0, f64::NAN, 4.0, 5.0], 1.0, 0.01, Trend::None);
    /// assert_eq!((angles.len(), angles.missing()), (6, 1));
    /// ```
    pub fn from_increments(increments: &[f64], scale: f64, step_s: f64, trend: Trend) -> Angles {
        let line = Line::new(trend, increments.len(), |i| increments[i]);
        let mut values = Vec::with_capacity(increments.len() + 1);
        let (mut runs, mut start, mut missing, mut angle) = (Vec::new(), 0, 0, 0.0);
        values.push(0.0);
        for (i, increment) in increments.iter().enumerate() {
            if increment.is_finite() {
                angle += (increment - line.at(i)) * scale;
            } else {
                missing += 1;
                runs.extend(worth_keeping(start..i + 1));
                start = i + 1;
            }
            values.push(angle);
        }
        runs.extend(worth_keeping(start..values.len()));
        let known = (missing > 0).then(|| counts(increments.iter().map(|increment| increment.is_finite())));
        let (spread, bridged) = Default::default();
        Angles { step_s, values, runs, removed: line, missing, known, spread, bridged }
    }

    /// Measured `angles`, each times `scale`; NaN stands for a missing one.
    ///
    /// Angles on both sides of a missing one are still known relative to each other, so only terms that need the
    /// missing angle are left out.
    pub fn from_angles(angles: &[f64], scale: f64, step_s: f64, trend: Trend) -> Angles {
        let line = Line::new(trend, angles.len().saturating_sub(1), |i| angles[i + 1] - angles[i]);
        let first = angles.iter().copied().find(|angle| angle.is_finite()).unwrap_or(0.0);
        let values: Vec<f64> = angles
            .iter()
            .enumerate()
            .map(|(k, angle)| {
                let value = (angle - first - line.sum(k)) * scale;
                if value.is_finite() { value } else { f64::NAN }
            })
            .collect();
        let missing = values.iter().filter(|value| value.is_nan()).count();
        Angles {
            step_s,
            runs: worth_keeping(0..values.len()).into_iter().collect(),
            values,
            removed: line,
            missing,
            known: None,
            spread: OnceLock::new(),
            bridged: OnceLock::new(),
        }
    }

    /// The number of angles, including missing ones.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no angles.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The number of missing increments or angles.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Mean and slope of the increments that were removed, in the original unit of the increments.
    pub fn removed(&self) -> Line {
        self.removed
    }

    /// The angles of a part of the record.
    pub fn part(&self, range: Range<usize>) -> Angles {
        let inside = |run: &Range<usize>| {
            let (start, end) = (run.start.max(range.start), run.end.min(range.end));
            (start < end).then(|| start - range.start..end - range.start).and_then(worth_keeping)
        };
        let runs: Vec<Range<usize>> = self.runs.iter().filter_map(inside).collect();
        let values = self.values[range.clone()].to_vec();
        let known = self.known.as_ref().map(|known| known[range].to_vec());
        let (spread, bridged) = Default::default();
        let mut part = Angles { values, runs, known, spread, bridged, ..*self };
        part.missing = match part.has_unknown() {
            true => part.values.iter().filter(|value| value.is_nan()).count(),
            false => part.len() - 1 - part.runs.iter().map(|run| run.len() - 1).sum::<usize>(),
        };
        part
    }

    /// Deviations of the Allan variances of the record beyond those of Gaussian noise.
    pub fn spread(&self) -> &Overdispersion {
        match self.spread.get() {
            Some(spread) => spread,
            // Not inside the lock, for which a thread of the same pool could wait for ever.
            None => {
                let spread = Overdispersion::new(self);
                self.spread.get_or_init(|| spread)
            }
        }
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether some angles within stretches are unknown.
    pub(crate) fn has_unknown(&self) -> bool {
        // Missing increments split the record into stretches and leave no angle unknown.
        self.runs.len() <= 1 && self.missing > 0 && self.values.iter().any(|value| value.is_nan())
    }

    /// The stretches within which angles are known relative to each other.
    pub(crate) fn runs(&self) -> &[Range<usize>] {
        &self.runs
    }

    /// The stretches in which every angle is known.
    pub(crate) fn solid_runs(&self) -> Vec<Range<usize>> {
        if !self.has_unknown() {
            return self.runs.clone();
        }
        let mut solid = Vec::new();
        for run in &self.runs {
            let mut start = run.start;
            for k in run.clone().filter(|&k| self.values[k].is_nan()) {
                solid.extend(worth_keeping(start..k));
                start = k + 1;
            }
            solid.extend(worth_keeping(start..run.end));
        }
        solid
    }

    /// Number of known increments before each angle; `None` where no increment is missing.
    pub(crate) fn known(&self) -> Option<&[u32]> {
        self.known.as_deref()
    }

    /// The mean rate over some increments, in the unit of the angle per second, with the share of them that is known; `None` where
    /// none is.
    pub(crate) fn mean_rate(&self, range: Range<usize>) -> Option<(f64, f64)> {
        if self.known.is_none() && range.end < self.len() {
            let mean =
                (self.values[range.end] - self.values[range.start]) / (range.len() as f64 * self.step_s);
            if mean.is_finite() {
                return Some((mean, 1.0));
            }
        }
        let rates = self.rates(range);
        let (count, sum) =
            rates.iter().filter(|x| x.is_finite()).fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
        (count > 0.0).then(|| (sum / count, count / rates.len() as f64))
    }

    /// The rates of some increments, in the unit of the angle per second; NaN where one is missing.
    pub(crate) fn rates(&self, range: Range<usize>) -> Vec<f64> {
        let is_known = |i: usize| self.known.as_ref().is_none_or(|known| known[i + 1] > known[i]);
        let rate = |i: usize| (self.values[i + 1] - self.values[i]) / self.step_s;
        range.map(|i| if is_known(i) { rate(i) } else { f64::NAN }).collect()
    }

    /// The record without the rate of an event at each increment, and without some increments, which are missing then.
    pub(crate) fn without(&self, rates: Option<&[f64]>, missing: &[usize]) -> Angles {
        let mut values = self.values.clone();
        let (mut sum, mut missed) = (0.0, missing.iter().peekable());
        for i in 0..self.len() - 1 {
            let is_known = self.known.as_ref().is_none_or(|known| known[i + 1] > known[i]);
            let increment = self.values[i + 1] - self.values[i];
            if missed.next_if(|&&sample| sample == i).is_some() {
                sum += if increment.is_finite() { increment } else { 0.0 };
            } else if let Some(rates) = rates.filter(|_| is_known) {
                sum += rates[i] * self.step_s;
            }
            values[i + 1] -= sum;
        }
        let (spread, bridged) = Default::default();
        let mut without =
            Angles { values, spread, bridged, runs: self.runs.clone(), known: self.known.clone(), ..*self };
        // Unknown angles do not go with missing increments: there an increment of nothing takes the place.
        if missing.is_empty() || self.has_unknown() {
            return without;
        }
        let mut are = vec![true; self.len() - 1];
        missing.iter().for_each(|&i| are[i] = false);
        let known =
            |(i, is): (usize, &bool)| *is && self.known.as_ref().is_none_or(|known| known[i + 1] > known[i]);
        let known = counts(are.iter().enumerate().map(known));
        without.missing = self.len() - 1 - known[self.len() - 1] as usize;
        without.runs = Vec::new();
        let mut start = 0;
        for i in (0..self.len() - 1).filter(|&i| known[i + 1] == known[i]) {
            without.runs.extend(worth_keeping(start..i + 1));
            start = i + 1;
        }
        without.runs.extend(worth_keeping(start..self.len()));
        without.known = Some(known);
        without
    }

    /// Share of the increments, or of the angles, that are known.
    pub(crate) fn share(&self) -> f64 {
        1.0 - self.missing as f64 / self.len().max(1) as f64
    }

    /// Variance of an increment about the mean of its neighbourhood, in the square of the unit of the angle.
    pub(crate) fn scatter(&self) -> f64 {
        let known = |i: usize| self.known.as_ref().is_none_or(|known| known[i + 1] > known[i]);
        let (mut squares, mut freedom) = (0.0, 0);
        let blocks = self.len() / SCATTERED;
        let stride = SCATTERED * (blocks / MAX_SCATTERED).max(1);
        for start in (0..self.len().saturating_sub(1)).step_by(stride) {
            let places = || (start..(start + SCATTERED).min(self.len() - 1)).filter(|&i| known(i));
            let increment = |i: usize| self.values[i + 1] - self.values[i];
            let (count, sum) = places().fold((0, 0.0), |(count, sum), i| (count + 1, sum + increment(i)));
            if count > 1 {
                let mean = sum / f64::from(count);
                squares += places().map(|i| (increment(i) - mean) * (increment(i) - mean)).sum::<f64>();
                freedom += count - 1;
            }
        }
        squares / f64::from(freedom)
    }

    /// The angles with short gaps filled by straight lines: between the angles on both sides where one is unknown, and between the
    /// mean increments of the neighbourhood on both sides where increments are missing.
    pub fn bridged(&self) -> Solid<'_> {
        if self.missing == 0 {
            return Solid { values: &self.values, runs: &self.runs, share: 1.0 };
        }
        let Bridged { values, runs, share } = self.bridged.get_or_init(|| match &self.known {
            Some(known) => self.with_increments(known),
            None => self.with_angles(),
        });
        Solid { values, runs, share: *share }
    }

    fn with_increments(&self, known: &[u32]) -> Bridged {
        let count = self.len() - 1;
        let is_known = |i: &usize| known[i + 1] > known[*i];
        let mean = |places: &mut dyn Iterator<Item = usize>| {
            let taken = places.filter(is_known).take(BESIDE);
            let (count, sum) = taken
                .fold((0.0, 0.0), |(count, sum), i| (count + 1.0, sum + self.values[i + 1] - self.values[i]));
            sum / count
        };
        let mut bridge = Bridged { values: vec![0.0], runs: vec![], share: 1.0 };
        let (mut start, mut angle, mut filled, mut i) = (0, 0.0, 0, 0);
        while i < count {
            if is_known(&i) {
                angle += self.values[i + 1] - self.values[i];
                bridge.values.push(angle);
                i += 1;
                continue;
            }
            let end = (i..count).find(is_known).unwrap_or(count);
            let before = mean(&mut (i.saturating_sub(BRIDGED)..i).rev());
            let after = mean(&mut (end..(end + BRIDGED).min(count)));
            let is_bridged = end - i <= BRIDGED && before.is_finite() && after.is_finite();
            for place in i..end {
                let part = (place - i + 1) as f64 / (end - i + 1) as f64;
                angle += if is_bridged { before + (after - before) * part } else { 0.0 };
                bridge.values.push(angle);
            }
            if is_bridged {
                filled += end - i;
            } else {
                bridge.runs.extend(worth_keeping(start..i + 1));
                start = end;
            }
            i = end;
        }
        bridge.runs.extend(worth_keeping(start..self.len()));
        let all: usize = bridge.runs.iter().map(|run| run.len() - 1).sum();
        bridge.share = 1.0 - filled as f64 / all.max(1) as f64;
        bridge
    }

    fn with_angles(&self) -> Bridged {
        let mut bridge = Bridged { values: self.values.clone(), runs: vec![], share: 1.0 };
        let (mut start, mut before) = (0, None);
        for (i, value) in self.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            match before {
                Some(k) if i - k > 1 + BRIDGED => {
                    bridge.runs.extend(worth_keeping(start..k + 1));
                    start = i;
                }
                Some(k) => {
                    let slope = (value - self.values[k]) / (i - k) as f64;
                    (k + 1..i).for_each(|j| bridge.values[j] = self.values[k] + slope * (j - k) as f64);
                }
                None => start = i,
            }
            before = Some(i);
        }
        bridge.runs.extend(before.and_then(|k| worth_keeping(start..k + 1)));
        bridge
    }
}

/// Stretches of angles in which every angle is known or bridged.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    /// The angles; of no meaning outside the stretches.
    pub values: &'a [f64],
    /// The stretches.
    pub runs: &'a [Range<usize>],
    /// Share of the increments in them that were measured.
    pub share: f64,
}

/// The number of true ones before each place, and that of all.
fn counts(are: impl Iterator<Item = bool>) -> Vec<u32> {
    let mut count = 0;
    let rising = are.map(|is| {
        count += u32::from(is);
        count
    });
    std::iter::once(0).chain(rising).collect()
}

/// A single angle has no difference.
fn worth_keeping(run: Range<usize>) -> Option<Range<usize>> {
    (run.len() > 1).then_some(run)
}

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
    pub(crate) fn new(trend: Trend, count: usize, increment: impl Fn(usize) -> f64) -> Line {
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

    const GAP: f64 = f64::NAN;

    #[test]
    fn a_missing_increment_splits_the_record_and_a_missing_angle_does_not() {
        let increments = Angles::from_increments(&[1.0, GAP, GAP, 2.0, 3.0], 1.0, 1.0, Trend::None);
        assert_eq!(increments.runs(), [0..2, 3..6]);
        assert_eq!((increments.missing(), increments.has_unknown()), (2, false));
        let angles = Angles::from_angles(&[0.0, 1.0, GAP, 2.0, 3.0], 1.0, 1.0, Trend::None);
        assert_eq!(angles.runs(), std::slice::from_ref(&(0..5)));
        assert_eq!((angles.missing(), angles.has_unknown()), (1, true));
    }

    #[test]
    fn a_part_has_the_runs_and_gaps_within_it() {
        let mut increments: Vec<f64> = (0..12).map(f64::from).collect();
        increments[4] = GAP;
        let of_increments = Angles::from_increments(&increments, 1.0, 1.0, Trend::None);
        let whole = of_increments.part(0..13);
        assert_eq!((whole.values(), whole.runs()), (of_increments.values(), of_increments.runs()));
        let (one, two, rest) = ([(0, 5)], [(0, 2), (2, 5)], [(0, 7)]);
        for (range, runs, missing) in [(0..5, &one[..], 0), (3..8, &two, 1), (6..13, &rest, 0)] {
            let part = of_increments.part(range.clone());
            let found: Vec<(usize, usize)> = part.runs().iter().map(|run| (run.start, run.end)).collect();
            assert_eq!((&found[..], part.missing()), (runs, missing), "{range:?}");
            assert_eq!(part.values(), &of_increments.values()[range]);
        }
        let of_angles = Angles::from_angles(&increments, 1.0, 1.0, Trend::None);
        assert_eq!(of_angles.part(2..8).missing(), 1);
        assert_eq!(of_angles.part(5..9).missing(), 0);
    }

    #[test]
    fn mean_and_line_are_removed_from_increments_and_from_angles_alike() {
        let increments: Vec<f64> = (0..9).map(|i| 5.0 + 0.5 * f64::from(i)).collect();
        let mut angles = vec![100.0];
        for increment in &increments {
            angles.push(angles[angles.len() - 1] + increment);
        }
        let of_increments = Angles::from_increments(&increments, 2.0, 1.0, Trend::Linear);
        let of_angles = Angles::from_angles(&angles, 2.0, 1.0, Trend::Linear);
        for (k, (a, b)) in of_increments.values().iter().zip(of_angles.values()).enumerate() {
            assert!(a.abs() < 1e-12 && b.abs() < 1e-12, "angle {k}: {a} and {b}");
        }
        assert!((of_angles.removed().mean - 7.0).abs() < 1e-14);
        assert!((of_angles.removed().slope - 0.5).abs() < 1e-14);
    }

    #[test]
    fn no_samples_make_no_runs() {
        let empty = Angles::from_increments(&[], 1.0, 1.0, Trend::Linear);
        assert!(empty.runs().is_empty() && empty.len() == 1);
        assert!(Angles::from_angles(&[], 1.0, 1.0, Trend::Linear).is_empty());
    }

    #[test]
    fn the_line_is_that_of_least_squares_over_the_known_increments() {
        // By hand: places 0, 1, 3 and values 1, 2, 6; means 4/3 and 3, slope (8/3 + 1/3 + 5) / (14/3).
        let values = [1.0, 2.0, f64::NAN, 6.0];
        let line = Line::new(Trend::Linear, 4, |i| values[i]);
        assert!((line.mean - 3.0).abs() < 1e-15 && (line.slope - 12.0 / 7.0).abs() < 1e-15, "{line:?}");
        let sum: f64 = (0..4).map(|i| line.at(i)).sum();
        assert!((line.sum(4) - sum).abs() < 1e-14);
        assert_eq!(Line::new(Trend::None, 4, |i| values[i]).slope, 0.0);
    }
}
