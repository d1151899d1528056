//! Integers in options, in the notations that people use for large ones.

use std::ops::RangeInclusive;

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
