//! Sine of the rate with a random phase.

use core::f64::consts::PI;

use crate::allan::part::sine_of_turns;
use crate::allan::terms::{Apart, Increment, Row, Shape, Source};

pub(super) static ROW: Row = Row {
    key: "noise.sine",
    symbol: "sine",
    title: "sine",
    name: ["a ", "sine"],
    size: ("an amplitude of", 0.0),
    shape: Some(Shape {
        key: "frequency",
        symbol: "sine_frequency",
        unit: "Hz",
        name: "frequency of the sine",
        title: "frequency of the sine",
        what: "a frequency of",
        letters: ["sine: Ω", "f"],
        // Its hump, a third of an octave wide, must lie within the curve; a slower sine looks like a ramp.
        range: |[shortest, longest]| [0.2 / longest, 0.5 / shortest],
        per_decade: 40.0,
    }),
    // The amplitude of the angle is Ω_0/2πf, and every difference multiplies it by 2 sin πfτ.
    variance: |part, difference, t0, m| {
        let step = 2.0 * sine_of_turns(0.5 * part.shape * (t0 * m as f64));
        let angle = part.size / (2.0 * PI * part.shape);
        0.5 * angle * angle * libm::pow(step * step, difference.spans() as f64)
    },
    // Ω_0²(sin²πfτ/πfτ)².
    continuous: |part, tau| {
        let sine = sine_of_turns(0.5 * part.shape * tau);
        let shape = sine * sine / (PI * part.shape * tau);
        Some(part.size * part.size * shape * shape)
    },
    // The mean over the phase, averaged over the lags.
    product: |part, &Apart { difference, sample_s, a, b, lag, width }| {
        let turns = part.shape * sample_s;
        let spans = difference.spans() as f64;
        let step = |m: f64| libm::pow(2.0 * sine_of_turns(0.5 * turns * m), spans);
        let angle = part.size / (2.0 * PI * part.shape);
        let from_middle = lag + 0.5 * spans * (b - a);
        let (one, whole) = (sine_of_turns(0.5 * turns), sine_of_turns(0.5 * turns * width));
        let smoothed = if width == 1.0 || one == 0.0 { 1.0 } else { whole / (width * one) };
        0.5 * angle * angle * step(a) * step(b) * smoothed * sine_of_turns(0.25 + turns * from_middle)
    },
    increment: |part, t0, n| {
        Increment::Sine(part.size / (PI * part.shape) * sine_of_turns(0.5 * part.shape * (t0 * n as f64)))
    },
    sources: |part, t0, _| {
        vec![Source::Sine { amplitude: part.size / (2.0 * PI * part.shape), turns: part.shape * t0 }]
    },
    ..Row::NOISE
};
