//! Parsers of the values of options: limits, whole numbers and words.

use std::ops::RangeInclusive;

use crate::failure::Failure;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use sagnac::analysis::requirement::{Limit, Limited};
use sagnac_base::quantity::{Dimension, accepted, bare, parse};
use sagnac_engine::key::docs::note;

/// Reads a limit on a log.
pub fn of_log(text: &str) -> Result<Limit, String> {
    Limit::parse(text, &Limited::OF_LOG).map_err(|error| error.to_string())
}

/// The value of a limit on what has one of these names, with or without the unit, as in `residual=8 arcsec`; without a name, as
/// before 0.3, it is on the first.
///
/// # Errors
/// It is on something else.
pub fn on<'t>(text: &'t str, names: &[&str]) -> Result<&'t str, Failure> {
    let is_known =
        |name: &str| names.iter().any(|known| *known == name || bare(known).any(|bare| bare == name));
    match text.split_once('=') {
        None => {
            let named = format!("--limit {}={text}", names[0]);
            note!("{}", note(&format!("--limit {text}"), &named));
            Ok(text)
        }
        Some((name, value)) if is_known(name.trim()) || bare(name.trim()).any(is_known) => Ok(value.trim()),
        Some((name, _)) => {
            let message = format!("--limit: unknown limit `{}`\naccepted: {}", name.trim(), names.join(", "));
            Err(Failure::Usage(message))
        }
    }
}

/// The value of a quantity of this dimension in base units.
///
/// # Errors
/// It is none; the message lists the units.
pub fn value_of(text: &str, dimension: Dimension) -> Result<f64, String> {
    let found = parse(text, &[dimension]).map_err(|error| format!("{error}; {}", accepted(&[dimension])))?;
    Ok(found.value)
}

/// An integer within `range`: `1000000`, `1_000_000`, `1e6` or `1.5e6`.
///
/// # Errors
/// The text is not a number, has a fraction, or is out of range.
pub fn whole(text: &str, range: RangeInclusive<u64>) -> Result<u64, String> {
    let (least, most) = (range.start(), range.end());
    let accepted = "write a whole number, as in 1000000, 1_000_000 or 1e6";
    let (mantissa, power) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (digits, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit() || byte == b'_');
    let power = power.parse::<i32>().ok().filter(|_| are_digits(digits) && are_digits(fraction));
    let digits = format!("{digits}{fraction}").replace('_', "");
    let Some(power) = power.filter(|_| !digits.is_empty()) else {
        return Err(format!("not a whole number: {accepted}"));
    };
    let significant = digits.trim_end_matches('0');
    let fraction = fraction.bytes().filter(|byte| *byte != b'_').count();
    // In i64, no power that is an i32 overflows.
    let zeros = i64::from(power) - fraction as i64 + (digits.len() - significant.len()) as i64;
    let significant = significant.trim_start_matches('0');
    if !significant.is_empty() && zeros < 0 {
        return Err(format!("not whole: {accepted}"));
    }
    let value = match significant {
        "" => Some(0),
        digits => u32::try_from(zeros)
            .ok()
            .and_then(|zeros| 10_u64.checked_pow(zeros))
            .and_then(|factor| digits.parse::<u64>().ok()?.checked_mul(factor)),
    };
    value.filter(|value| range.contains(value)).ok_or_else(|| format!("not in {least}..={most}"))
}

/// A parser that accepts one of several words, which may have a help, each with its value.
pub fn one_of<W, T, const N: usize>(values: [(W, T); N]) -> impl TypedValueParser<Value = T>
where
    W: Into<PossibleValue> + 'static,
    T: Clone + Send + Sync + 'static,
{
    let values = values.map(|(word, value)| (word.into(), value));
    let words = values.each_ref().map(|(word, _)| word.clone());
    PossibleValuesParser::new(words).map(move |word| {
        // The parser passes no other words.
        let found = values.iter().find(|(known, _)| known.get_name() == word);
        found.unwrap_or(&values[0]).1.clone()
    })
}

/// Reads a list of names, separated by commas, of which `all` has the values; `others` are the words that stand for a list.
pub fn list_of<T: Copy>(
    text: &str,
    all: &[T],
    name: fn(T) -> &'static str,
    others: &str,
) -> Result<Vec<T>, String> {
    let value = |asked: &str| {
        let found = all.iter().copied().find(|value| name(*value).eq_ignore_ascii_case(asked.trim()));
        found.ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|value| name(*value)).collect();
            format!("`{}` is not a term; accepted: {others}, or some of {}", asked.trim(), known.join(","))
        })
    };
    text.split(',').map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_are_read_as_people_write_them() {
        let read = |text: &str| whole(text, 0..=1 << 40);
        for text in ["1000000", "1_000_000", "1e6", "1E6", "1.0e+6", "0.001e9", "10000000e-1", "1000000.0"] {
            assert_eq!(read(text), Ok(1_000_000), "{text}");
        }
        assert_eq!((read("1.5e6"), read("0"), read("0e99999")), (Ok(1_500_000), Ok(0), Ok(0)));
        assert_eq!(whole("9223372036854775807", 0..=i64::MAX as u64), Ok(i64::MAX as u64));
        for text in
            ["", "many", "1e", "e6", ".", "-1", "+1", "1e6.5", "1 000", "1,000", "0x10", "1e99999999999", "∞"]
        {
            assert!(read(text).is_err_and(|why| why.starts_with("not a whole number: write")), "{text}");
        }
        for text in ["1.5", "1.25e1", "1e-1"] {
            assert!(read(text).is_err_and(|why| why.starts_with("not whole: write")), "{text}");
        }
        for text in ["1e13", "99999999999999999999", "1e2147483647"] {
            assert!(read(text).is_err_and(|why| why == "not in 0..=1099511627776"), "{text}");
        }
    }
}
