//! The quantity measured by a log and its unit, doubts about that unit from the mean of a sensor at rest, and the check of a log
//! before deviations are computed.

use crate::allan::Unit as Curves;
use crate::record::RecordError;
use crate::record::log::{Channel, Fault, Log};
use crate::record::names::unit_of;
use sagnac_base::names;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity, parse as parse_quantity};

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

/// Largest mean rate of a good gyro at rest, ″/s (°/h): the Earth's rotation on its axis, and 1 °/h of bias.
const AT_REST: f64 = EARTH + 1.0;

/// The Earth's rotation on its axis, ″/s (°/h), and the relative deviation of a mean that is taken for it.
const EARTH: f64 = 15.041_067;
const NEAR_EARTH: f64 = 0.03;

/// One rad in °.
pub(crate) const DEGREES: f64 = 57.295_779_513_082_32;

/// Mean rate, ″/s, above which no gyro is at rest; 20 °/s is the bias of the worst.
const NEVER_AT_REST: f64 = 72_000.0;

/// Gravity, µg.
const GRAVITY: f64 = 1e6;

/// Relative deviation from gravity by biases, scale factors and the place on Earth.
const NEAR: f64 = 0.05;

/// Mean acceleration of up to three axes, µg, above which no accelerometer is at rest, whatever their directions.
const MAX_GRAVITY: f64 = 2.0 * GRAVITY;

/// Units that accelerometers are often taken to have.
const ACCELERATIONS: [&str; 7] = ["m/s^2", "g", "mg", "ug", "m/s", "g*s", "mm/s"];

/// Why the unit of samples is doubtful.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// The samples are rates in rad whose mean is above the Earth's rotation plus 1 °/h of bias, but would not be in
    /// degrees; with the magnitude of the mean rate, ″/s.
    DegreesAsRadians(f64),
    /// The mean rate is above 20 °/s, or the mean acceleration above 2 g, unlike that of any sensor at rest; with its
    /// magnitude, ″/s or µg.
    NeverAtRest(f64),
    /// The mean acceleration is not gravity within 5 %, but would be in another unit.
    Gravity {
        /// Magnitude of the mean acceleration, µg.
        mean: f64,
        /// The other unit.
        other: &'static str,
    },
}

/// Whether a unit is rad/s, or rad, and no part of it.
fn is_radian(unit: &Unit) -> bool {
    (unit.factor / (648_000.0 / core::f64::consts::PI) - 1.0).abs() < 1e-9
}

impl Doubt {
    /// Whether the doubt stands against a unit that is stated. A rate in radians is often a bias, unless in degrees it is the Earth's.
    fn is_strong(&self) -> bool {
        match self {
            Doubt::DegreesAsRadians(mean) => (mean / DEGREES / EARTH - 1.0).abs() < NEAR_EARTH,
            _ => true,
        }
    }

    /// The doubt about the unit of samples whose mean rate or acceleration has the magnitude `mean`, in ″/s or µg. That of
    /// several axes of an accelerometer is the length of the vector of their means.
    pub(crate) fn new(mean: f64, unit: &Unit, data: Data) -> Option<Doubt> {
        let is_gravity = |mean: f64| (mean / GRAVITY - 1.0).abs() < NEAR;
        match unit.curves {
            Curves::Angular if is_radian(unit) && mean > AT_REST && mean <= AT_REST * DEGREES => {
                Some(Doubt::DegreesAsRadians(mean))
            }
            Curves::Angular => (mean > NEVER_AT_REST).then_some(Doubt::NeverAtRest(mean)),
            Curves::Acceleration if is_gravity(mean) => None,
            Curves::Acceleration => {
                let explains = |other: &&str| {
                    let other = Unit::parse(other, data);
                    other.is_ok_and(|other| is_gravity(mean / unit.factor * other.factor))
                };
                let other = ACCELERATIONS.into_iter().find(explains);
                let never = || (mean > MAX_GRAVITY).then_some(Doubt::NeverAtRest(mean));
                other.map(|other| Doubt::Gravity { mean, other }).or_else(never)
            }
            Curves::Plain => None,
        }
    }
}

/// Fewest samples for an analysis.
pub const MIN_SAMPLES: usize = 16;

/// Axes of a sensor.
const AXES: usize = 3;

/// Whether rates and accelerations that appear to be in a wrong unit are noted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitCheck {
    /// They are noted, with a suggestion.
    On,
    /// They are accepted.
    Off,
}

impl Log {
    /// Refuses channels that carry no information, by [`Samples::fault`](crate::record::log::Samples::fault):
    /// those with fewer than [`MIN_SAMPLES`] samples, or with all samples equal.
    ///
    /// With [`UnitCheck::On`] it notes channels whose mean looks like that of another unit, by
    /// [`Doubt`]. Only the mean is examined, which no deviation depends on. Gravity is sought
    /// in up to three accelerometers of one unit together.
    ///
    /// # Errors
    /// The first such fault, with its column.
    pub fn check(&mut self, unit: UnitCheck) -> Result<(), RecordError> {
        for channel in &self.channels {
            if let Some(fault) = channel.view(self.data, self.step_s).fault() {
                let (message, help) = self.told(channel, fault);
                return Err(RecordError::new(message, "this column", help, channel.place.clone()));
            }
        }
        if unit == UnitCheck::On {
            let doubts: Vec<String> = self.sensors().iter().filter_map(|axes| self.doubt(axes)).collect();
            self.notes.extend(doubts);
        }
        Ok(())
    }

