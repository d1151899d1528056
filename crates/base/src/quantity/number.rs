//! Numbers: how they are written for the user, and the scale on which an axis shows them.

use std::fmt::Write as _;

use serde::{Serialize, Serializer};

use crate::names;

/// `x` with `digits` significant digits, without trailing zeros; with an exponent below 10^-5, and from 10^6 (or the
/// largest number that `digits` digits can write out) on.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    // With room for sign, point and exponent, and for the zeros of a number below 1.
    let mut scientific = String::with_capacity(digits + 8);
    // Writing to memory does not fail.
    let _ = write!(scientific, "{:.*e}", digits - 1, x);
    // Neither infinity nor NaN has an exponent.
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let mantissa = match mantissa.contains('.') {
        true => mantissa.trim_end_matches('0').trim_end_matches('.').len(),
        false => mantissa.len(),
    };
    if !(-5..(digits as i32).max(6)).contains(&exponent) {
        return format!("{}e{exponent}", &scientific[..mantissa]);
    }
    if exponent == 0 {
        scientific.truncate(mantissa);
        return scientific;
    }
    let (sign, figures) = scientific[..mantissa].split_at(usize::from(x < 0.0));
    let (first, rest) = figures.split_at(1);
    let rest = rest.strip_prefix('.').unwrap_or("");
    let mut text = String::with_capacity(scientific.len() + 6);
    text += sign;
    match usize::try_from(exponent) {
        Ok(exponent) => {
            // Digits beyond the significant ones are zeros.
            let (whole, part) = rest.split_at(exponent.min(rest.len()));
            text += first;
            text += whole;
            text.extend(std::iter::repeat_n('0', exponent - whole.len()));
            if !part.is_empty() {
                text.push('.');
                text += part;
            }
        }
        Err(_) => {
            text += "0.";
            text.extend(std::iter::repeat_n('0', (-exponent - 1) as usize));
            text += first;
            text += rest;
        }
    }
    text
}

/// The ends of the interval of an estimate with equal decimals: half the width of the interval has two digits, and the estimate
/// at most three, or as many as the ends need to differ. Ends of which one is more than ten times the other have two digits each.
/// `None` where even five digits do not tell the ends apart, and for ends that are not finite.
pub fn interval_ends(value: f64, [low, high]: [f64; 2]) -> Option<[String; 2]> {
    if !low.is_finite() || !high.is_finite() || low >= high {
        return None;
    }
    let order = |x: f64| libm::floor(libm::log10(x.abs())) as i32;
    let largest = low.abs().max(high.abs());
    let of_value = order(if value.is_normal() { value } else { largest });
    let [near, far] = if low > 0.0 { [low, high] } else { [-high, -low] };
    if !(-5..6).contains(&order(largest)) || near > 0.0 && far > 10.0 * near {
        let with_digits = |digits| [low, high].map(|end| significant(end, digits));
        return (2..=5).map(with_digits).find(|[low, high]| low != high);
    }
    let of_half = order((high - low) / 2.0) - 1;
    let with_last = |last: i32| {
        let decimals = usize::try_from(-last).unwrap_or(0);
        let unit = libm::pow(10.0, f64::from(last));
        let rounded = |end: f64| if last > 0 { libm::round(end / unit) * unit } else { end };
        let text = |end: f64| format!("{:.decimals$}", rounded(end));
        // Without the sign of an end that is rounded to 0.
        [low, high].map(|end| if rounded(end).abs() < 0.5 * unit { text(0.0) } else { text(end) })
    };
    (2..5).map(|digits| with_last(of_half.max(of_value - digits))).find(|[low, high]| low != high)
}

/// A number with its unit, or alone if the unit is empty.
pub fn with_unit(x: f64, digits: usize, unit: &str) -> String {
    format!("{} {unit}", significant(x, digits)).trim_end().to_owned()
}

