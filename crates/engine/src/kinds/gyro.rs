//! The tick of a gyro, which several kinds of study have.

use crate::key::holds::measure;
use crate::key::row::keys;
use sagnac_base::quantity::units::Dimension;

keys! {
    /// The key of the tick.
    pub(crate) static KEYS;
    /// Length of a tick, the time between two readings of the angle: "5 ms".
    pub TICK = "gyro.tick", "tick", Choice, measure(&[Dimension::Time], 1e-6, 1e3, "1 µs to 1000 s"), r#"tick = "5 ms""#, required;
}
