//! Relock studies: the apparent rotation of the closing path-length control loop after a mode switch, and its remainder after
//! compensation.

pub(crate) mod columns;
pub mod inputs;
pub mod kind;
pub mod lower;
pub(crate) mod parts;
pub(crate) mod run;
pub mod verify;

pub use crate::kinds::relock::inputs::{Compensation, Relock};

use crate::key::row::{Holds, Key, Reading, keys};
use crate::key::sweep::{self, Setting, Swept};
use crate::kinds::{self, TICK};
use sagnac_base::source::diagnose::Wrong;

/// The part of a study that is specific to relocking.
#[derive(Debug, Clone)]
pub struct RelockStudy {
    /// Inputs before any sweep.
    pub inputs: RelockInputs,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<RelockPoint>,
}

/// The inputs of a relock.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockInputs {
    /// Tick T, s.
    pub tick_s: f64,
    /// Perimeter loop and its measurements.
    pub relock: Relock,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockPoint {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// Inputs that determine the draws.
    pub inputs: RelockInputs,
}

keys! {
    /// The table of the tick, the only property of the gyro that a relock uses.
    static GYRO_KEYS;
    /// The gyro.
    GYRO = "gyro", "", Fixed, Holds::Table, "[gyro]\ntick = \"5 ms\"";
}

static SETTINGS: [Setting<RelockInputs>; 1] =
    [Setting::new(&TICK, |inputs, tick| inputs.tick_s = tick.value)];

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [GYRO_KEYS, kinds::KEYS, inputs::KEYS, inputs::SIGNAL_KEYS].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    sweep::keys(&SETTINGS).chain(sweep::keys(&inputs::SETTINGS)).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<RelockStudy, Wrong> {
    let mut inputs = RelockInputs { tick_s: 0.0, relock: inputs::read(reading)? };
    reading.set(&mut inputs, &SETTINGS)?;
    let points = sweep::points(reading.sweeps).map(|swept| {
        let mut inputs = inputs.clone();
        sweep::set(&mut inputs, &SETTINGS, &swept);
        sweep::set(&mut inputs.relock, &inputs::SETTINGS, &swept);
        RelockPoint { swept, inputs }
    });
    Ok(RelockStudy { points: points.collect(), inputs })
}