/// A fraction in percent with three digits.
pub fn percent(fraction: f64) -> String {
    format!("{} %", significant(100.0 * fraction, 3)).replace('-', "−")
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

/// A number with its unit.
pub fn joined(number: &str, unit: &str) -> String {
    match unit {
        "" | "″" | "°" => format!("{number}{unit}"),
        unit => format!("{number} {unit}"),
    }
}

/// Least probability that is stated; smaller ones belong to tails that no approximation describes.
const MIN_SAID: f64 = 1e-12;

/// Formats a probability as `p = 0.03` or `p < 1e-12`.
pub fn probability(p: f64) -> String {
    if p < MIN_SAID { format!("p < {MIN_SAID:e}") } else { format!("p = {}", significant(p, 2)) }
}

names! {
    /// The scale of an axis.
    pub enum Scale {
        /// Equal ratios are equally long.
        Log = "log",
        /// Equal differences are equally long.
        Linear = "linear",
    }
}

impl Default for Scale {
    fn default() -> Scale {
        Scale::ALL[0]
    }
}

/// Numbers below this count as zero on an axis.
pub const TINY: f64 = 1e-250;

impl Serialize for Scale {
    /// The word as written in study files.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Scale {
    /// Whether an axis can show `value`: finite, and positive if logarithmic. Numbers beyond 10^±250 count as infinite
    /// or zero, because margins and ticks around them would exceed the range of f64.
    pub fn shows(self, value: f64) -> bool {
        value.abs() < 1.0 / TINY && (self == Scale::Linear || value > TINY)
    }

    /// A coordinate in which the axis is uniform.
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Scale::Log => libm::log10(value),
            Scale::Linear => value,
        }
    }

    /// The value at a coordinate.
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Scale::Log => libm::pow(10.0, coordinate),
            Scale::Linear => coordinate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_an_interval_have_the_digits_that_its_width_bears() {
        for (value, ends, shown) in [
            (0.600_123, [0.598_041, 0.602_377], ["0.598", "0.602"]),
            (0.001_53, [0.001_096, 0.002_014], ["0.00110", "0.00201"]),
            (0.059_4, [0.0471, 0.0742], ["0.047", "0.074"]),
            (211.84, [94.513, 6759.9], ["95", "6800"]),
            (306.31, [304.88, 307.76], ["305", "308"]),
            (50.0, [49.982, 50.012], ["49.98", "50.01"]),
            (0.9996, [0.71, 1.6], ["0.71", "1.60"]),
            (-12_345.6, [-12_500.0, -12_200.0], ["-12500", "-12200"]),
            (2.5e-9, [2.4e-9, 2.6e-9], ["2.4e-9", "2.6e-9"]),
            (0.0, [-1.0, 1.0], ["-1.0", "1.0"]),
            (1.67e-12, [1.66e-12, 1.68e-12], ["1.66e-12", "1.68e-12"]),
            (1e6, [0.999e6, 1.003e6], ["999000", "1e6"]),
            (5.0, [-0.04, 10.0], ["0.0", "10.0"]),
            (-50.0, [-1000.0, -1.0], ["-1000", "-1"]),
        ] {
            assert_eq!(interval_ends(value, ends), Some(shown.map(str::to_owned)), "{value}");
        }
        assert_eq!(interval_ends(3.0, [3.0, 3.0]), None);
        assert_eq!(interval_ends(3.0, [3.000_01, 3.000_02]), None);
        assert_eq!(interval_ends(5.0, [4.0, f64::INFINITY]), None);
    }

    #[test]
    fn numbers_between_a_thousandth_and_a_million_have_no_exponent() {
        let shown = [4262.0, 2e4, 999_499.0, 0.001, 4.36, -1234.5].map(|x| significant(x, 3));
        assert_eq!(shown, ["4260", "20000", "999000", "0.001", "4.36", "-1230"]);
        assert_eq!([999_999.0, 1.5e6, 1.5e-7].map(|x| significant(x, 3)), ["1e6", "1.5e6", "1.5e-7"]);
        let rest = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -0.0, -7.0, 10.0, 0.1, -0.012_346];
        let shown = rest.map(|x| significant(x, 4));
        assert_eq!(shown, ["inf", "-inf", "NaN", "0", "-7", "10", "0.1", "-0.01235"]);
    }

    #[test]
    fn figures_are_those_of_the_rounded_number() {
        // By way of the number that the digits give, written out with as many decimals.
        let by_rounding = |x: f64, digits: usize| {
            let scientific = format!("{:.*e}", digits - 1, x);
            let exponent: i32 = scientific.split_once('e').unwrap().1.parse().unwrap();
            let rounded: f64 = scientific.parse().unwrap();
            let text = format!("{:.*}", (digits as i32 - 1 - exponent).max(0) as usize, rounded);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        };
        for digits in 1..=15 {
            for place in 0..2000_i32 {
                let x = libm::sin(f64::from(place)) * libm::pow(10.0, f64::from(place % 10 - 4));
                let exponent = libm::floor(libm::log10(x.abs())) as i32;
                if (-4..digits.max(6) - 1).contains(&exponent) {
                    let digits = digits as usize;
                    assert_eq!(significant(x, digits), by_rounding(x, digits), "{x:e} with {digits} digits");
                }
            }
        }
    }
}
