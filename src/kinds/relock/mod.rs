//! Relock studies: what the closing perimeter loop fakes after a mode switch, and what compensations leave of it.

pub mod inputs;
pub mod kind;
pub mod lower;
pub mod run;

pub use crate::kinds::relock::inputs::{Compensation, Relock};
pub(crate) use crate::kinds::relock::inputs::{SETTINGS as RELOCK_SETTINGS, read as read_relock};

use crate::key::file::{GyroTable, StudyFile};
use crate::key::setting::{Key, Setting, Swept};
use crate::key::sweep::{self, Sweep};
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::study::needed;

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

static TICK: Setting<RelockInputs> = Setting {
    key: Key {
        name: "gyro.tick",
        label: "tick",
        accepts: &[Dimension::Time],
        limits: (1e-6, 1e3, "1 µs to 1000 s"),
    },
    applies: |_| true,
    set: |inputs, tick| inputs.tick_s = tick.value,
};

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    std::iter::once(&TICK.key).chain(RELOCK_SETTINGS.iter().map(|setting| &setting.key)).collect()
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(file: &StudyFile, sweeps: &[Sweep], places: &mut Places) -> Result<RelockStudy, Wrong> {
    if let Some(precision) = &file.precision {
        let message = "precision is no key of a study of kind = \"relock\"";
        let help = "leave it out: trials says how many there are";
        return Err(Fault::new(precision.span(), message, "not of this kind", help).into());
    }
    let gyro = needed(file.gyro.as_ref(), "gyro", file)?.get_ref();
    check_gyro(gyro)?;
    let table = needed(file.relock.as_ref(), "relock", file)?.get_ref();
    if let Some(compensation) = &table.compensation {
        let message =
            "relock.compensation is no key of a study of kind = \"relock\", which compares all of them";
        return Err(Fault::new(compensation.span(), message, "not of this kind", "leave it out").into());
    }
    let mut inputs = RelockInputs { tick_s: 0.0, relock: read_relock(table, places)? };
    (TICK.set)(&mut inputs, TICK.read(&gyro.tick)?);
    places.add(TICK.name, gyro.tick.span());
    let points = (0..sweep::points(sweeps)).map(|index| {
        let mut inputs = inputs.clone();
        let swept = sweep::values_at(sweeps, index);
        sweep::set(&mut inputs, &[&TICK], &swept);
        sweep::set(&mut inputs.relock, &RELOCK_SETTINGS, &swept);
        RelockPoint { swept, inputs }
    });
    let points = points.collect();
    Ok(RelockStudy { inputs, points })
}

/// Refuses what is about ticks that are read.
fn check_gyro(gyro: &GyroTable) -> Result<(), Fault> {
    let others = [
        ("gyro.tick_noise", gyro.tick_noise.as_ref().map(toml::Spanned::span)),
        ("gyro.readout_lsb", gyro.readout_lsb.as_ref().map(toml::Spanned::span)),
        ("gyro.relock", gyro.relock.as_ref().map(toml::Spanned::span)),
    ];
    match others.into_iter().find_map(|(key, place)| Some((key, place?))) {
        Some((key, place)) => {
            let message = format!("{key} is no key of a study of kind = \"relock\"");
            let help = "leave it out: of the gyro it takes the tick alone";
            Err(Fault::new(place, message, "not of this kind", help))
        }
        None => Ok(()),
    }
}
