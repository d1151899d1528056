//! Axes: conversion of numbers to places on them, and their ticks, which are at whole numbers for counts and names, and at parts
//! of a turn for phases.

use crate::chart::figure::Axis;
use crate::chart::layout::MAX_LABELS;
use crate::chart::ticks::{Ladder, Steps, Ticks};
pub use sagnac_base::quantity::number::Scale;
use sagnac_base::quantity::number::TINY;
use sagnac_base::table::Unit;

/// The edges of cells around `values`, which ascend and can be shown: midway between neighbours, and equally far
/// beyond the outer ones. The cell of a single value is as wide as an axis around it.
pub(crate) fn edges(scale: Scale, values: &[f64]) -> Vec<f64> {
    match *values {
        [] => vec![],
        [only] => {
            let Range { low, high, .. } = Range::around(scale, [only]);
            vec![low, high]
        }
        [first, second, ..] => {
            let between = |a: f64, b: f64| scale.value(0.5 * (scale.coordinate(a) + scale.coordinate(b)));
            let beyond = |outer: f64, inner: f64| {
                scale.value(1.5 * scale.coordinate(outer) - 0.5 * scale.coordinate(inner))
            };
            let [.., inner, last] = *values else { return vec![] };
            let middles = values.windows(2).map(|pair| between(pair[0], pair[1]));
            std::iter::once(beyond(first, second)).chain(middles).chain([beyond(last, inner)]).collect()
        }
    }
}

/// The range of numbers on an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The scale.
    pub scale: Scale,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Range {
    /// The range of cells with these `edges`; arbitrary without cells.
    pub fn between(scale: Scale, edges: &[f64]) -> Range {
        match *edges {
            [low, .., high] => Range { scale, low, high },
            _ => Range::around(scale, []),
        }
    }

    /// A range with all of `values` that the scale can show, and a margin around them; arbitrary without values.
    pub fn around(scale: Scale, values: impl IntoIterator<Item = f64>) -> Range {
        let (low, high) = match (scale, extent(values.into_iter().filter(|&value| scale.shows(value)))) {
            (Scale::Log, None) => (1.0, 10.0),
            (Scale::Linear, None) => (0.0, 1.0),
            (Scale::Log, Some((low, high))) => log_margins(low, high),
            (Scale::Linear, Some((low, high))) => linear_margins(low, high),
        };
        Range { scale, low, high }
    }

    /// The place of `value`: 0 at the lower end, 1 at the upper. Values that cannot be shown lie far below.
    pub fn fraction(&self, value: f64) -> f64 {
        /// Many axis lengths, but still drawable.
        const FAR: f64 = 20.0;
        if value.is_nan() || (self.scale == Scale::Log && value <= 0.0) {
            return -FAR;
        }
        let [low, high, at] = [self.low, self.high, value].map(|v| self.scale.coordinate(v));
        ((at - low) / (high - low)).clamp(-FAR, FAR)
    }
}

/// The least and the greatest of some values.
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (value.min(low), value.max(high)))
}

fn log_margins(low: f64, high: f64) -> (f64, f64) {
    let decades = libm::log10(high) - libm::log10(low);
    let margin = if decades < 1e-6 { 0.5 } else { 0.04 * decades };
    let factor = libm::pow(10.0, margin);
    (low / factor, high * factor)
}

fn linear_margins(low: f64, high: f64) -> (f64, f64) {
    let largest = low.abs().max(high.abs());
    let span = high - low;
    if largest < TINY {
        (-1.0, 1.0)
    } else if span <= 1e-12 * largest {
        (low - 0.5 * largest, high + 0.5 * largest)
    } else if low >= 0.0 && low <= 0.3 * high {
        (0.0, high + 0.05 * high)
    } else if high <= 0.0 && high >= 0.3 * low {
        (low + 0.05 * low, 0.0)
    } else {
        (low - 0.05 * span, high + 0.05 * span)
    }
}

/// Number of whole numbers that all get a label.
const FEW: f64 = 12.0;

impl Axis {
    /// The range of the axis that shows `values`, with a margin. An axis that counts does not extend to 0 merely
    /// because 0 is near.
    pub fn around(&self, values: impl IntoIterator<Item = f64>) -> Range {
        let values: Vec<f64> = values.into_iter().filter(|&value| self.scale.shows(value)).collect();
        if !self.names.is_empty() {
            return Range { scale: self.scale, low: 0.5, high: self.names.len() as f64 + 0.5 };
        }
        match extent(values.iter().copied()) {
            Some((low, high)) if self.whole && self.scale == Scale::Linear && 0.0 < low && low < high => {
                let margin = 0.05 * (high - low);
                Range { scale: self.scale, low: (low - margin).max(0.0), high: high + margin }
            }
            _ => Range::around(self.scale, values),
        }
    }

