//! The scale of an axis.

use serde::{Serialize, Serializer};

use crate::names;

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
