//! Flicker of the rate, as a sum of octave holds.

use core::f64::consts::PI;

use crate::allan::generalized::Holds;
use crate::allan::holds;
use crate::allan::part::{FLAT_LEVEL, Part};
use crate::allan::terms::{Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.bias_instability",
    symbol: "B",
    title: "bias instability B",
    name: ["a ", "bias instability"],
    part: |_, b, _, octaves| Part::bias_instability(b, octaves),
    variance: |part, difference, t0, m| {
        let one = |(o, v): (usize, &f64)| v * holds::mean_square(difference, 1 << o, m);
        FLAT_LEVEL
            * part.size
            * part.size
            * t0
            * t0
            * variances(part).iter().enumerate().map(one).sum::<f64>()
    },
    // That of continuous flicker; the holds have it within 14 % up to a tenth of the sampling rate.
    density: |part, _, f| Some(part.size * part.size / (PI * f)),
    continuous: |part, _| Some(FLAT_LEVEL * part.size * part.size),
    kernel: |part, t0| {
        let scale = FLAT_LEVEL * part.size * part.size * t0 * t0;
        let holds = Holds::new(variances(part).iter().map(|variance| scale * variance).collect());
        Some(Box::new(move |m, n| holds.at(m, n)))
    },
    // The number of octaves is that which the record needs, regardless of the part.
    sources: |part, t0, samples| {
        let octaves = holds::octaves(samples).unwrap_or_default();
        let sigma = |v: &f64| part.size * t0 * libm::sqrt(FLAT_LEVEL * v);
        vec![Source::Holds(variances(&Part { octaves, ..*part }).iter().map(sigma).collect())]
    },
    ..Row::NOISE
};

/// The variance of each octave for an Allan variance of 1, or NaN.
fn variances(part: &Part) -> Vec<f64> {
    holds::variances(part.octaves).unwrap_or_else(|| vec![f64::NAN])
}

impl Part {
    /// Flicker of the rate with the coefficient B, ″/s, as a sum of `octaves` octave holds. It is NaN if there are no
    /// [variances](holds::variances) for that number of octaves.
    pub const fn bias_instability(b: f64, octaves: usize) -> Part {
        Part { octaves, ..Part::new(Term::BiasInstability, [b, 1.0]) }
    }
}
