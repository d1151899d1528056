//! Random walk of the rate.

use crate::allan::estimator::Difference;
use crate::allan::generalized::cubic;
use crate::allan::part::sine_of_turns;
use crate::allan::terms::{Row, Source};

pub(super) static ROW: Row = Row {
    key: "noise.rate_random_walk",
    symbol: "K",
    title: "rate random walk K",
    title_of_acceleration: Some("acceleration random walk K"),
    name: ["a ", "rate random walk"],
    unit: (60.0, "deg/h/sqrt(h)", "°/h/√h"),
    unit_of_acceleration: (60.0, "ug/sqrt(h)", "µg/√h"),
    plain: ("1/sqrt(s)", "/ √s"),
    // Squares of 1, 2, … m, … 2, 1 for the second difference: K²τ/3·(1 + 1/2m²) as Allan variance, and K²τ/6·(1
    // + 1/m²) as Hadamard variance.
    variance: |part, difference, t0, m| {
        let n = m as f64;
        let sum = match difference {
            Difference::Second => (2.0 * n * n * n + n) / 3.0,
            Difference::Third => n * n * n + n,
        };
        part.size * part.size * t0 * t0 * t0 * sum
    },
    continuous: |part, tau| Some(part.size * part.size * tau / 3.0),
    // Steps of variance K²t0, divided by the response of a difference.
    density: |part, t0, f| {
        let walk = part.size * t0 / (2.0 * sine_of_turns(0.5 * f * t0));
        Some(2.0 * walk * walk)
    },
    // G = (|n|³ − |n|)/12.
    kernel: |part, t0| {
        let scale = part.size * part.size * t0 * t0 * t0;
        Some(Box::new(move |m, n| scale * cubic(m, n)))
    },
    sources: |part, t0, _| vec![Source::Walk(part.size * t0 * libm::sqrt(t0))],
    turned: |k, t| k * t * libm::sqrt(t),
    ..Row::NOISE
};
