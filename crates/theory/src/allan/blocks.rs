//! The covariance of the mean rates of blocks, for regressions on a record that is averaged over blocks.

use crate::allan::part::Part;

/// Covariance of the mean rates of two blocks of `m` samples that start 0, 1, … `blocks` − 1 blocks apart, (″/s)², up to a
/// constant.
///
/// A random walk of the rate has no covariance, but every sum of its means whose weights add up to 0 has a variance, on
/// which the constant has no effect. Regressions with a constant term consist of such sums. Ramps, warm-ups and sines,
/// which are no Gaussian noise, have 0.
///
/// ```
/// # use sagnac_theory::allan::{Part, blocks::covariance};
/// assert_eq!(covariance(&Part::angle_random_walk(3.0), 0.5, 4, 3), [4.5, 0.0, 0.0]);
/// // The variance of the difference of neighbours is K²τ·2/3 for long blocks.
/// let walk = covariance(&Part::rate_random_walk(3.0), 0.5, 1000, 2);
/// assert!((2.0 * (walk[0] - walk[1]) / (9.0 * 500.0 * 2.0 / 3.0) - 1.0).abs() < 1e-5);
/// ```
pub fn covariance(part: &Part, sample_s: f64, m: u64, blocks: usize) -> Vec<f64> {
    let (row, samples) = (part.term.row(), m as f64);
    let kernel = (row.kernel)(part, sample_s);
    let tau = sample_s * samples;
    let at = |lag: usize| match &kernel {
        Some(kernel) => -kernel(samples, samples * lag as f64),
        // The product of the coefficients of the angles that both blocks have.
        None => (row.covariance)(part, [2.0, -1.0].get(lag).copied().unwrap_or_default()),
    };
    (0..blocks).map(|lag| at(lag) / (tau * tau)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Allan variance at τ = one block is half the mean square difference of neighbours, a contrast.
    #[test]
    fn differences_of_neighbours_have_the_allan_variance() {
        use crate::allan::{Estimator, Process};

        for part in [
            Part::quantization(0.3),
            Part::angle_random_walk(0.3),
            Part::bias_instability(0.3, 24),
            Part::rate_random_walk(0.3),
            Part::markov(0.3, 40.0),
        ] {
            for m in [1, 7, 100] {
                let process = Process { sample_s: 0.5, parts: vec![part] };
                let expected = process.expected(Estimator::OVERLAPPING, 10_000, m).unwrap();
                let covariance = covariance(&part, 0.5, m, 2);
                let found = covariance[0] - covariance[1];
                assert!((found / expected - 1.0).abs() < 1e-9, "{part:?}, m = {m}: {found}, not {expected}");
            }
        }
    }
}
