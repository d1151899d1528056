//! The names of columns and their units, as in a header, and units as loggers spell them: `dps`, `deg/sec`, `°/s`, `rad s^-1`,
//! `m/s²`, `mps2`.

use crate::record::log::measure::{Data, Unit};
use sagnac_base::quantity::{Dimension, UnitError, parse_unit};

/// Longest unit after an underscore, in bytes including it.
const MAX_UNIT: usize = 64;

/// Brackets at the end of a unit.
const BRACKETS: [char; 3] = [']', ')', '}'];

/// What a unit without brackets may measure. Of the first three, an underscore may stand for a division.
const MEASURED: [Dimension; 5] =
    [Dimension::Rate, Dimension::Acceleration, Dimension::Velocity, Dimension::Angle, Dimension::Time];

/// Units of time that are the whole name of a column of times.
const UNITS_AS_NAMES: [&str; 12] = [
    "ms",
    "us",
    "ns",
    "millis",
    "micros",
    "nanos",
    "msec",
    "usec",
    "nsec",
    "milliseconds",
    "microseconds",
    "seconds",
];

/// Words of names of increments.
const INCREMENTS: [&str; 5] = ["delta", "dangle", "dtheta", "increment", "integral"];

/// Words of names of angles since some start.
const ANGLES: [&str; 3] = ["angle", "theta", "phase"];

/// Words of names of attitudes, which are not angles of a gyro.
const ATTITUDES: [&str; 6] = ["roll", "pitch", "yaw", "heading", "azimuth", "course"];

/// Words for gyros, without the letter of their axis; `gyr` and what begins with it are others.
const GYROS: [&str; 5] = ["w", "g", "omega", "ang", "angular"];

/// Words of columns with the length of a vector of several axes.
const NORMS: [&str; 5] = ["absolute", "abs", "norm", "magnitude", "total"];

/// Words of columns that tell about the samples and have none.
const AUXILIARIES: [&str; 16] = [
    "status", "state", "flag", "flags", "error", "errors", "clip", "counter", "id", "tow", "year", "month",
    "day", "hour", "minute", "second",
];

/// Names of columns with the number of the sensor of a row, without signs between words.
const INSTANCES: [&str; 8] = ["i", "id", "instance", "imu", "imuid", "deviceid", "sensor", "sensorid"];

/// A column of the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name {
    /// Name as in the file.
    pub whole: String,
    /// Name without the unit.
    pub bare: String,
    pub unit: Option<String>,
    /// Whether the file does not state the unit, but its logger is known to have it.
    pub is_assumed: bool,
    /// The logger, where the header does not tell whether the column is of its gyro or of its accelerometer.
    pub logger: Option<&'static str>,
}

