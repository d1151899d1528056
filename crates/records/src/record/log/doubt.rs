//! Doubts about the unit of samples, from the mean of a sensor at rest.

use crate::allan::Unit as Curves;
use crate::record::log::measure::{Data, Unit};

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
    pub(crate) fn is_strong(&self) -> bool {
        match self {
            Doubt::DegreesAsRadians(mean) => (mean / DEGREES / EARTH - 1.0).abs() < NEAR_EARTH,
            _ => true,
        }
    }

    /// The doubt about the unit of samples whose mean rate or acceleration has the magnitude `mean`, in ″/s or µg. That of
    /// several axes of an accelerometer is the length of the vector of their means.
    pub(crate) fn of(mean: f64, unit: &Unit, data: Data) -> Option<Doubt> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_tells_the_unit_of_an_accelerometer() {
        let doubt = |mean: f64, unit: &str, data| {
            let unit = Unit::parse(unit, data).unwrap();
            Doubt::of(mean * unit.factor, &unit, data)
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
