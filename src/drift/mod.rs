//! The drift of a gyro that switches modes, and when it switches: what budgets and whole runs share.

pub mod schedule;

pub use crate::drift::schedule::Schedule;
pub(crate) use crate::drift::schedule::{SETTINGS as SCHEDULE_SETTINGS, read as read_schedule};

use toml::Spanned;

use crate::key::file::drift::DriftTable;
use crate::key::setting::{Key, Setting};
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;
use crate::source::place::Places;
use crate::theory::drift::magnetic::Magnetic;

/// Parts of the drift in ″ and s, each with its standard deviation from run to run; 0 is absent. Every number has 12
/// significant digits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drift {
    /// A, ″/s.
    pub magnetic: f64,
    /// Of A, ″/s.
    pub magnetic_spread: f64,
    /// τ, s; 0 where there is no warm-up, and A is there from the start.
    pub warm_up_s: f64,
    /// Of ln τ.
    pub warm_up_spread: f64,
    /// Ω_nm, ″/s.
    pub non_magnetic: f64,
    /// Of Ω_nm, ″/s.
    pub non_magnetic_spread: f64,
    /// Ω_m0, ″/s.
    pub initial_magnetic: f64,
    /// Of Ω_m0, ″/s.
    pub initial_magnetic_spread: f64,
    /// N, ″/√s.
    pub angle_random_walk: f64,
    /// δP_max, ″.
    pub residual_max: f64,
}

impl Drift {
    /// What determines the draws but for the residual, key by key; what is absent has no line.
    pub(crate) fn canonical(&self) -> String {
        let all = [
            ("magnetic", self.magnetic),
            ("magnetic_spread", self.magnetic_spread),
            ("warm_up_time", self.warm_up_s),
            ("warm_up_time_spread", self.warm_up_spread),
            ("non_magnetic", self.non_magnetic),
            ("non_magnetic_spread", self.non_magnetic_spread),
            ("initial_magnetic", self.initial_magnetic),
            ("initial_magnetic_spread", self.initial_magnetic_spread),
            ("angle_random_walk", self.angle_random_walk),
        ];
        let given = all.into_iter().filter(|(_, value)| *value != 0.0);
        given.map(|(name, value)| format!("{name}={value:.11e}\n")).collect()
    }

    /// Whether every part that turns the gyro is absent.
    pub(crate) fn is_nothing(&self) -> bool {
        // The time constant of no drift moves nothing, nor does its spread.
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

    /// Ω_m over time; without a warm-up A is there from the start.
    pub fn magnetic_drift(&self) -> Magnetic {
        let (amplitude, initial) = (self.magnetic, self.initial_magnetic);
        match self.warm_up_s {
            0.0 => Magnetic { amplitude: 0.0, time_s: 1.0, initial: amplitude + initial },
            time_s => Magnetic { amplitude, time_s, initial },
        }
    }
}

/// Declares the setting of a part.
macro_rules! setting {
    ($name:ident, $key:literal, $label:literal, $dimension:ident, $limits:expr, $field:ident) => {
        static $name: Setting<Drift> = Setting {
            key: Key { name: $key, label: $label, accepts: &[Dimension::$dimension], limits: $limits },
            applies: |_| true,
            set: |drift, quantity| drift.$field = quantity.value,
        };
    };
}

const SIGNED: (f64, f64, &str) = (-1e6, 1e6, "-1e6 to 1e6 arcsec/s");
const SPREADS: (f64, f64, &str) = (0.0, 1e6, "0 to 1e6 arcsec/s");

setting!(MAGNETIC, "drift.magnetic", "magnetic drift A", Rate, SIGNED, magnetic);
setting!(MAGNETIC_SPREAD, "drift.magnetic_spread", "spread of A", Rate, SPREADS, magnetic_spread);
setting!(WARM_UP, "drift.warm_up_time", "warm-up time τ", Time, (1e-3, 1e9, "1 ms to 1e9 s"), warm_up_s);
setting!(
    WARM_UP_SPREAD,
    "drift.warm_up_time_spread",
    "spread of τ",
    Ratio,
    (0.0, 0.5, "0 to 0.5, or 0 % to 50 %"),
    warm_up_spread
);
setting!(NON_MAGNETIC, "drift.non_magnetic", "non-magnetic drift", Rate, SIGNED, non_magnetic);
setting!(
    NON_MAGNETIC_SPREAD,
    "drift.non_magnetic_spread",
    "spread of the non-magnetic drift",
    Rate,
    SPREADS,
    non_magnetic_spread
);
setting!(INITIAL, "drift.initial_magnetic", "initial magnetic drift", Rate, SIGNED, initial_magnetic);
setting!(
    INITIAL_SPREAD,
    "drift.initial_magnetic_spread",
    "spread of the initial magnetic drift",
    Rate,
    SPREADS,
    initial_magnetic_spread
);
setting!(
    RANDOM_WALK,
    "drift.angle_random_walk",
    "angle random walk N",
    AngleRandomWalk,
    (0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)"),
    angle_random_walk
);
setting!(
    RESIDUAL_MAX,
    "drift.residual_max",
    "largest residual of a switch",
    Angle,
    (0.0, 1e6, "0 to 1e6 arcsec"),
    residual_max
);

/// Every key of the drift that a sweep may vary.
pub(crate) static SETTINGS: [&Setting<Drift>; 10] = [
    &MAGNETIC,
    &MAGNETIC_SPREAD,
    &WARM_UP,
    &WARM_UP_SPREAD,
    &NON_MAGNETIC,
    &NON_MAGNETIC_SPREAD,
    &INITIAL,
    &INITIAL_SPREAD,
    &RANDOM_WALK,
    &RESIDUAL_MAX,
];

/// The drift that is written.
pub(crate) fn read(table: &DriftTable, places: &mut Places) -> Result<Drift, Fault> {
    let written = [
        (&MAGNETIC, &table.magnetic),
        (&MAGNETIC_SPREAD, &table.magnetic_spread),
        (&WARM_UP, &table.warm_up_time),
        (&WARM_UP_SPREAD, &table.warm_up_time_spread),
        (&NON_MAGNETIC, &table.non_magnetic),
        (&NON_MAGNETIC_SPREAD, &table.non_magnetic_spread),
        (&INITIAL, &table.initial_magnetic),
        (&INITIAL_SPREAD, &table.initial_magnetic_spread),
        (&RANDOM_WALK, &table.angle_random_walk),
        (&RESIDUAL_MAX, &table.residual_max),
    ];
    let mut drift = Drift::default();
    for (setting, value) in written {
        if let Some(value) = value {
            (setting.set)(&mut drift, setting.read(value)?);
            places.add(setting.name, Spanned::span(value));
        }
    }
    Ok(drift)
}
