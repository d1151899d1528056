//! What bounds another record of the same sensor and length.
//!
//! The upper end of a band is above the *true* deviation with a probability, at each τ by itself. Whether the band of a second
//! record lies below that of the first is another question: with equal noise it is about as likely as not at each τ, and over many τ
//! it hardly happens. Of two records with the same noise, the ratio of the variances has the F distribution with the
//! degrees of freedom of both. The bound is therefore the value of the first record times the largest ratio that is likely at all τ
//! together, times the width of the band of the second.

use crate::analysis::model::ModelError;
use crate::analysis::model::target::{Point, Target};
use sagnac_records::allan::{chi_squared, fisher};

/// The upper ends of the bands of another record, which it exceeds at any τ with a probability of at most 1 − `confidence`.
///
/// The probability is divided among the octaves of τ (Bonferroni), because estimates within an octave are of the same differences.
///
/// # Errors
/// There is no record.
pub(crate) fn repeated(target: &Target, confidence: f64) -> Result<Vec<f64>, ModelError> {
    let [from_s, to_s] = target.taus();
    let octaves = libm::ceil(libm::log2(to_s / from_s)).max(0.0) + 1.0;
    let of = |point: &Point| {
        let edf = point.edf.ok_or(ModelError::NoRecord)?;
        let ratio = fisher::quantile(1.0 - (1.0 - confidence) / octaves, edf, edf);
        let width = chi_squared::quantile(0.5 * (1.0 - confidence), edf).map(|quantile| edf / quantile);
        let factor = ratio.zip(width).map(|(ratio, width)| libm::sqrt(ratio * width));
        Ok(factor.map_or(f64::NAN, |factor| factor * point.value))
    };
    target.points.iter().map(of).collect()
}
