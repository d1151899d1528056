//! Decay of the rate after the start of the record.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::{Part, Trend};
use crate::theory::allan::terms::{DEG_PER_H, Law, Row, Shape, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.warm_up",
    symbol: "warm_up",
    title: "warm-up",
    name: "warm-up",
    article: "a ",
    unit: DEG_PER_H,
    plain: ("", ""),
    size: ("an amplitude of", f64::MIN),
    shape: Some(Shape::TIME),
    law: &WarmUp,
};

impl Part {
    /// Decay of the rate after the start of the record: A, ″/s, and T, s.
    pub const fn warm_up(amplitude: f64, time_s: f64) -> Part {
        Part::new(Term::WarmUp, amplitude, time_s)
    }
}

struct WarmUp;

impl Law for WarmUp {
    /// θ = AT(1 − e^{−t/T}): each difference multiplies e^{−t/T} by e^{−τ/T} − 1.
    fn trend(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> Option<Trend> {
        let (amplitude, time_s, tau) = (part.size, part.shape, sample_s * m as f64);
        let power = f64::from(difference.spans() as u32);
        let first = -amplitude * time_s * libm::pow(libm::expm1(-tau / time_s), power);
        Some(Trend { first, decay: sample_s / time_s })
    }

    fn continuous(&self, _: &Part, _: f64) -> Option<f64> {
        None
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        vec![Source::Decay { reach: part.size * part.shape, decay: sample_s / part.shape }]
    }
}
