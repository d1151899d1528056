//! Studies of the drift budget: the paper's bound, its optimum, and the true drift of a run, in closed form.

pub(crate) mod columns;
pub(crate) mod kind;
pub(crate) mod parts;

use crate::drift::{self, Drift, END, End, RESIDUAL_MAX, SCHEDULE_SETTINGS, Schedule};
use crate::key::row::{Key, Reading};
use crate::key::sweep::{self, Swept};
use sagnac_base::source::diagnose::{Fault, Wrong};

/// The part of a study that is specific to the drift budget.
#[derive(Debug, Clone)]
pub(crate) struct DriftBudget {
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Swept)>,
    /// The parts of the drift.
    pub drift: Drift,
    /// Interval and duration.
    pub schedule: Schedule,
}

/// Every key of this kind; a budget has no spreads.
pub(crate) fn keys() -> Vec<&'static Key> {
    [drift::KEYS, drift::SCHEDULE_KEYS].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    let settings = sweep::keys(&drift::SETTINGS).chain(sweep::keys(&SCHEDULE_SETTINGS));
    settings.filter(|key| keys().iter().any(|known| known.name == key.name)).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<DriftBudget, Wrong> {
    reading.table.needed(&RESIDUAL_MAX)?;
    let (mut drift, mut schedule) = (Drift::default(), Schedule::default());
    reading.set(&mut drift, &drift::SETTINGS)?;
    reading.set(&mut schedule, &SCHEDULE_SETTINGS)?;
    schedule.end = End::of(reading.get(&END));
    let point = |swept: Vec<_>| {
        let (mut drift, mut schedule) = (drift.clone(), schedule);
        sweep::set(&mut drift, &drift::SETTINGS, &swept);
        sweep::set(&mut schedule, &SCHEDULE_SETTINGS, &swept);
        schedule.check(&reading.places)?;
        Ok(Point { swept, drift, schedule })
    };
    Ok(DriftBudget { points: sweep::points(reading.sweeps).map(point).collect::<Result<_, Fault>>()? })
}
