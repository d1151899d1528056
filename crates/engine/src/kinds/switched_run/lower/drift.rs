//! The drift of a run in closed form, ″: its nominal value, and its deviations.

use crate::drift::{End, Schedule};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::{FirstMode, SwitchedRun};
use sagnac_theory::drift::magnetic::{signed_decay, signed_time, switches};

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

/// The drift of a point at the end of each interval, at each of the study's times, and at each end that is drawn, which
/// there are none of where the end is exact.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drift {
    pub(crate) ends: Vec<Row>,
    pub(crate) times: Vec<Row>,
    pub(crate) drawn: Vec<Row>,
}

impl Drift {
    pub(crate) fn of(point: &RunPoint, study: &SwitchedRun) -> Drift {
        let Schedule { interval_s, duration_s, end } = point.schedule;
        let intervals = point.intervals();
        let ends = (1..=intervals).map(|k| match end {
            // A run of whole intervals ends with the last one, whatever the rounding of interval times number.
            End::Exact if k == intervals => duration_s,
            _ => k as f64 * interval_s,
        });
        let ends = ends.enumerate().map(|(k, time_s)| row(point, study.first_mode, time_s, k));
        let at = |&time_s: &f64| row(point, study.first_mode, time_s, switches(interval_s, time_s) as usize);
        // The non-magnetic drift acts for the whole run time, whatever the phase of switching.
        let of_whole = |drawn: Row| {
            let whole = row(point, study.first_mode, duration_s, 0);
            let [magnetic, initial, _] = drawn.deviations;
            Row {
                non_magnetic: whole.non_magnetic,
                deviations: [magnetic, initial, whole.deviations[2]],
                ..drawn
            }
        };
        let drawn = match end {
            End::Any => point.schedule.ends().iter().map(at).map(of_whole).collect(),
            End::Exact => vec![],
        };
        Drift { ends: ends.collect(), times: study.times.iter().map(at).collect(), drawn }
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
