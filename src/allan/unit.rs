//! Units of curves.

use crate::allan::Deviation;

/// The unit of the curves of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// °/h and ″.
    Angular,
    /// The unknown unit of plain numbers.
    Plain,
}

impl Unit {
    /// Unit in files, such as `deg/h`; empty for plain numbers.
    pub fn in_files(self, deviation: Deviation) -> &'static str {
        match (self, deviation.is_of_angle()) {
            (Unit::Angular, false) => "deg/h",
            (Unit::Angular, true) => "arcsec",
            (Unit::Plain, _) => "",
        }
    }

    /// Unit for the user.
    pub fn symbol(self, deviation: Deviation) -> &'static str {
        match self.in_files(deviation) {
            "deg/h" => "°/h",
            "arcsec" => "″",
            other => other,
        }
    }
}