impl Name {
    /// Reads `gz [deg/s]`, `gz (deg/s)`, or `gz_deg_per_s`, `gz_deg_s` and `gz dps` where the end is a unit of a rate, an
    /// acceleration, a velocity, an angle or a time. `gyro_rad[0]` is a part of an array.
    pub(crate) fn read(cell: &str) -> Name {
        let whole = cell.trim();
        let (base, index) = whole.split_at(whole.len() - index(whole).len());
        if !index.is_empty() {
            let name = Name::read(base);
            return Name { whole: whole.to_owned(), bare: name.bare + index, ..name };
        }
        let with = |bare: &str, unit: &str| Name {
            whole: whole.to_owned(),
            bare: bare.trim().to_owned(),
            unit: Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()),
            is_assumed: false,
            logger: None,
        };
        if UNITS_AS_NAMES.iter().any(|unit| whole.eq_ignore_ascii_case(unit)) {
            return with(whole, whole);
        }
        for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
            let inner = whole.strip_suffix(close).and_then(|rest| rest.split_once(open));
            if let Some((bare, unit)) = inner.filter(|(bare, _)| !bare.trim().is_empty()) {
                return with(bare, unit);
            }
        }
        // Without a bound, a long cell of underscores would take time in proportion to the square of its length.
        let is_short = |at: usize| whole.len() - at <= MAX_UNIT;
        for (at, _) in whole.match_indices('_').filter(|(at, _)| *at > 0 && is_short(*at)) {
            let unit = whole[at + 1..].replace("_per_", "/");
            let quotient = unit.replace('_', "/");
            let found = [(&unit, &MEASURED[..]), (&quotient, &MEASURED[..3])];
            if let Some((unit, _)) = found.into_iter().find(|(unit, wanted)| unit_of(unit, wanted).is_ok()) {
                return with(&whole[..at], unit);
            }
        }
        if let Some((bare, unit)) = whole.rsplit_once(' ').filter(|(_, unit)| unit.len() < MAX_UNIT)
            && unit_of(unit, &MEASURED).is_ok()
        {
            return with(bare, unit);
        }
        with(whole, "")
    }

    /// The whole name without an index.
    pub(crate) fn base(&self) -> &str {
        &self.whole[..self.whole.len() - index(&self.whole).len()]
    }

    /// The unit of the column where it measures `data`. That of rates in `gyro_rad` is an angle in one second, but not that in brackets or
    /// of an increment, such as `delta_angle`.
    pub(crate) fn unit_of(&self, data: Data) -> Option<String> {
        let unit = self.unit.as_ref()?;
        let is_plain = !self.base().ends_with(BRACKETS);
        let is_angle = || unit_of(unit, &[Dimension::Angle]).is_ok();
        let is_increment = || self.has_word(&INCREMENTS);
        let is_rate = data == Data::Rate && is_plain && self.is_gyro() && !is_increment() && is_angle();
        Some(if is_rate { format!("{unit}/s") } else { unit.clone() })
    }

    /// Whether the column measures `data` by its unit. An angle is taken for that in one second only in the name of a gyro: `gyro_rad`
    /// has rates, and `roll_rad` attitudes.
    pub(crate) fn measures(&self, data: Data) -> bool {
        let fits = |unit: &String| Unit::of_header(unit, data).is_ok();
        let is_plain = !self.base().ends_with(BRACKETS);
        let is_known = |unit: &String| self.unit.as_ref() == Some(unit) || self.is_gyro();
        self.unit_of(data).is_some_and(|unit| fits(&unit) && is_known(&unit))
            && !(is_plain && self.is_auxiliary())
    }

    /// Whether the name says that its angles are increments, or that they count from some start.
    pub(crate) fn says(&self, data: Data) -> bool {
        match data {
            Data::Rate => false,
            Data::Increment => self.has_word(&INCREMENTS),
            Data::Angle => {
                self.has_word(&ANGLES) && !self.has_word(&INCREMENTS) && !self.has_word(&ATTITUDES)
            }
        }
    }

    /// Whether the name is that of a gyro.
    pub(crate) fn is_gyro(&self) -> bool {
        let is = |word: &String| {
            word.starts_with("gyr") || GYROS.contains(&word.trim_end_matches(['x', 'y', 'z']))
        };
        words(&self.bare).iter().any(is)
    }

    /// Whether the column has the length of a vector, such as `Absolute` beside three axes.
    pub(crate) fn is_norm(&self) -> bool {
        self.has_word(&NORMS)
    }

    /// Whether the column tells about the samples and has none, such as `status` and `device_id`.
    pub(crate) fn is_auxiliary(&self) -> bool {
        self.has_word(&AUXILIARIES) || self.unit.is_none() && self.is_instance()
    }

    /// Whether the column has the number of the sensor that each row is of.
    pub(crate) fn is_instance(&self) -> bool {
        INSTANCES.contains(&self.last_words().concat().as_str())
    }

    pub(crate) fn has_word(&self, known: &[&str]) -> bool {
        self.last_words().iter().any(|word| known.contains(&word.as_str()))
    }

    /// The words behind the groups of a path such as `state/imu.status`.
    fn last_words(&self) -> Vec<String> {
        words(self.bare.rsplit(['/', '.']).next().unwrap_or_default())
    }

    /// The name of a column of a matrix with this name.
    pub(crate) fn numbered(&self, number: usize) -> Name {
        let [whole, bare] = [&self.whole, &self.bare].map(|name| format!("{name}.{number}"));
        Name { whole, bare, ..self.clone() }
    }

    /// Takes the unit from elsewhere, such as a line of units below the names, if the name has none.
    pub(crate) fn complete(&mut self, unit: &str) {
        let unit = unit.trim_matches(['[', ']', '(', ')', ' ']);
        if self.unit.is_none() && !unit.is_empty() {
            self.unit = Some(unit.to_owned());
        }
    }
}