    /// The channels whose means belong together: each gyro by itself, and the axes of accelerometers.
    fn sensors(&self) -> Vec<Vec<&Channel>> {
        let mut sensors: Vec<Vec<&Channel>> = Vec::new();
        for channel in &self.channels {
            let is_of = |axes: &&mut Vec<&Channel>| {
                channel.unit.curves == Curves::Acceleration
                    && axes[0].unit == channel.unit
                    && axes.len() < AXES
            };
            match sensors.iter_mut().find(is_of) {
                Some(axes) => axes.push(channel),
                None => sensors.push(vec![channel]),
            }
        }
        sensors
    }

    /// The note on the unit of some axes, if it is doubtful.
    fn doubt(&self, axes: &[&Channel]) -> Option<String> {
        let means = axes.iter().map(|channel| channel.view(self.data, self.step_s).mean_rate());
        let means: Vec<f64> = means.collect::<Option<_>>()?;
        let doubt = Doubt::new(means.into_iter().fold(0.0, libm::hypot), &axes[0].unit, self.data)?;
        let has_mean = |axis: &&Channel| axis.view(self.data, self.step_s).has_mean();
        let is_known = !matches!(doubt, Doubt::DegreesAsRadians(_)) || axes.iter().all(has_mean);
        let is_guessed = axes.iter().any(|axis| axis.is_unit_guessed);
        (is_known && (is_guessed || doubt.is_strong())).then(|| self.noted(axes, doubt))
    }

    /// The message and the help for a fault of a column.
    fn told(&self, channel: &Channel, fault: Fault) -> (String, String) {
        let column = format!("column {} of {}", channel.name, self.file);
        let (message, help) = match fault {
            Fault::TooFew(there) => {
                let samples = if there == 1 { "sample" } else { "samples" };
                let help = "record longer, or skip less; the rows of an array are samples, its columns axes";
                (format!("has {there} {samples}, at least {MIN_SAMPLES} are needed"), help)
            }
            Fault::Constant { there, value } => {
                let help =
                    "is it the right column, and was the sensor on? a constant has no deviation to show";
                (format!("is constant: all {there} samples are {value}"), help)
            }
        };
        (format!("{column} {message}"), help.to_owned())
    }

    /// The note on a doubtful unit of some axes.
    fn noted(&self, axes: &[&Channel], doubt: Doubt) -> String {
        let (unit, data) = (&axes[0].unit, self.data.name());
        let note = match doubt {
            Doubt::DegreesAsRadians(mean) => {
                let other = if self.data == Data::Rate { "`unit = deg/s`" } else { "`unit = deg`" };
                format!(
                    "may be in degrees, not in radians: its mean is {}, in degrees it would be {}, as a gyro at rest shows of \
                     the Earth's 15.04 °/h; if so, give {other}",
                    rate(mean),
                    rate(mean / DEGREES)
                )
            }
            Doubt::NeverAtRest(mean) => {
                let (text, other) = (&unit.text, unit.curves == Curves::Acceleration);
                let (mean, sensor) = if other { (in_g(mean), "accelerometer") } else { (rate(mean), "gyro") };
                format!(
                    "has a mean {} of {mean}, which no {sensor} at rest has: is {text} its unit, and `data = {data}` right?",
                    unit.curves.measured()
                )
            }
            Doubt::Gravity { mean, other } => format!(
                "may be in {other}, not in {}: its mean is {}, in {other} it would be 1 g, as an accelerometer at rest shows of \
                 gravity; if so, give `unit = {other}`",
                unit.text,
                in_g(mean)
            ),
        };
        let names: Vec<&str> = axes.iter().map(|channel| channel.name.as_str()).collect();
        let columns = if names.len() == 1 { "column" } else { "the vector of columns" };
        format!("{columns} {} {note}", names.join(", "))
    }
}

/// An acceleration in µg, formatted for the user.
fn in_g(mean: f64) -> String {
    format!("{} g", significant(1e-6 * mean, 3))
}

/// A rate in ″/s, formatted for the user.
fn rate(mean: f64) -> String {
    if mean < 3600.0 {
        format!("{} °/h", significant(mean, 3))
    } else {
        format!("{} °/s", significant(mean / 3600.0, 3))
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

    #[test]
    fn gravity_tells_the_unit_of_an_accelerometer() {
        let doubt = |mean: f64, unit: &str, data| {
            let unit = Unit::parse(unit, data).unwrap();
            Doubt::new(mean * unit.factor, &unit, data)
        };
        for (mean, unit, data) in [
            (9.81, "m/s^2", Data::Rate),
            (1.02, "g", Data::Rate),
            (0.3, "g", Data::Rate),
            (0.0, "m/s^2", Data::Rate),
            (1.41, "g", Data::Rate),
            (0.0981, "m/s", Data::Angle),
        ] {
            assert_eq!(doubt(mean, unit, data), None, "{mean} {unit}");
        }
        for (mean, unit, data, expected) in [
            (1.0, "m/s^2", Data::Rate, "g"),
            (9.8, "g", Data::Rate, "m/s^2"),
            (1010.0, "m/s^2", Data::Rate, "mg"),
            (1.0, "mg", Data::Rate, "g"),
            (9.81, "mm/s", Data::Increment, "m/s"),
        ] {
            let Some(Doubt::Gravity { other, .. }) = doubt(mean, unit, data) else {
                panic!("no doubt about {mean} {unit}")
            };
            assert_eq!(other, expected);
        }
        assert!(matches!(doubt(30.0, "m/s^2", Data::Rate), Some(Doubt::NeverAtRest(_))));
    }
}
