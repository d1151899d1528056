//! The schedule of a gyro: its switching interval and run time.

use crate::key::holds::{Holds, measure};
use crate::key::places::Places;
use crate::key::row::keys;
use crate::key::setting::Setting;
use crate::quantity::number::significant;
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;

/// Times in s, with 12 significant digits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Schedule {
    /// Switching interval MT.
    pub interval_s: f64,
    /// Run time t, from switch-on to the end.
    pub duration_s: f64,
}

const TIMES: Holds = measure(&[Dimension::Time], 1e-3, 1e9, "1 ms to 1e9 s");

keys! {
    /// The keys of the schedule.
    pub(crate) static KEYS;
    /// The mode switches of a run.
    SWITCHING = "switching", "", Holds::Table, "[switching]\ninterval = \"40 s\"";
    /// Switching interval MT: "40 s".
    pub INTERVAL = "switching.interval", "switching interval", TIMES, r#"interval = "40 s""#, required;
    /// A whole run.
    RUN = "run", "", Holds::Table, "[run]\nduration = \"1 h\"";
    /// Run time t from switch-on: "1 h".
    DURATION = "run.duration", "run time", TIMES, r#"duration = "1 h""#, required;
}

/// The settings of these keys.
pub(crate) static SETTINGS: [Setting<Schedule>; 2] = [
    Setting::new(&INTERVAL, |schedule, interval| schedule.interval_s = interval.value),
    Setting::new(&DURATION, |schedule, duration| schedule.duration_s = duration.value),
];

impl Schedule {
    /// Refuses a run that is shorter than an interval.
    pub(crate) fn check(&self, places: &Places) -> Result<(), Fault> {
        if self.interval_s <= self.duration_s {
            return Ok(());
        }
        let [interval, duration] = [self.interval_s, self.duration_s].map(|time| significant(time, 6));
        let message = format!("a run of {duration} s is shorter than the switching interval of {interval} s");
        let help = "shorten switching.interval, or lengthen run.duration";
        let names = ["switching.interval", "run.duration"];
        places.refuse(&names, message, "the gyro would never switch", help)
    }
}
