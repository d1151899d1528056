//! Constant acceleration.

use crate::allan::estimator::Difference;
use crate::allan::part::Trend;
use crate::allan::terms::{Row, Source};

pub(super) static ROW: Row = Row {
    key: "noise.rate_ramp",
    symbol: "R",
    title: "rate ramp R",
    title_of_acceleration: Some("acceleration ramp R"),
    name: ["a ", "rate ramp"],
    unit: (3600.0, "deg/h/h", "°/h/h"),
    unit_of_acceleration: (3600.0, "ug/h", "µg/h"),
    plain: ("1/s", "/ s"),
    size: ("a ramp of", f64::MIN),
    trend: |part, difference, t0, m| {
        let tau = t0 * m as f64;
        let first = if difference == Difference::Second { part.size * tau * tau } else { 0.0 };
        Some(Trend { first, decay: 0.0 })
    },
    continuous: |part, tau| Some(part.size * part.size * tau * tau / 2.0),
    sources: |part, t0, _| vec![Source::Ramp(part.size * t0 * t0)],
    turned: |r, t| 0.5 * r.abs() * t * t,
    ..Row::NOISE
};
