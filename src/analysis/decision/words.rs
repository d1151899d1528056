//! Figures of decisions in words.

use crate::analysis::decision::Figure;
use crate::quantity::number::{percent, significant};
use crate::quantity::units::{Dimension, Quantity};

/// Probability of the intervals.
pub(crate) const LEVEL: &str = "95 %";

/// The fraction of a limit that is left, or by how much the limit is exceeded, in a sentence. The probability of the
/// interval is `level`.
pub(crate) fn margin_in_words(margin: Figure, level: &str) -> String {
    let told = |figure: Figure| at_level(figure, level, percent);
    if margin.value >= 0.0 {
        return format!("{} of the limit is left.", told(margin));
    }
    let over = |of: fn(f64) -> f64| Figure {
        value: of(margin.value),
        interval: margin.interval.map(|(low, high)| (of(high), of(low))),
    };
    match margin.value > -1.0 {
        true => format!("The limit is exceeded by {}.", told(over(|left| -left))),
        false => {
            let times = at_level(over(|left| 1.0 - left), level, |times| significant(times, 3));
            format!("The value is {times} times the limit.")
        }
    }
}

/// A value with its 95 % interval in brackets, unless the digits shown do not tell its ends apart.
pub(crate) fn with_interval(figure: Figure, shown: impl Fn(f64) -> String) -> String {
    at_level(figure, LEVEL, shown)
}

/// A value with its interval in brackets after the probability of the interval, unless the digits shown do not tell its ends
/// apart.
pub(crate) fn at_level(figure: Figure, level: &str, shown: impl Fn(f64) -> String) -> String {
    match figure.interval {
        Some((low, high)) if shown(low) != shown(high) => {
            format!("{} ({level}: {} to {})", shown(figure.value), shown(low), shown(high))
        }
        _ => shown(figure.value),
    }
}

/// A quantity with six digits; a time below a tenth of a second in milliseconds.
pub(crate) fn short(quantity: Quantity) -> String {
    // In the unit of tables, which is shown.
    let shown = quantity.shown();
    let part = significant(shown, 6).parse().map_or(1.0, |rounded: f64| rounded / shown);
    let value = if shown == 0.0 { 0.0 } else { quantity.value * part };
    match quantity.dimension {
        Dimension::Time if value.abs() < 0.1 => format!("{} ms", significant(1000.0 * value, 6)),
        _ => Quantity { value, ..quantity }.to_string(),
    }
}
