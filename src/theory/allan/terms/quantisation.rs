//! White error of the angles.

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::Part;
use crate::theory::allan::terms::{Increment, Law, Row, Source, Term};

pub(super) static ROW: Row = Row {
    key: "noise.quantisation",
    symbol: "Q",
    title: "quantisation noise Q",
    name: "quantisation",
    article: "",
    unit: (1.0, "arcsec", "″"),
    plain: ("s", "· s"),
    size: ("a noise of", 0.0),
    shape: None,
    law: &Quantisation,
};

impl Part {
    /// White error of the angles: rms Q, ″.
    pub const fn quantisation(q: f64) -> Part {
        Part::new(Term::Quantisation, q, 1.0)
    }
}

struct Quantisation;

impl Law for Quantisation {
    /// Σc² of the coefficients of the angles.
    fn variance(&self, part: &Part, difference: Difference, _: f64, _: u64) -> f64 {
        part.size * part.size * if difference == Difference::Second { 6.0 } else { 20.0 }
    }

    fn continuous(&self, part: &Part, tau: f64) -> Option<f64> {
        Some(3.0 * part.size * part.size / (tau * tau))
    }

    fn covariance(&self, part: &Part, met: f64) -> f64 {
        met * part.size * part.size
    }

    fn increment(&self, part: &Part, _: f64, _: u64) -> Increment {
        Increment::Normal(2.0 * part.size * part.size)
    }

    fn sources(&self, part: &Part, _: f64, _: u64) -> Vec<Source> {
        vec![Source::Errors(part.size)]
    }

    fn turned(&self, _: f64, _: f64) -> f64 {
        0.0
    }
}
