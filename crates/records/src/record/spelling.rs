//! Units as loggers spell them: `dps`, `deg/sec`, `°/s`, `rad s^-1`, `m/s²`, `mps2`.

use sagnac_base::quantity::error::UnitError;
use sagnac_base::quantity::units::{Dimension, parse_unit};

/// Words of loggers in lower case, with the same in the units of studies.
const WORDS: [(&[&str], &str); 23] = [
    (&["dps"], "deg/s"),
    (&["mdps"], "mdeg/s"),
    (&["dph"], "deg/h"),
    (&["s", "sec", "secs", "second", "seconds"], "s"),
    (&["ms", "msec", "msecs", "millisecond", "milliseconds", "millis"], "ms"),
    (&["us", "µs", "μs", "usec", "µsec", "μsec", "usecs", "microsecond", "microseconds", "micros"], "us"),
    (&["ns", "nsec", "nsecs", "nanosecond", "nanoseconds", "nanos"], "ns"),
    (&["min", "mins", "minute", "minutes"], "min"),
    (&["h", "hr", "hrs", "hour", "hours"], "h"),
    (&["hz"], "Hz"),
    (&["deg", "degs", "degree", "degrees"], "deg"),
    (&["mdeg"], "mdeg"),
    (&["rad", "rads", "radian", "radians"], "rad"),
    (&["mrad"], "mrad"),
    (&["urad", "µrad", "μrad"], "urad"),
    (&["arcsec", "arcsecs", "arcsecond", "arcseconds", "asec"], "arcsec"),
    (&["arcmin", "arcmins", "arcminute", "arcminutes"], "arcmin"),
    (&["m", "meter", "meters", "metre", "metres"], "m"),
    (&["mps"], "m/s"),
    (&["ft", "foot", "feet"], "ft"),
    (&["gal", "gals"], "Gal"),
    (&["mgal", "mgals"], "mGal"),
    (&["per"], "/"),
];

/// Powers after a word without a sign between, with the same as studies write them.
const POWERS: [(&str, &str); 6] =
    [("-1", "^-1"), ("⁻¹", "^-1"), ("-2", "^-2"), ("⁻²", "^-2"), ("2", "^2"), ("²", "^2")];

/// Reads a unit as [`parse_unit`] does, also where it is spelled otherwise.
///
/// # Errors
/// The unit is unknown, or has another dimension.
pub(crate) fn unit_of(unit: &str, wanted: &[Dimension]) -> Result<(f64, Dimension), UnitError> {
    parse_unit(unit, wanted).or_else(|error| match &error {
        UnitError::Dimension { .. } => Err(error),
        // An error of the unit as it is written says more.
        _ => parse_unit(&respelled(unit), wanted).map_err(|other| match other {
            UnitError::Dimension { found, .. } => UnitError::Dimension { text: unit.to_owned(), found },
            _ => error,
        }),
    })
}

/// The unit in the words of studies. Units with a blank between them are a product, and `s-1` and `s2` are powers.
fn respelled(unit: &str) -> String {
    let (mut text, mut rest) = (String::new(), unit.trim());
    while let Some(first) = rest.chars().next() {
        let letters = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
        // º and ª count as letters.
        let (word, after) = match first {
            'º' | '˚' => ("°", &rest[first.len_utf8()..]),
            '⋅' | '×' => ("·", &rest[first.len_utf8()..]),
            _ if letters > 0 => rest.split_at(letters),
            _ => rest.split_at(first.len_utf8()),
        };
        let known = WORDS.iter().find(|(words, _)| words.contains(&word.to_lowercase().as_str()));
        text += known.map_or(word, |(_, known)| known);
        let power = POWERS.iter().find_map(|(sign, power)| Some((power, after.strip_prefix(sign)?)));
        rest = match power.filter(|_| letters > 0) {
            Some((power, after)) => {
                text += power;
                after
            }
            None => after,
        };
        let next = rest.trim_start();
        let is_between = rest.len() > next.len() && text.ends_with(|c: char| c.is_alphanumeric() || c == '°');
        if is_between && next.starts_with(char::is_alphabetic) && !next.to_lowercase().starts_with("per ") {
            text += "·";
        }
        rest = next;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_times_are_read_as_loggers_spell_them() {
        let (rate, time) = (&[Dimension::Rate][..], &[Dimension::Time][..]);
        let radian = unit_of("rad/s", rate).unwrap().0;
        for (texts, wanted, size) in [
            (
                &["dps", "DPS", "deg/sec", "Deg/S", "degrees per second", "º/s", "°/sec", "deg s^-1"][..],
                rate,
                3600.0,
            ),
            (&["deg s-1", "degree/second", "deg·s⁻¹", "deg/s"], rate, 3600.0),
            (&["mdps", "mdeg/s"], rate, 3.6),
            (&["rad/sec", "rad s-1", "Rad/s", "radians/second"], rate, radian),
            (&["mrad/sec", "mrad/s"], rate, unit_of("mrad/s", rate).unwrap().0),
            (&["deg/hr", "°/hour", "dph", "degrees per hour"], rate, 1.0),
            (&["msec", "ms", "milliseconds"], time, 1e-3),
            (&["usec", "µs", "micros"], time, 1e-6),
            (&["nsec", "Nanoseconds"], time, 1e-9),
            (&["sec", "S", "seconds"], time, 1.0),
        ] {
            for text in texts {
                assert_eq!(unit_of(text, wanted).map(|unit| unit.0), Ok(size), "{text}");
            }
        }
    }

    #[test]
    fn accelerations_are_read_as_loggers_spell_them() {
        let size = |unit: &str| unit_of(unit, &[Dimension::Acceleration]).map(|unit| unit.0);
        let metre = size("m/s^2").unwrap();
        for text in ["m/s²", "m/s2", "m s-2", "m s⁻²", "m·s^-2", "m/s/s", "mps2", "meters/second^2", "m/sec2"]
        {
            assert_eq!(size(text), Ok(metre), "{text}");
        }
        assert!((metre * 9.80665 - 1.0).abs() < 1e-15, "{metre}");
        for (text, expected) in [("mg", 1e-3), ("ug", 1e-6), ("µg", 1e-6), ("mGal", metre * 1e-5)] {
            assert_eq!(size(text), Ok(expected), "{text}");
        }
        assert!((size("ft/s²").unwrap() / metre - 0.3048).abs() < 1e-15);
        // Gauss, and not g.
        assert!(size("G").is_err() && size("mG").is_err());
    }

    #[test]
    fn what_is_no_unit_is_named_as_it_is_written() {
        for (text, piece) in
            [("volts", "`volts` is not a known unit"), ("", "cannot be read"), ("sec", "\"sec\" is a time")]
        {
            let error = unit_of(text, &[Dimension::Rate]).unwrap_err().to_string();
            assert!(error.contains(piece), "{text}: {error}");
        }
    }
}
