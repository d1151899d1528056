//! Numbers formatted for the user.

/// `x` with `digits` significant digits, without trailing zeros; with an exponent below 10^-5, and from 10^6 (or the
/// largest number that `digits` digits can write out) on.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{:.*e}", digits - 1, x);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (-5..(digits as i32).max(6)).contains(&exponent) {
        // Digits beyond the significant ones are zeros.
        let rounded: f64 = scientific.parse().unwrap_or(x);
        trim(&format!("{:.*}", (digits as i32 - 1 - exponent).max(0) as usize, rounded))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

/// A number with its unit, or alone if the unit is empty.
pub fn with_unit(x: f64, digits: usize, unit: &str) -> String {
    format!("{} {unit}", significant(x, digits)).trim_end().to_owned()
}

/// A large number with three digits and a word.
pub fn short(number: f64) -> String {
    let (scale, unit) = match number {
        x if x >= 1e12 => (1e12, " trillion"),
        x if x >= 1e9 => (1e9, " billion"),
        x if x >= 1e6 => (1e6, " million"),
        x if x >= 1e4 => (1e3, " thousand"),
        x => return significant(x, 4),
    };
    format!("{}{unit}", significant(number / scale, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_between_a_thousandth_and_a_million_have_no_exponent() {
        let shown = [4262.0, 2e4, 999_499.0, 0.001, 4.36, -1234.5].map(|x| significant(x, 3));
        assert_eq!(shown, ["4260", "20000", "999000", "0.001", "4.36", "-1230"]);
        assert_eq!([999_999.0, 1.5e6, 1.5e-7].map(|x| significant(x, 3)), ["1e6", "1.5e6", "1.5e-7"]);
    }
}