/// The words of a name in lower case: those of `SampleTimeFine` and of `delta_angle_dt` are three each.
pub(crate) fn words(name: &str) -> Vec<String> {
    let (mut words, mut before) = (vec![String::new()], ' ');
    let mut letters = name.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_first = letter.is_uppercase()
            && (before.is_lowercase()
                || before.is_uppercase() && letters.peek().is_some_and(|next| next.is_lowercase()));
        match words.last_mut().filter(|_| letter.is_alphanumeric() && !is_first) {
            Some(word) => word.extend(letter.to_lowercase()),
            None if letter.is_alphanumeric() => words.push(letter.to_lowercase().collect()),
            None => words.push(String::new()),
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The index at the end of a part of an array such as `gyro_rad[0]`, with its brackets.
fn index(name: &str) -> &str {
    let is_number = |number: &str| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let index = name.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    match index.filter(|(base, number)| !base.is_empty() && is_number(number)) {
        Some((base, _)) => &name[base.len()..],
        None => "",
    }
}

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
    fn units_stand_in_brackets_or_after_an_underscore() {
        let read = |cell| {
            let name = Name::read(cell);
            (name.bare, name.unit.unwrap_or_default())
        };
        for (cell, bare, unit) in [
            ("gz [deg/s]", "gz", "deg/s"),
            (" gz(rad/s) ", "gz", "rad/s"),
            ("gz_deg_per_s", "gz", "deg/s"),
            ("gyro_z_deg/h", "gyro_z", "deg/h"),
            ("time_ns", "time", "ns"),
            ("gyro_x", "gyro_x", ""),
            ("gyro_z_dps", "gyro_z", "dps"),
            ("gyro_z_rad_s", "gyro_z", "rad/s"),
            ("Gyro Z deg/sec", "Gyro Z", "deg/sec"),
            ("gyro z", "gyro z", ""),
            ("ax_m_s2", "ax", "m/s2"),
            ("ax_m_per_s2", "ax", "m/s2"),
            ("acc_x_g", "acc_x", "g"),
            ("Accel X m/s²", "Accel X", "m/s²"),
            ("dv_mm_s", "dv", "mm/s"),
            ("mag_x_G", "mag_x_G", ""),
            ("gz {°/s}", "gz", "°/s"),
            ("millis", "millis", "millis"),
            ("gyro_rad[0]", "gyro[0]", "rad"),
            ("gz [rad/s][2]", "gz[2]", "rad/s"),
            ("delta_angle[1]", "delta_angle[1]", ""),
            (&"_".repeat(1 << 20), &"_".repeat(1 << 20), ""),
            ("[s]", "[s]", ""),
            ("t []", "t", ""),
            ("", "", ""),
        ] {
            assert_eq!(read(cell), (bare.to_owned(), unit.to_owned()), "{cell}");
        }
        let rate = |cell| Name::read(cell).unit_of(Data::Rate);
        assert_eq!(rate("gyro_rad[0]").as_deref(), Some("rad/s"));
        assert_eq!([rate("gz [rad]"), rate("gz_dps")].map(Option::unwrap), ["rad", "dps"]);
        for (cell, measures) in [
            ("gyro_rad[0]", true),
            ("wz_deg", true),
            ("gz_dps", true),
            ("Drehrate [°/s]", true),
            ("status [deg/s]", true),
            ("roll_deg", false),
            ("lat_deg", false),
            ("temp_deg", false),
            ("angle_rad", false),
            ("status_g", false),
            ("imu/status.flags_g", false),
            ("state/gyro_dps", true),
            ("gz", false),
        ] {
            assert_eq!(Name::read(cell).measures(Data::Rate), measures, "{cell}");
        }
        assert_eq!(Name::read("angle_rad").unit_of(Data::Angle).as_deref(), Some("rad"));
        let second = Name::read("gyro_dps").numbered(2);
        let expected = ("gyro_dps.2", "gyro.2", Some("dps"));
        assert_eq!((&*second.whole, &*second.bare, second.unit.as_deref()), expected);
    }
    #[test]
    fn words_are_divided_by_signs_and_by_capitals() {
        for (name, expected) in [
            ("GyrX", &["gyr", "x"][..]),
            ("TimeUS", &["time", "us"]),
            ("UTCTime", &["utc", "time"]),
            ("SampleTimeFine", &["sample", "time", "fine"]),
            ("imu/delta_angle[1]", &["imu", "delta", "angle", "1"]),
            ("GYROSCOPE X", &["gyroscope", "x"]),
            ("", &[]),
        ] {
            assert_eq!(words(name), expected, "{name}");
        }
    }

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
