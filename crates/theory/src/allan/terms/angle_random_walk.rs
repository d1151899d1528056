//! White rate.

use crate::allan::terms::{Increment, MICRO_G, Row, Source};

pub(super) static ROW: Row = Row {
    key: "noise.angle_random_walk",
    symbol: "N",
    title: "angle random walk N",
    title_of_acceleration: Some("velocity random walk N"),
    name: ["an ", "angle random walk"],
    unit: (1.0 / 60.0, "deg/sqrt(h)", "°/√h"),
    unit_of_acceleration: (60.0 * MICRO_G, "m/s/sqrt(h)", "m/s/√h"),
    plain: ("sqrt(s)", "· √s"),
    // Σc² of the coefficients of the increments.
    variance: |part, difference, t0, m| part.size * part.size * (t0 * m as f64) * difference.divisor(),
    continuous: |part, tau| Some(part.size * part.size / tau),
    density: |part, _, _| Some(2.0 * part.size * part.size),
    // G = −|n|/2.
    kernel: |part, t0| {
        let scale = part.size * part.size * t0;
        Some(Box::new(move |m, n| -scale * (m - n).max(0.0)))
    },
    increment: |part, t0, n| Increment::Normal(part.size * part.size * t0 * n as f64),
    sources: |part, t0, _| vec![Source::White(part.size * libm::sqrt(t0))],
    turned: |_, _| 0.0,
    ..Row::NOISE
};
