//! Random walk of the rate.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::generalised::cubic;
use crate::theory::allan::part::Part;
use crate::theory::allan::terms::{Kernel, Law, Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.rate_random_walk",
    symbol: "K",
    title: "rate random walk K",
    name: "rate random walk",
    article: "a ",
    unit: (60.0, "deg/h/sqrt(h)", "°/h/√h"),
    plain: ("1/sqrt(s)", "/ √s"),
    size: ("a noise of", 0.0),
    shape: None,
    law: &RateRandomWalk,
};

impl Part {
    /// Random walk of the rate: K, ″/s^1.5.
    pub const fn rate_random_walk(k: f64) -> Part {
        Part::new(Term::RateRandomWalk, k, 1.0)
    }
}

struct RateRandomWalk;

impl Law for RateRandomWalk {
    /// Squares of 1, 2, … m, … 2, 1 for the second difference: K²τ/3·(1 + 1/2m²) as Allan variance, and
    /// K²τ/6·(1 + 1/m²) as Hadamard variance.
    fn variance(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        let n = m as f64;
        let sum = match difference {
            Difference::Second => (2.0 * n * n * n + n) / 3.0,
            Difference::Third => n * n * n + n,
        };
        part.size * part.size * sample_s * sample_s * sample_s * sum
    }

    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        Some(part.size * part.size * tau / 3.0)
    }

    /// G = (|n|³ − |n|)/12.
    fn kernel(&self, part: &Part, sample_s: f64) -> Option<Kernel> {
        let scale = part.size * part.size * sample_s * sample_s * sample_s;
        Some(Box::new(move |m, n| scale * cubic(m, n)))
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        vec![Source::Walk(part.size * sample_s * libm::sqrt(sample_s))]
    }

    fn turned(&self, k: f64, t: f64) -> f64 {
        k * t * libm::sqrt(t)
    }
}
