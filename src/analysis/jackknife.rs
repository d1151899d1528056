//! The standard error from parts of the trials, each of which is left out in turn.

/// Number of parts of the trials.
pub(crate) const PARTS: u64 = 32;

/// Half the width of a 95 % interval in jackknife standard errors of all parts: Student's t with 31 degrees of freedom.
pub(crate) const T_95: f64 = 2.039_513;

/// The standard error from delete-one replicates.
pub(crate) fn jackknife(replicates: &[f64]) -> f64 {
    let n = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / n;
    let squares: f64 = replicates.iter().map(|x| (x - mean) * (x - mean)).sum();
    libm::sqrt((n - 1.0) / n * squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values = [3.0, 5.0, 4.0, 8.0, 1.0];
        let sum: f64 = values.iter().sum();
        let replicates: Vec<f64> = values.iter().map(|x| (sum - x) / 4.0).collect();
        let variance: f64 = values.iter().map(|x| (x - sum / 5.0).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(&replicates) - (variance / 5.0).sqrt()).abs() < 1e-12);
    }
}
