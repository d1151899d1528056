//! Exponentially correlated rate.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::exponential::beyond_square;
use crate::theory::allan::markov;
use crate::theory::allan::part::Part;
use crate::theory::allan::terms::{DEG_PER_H, Increment, Kernel, Law, Row, Shape, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.markov",
    symbol: "markov",
    title: "Markov noise",
    name: "Markov noise",
    article: "",
    unit: DEG_PER_H,
    plain: ("", ""),
    size: ("a noise of", 0.0),
    shape: Some(Shape {
        symbol: "markov_time",
        name: "correlation time",
        title: "correlation time of the Markov noise",
        what: "a correlation time of",
        letters: ["Markov: σ", "T"],
        ..Shape::TIME
    }),
    law: &Markov,
};

impl Part {
    /// Exponentially correlated rate: IEEE's q_c, ″/s^1.5, and T_c, s. Its variance is q_c²T_c/2.
    pub const fn markov(q_c: f64, time_s: f64) -> Part {
        Part::new(Term::Markov, q_c, time_s)
    }
}

struct Markov;

/// Variance of the rate times t0², ″².
fn scale(part: &Part, sample_s: f64) -> f64 {
    0.5 * part.size * part.size * part.shape * sample_s * sample_s
}

impl Law for Markov {
    fn part(&self, _: Term, sigma: f64, time_s: f64, _: usize) -> Part {
        Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s)
    }

    fn square(&self, part: &Part) -> f64 {
        0.5 * part.size * part.size * part.shape
    }

    fn variance(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        scale(part, sample_s) * markov::mean_square(difference, sample_s / part.shape, m as f64)
    }

    /// (q_cT_c)²/τ·[1 − (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})].
    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        let (q_c, time_s) = (part.size, part.shape);
        let z = tau / time_s;
        // 2z − 3 + 4e^{−z} − e^{−2z}, whose powers up to z² cancel.
        let bracket = match z < 0.5 {
            true => 4.0 * beyond_square(z) - beyond_square(2.0 * z),
            false => 2.0 * z - 3.0 + 4.0 * libm::exp(-z) - libm::exp(-2.0 * z),
        };
        Some(q_c * q_c * time_s * time_s / tau * bracket / (2.0 * z))
    }

    fn kernel(&self, part: &Part, sample_s: f64) -> Option<Kernel> {
        let (variance, decay) = (scale(part, sample_s), sample_s / part.shape);
        Some(Box::new(move |m, n| variance * markov::kernel(decay, m, n)))
    }

    fn increment(&self, part: &Part, sample_s: f64, n: u64) -> Increment {
        Increment::Normal(scale(part, sample_s) * markov::summed(sample_s / part.shape, n as f64))
    }

    fn sources(&self, part: &Part, sample_s: f64, _: u64) -> Vec<Source> {
        let sigma = part.size * libm::sqrt(0.5 * part.shape) * sample_s;
        vec![Source::Markov { sigma, decay: sample_s / part.shape }]
    }
}
