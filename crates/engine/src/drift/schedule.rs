//! The schedule of a gyro: its switching interval and run time.

use crate::key::holds::{Holds, measure, words};
use crate::key::places::Places;
use crate::key::row::keys;
use crate::key::setting::Setting;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::Fault;
use sagnac_kernel::switched_run::ENDS;

words! {
    /// When a run ends.
    pub enum End {
        /// At any phase of switching: at 64 equally likely times over one cycle of two intervals, centred on the run time. How
        /// far the last interval has come then does not matter.
        Any = "any",
        /// Exactly at the run time, wherever in an interval that is.
        Exact = "exact",
    }
}

/// Times in s, with 12 significant digits, and what the run time means.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Schedule {
    /// Switching interval MT.
    pub interval_s: f64,
    /// Run time t, from switch-on to the end.
    pub duration_s: f64,
    /// Whether a run ends exactly then.
    pub end: End,
}

const TIMES: Holds = measure(&[Dimension::Time], 1e-3, 1e9, "1 ms to 1e9 s");

keys! {
    /// The keys of the schedule.
    pub(crate) static KEYS;
    /// The mode switches of a run.
    SWITCHING = "switching", "", Fixed, Holds::Table, "[switching]\ninterval = \"40 s\"";
    /// Switching interval MT: "40 s".
    pub INTERVAL = "switching.interval", "switching interval", Choice, TIMES, r#"interval = "40 s""#, required;
    /// A whole run.
    RUN = "run", "", Fixed, Holds::Table, "[run]\nduration = \"1 h\"";
    /// Run time t from switch-on: "1 h".
    DURATION = "run.duration", "run time", Question, TIMES, r#"duration = "1 h""#, required;
    /// The end of a run. "any", the default, averages it over the phase of switching: the angle at the end is read at 64
    /// equally likely times over one cycle of two intervals, centred on run.duration. "exact" reads it at run.duration,
    /// where the drift depends on how far the last interval has come. Rates are angles divided by run.duration, and the
    /// non-magnetic drift acts for exactly that time. Times and trajectories are exact in both cases.
    pub END = "run.end", "", Fixed, Holds::Word(End::WORDS), r#"end = "any""#;
}

/// The settings of these keys.
pub(crate) static SETTINGS: [Setting<Schedule>; 2] = [
    Setting::new(&INTERVAL, |schedule, interval| schedule.interval_s = interval.value),
    Setting::new(&DURATION, |schedule, duration| schedule.duration_s = duration.value),
];

impl Schedule {
    /// The equally likely times at which a run ends, s.
    pub fn ends(&self) -> Vec<f64> {
        let part = |step: usize| (2 * step + 1) as f64 / ENDS as f64 - 1.0;
        match self.end {
            End::Any => (0..ENDS).map(|step| self.duration_s + part(step) * self.interval_s).collect(),
            End::Exact => vec![self.duration_s],
        }
    }

    /// Bound of the time that a run lasts, s.
    pub(crate) fn longest_s(&self) -> f64 {
        match self.end {
            End::Any => self.duration_s + self.interval_s,
            End::Exact => self.duration_s,
        }
    }

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
