//! White rate.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::Part;
use crate::theory::allan::terms::{Increment, Kernel, Law, Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.angle_random_walk",
    symbol: "N",
    title: "angle random walk N",
    name: "angle random walk",
    article: "an ",
    unit: (1.0 / 60.0, "deg/sqrt(h)", "°/√h"),
    plain: ("sqrt(s)", "· √s"),
    size: ("a noise of", 0.0),
    shape: None,
    law: &AngleRandomWalk,
};

impl Part {
    /// White rate: N, ″/√s.
    pub const fn angle_random_walk(n: f64) -> Part {
        Part::new(Term::AngleRandomWalk, n, 1.0)
    }
}

struct AngleRandomWalk;

impl Law for AngleRandomWalk {
    /// Σc² of the coefficients of the increments.
    fn variance(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        part.size * part.size * (sample_s * m as f64) * difference.divisor()
    }

    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        Some(part.size * part.size / tau)
    }

    /// G = −|n|/2.
    fn kernel(&self, part: &Part, sample_s: f64) -> Option<Kernel> {
        let scale = part.size * part.size * sample_s;
        Some(Box::new(move |m, n| -scale * (m - n).max(0.0)))
    }

    fn increment(&self, part: &Part, sample_s: f64, n: u64) -> Increment {
        Increment::Normal(part.size * part.size * sample_s * n as f64)
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        vec![Source::White(part.size * libm::sqrt(sample_s))]
    }

    fn turned(&self, _: f64, _: f64) -> f64 {
        0.0
    }
}
