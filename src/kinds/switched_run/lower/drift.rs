//! The drift of a run in closed form, ″: its nominal value, and its deviations.

use crate::kinds::switched_run::FirstMode;
use crate::kinds::switched_run::SwitchedRun;
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::theory::drift::magnetic::{signed_decay, signed_time, switches};

/// The angle of the drift at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) time_s: f64,
    /// Number of switches before that time.
    pub(crate) switches: usize,
    /// Part that does not change its sign with the mode.
    pub(crate) non_magnetic: f64,
    /// Magnetic part, without the warm-up where its time constant is drawn.
    pub(crate) magnetic: f64,
    /// ∫ s dt with s = +1 in the first interval, s.
    pub(crate) held_s: f64,
    /// Effects of one standard deviation of A, Ω_m0 and Ω_nm.
    pub(crate) deviations: [f64; 3],
}

/// The drift of a point at the end of each interval, and at each of the study's times.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drift {
    pub(crate) ends: Vec<Row>,
    pub(crate) times: Vec<Row>,
}

impl Drift {
    pub(crate) fn of(point: &RunPoint, study: &SwitchedRun) -> Drift {
        let (interval_s, duration_s) = (point.schedule.interval_s, point.schedule.duration_s);
        let intervals = point.switches() + 1;
        let ends = (1..=intervals).map(|k| (k as f64 * interval_s).min(duration_s));
        // A run of whole intervals ends with the last one, whatever the rounding of interval times number.
        let end = |(k, time_s): (usize, f64)| {
            let at = if k as u64 + 1 == intervals { duration_s } else { time_s };
            row(point, study.first_mode, at, k)
        };
        let at = |&time_s: &f64| row(point, study.first_mode, time_s, switches(interval_s, time_s) as usize);
        Drift { ends: ends.enumerate().map(end).collect(), times: study.times.iter().map(at).collect() }
    }
}

fn row(point: &RunPoint, first_mode: FirstMode, time_s: f64, switches: usize) -> Row {
    let drift = &point.drift;
    let interval_s = point.schedule.interval_s;
    let sign = if first_mode == FirstMode::Negative { -1.0 } else { 1.0 };
    let held = sign * signed_time(interval_s, time_s);
    // Without a warm-up, all of A is present from the start.
    let warmed = if drift.warm_up_s > 0.0 {
        held - sign * signed_decay(interval_s, drift.warm_up_s, time_s)
    } else {
        held
    };
    let drawn = drift.warm_up_spread > 0.0;
    let amplitude = if drawn { 0.0 } else { drift.magnetic };
    Row {
        time_s,
        switches,
        non_magnetic: drift.non_magnetic * time_s,
        magnetic: amplitude * warmed + drift.initial_magnetic * held,
        held_s: sign * held,
        deviations: [
            if drawn { 0.0 } else { drift.magnetic_spread * warmed },
            drift.initial_magnetic_spread * held,
            drift.non_magnetic_spread * time_s,
        ],
    }
}
