//! The drift of a gyro that switches modes, and its schedule of switches; shared by budgets and whole runs.

use crate::key::document::SpanMap;
use crate::key::sweep::SweepTarget;
use crate::key::{ValueType, keys, measure, words};
use sagnac_base::diagnostics::Fault;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::switched_run::ENDS;
use sagnac_theory::drift::Magnetic;

/// Parts of the drift in ″ and s, each with its standard deviation from run to run; 0 means absent. Every number has 12
/// significant digits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drift {
    /// Magnetic drift A, ″/s.
    pub magnetic: f64,
    /// Standard deviation of A, ″/s.
    pub magnetic_spread: f64,
    /// Time constant of the warm-up τ, s; 0 where there is no warm-up and A is present from the start.
    pub warm_up_s: f64,
    /// Standard deviation of ln τ.
    pub warm_up_spread: f64,
    /// Non-magnetic drift Ω_nm, ″/s.
    pub non_magnetic: f64,
    /// Standard deviation of Ω_nm, ″/s.
    pub non_magnetic_spread: f64,
    /// Initial magnetic drift Ω_m0, ″/s.
    pub initial_magnetic: f64,
    /// Standard deviation of Ω_m0, ″/s.
    pub initial_magnetic_spread: f64,
    /// Angle random walk N, ″/√s.
    pub angle_random_walk: f64,
    /// Largest residual of a switch δP_max, ″.
    pub residual_max: f64,
}

impl Drift {
    /// The inputs that determine the draws, key by key, without the residual; absent parts have no line.
    pub(crate) fn canonical(&self) -> String {
        // Every field, so that a new one cannot be left out by mistake.
        let Drift {
            magnetic,
            magnetic_spread,
            warm_up_s,
            warm_up_spread,
            non_magnetic,
            non_magnetic_spread,
            initial_magnetic,
            initial_magnetic_spread,
            angle_random_walk,
            residual_max: _,
        } = self;
        let all = [
            ("magnetic", magnetic),
            ("magnetic_spread", magnetic_spread),
            ("warm_up_time", warm_up_s),
            ("warm_up_time_spread", warm_up_spread),
            ("non_magnetic", non_magnetic),
            ("non_magnetic_spread", non_magnetic_spread),
            ("initial_magnetic", initial_magnetic),
            ("initial_magnetic_spread", initial_magnetic_spread),
            ("angle_random_walk", angle_random_walk),
        ];
        let given = all.into_iter().filter(|(_, value)| **value != 0.0);
        given.map(|(name, value)| format!("{name}={value:.11e}\n")).collect()
    }

    /// Whether the gyro has no drift at all.
    pub(crate) fn is_nothing(&self) -> bool {
        // Without a magnetic drift, its time constant and the spread of that have no effect.
        let all = [
            self.magnetic,
            self.magnetic_spread,
            self.non_magnetic,
            self.non_magnetic_spread,
            self.initial_magnetic,
            self.initial_magnetic_spread,
            self.angle_random_walk,
            self.residual_max,
        ];
        all.iter().all(|part| *part == 0.0)
    }

    /// Ω_m over time; without a warm-up, A is present from the start.
    pub fn magnetic_drift(&self) -> Magnetic {
        let (amplitude, initial) = (self.magnetic, self.initial_magnetic);
        match self.warm_up_s {
            0.0 => Magnetic { amplitude: 0.0, time_s: 1.0, initial: amplitude + initial },
            time_s => Magnetic { amplitude, time_s, initial },
        }
    }
}

const RATES: ValueType = measure(&[Dimension::Rate], -1e6, 1e6, "-1e6 to 1e6 arcsec/s");
const SPREADS: ValueType = measure(&[Dimension::Rate], 0.0, 1e6, "0 to 1e6 arcsec/s");
const TIMES: ValueType = measure(&[Dimension::Time], 1e-3, 1e9, "1 ms to 1e9 s");
const PARTS: ValueType = measure(&[Dimension::Ratio], 0.0, 0.5, "0 to 0.5, or 0 % to 50 %");
const N: ValueType = measure(&[Dimension::AngleRandomWalk], 0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)");
const ANGLES: ValueType = measure(&[Dimension::Angle], 0.0, 1e6, "0 to 1e6 arcsec");