    /// The ticks in a range of the axis.
    pub fn ticks(&self, range: Range) -> Ticks {
        if !self.names.is_empty() {
            let major = (1..).zip(&self.names).map(|(place, name)| (f64::from(place), name.clone()));
            return Ticks { major: major.collect(), minor: vec![] };
        }
        let mut ticks = range.ticks(MAX_LABELS, self.steps());
        if !self.whole {
            return ticks;
        }
        let [first, last] = [libm::ceil(range.low), libm::floor(range.high)];
        if (1.0..FEW).contains(&(last - first)) {
            let all = (first as i64..=last as i64).map(|count| (count as f64, count.to_string()));
            return Ticks { major: all.collect(), minor: vec![] };
        }
        ticks.keep_whole();
        ticks
    }

    /// All ticks that parts of a range and its surroundings may have.
    pub fn ladder(&self, range: Range) -> Ladder {
        range.ladder(self.whole, self.steps())
    }

    /// The distances between even ticks.
    fn steps(&self) -> Steps {
        match self.times {
            true => Steps::Time,
            false if self.unit == Unit::DEG.symbol => Steps::Phase,
            false => Steps::Decimal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_values_lie_within_the_range_and_the_log_margin_is_even() {
        let range = Range::around(Scale::Log, [0.27, 109.0, -3.0, 0.0, f64::NAN]);
        let (low, high) = (range.fraction(0.27), range.fraction(109.0));
        assert!((low - 0.04 / 1.08).abs() < 1e-9 && (low + high - 1.0).abs() < 1e-9, "{low} {high}");
    }

    #[test]
    fn one_value_or_none_gives_a_range_with_the_value_inside() {
        for scale in [Scale::Log, Scale::Linear] {
            for values in
                [vec![], vec![5.0], vec![0.0], vec![-2.0], vec![1e-249], vec![9e249], vec![f64::NAN]]
            {
                let range = Range::around(scale, values.iter().copied());
                assert!(range.low < range.high && range.high.is_finite(), "{scale:?} {values:?}: {range:?}");
                for value in values.into_iter().filter(|&v| scale.shows(v)) {
                    let at = range.fraction(value);
                    assert!((0.0..=1.0).contains(&at), "{value} at {at} of {range:?}");
                }
            }
        }
    }

    #[test]
    fn edges_lie_in_the_middle_between_values_on_their_scale() {
        let near = |found: Vec<f64>, expected: &[f64]| {
            let close = found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12);
            assert!(close && found.len() == expected.len(), "{found:?}, not {expected:?}");
        };
        near(edges(Scale::Log, &[1.0, 4.0, 64.0]), &[0.5, 2.0, 16.0, 256.0]);
        near(edges(Scale::Linear, &[1.0, 2.0, 4.0]), &[0.5, 1.5, 3.0, 5.0]);
        near(edges(Scale::Linear, &[4.0]), &[2.0, 6.0]);
        near(edges(Scale::Log, &[]), &[]);
    }

    #[test]
    fn a_linear_range_of_values_near_zero_starts_at_zero() {
        assert_eq!(
            Range::around(Scale::Linear, [1.0, 10.0]),
            Range { scale: Scale::Linear, low: 0.0, high: 10.5 }
        );
        assert_eq!(Range::around(Scale::Linear, [-10.0, -1.0]).high, 0.0);
        assert_eq!(Range::around(Scale::Linear, [9.0, 10.0]).low, 8.95);
    }

    /// Labels, and the ticks without one, of an axis around these values.
    fn ticks(scale: Scale, whole: bool, values: &[f64]) -> (Vec<String>, Vec<f64>) {
        let axis = Axis { scale, whole, ..Axis::default() };
        let ticks = axis.ticks(axis.around(values.iter().copied()));
        (ticks.major.into_iter().map(|(_, label)| label).collect(), ticks.minor)
    }

    #[test]
    fn few_counts_have_a_label_each_and_no_tick_between_them() {
        for scale in [Scale::Linear, Scale::Log] {
            assert_eq!(ticks(scale, true, &[1.0, 2.0, 3.0]).0, ["1", "2", "3"], "{scale:?}");
            let (labels, minor) = ticks(scale, true, &[1.0, 2.0, 5.0, 10.0]);
            assert_eq!(
                (labels.len(), labels[9].as_str(), minor.len()),
                (10, "10", 0),
                "{scale:?} {labels:?}"
            );
        }
    }

    #[test]
    fn many_counts_have_ticks_at_whole_numbers() {
        for scale in [Scale::Linear, Scale::Log] {
            for high in [16.0, 23.0, 64.0, 5000.0] {
                let (labels, minor) = ticks(scale, true, &[1.0, high]);
                assert!(labels.len() >= 3 && labels.iter().all(|label| !label.contains('.')), "{labels:?}");
                assert!(minor.iter().all(|value| value.fract() == 0.0), "{scale:?} {high}: {minor:?}");
            }
        }
        assert_eq!(ticks(Scale::Linear, false, &[1.0, 3.0]).0, ["1.0", "1.5", "2.0", "2.5", "3.0"]);
        assert!(ticks(Scale::Linear, true, &[7.0]).0.contains(&"7".to_owned()));
    }
}
