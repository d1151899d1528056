//! Numbers of a comparison as text.

use crate::analysis::compare::Length;
use sagnac_base::quantity::number::significant;

/// Formats a duration with two digits, such as `31 h`.
pub fn duration(seconds: f64) -> String {
    const UNITS: [(f64, f64, &str); 5] = [
        (120.0, 1.0, "s"),
        (7200.0, 60.0, "min"),
        (72.0 * 3600.0, 3600.0, "h"),
        (730.0 * 86400.0, 86400.0, "days"),
        (f64::INFINITY, 365.25 * 86400.0, "years"),
    ];
    let (_, size, name) = UNITS.into_iter().find(|(most, ..)| seconds < *most).unwrap_or(UNITS[4]);
    format!("{} {name}", significant(seconds / size, 2))
}

/// The required length of a row, such as `31 h` or `> 2.1 years`; empty where it is unknown.
pub fn length(length: Length) -> String {
    match length {
        Length::Needed(length_s) => duration(length_s),
        Length::Beyond(length_s) => format!("> {}", duration(length_s)),
        Length::Unknown => String::new(),
    }
}

/// A ratio with `digits` digits, or near 1 with enough to distinguish it from 1.
pub fn times(ratio: f64, digits: usize) -> String {
    let shown = (digits..digits + 6).map(|digits| significant(ratio, digits));
    shown.into_iter().find(|text| text != "1").unwrap_or_else(|| "1".to_owned())
}

/// An interval such as `0.6 … 1.3`, with words where an end is unknown.
pub(crate) fn interval([low, high]: [Option<f64>; 2], number: &dyn Fn(f64) -> String) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("{} … {}", number(low), number(high)),
        (Some(low), None) => format!("at least {}", number(low)),
        (None, Some(high)) => format!("at most {}", number(high)),
        (None, None) => "no interval".to_owned(),
    }
}
