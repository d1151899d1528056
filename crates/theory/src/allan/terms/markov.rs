//! Exponentially correlated rate.

use crate::allan::exponential::beyond_square;
use crate::allan::markov;
use crate::allan::part::{Part, sine_of_turns};
use crate::allan::terms::{Increment, Row, Shape, Source};

pub(super) static ROW: Row = Row {
    key: "noise.markov",
    symbol: "markov",
    title: "Markov noise",
    name: ["", "Markov noise"],
    shape: Some(Shape {
        symbol: "markov_time",
        name: "correlation time",
        title: "correlation time of the Markov noise",
        what: "a correlation time of",
        letters: ["Markov: σ", "T"],
        ..Shape::TIME
    }),
    part: |_, sigma, time_s, _| Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s),
    square: |part| 0.5 * part.size * part.size * part.shape,
    variance: |part, difference, t0, m| {
        scale(part, t0) * markov::mean_square(difference, t0 / part.shape, m as f64)
    },
    // (q_cT_c)²/τ·[1 − (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})].
    continuous: |part, tau| {
        let (q_c, time_s) = (part.size, part.shape);
        let z = tau / time_s;
        // 2z − 3 + 4e^{−z} − e^{−2z}, in which the powers up to z² cancel.
        let bracket = match z < 0.5 {
            true => 4.0 * beyond_square(z) - beyond_square(2.0 * z),
            false => 2.0 * z - 3.0 + 4.0 * libm::exp(-z) - libm::exp(-2.0 * z),
        };
        Some(q_c * q_c * time_s * time_s / tau * bracket / (2.0 * z))
    },
    // 2t0·σ²(1 − a²)/(1 − 2a cos 2πft0 + a²), whose differences are of small numbers where t0 is short.
    density: |part, t0, f| {
        let (decay, step) = (t0 / part.shape, 2.0 * sine_of_turns(0.5 * f * t0));
        let fallen = -libm::expm1(-decay);
        let response = fallen * fallen + libm::exp(-decay) * step * step;
        Some(part.size * part.size * part.shape * t0 * -libm::expm1(-2.0 * decay) / response)
    },
    kernel: |part, t0| {
        let (variance, decay) = (scale(part, t0), t0 / part.shape);
        Some(Box::new(move |m, n| variance * markov::kernel(decay, m, n)))
    },
    increment: |part, t0, n| Increment::Normal(scale(part, t0) * markov::summed(t0 / part.shape, n as f64)),
    sources: |part, t0, _| {
        let sigma = part.size * libm::sqrt(0.5 * part.shape) * t0;
        vec![Source::Markov { sigma, decay: t0 / part.shape }]
    },
    ..Row::NOISE
};

/// Variance of the rate times t0², ″².
fn scale(part: &Part, t0: f64) -> f64 {
    0.5 * part.size * part.size * part.shape * t0 * t0
}
