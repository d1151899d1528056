//! Units of curves.

use crate::allan::Deviation;

/// The unit of the curves of a record, which follows from what the sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// °/h and ″, of rotation.
    Angular,
    /// µg and µg·s, of acceleration.
    Acceleration,
    /// The unknown unit of plain numbers.
    Plain,
}

impl Unit {
    /// All units, in the order of results.
    pub const ALL: [Unit; 3] = [Unit::Angular, Unit::Acceleration, Unit::Plain];

    /// Unit in files, such as `deg/h`; empty for plain numbers.
    pub fn in_files(self, deviation: Deviation) -> &'static str {
        match (self, deviation.is_of_angle()) {
            (Unit::Angular, false) => "deg/h",
            (Unit::Angular, true) => "arcsec",
            (Unit::Acceleration, false) => "ug",
            (Unit::Acceleration, true) => "ug*s",
            (Unit::Plain, _) => "",
        }
    }

    /// Unit for the user.
    pub fn symbol(self, deviation: Deviation) -> &'static str {
        match self.in_files(deviation) {
            "deg/h" => "°/h",
            "arcsec" => "″",
            "ug" => "µg",
            "ug*s" => "µg·s",
            other => other,
        }
    }

    /// What a sample measures, in a sentence. Plain numbers are taken for rates.
    pub fn measured(self) -> &'static str {
        if self == Unit::Acceleration { "acceleration" } else { "rate" }
    }

    /// What records of this unit have, in a sentence.
    pub fn content(self) -> &'static str {
        match self {
            Unit::Angular => "angular rates",
            Unit::Acceleration => "accelerations",
            Unit::Plain => "plain numbers",
        }
    }
}
