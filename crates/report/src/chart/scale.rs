//! Conversion of numbers to places on an axis.

pub use sagnac_base::scale::Scale;
use sagnac_base::scale::TINY;

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
}
