//! Decay of the rate after the start of the record.

use crate::allan::part::Trend;
use crate::allan::terms::{Row, Shape, Source};

pub(super) static ROW: Row = Row {
    key: "noise.warm_up",
    symbol: "warm_up",
    title: "warm-up",
    name: ["a ", "warm-up"],
    size: ("an amplitude of", f64::MIN),
    shape: Some(Shape::TIME),
    // θ = AT(1 − e^{−t/T}): each difference multiplies e^{−t/T} by e^{−τ/T} − 1.
    trend: |part, difference, t0, m| {
        let (amplitude, time_s, tau) = (part.size, part.shape, t0 * m as f64);
        let power = f64::from(difference.spans() as u32);
        let first = -amplitude * time_s * libm::pow(libm::expm1(-tau / time_s), power);
        Some(Trend { first, decay: t0 / time_s })
    },
    sources: |part, t0, _| vec![Source::Decay { reach: part.size * part.shape, decay: t0 / part.shape }],
    ..Row::NOISE
};
