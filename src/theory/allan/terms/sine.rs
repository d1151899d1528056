//! Sine of the rate with a random phase.

use core::f64::consts::PI;

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::{Part, sine_of_turns};
use crate::theory::allan::terms::{Apart, DEG_PER_H, Increment, Law, Row, Shape, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.sine",
    symbol: "sine",
    title: "sine",
    name: "sine",
    article: "a ",
    unit: DEG_PER_H,
    plain: ("", ""),
    size: ("an amplitude of", 0.0),
    shape: Some(Shape {
        key: "frequency",
        symbol: "sine_frequency",
        unit: "Hz",
        name: "frequency of the sine",
        title: "frequency of the sine",
        what: "a frequency of",
        letters: ["sine: Ω", "f"],
        // With a hump within the curve, which is a third of an octave wide: a slower sine is a ramp.
        range: |[shortest, longest]| [0.2 / longest, 0.5 / shortest],
        per_decade: 40.0,
    }),
    law: &Sine,
};

impl Part {
    /// Sine of the rate with a random phase: Ω_0, ″/s, and f, Hz.
    pub const fn sine(amplitude: f64, frequency_hz: f64) -> Part {
        Part::new(Term::Sine, amplitude, frequency_hz)
    }
}

struct Sine;

impl Law for Sine {
    /// The angle's amplitude is Ω_0/2πf, and every difference multiplies it by 2 sin πfτ.
    fn variance(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        let step = 2.0 * sine_of_turns(0.5 * part.shape * (sample_s * m as f64));
        let angle = part.size / (2.0 * PI * part.shape);
        0.5 * angle * angle * libm::pow(step * step, difference.spans() as f64)
    }

    fn largest(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        libm::sqrt(2.0 * self.variance(part, difference, sample_s, m))
    }

    /// Ω_0²(sin²πfτ/πfτ)².
    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        let sine = sine_of_turns(0.5 * part.shape * tau);
        let shape = sine * sine / (PI * part.shape * tau);
        Some(part.size * part.size * shape * shape)
    }

    /// Mean product over the phase, averaged over the lags.
    fn product(&self, part: &Part, apart: &Apart) -> f64 {
        let &Apart { difference, sample_s, a, b, lag, width } = apart;
        let turns = part.shape * sample_s;
        let spans = difference.spans() as f64;
        let step = |m: f64| libm::pow(2.0 * sine_of_turns(0.5 * turns * m), spans);
        let angle = part.size / (2.0 * PI * part.shape);
        let from_middle = lag + 0.5 * spans * (b - a);
        let (one, whole) = (sine_of_turns(0.5 * turns), sine_of_turns(0.5 * turns * width));
        let smoothed = if width == 1.0 || one == 0.0 { 1.0 } else { whole / (width * one) };
        0.5 * angle * angle * step(a) * step(b) * smoothed * sine_of_turns(0.25 + turns * from_middle)
    }

    fn increment(&self, part: &Part, sample_s: f64, n: u64) -> Increment {
        let tau = sample_s * n as f64;
        Increment::Sine(part.size / (PI * part.shape) * sine_of_turns(0.5 * part.shape * tau))
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        vec![Source::Sine { amplitude: part.size / (2.0 * PI * part.shape), turns: part.shape * sample_s }]
    }
}
