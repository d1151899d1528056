//! Units of curves.

use crate::allan::deviation::Deviation;

/// What the curves of a record are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// °/h and ″.
    Angular,
    /// The unit of the numbers as they came, which nothing is known of.
    Plain,
}

impl Unit {
    /// As files have it: `deg/h`; empty for plain numbers.
    pub fn in_files(self, deviation: Deviation) -> &'static str {
        match (self, deviation.is_of_angle()) {
            (Unit::Angular, false) => "deg/h",
            (Unit::Angular, true) => "arcsec",
            (Unit::Plain, _) => "",
        }
    }

    /// For people.
    pub fn symbol(self, deviation: Deviation) -> &'static str {
        match self.in_files(deviation) {
            "deg/h" => "°/h",
            "arcsec" => "″",
            other => other,
        }
    }
}
