//! White error of the angles.

use crate::allan::estimator::Difference;
use crate::allan::part::sine_of_turns;
use crate::allan::terms::{Increment, MICRO_G, Row, Source};

pub(super) static ROW: Row = Row {
    key: "noise.quantization",
    symbol: "Q",
    title: "quantization noise Q",
    name: ["", "quantization"],
    unit: (1.0, "arcsec", "″"),
    unit_of_acceleration: (MICRO_G, "m/s", "m/s"),
    plain: ("s", "· s"),
    // Σc² of the coefficients of the angles.
    variance: |part, difference, _, _| {
        part.size * part.size * if difference == Difference::Second { 6.0 } else { 20.0 }
    },
    continuous: |part, tau| Some(3.0 * part.size * part.size / (tau * tau)),
    // The difference of two errors over t0.
    density: |part, t0, f| {
        let step = 2.0 * part.size * sine_of_turns(0.5 * f * t0);
        Some(2.0 * step * step / t0)
    },
    covariance: |part, met| met * part.size * part.size,
    increment: |part, _, _| Increment::Normal(2.0 * part.size * part.size),
    sources: |part, _, _| vec![Source::Errors(part.size)],
    turned: |_, _| 0.0,
    ..Row::NOISE
};