keys! {
    /// The parts of a drift.
    pub(crate) static KEYS;
    /// The drift of a gyro that switches modes; absent parts are 0. Spreads are standard deviations from run to run,
    /// normally distributed.
    pub DRIFT = "drift", "", Fixed, ValueType::Table, "[drift]\nmagnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"";
    /// A = A_qm·A_T, the magnetic drift that builds up during the warm-up: "14 arcsec/s".
    MAGNETIC = "drift.magnetic", "magnetic drift A", Condition, RATES, r#"magnetic = "14 arcsec/s""#;
    /// Time constant τ of the warm-up: "3000 s".
    WARM_UP = "drift.warm_up_time", "warm-up time τ", Condition, TIMES, r#"warm_up_time = "3000 s""#;
    /// Non-magnetic drift Ω_nm, whose sign does not depend on the mode: "0.05 arcsec/s".
    NON_MAGNETIC = "drift.non_magnetic", "non-magnetic drift", Condition, RATES, r#"non_magnetic = "0.05 arcsec/s""#;
    /// Magnetic drift Ω_m0 that is present from the start.
    INITIAL = "drift.initial_magnetic", "initial magnetic drift", Condition, RATES, r#"initial_magnetic = "1 arcsec/s""#;
    /// δP_max, the largest error of the angle at a switch: "10 arcsec". In a study of kind = "switched-run" without
    /// fillers it is the amplitude of a residual that is a sine of the phase of the switch.
    pub(crate) RESIDUAL_MAX = "drift.residual_max", "largest residual of a switch", Condition, ANGLES, r#"residual_max = "10 arcsec""#;
}

keys! {
    /// The keys that differ from run to run.
    pub(crate) static SPREAD_KEYS;
    /// Standard deviation of drift.magnetic.
    MAGNETIC_SPREAD = "drift.magnetic_spread", "spread of A", Condition, SPREADS, r#"magnetic_spread = "1 arcsec/s""#;
    /// Standard deviation of the logarithm of drift.warm_up_time, which is normally distributed: "5 %".
    WARM_UP_SPREAD = "drift.warm_up_time_spread", "spread of τ", Condition, PARTS, r#"warm_up_time_spread = "5 %""#;
    /// Standard deviation of drift.non_magnetic.
    NON_MAGNETIC_SPREAD = "drift.non_magnetic_spread", "spread of the non-magnetic drift", Condition, SPREADS, r#"non_magnetic_spread = "0.01 arcsec/s""#;
    /// Standard deviation of drift.initial_magnetic.
    INITIAL_SPREAD = "drift.initial_magnetic_spread", "spread of the initial magnetic drift", Condition, SPREADS, r#"initial_magnetic_spread = "0.1 arcsec/s""#;
    /// Angle random walk N: "0.003 deg/sqrt(h)".
    RANDOM_WALK = "drift.angle_random_walk", "angle random walk N", Condition, N, r#"angle_random_walk = "0.003 deg/sqrt(h)""#;
}

/// The settings of these keys.
pub(crate) static SETTINGS: [SweepTarget<Drift>; 10] = [
    SweepTarget::new(&MAGNETIC, |drift, rate| drift.magnetic = rate.value),
    SweepTarget::new(&MAGNETIC_SPREAD, |drift, rate| drift.magnetic_spread = rate.value),
    SweepTarget::new(&WARM_UP, |drift, time| drift.warm_up_s = time.value),
    SweepTarget::new(&WARM_UP_SPREAD, |drift, part| drift.warm_up_spread = part.value),
    SweepTarget::new(&NON_MAGNETIC, |drift, rate| drift.non_magnetic = rate.value),
    SweepTarget::new(&NON_MAGNETIC_SPREAD, |drift, rate| drift.non_magnetic_spread = rate.value),
    SweepTarget::new(&INITIAL, |drift, rate| drift.initial_magnetic = rate.value),
    SweepTarget::new(&INITIAL_SPREAD, |drift, rate| drift.initial_magnetic_spread = rate.value),
    SweepTarget::new(&RANDOM_WALK, |drift, n| drift.angle_random_walk = n.value),
    SweepTarget::new(&RESIDUAL_MAX, |drift, angle| drift.residual_max = angle.value),
];

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

keys! {
    /// The keys of the schedule.
    pub(crate) static SCHEDULE_KEYS;
    /// The mode switches of a run.
    SWITCHING = "switching", "", Fixed, ValueType::Table, "[switching]\ninterval = \"40 s\"";
    /// Switching interval MT: "40 s".
    pub INTERVAL = "switching.interval", "switching interval", Choice, TIMES, r#"interval = "40 s""#, required;
    /// A whole run.
    RUN = "run", "", Fixed, ValueType::Table, "[run]\nduration = \"1 h\"";
    /// Run time t from switch-on: "1 h".
    DURATION = "run.duration", "run time", Question, TIMES, r#"duration = "1 h""#, required;
    /// The end of a run. "any", the default, averages it over the phase of switching: the angle at the end is read at 64
    /// equally likely times over one cycle of two intervals, centred on run.duration. "exact" reads it at run.duration,
    /// where the drift depends on how far the last interval has come. Rates are angles divided by run.duration, and the
    /// non-magnetic drift acts for exactly that time. Times and trajectories are exact in both cases.
    pub END = "run.end", "", Fixed, ValueType::Word(End::WORDS), r#"end = "any""#;
}

/// The settings of these keys.
pub(crate) static SCHEDULE_SETTINGS: [SweepTarget<Schedule>; 2] = [
    SweepTarget::new(&INTERVAL, |schedule, interval| schedule.interval_s = interval.value),
    SweepTarget::new(&DURATION, |schedule, duration| schedule.duration_s = duration.value),
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
    pub(crate) fn check(&self, places: &SpanMap) -> Result<(), Fault> {
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
