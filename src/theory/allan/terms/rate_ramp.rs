//! Constant acceleration.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::{Part, Trend};
use crate::theory::allan::terms::{Law, Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.rate_ramp",
    symbol: "R",
    title: "rate ramp R",
    name: "rate ramp",
    article: "a ",
    unit: (3600.0, "deg/h/h", "°/h/h"),
    plain: ("1/s", "/ s"),
    size: ("a ramp of", f64::MIN),
    shape: None,
    law: &RateRamp,
};

impl Part {
    /// Constant acceleration: R, ″/s².
    pub const fn rate_ramp(r: f64) -> Part {
        Part::new(Term::RateRamp, r, 1.0)
    }
}

struct RateRamp;

impl Law for RateRamp {
    fn trend(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> Option<Trend> {
        let tau = sample_s * m as f64;
        let first = if difference == Difference::Second { part.size * tau * tau } else { 0.0 };
        Some(Trend { first, decay: 0.0 })
    }

    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        Some(part.size * part.size * tau * tau / 2.0)
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        vec![Source::Ramp(part.size * sample_s * sample_s)]
    }

    fn turned(&self, r: f64, t: f64) -> f64 {
        0.5 * r.abs() * t * t
    }
}
