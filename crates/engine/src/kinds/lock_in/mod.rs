//! Studies of lock-in and dither: what a ring laser gyro puts out near its reversals, from its physics.

pub(crate) mod columns;
pub mod inputs;
pub(crate) mod kind;
pub mod lower;
pub(crate) mod motion;
pub(crate) mod notes;
pub(crate) mod parts;
pub(crate) mod point;
pub(crate) mod run;
pub mod verify;

pub use crate::kinds::lock_in::inputs::{Dither, Inputs, Readout};

use crate::key::row::{Key, Reading};
use crate::key::sweep::{self, Swept};
use crate::kinds::allan;
use crate::kinds::lock_in::inputs::{DITHER, KEYS, READOUT, SETTINGS};
use crate::kinds::lock_in::point::Times;
use sagnac_base::source::diagnose::Wrong;
use sagnac_records::fit::choose::Terms;
use sagnac_theory::allan::estimator::{Estimator, Stride};

/// The part of a study that is specific to lock-in.
#[derive(Debug, Clone)]
pub struct LockInStudy {
    /// Order and spacing of the differences of the angle.
    pub estimator: Estimator,
    /// The terms fitted to the curve of each gyro, if any.
    pub terms: Option<Terms>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// Inputs that determine the draws.
    pub inputs: Inputs,
    /// Samples of the record and averaging times.
    pub times: Times,
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [KEYS, &motion::keys(), allan::keys::CURVE_KEYS].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    sweep::keys(&SETTINGS).chain(sweep::keys(&motion::SETTINGS)).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<LockInStudy, Wrong> {
    let dither = reading
        .get(&DITHER)
        .map(|_| Dither { readout: Readout::of(reading.get(&READOUT)), ..Dither::default() });
    let mut inputs = Inputs {
        scale_factor: 0.0,
        threshold: 0.0,
        beam_noise: 0.0,
        refinement: 1.0,
        dither,
        rate: 0.0,
        ramp: 0.0,
        motion: motion::read_motion(reading)?,
        sample_s: None,
        length_s: 0.0,
    };
    reading.set(&mut inputs, &SETTINGS)?;
    reading.note(&[&READOUT, &allan::keys::TAU]);
    for sweep in reading.sweeps {
        sweep::check_applies(sweep, &inputs, &SETTINGS, "the study without [dither]")?;
        sweep::check_applies(sweep, &inputs, &motion::SETTINGS, "the motion")?;
    }
    let keys = [&allan::keys::TAU, &allan::keys::FIT];
    let taus = keys.iter().any(|key| reading.get(key).is_some());
    let estimate = allan::estimate::read(&reading.table)?;
    if let Some(fit) = reading.get(&allan::keys::FIT)
        && estimate.estimator.stride == Stride::Cluster
    {
        let message = "allan.fit conflicts with estimator = \"non-overlapping\" in a study of lock-in";
        return Err(fit.fault(message, "adjacent groups are not fitted", "leave one of them out").into());
    }
    let mut points = Vec::new();
    for swept in sweep::points(reading.sweeps) {
        let mut inputs = inputs.clone();
        sweep::set(&mut inputs, &SETTINGS, &swept);
        sweep::set(&mut inputs, &motion::SETTINGS, &swept);
        let times =
            point::check(&inputs, taus.then_some(&estimate.taus), estimate.estimator, &reading.places)?;
        points.push(Point { swept, inputs, times });
    }
    reading.notes.extend(notes::of(&points));
    Ok(LockInStudy { estimator: estimate.estimator, terms: estimate.terms, points })
}
