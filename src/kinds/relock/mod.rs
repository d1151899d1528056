//! Relock studies: what the closing perimeter loop fakes after a mode switch, and what compensations leave of it.

pub(crate) mod columns;
pub mod inputs;
pub mod kind;
pub mod lower;
pub mod run;
pub mod verify;

pub use crate::kinds::relock::inputs::{Compensation, Relock};

use crate::key::holds::Holds;
use crate::key::reading::Reading;
use crate::key::row::{Key, keys};
use crate::key::setting::{self, Setting, Swept};
use crate::key::sweep;
use crate::kinds::gyro;
use crate::kinds::gyro::TICK;
use crate::source::diagnose::Wrong;

/// What a relock study asks.
#[derive(Debug, Clone)]
pub struct RelockStudy {
    /// Before any sweep.
    pub inputs: RelockInputs,
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<RelockPoint>,
}

/// All that a relock depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockInputs {
    /// T, s.
    pub tick_s: f64,
    /// What the loop does and how it is measured.
    pub relock: Relock,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockPoint {
    /// Name of each swept key, and its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// All that the draws depend on.
    pub inputs: RelockInputs,
}

keys! {
    /// The table of the tick, which is all that a relock has of the gyro.
    static GYRO_KEYS;
    /// The gyro.
    GYRO = "gyro", "", Holds::Table, "[gyro]\ntick = \"5 ms\"";
}

static SETTINGS: [Setting<RelockInputs>; 1] =
    [Setting::new(&TICK, |inputs, tick| inputs.tick_s = tick.value)];

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [GYRO_KEYS, gyro::KEYS, inputs::KEYS, inputs::SIGNAL_KEYS].concat()
}

/// Every key that a sweep may vary.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    setting::keys(&SETTINGS).chain(setting::keys(&inputs::SETTINGS)).collect()
}

/// Reads what is of this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<RelockStudy, Wrong> {
    let mut inputs = RelockInputs { tick_s: 0.0, relock: inputs::read(reading)? };
    reading.set(&mut inputs, &SETTINGS)?;
    let points = (0..sweep::points(reading.sweeps)).map(|index| {
        let mut inputs = inputs.clone();
        let swept = sweep::values_at(reading.sweeps, index);
        setting::set(&mut inputs, &SETTINGS, &swept);
        setting::set(&mut inputs.relock, &inputs::SETTINGS, &swept);
        RelockPoint { swept, inputs }
    });
    let points = points.collect();
    Ok(RelockStudy { inputs, points })
}
