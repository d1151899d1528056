//! When a gyro switches, and how long it runs.

use toml::Spanned;

use crate::key::scalar::Scalar;
use crate::key::setting::{Key, Setting};
use crate::key::sweep::Sweep;
use crate::quantity::number::significant;
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;
use crate::source::place::Places;

/// In s, with 12 significant digits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Schedule {
    /// MT, from one switch to the next.
    pub interval_s: f64,
    /// t, from switching on to the end.
    pub duration_s: f64,
}

pub(crate) static INTERVAL: Setting<Schedule> = Setting {
    key: Key {
        name: "switching.interval",
        label: "switching interval",
        accepts: &[Dimension::Time],
        limits: (1e-3, 1e9, "1 ms to 1e9 s"),
    },
    applies: |_| true,
    set: |schedule, interval| schedule.interval_s = interval.value,
};

static DURATION: Setting<Schedule> = Setting {
    key: Key {
        name: "run.duration",
        label: "run time",
        accepts: &[Dimension::Time],
        limits: (1e-3, 1e9, "1 ms to 1e9 s"),
    },
    applies: |_| true,
    set: |schedule, duration| schedule.duration_s = duration.value,
};

/// Every key of the schedule that a sweep may vary.
pub(crate) static SETTINGS: [&Setting<Schedule>; 2] = [&INTERVAL, &DURATION];

/// The schedule that is written; an interval of 0 where it is not.
pub(crate) fn read(
    interval: Option<&Spanned<Scalar>>,
    duration: &Spanned<Scalar>,
    places: &mut Places,
) -> Result<Schedule, Fault> {
    let mut schedule = Schedule::default();
    for (setting, value) in [(&INTERVAL, interval), (&DURATION, Some(duration))] {
        if let Some(value) = value {
            (setting.set)(&mut schedule, setting.read(value)?);
            places.add(setting.name, value.span());
        }
    }
    Ok(schedule)
}

impl Schedule {
    /// Refuses a run that is shorter than an interval.
    pub(crate) fn check(&self, places: &Places, sweeps: &[Sweep]) -> Result<(), Fault> {
        if self.interval_s <= self.duration_s {
            return Ok(());
        }
        let [interval, duration] = [self.interval_s, self.duration_s].map(|time| significant(time, 6));
        let message = format!("a run of {duration} s is shorter than the switching interval of {interval} s");
        let place = places.blame(sweeps, &["switching.interval", "run.duration"]);
        let help = "shorten switching.interval, or lengthen run.duration";
        Err(Fault::new(place, message, "the gyro would never switch", help))
    }
}
