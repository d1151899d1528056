//! Flicker of the rate, as a sum of octave holds.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::generalised::Holds;
use crate::theory::allan::holds;
use crate::theory::allan::part::{FLAT_LEVEL, Part};
use crate::theory::allan::terms::{DEG_PER_H, Kernel, Law, Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.bias_instability",
    symbol: "B",
    title: "bias instability B",
    name: "bias instability",
    article: "a ",
    unit: DEG_PER_H,
    plain: ("", ""),
    size: ("a noise of", 0.0),
    shape: None,
    law: &BiasInstability,
};

impl Part {
    /// Flicker of the rate: B, ″/s, whose Allan variance is flat at (2 ln2/π)B², of so many octave holds. Octaves for
    /// which there are no [variances](holds::variances) make it NaN.
    pub const fn bias_instability(b: f64, octaves: usize) -> Part {
        Part { octaves, ..Part::new(Term::BiasInstability, b, 1.0) }
    }
}

struct BiasInstability;

impl Law for BiasInstability {
    fn part(&self, _: Term, coefficient: f64, _: f64, octaves: usize) -> Part {
        Part::bias_instability(coefficient, octaves)
    }

    fn variance(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        let variances = holds::variances(part.octaves).unwrap_or_else(|| vec![f64::NAN]);
        let one = |(o, v): (usize, &f64)| v * holds::mean_square(difference, 1 << o, m);
        FLAT_LEVEL
            * part.size
            * part.size
            * sample_s
            * sample_s
            * variances.iter().enumerate().map(one).sum::<f64>()
    }

    fn continuous(&self, part: &Part, _: f64) -> Option<f64> {
        Some(FLAT_LEVEL * part.size * part.size)
    }

    fn kernel(&self, part: &Part, sample_s: f64) -> Option<Kernel> {
        let holds = Holds::new(FLAT_LEVEL * part.size * part.size * sample_s * sample_s, part.octaves);
        Some(Box::new(move |m, n| holds.at(m, n)))
    }

    /// Of the octaves that the record needs, whatever the part says.
    fn sources(&self, part: &Part, sample_s: f64, samples: u64) -> Vec<Source> {
        let variances = holds::octaves(samples).and_then(holds::variances);
        let sigma = |v: &f64| part.size * sample_s * libm::sqrt(FLAT_LEVEL * v);
        vec![Source::Holds(variances.unwrap_or_else(|| vec![f64::NAN]).iter().map(sigma).collect())]
    }
}
