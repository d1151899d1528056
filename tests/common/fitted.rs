//! What is counted over many fits.

use sagnac::fit::{Fit, Verdict};
use sagnac::theory::allan::terms::Term;

/// The terms of the paper's gyros.
pub const QNB: [Term; 3] = [Term::Quantization, Term::AngleRandomWalk, Term::BiasInstability];

/// How often something is so.
pub fn share(fits: &[Fit], is_so: impl Fn(&Fit) -> bool) -> f64 {
    fits.iter().filter(|fit| is_so(fit)).count() as f64 / fits.len() as f64
}

pub fn is_identified(fit: &Fit, term: Term) -> bool {
    fit.coefficient(term).unwrap().verdict == Verdict::Identified
}

pub fn covers(fit: &Fit, term: Term, truth: f64) -> bool {
    fit.coefficient(term).unwrap().interval.is_some_and(|[low, high]| low <= truth && truth <= high)
}
