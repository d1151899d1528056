//! The quantity measured by a log, and its unit.

use crate::key::holds::names;
use crate::quantity::units::{Dimension, parse as parse_quantity};
use crate::record::spelling::unit_of;

names! {
    /// The quantity of the numbers of a log.
    pub enum Data {
        /// The mean angular rate over a sample.
        Rate = "rate",
        /// The angle turned during a sample.
        Increment = "increment",
        /// The angle since some start; also for phase records.
        Angle = "angle",
    }
}

impl Data {
    fn dimension(self) -> Dimension {
        if self == Data::Rate { Dimension::Rate } else { Dimension::Angle }
    }
}

/// The unit of a log's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Text as written by the user or in the header.
    pub text: String,
    /// Size in ″/s for rates and in ″ for increments and angles; 1 for plain numbers.
    pub factor: f64,
    /// Whether it is a unit of rate or angle, as opposed to `none`.
    pub is_angular: bool,
}

/// Accepted names of pulses in a scale.
const PULSES: [&str; 6] = ["pulse", "pulses", "count", "counts", "LSB", "lsb"];

/// Why a unit or scale does not fit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct UnitMismatch {
    /// The mismatch, for the user.
    pub message: String,
    /// What to write instead.
    pub help: String,
}

impl Unit {
    /// Reads a unit such as `deg/h`; `none` stands for plain numbers.
    ///
    /// # Errors
    /// The unit is unknown, or does not measure this `data`.
    pub fn parse(text: &str, data: Data) -> Result<Unit, UnitMismatch> {
        let text = text.trim();
        if text == "none" {
            return Ok(Unit { text: text.to_owned(), factor: 1.0, is_angular: false });
        }
        let wanted = data.dimension();
        unit_of(text, &[wanted])
            .map(|(factor, _)| Unit { text: text.to_owned(), factor, is_angular: true })
            .map_err(|error| UnitMismatch {
                message: format!("the unit of `data = {}`: {error}", data.name()),
                help: expected(data),
            })
    }

    /// Reads the size of a pulse such as `0.5 arcsec/pulse`; `count` and `LSB` are accepted for a pulse.
    ///
    /// # Errors
    /// The text is not a number with a unit per pulse, or the unit does not measure this `data`.
    pub fn parse_scale(text: &str, data: Data) -> Result<Unit, UnitMismatch> {
        let help = match data {
            Data::Rate => {
                "write the rate of a pulse, as in `scale = \"0.01 deg/s/LSB\"`; pulses counted in each sample are \
                 `data = increment`"
            }
            _ => "write the angle of a pulse, as in `scale = \"0.5 arcsec/pulse\"`",
        };
        let wrong = |message: String| UnitMismatch { message, help: help.to_owned() };
        let size = text.trim().rsplit_once('/').filter(|(_, per)| PULSES.contains(&per.trim()));
        let Some((size, _)) = size else {
            return Err(wrong(format!("the scale \"{text}\" is not the size of a pulse")));
        };
        let quantity = parse_quantity(size, &[data.dimension()])
            .map_err(|error| wrong(format!("the scale of `data = {}`: {error}", data.name())))?;
        if quantity.value == 0.0 {
            return Err(wrong(format!("the scale \"{text}\" is 0")));
        }
        Ok(Unit { text: text.trim().to_owned(), factor: quantity.value, is_angular: true })
    }
}

/// Help with the accepted units for this data.
pub(crate) fn expected(data: Data) -> String {
    match data {
        Data::Rate => "accepted: `unit = deg/h`, deg/s, rad/s, arcsec/s, or `unit = none` for plain numbers; angles are \
                       `data = increment` or `data = angle`"
            .to_owned(),
        _ => "accepted: `unit = arcsec`, deg, rad, mrad, urad, `unit = none` for plain numbers, or for pulses `scale = \
              \"0.5 arcsec/pulse\"`; rates are `data = rate`"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_scales_have_their_size_in_arcseconds_and_seconds() {
        let unit = |text, data| Unit::parse(text, data).unwrap().factor;
        assert_eq!((unit("deg/h", Data::Rate), unit("deg/s", Data::Rate)), (1.0, 3600.0));
        assert!((unit("rad/s", Data::Rate) / 206_264.806_247 - 1.0).abs() < 1e-12);
        assert_eq!((unit("dps", Data::Rate), unit("deg/sec", Data::Rate)), (3600.0, 3600.0));
        assert_eq!(unit("deg", Data::Angle), 3600.0);
        assert!(!Unit::parse("none", Data::Rate).unwrap().is_angular);
        let scale = |text, data| Unit::parse_scale(text, data).unwrap().factor;
        assert_eq!(scale("0.5 arcsec/pulse", Data::Increment), 0.5);
        assert_eq!(scale("0.5″/counts", Data::Angle), 0.5);
        assert_eq!(scale("0.01 deg/s/LSB", Data::Rate), 36.0);
    }

    #[test]
    fn a_unit_of_something_else_is_refused_with_what_is_accepted() {
        for (text, data, piece) in [
            ("deg", Data::Rate, "an angle"),
            ("deg/s", Data::Increment, "an angular rate"),
            ("volts", Data::Rate, "`volts` is not a known unit"),
            ("", Data::Rate, "cannot be read"),
        ] {
            let error = Unit::parse(text, data).unwrap_err();
            assert!(error.message.contains(piece) && error.help.contains("accepted"), "{text}: {error:?}");
        }
        for (text, data) in [
            ("0.5", Data::Angle),
            ("0.5 arcsec", Data::Angle),
            ("arcsec/pulse", Data::Angle),
            ("0 arcsec/pulse", Data::Angle),
            ("0.5 arcsec/pulse", Data::Rate),
            ("0.5 arcsec/volt", Data::Angle),
        ] {
            assert!(Unit::parse_scale(text, data).unwrap_err().help.contains("`scale = "), "{text}");
        }
    }
}
