//! The quantity measured by a log, and its unit.

use crate::allan::Unit as Curves;
use crate::record::spelling::unit_of;
use sagnac_base::names;
use sagnac_base::quantity::units::{Dimension, Quantity, parse as parse_quantity};

names! {
    /// The quantity of the numbers of a log. The unit of a column tells rotation from acceleration.
    pub enum Data {
        /// The mean angular rate or acceleration over a sample.
        Rate = "rate",
        /// The angle turned or the velocity gained during a sample.
        Increment = "increment",
        /// The angle or velocity since some start; also for phase records.
        Angle = "angle",
    }
}

impl Data {
    fn dimensions(self) -> [Dimension; 2] {
        match self {
            Data::Rate => [Dimension::Rate, Dimension::Acceleration],
            Data::Increment | Data::Angle => [Dimension::Angle, Dimension::Velocity],
        }
    }
}

/// The unit of a log's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Text as written by the user or in the header.
    pub text: String,
    /// Size in ″/s for rates and in ″ for angles, in µg for accelerations and in µg·s for velocities; 1 for plain numbers.
    pub factor: f64,
    /// Unit of the curves of such samples.
    pub curves: Curves,
}

/// One g in µg, the base unit of accelerations in logs.
const MICRO_G: f64 = 1e6;

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
            return Ok(Unit { text: text.to_owned(), factor: 1.0, curves: Curves::Plain });
        }
        unit_of(text, &data.dimensions()).map(|(size, dimension)| Unit::sized(text, size, dimension)).map_err(
            |error| UnitMismatch {
                message: format!("the unit of `data = {}`: {error}", data.name()),
                help: expected(data),
            },
        )
    }

    /// Reads the unit in a header, which may be the size of a pulse, as in `gz [0.5 arcsec/pulse]`.
    ///
    /// # Errors
    /// It is no unit or size of a pulse that measures this `data`.
    pub fn of_header(text: &str, data: Data) -> Result<Unit, UnitMismatch> {
        Unit::parse(text, data).or_else(|mismatch| Unit::parse_scale(text, data).map_err(|_| mismatch))
    }

    /// The unit for its size in the base unit of `dimension`.
    fn sized(text: &str, size: f64, dimension: Dimension) -> Unit {
        let (factor, curves) = match dimension {
            Dimension::Acceleration | Dimension::Velocity => (MICRO_G * size, Curves::Acceleration),
            _ => (size, Curves::Angular),
        };
        Unit { text: text.to_owned(), factor, curves }
    }

    /// Reads the size of a pulse such as `0.5 arcsec/pulse` or `0.1 mm/s/pulse`; `count` and `LSB` are accepted for a pulse.
    ///
    /// # Errors
    /// The text is not a number with a unit per pulse, or the unit does not measure this `data`.
    pub fn parse_scale(text: &str, data: Data) -> Result<Unit, UnitMismatch> {
        let help = match data {
            Data::Rate => {
                "write the rate or acceleration of a pulse, as in `scale = \"0.01 deg/s/LSB\"`; pulses counted in each sample \
                 are `data = increment`"
            }
            _ => "write the angle or velocity of a pulse, as in `scale = \"0.5 arcsec/pulse\"`",
        };
        let wrong = |message: String| UnitMismatch { message, help: help.to_owned() };
        let size = text.trim().rsplit_once('/').filter(|(_, per)| PULSES.contains(&per.trim()));
        let Some((size, _)) = size else {
            return Err(wrong(format!("the scale \"{text}\" is not the size of a pulse")));
        };
        let Quantity { value, dimension, .. } = parse_quantity(size, &data.dimensions())
            .map_err(|error| wrong(format!("the scale of `data = {}`: {error}", data.name())))?;
        if value == 0.0 {
            return Err(wrong(format!("the scale \"{text}\" is 0")));
        }
        Ok(Unit::sized(text.trim(), value, dimension))
    }
}

/// Help with the accepted units for this data.
pub(crate) fn expected(data: Data) -> String {
    match data {
        Data::Rate => "accepted: `unit = deg/h`, deg/s, rad/s, arcsec/s of gyros, m/s^2, g, mg, ug of accelerometers, or \
                       `unit = none` for plain numbers; angles and velocities are `data = increment` or `data = angle`"
            .to_owned(),
        _ => "accepted: `unit = arcsec`, deg, rad, mrad, urad of gyros, m/s, mm/s, g*s of accelerometers, `unit = none` for \
              plain numbers, or for pulses `scale = \"0.5 arcsec/pulse\"`; rates and accelerations are `data = rate`"
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
        let curves = |text| Unit::parse(text, Data::Rate).unwrap().curves;
        assert_eq!(["none", "dps", "g"].map(curves), [Curves::Plain, Curves::Angular, Curves::Acceleration]);
        assert_eq!((unit("g", Data::Rate), unit("ug", Data::Rate)), (1e6, 1.0));
        assert_eq!((unit("mg", Data::Rate), unit("g*s", Data::Increment)), (1e3, 1e6));
        assert!((unit("m/s", Data::Angle) * 9.80665 / 1e6 - 1.0).abs() < 1e-15);
        let scale = |text, data| Unit::parse_scale(text, data).unwrap().factor;
        assert_eq!(scale("0.5 arcsec/pulse", Data::Increment), 0.5);
        assert_eq!(scale("0.5″/counts", Data::Angle), 0.5);
        assert_eq!(scale("0.01 deg/s/LSB", Data::Rate), 36.0);
        assert!((scale("0.1 mm/s/pulse", Data::Increment) / (100.0 / 9.80665) - 1.0).abs() < 1e-11);
        assert_eq!(Unit::parse_scale("0.1 mg/LSB", Data::Rate).unwrap().curves, Curves::Acceleration);
    }

    #[test]
    fn a_unit_of_something_else_is_refused_with_what_is_accepted() {
        for (text, data, piece) in [
            ("deg", Data::Rate, "an angle"),
            ("deg/s", Data::Increment, "an angular rate"),
            ("m/s^2", Data::Increment, "an acceleration"),
            ("m/s", Data::Rate, "a velocity"),
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
