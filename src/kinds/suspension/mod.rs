//! Studies of a suspension: its response over the frequency of a vibration, in closed form.

pub mod kind;
pub mod read;
pub mod table;

use std::sync::Arc;

pub(crate) use crate::kinds::suspension::read::{GYROS, assumed, read as read_suspension};

use crate::key::file::StudyFile;
use crate::key::setting::{Key, Setting, Swept};
use crate::key::sweep::{self, Sweep};
use crate::quantity::units::Dimension;
use crate::source::diagnose::Wrong;
use crate::source::place::Places;
use crate::study::{needed, needed_key};
use crate::theory::suspension::Suspension;

/// What a study of a suspension asks.
#[derive(Debug, Clone)]
pub struct SuspensionStudy {
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<Point>,
    /// What is assumed, each in a sentence.
    pub notes: Vec<String>,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key, and its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// Its modes.
    pub suspension: Arc<Suspension>,
    /// Of the vibration.
    pub frequency_hz: f64,
}

static FREQUENCY: Setting<Point> = Setting {
    key: Key {
        name: "suspension.frequency",
        label: "vibration frequency",
        accepts: &[Dimension::Frequency],
        limits: (1e-6, 1e7, "1e-6 Hz to 1e7 Hz"),
    },
    applies: |_| true,
    set: |point, frequency| point.frequency_hz = frequency.value,
};

static GYRO: Key = Key { name: "suspension.gyro", label: "gyro", accepts: &[], limits: (0.0, 0.0, GYROS) };

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    vec![&FREQUENCY.key, &GYRO]
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(
    file: &StudyFile,
    sweeps: &[Sweep],
    places: &mut Places,
) -> Result<SuspensionStudy, Wrong> {
    let table = needed(file.suspension.as_ref(), "suspension", file)?;
    places.add("suspension", table.span());
    let written = table.get_ref();
    let suspension = read_suspension(GYRO.name, &written.gyro, &written.modes, table.span(), sweeps)?;
    let mut point = Point { swept: vec![], suspension, frequency_hz: 0.0 };
    let swept = sweeps.iter().any(|sweep| sweep.key.name == FREQUENCY.name);
    if let Some(frequency) = &written.frequency {
        (FREQUENCY.set)(&mut point, FREQUENCY.read(frequency)?);
    } else if !swept {
        needed_key(written.frequency.as_ref(), FREQUENCY.name, table)?;
    }
    let points = (0..sweep::points(sweeps)).map(|index| {
        let mut point = Point { swept: sweep::values_at(sweeps, index), ..point.clone() };
        let swept = point.swept.clone();
        sweep::set(&mut point, &[&FREQUENCY], &swept);
        if let Some(named) = named(&swept, GYRO.name) {
            point.suspension = named;
        }
        point
    });
    let notes = assumed(GYRO.name, &written.gyro, sweeps).into_iter().collect();
    Ok(SuspensionStudy { points: points.collect(), notes })
}

/// The suspension that a sweep over names under this key chooses.
pub(crate) fn named(swept: &[(&'static str, Swept)], key: &str) -> Option<Arc<Suspension>> {
    swept.iter().find_map(|(name, value)| match value {
        Swept::Name(gyro) if *name == key => Suspension::named(gyro).map(Arc::new),
        _ => None,
    })
}
