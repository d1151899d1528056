//! Standard errors from parts of the trials: each of them left out in turn, or balanced halves of them.

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

/// The parts in each of the balanced halves of all parts, by the rows of a Hadamard matrix, and those in its complement:
/// 31 pairs, in which any two parts are in the same half as often as not.
pub(crate) fn halves() -> impl Iterator<Item = [Vec<usize>; 2]> {
    let is_in = |half: u64, part: u64| (half & part).count_ones().is_multiple_of(2);
    (1..PARTS).map(move |half| {
        let (one, other): (Vec<u64>, Vec<u64>) = (0..PARTS).partition(|part| is_in(half, *part));
        [one, other].map(|parts| parts.into_iter().map(|part| part as usize).collect())
    })
}

/// The standard error from an estimate in each of the [`halves`] and in its complement. Halves differ by as much as the
/// estimate itself scatters, so that it holds for levels found in bins and for minima, of which the small differences without
/// one part tell the scatter badly (McCarthy, *Review of the International Statistical Institute* 37, 1969, 239).
pub(crate) fn of_halves(pairs: &[[f64; 2]]) -> f64 {
    let squares: f64 = pairs.iter().map(|[a, b]| 0.25 * (a - b) * (a - b)).sum();
    libm::sqrt(squares / pairs.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balanced_halves_give_the_standard_error_of_a_mean() {
        let values: Vec<f64> = (0..PARTS).map(|k| (k * k % 37) as f64).collect();
        let mean =
            |parts: &Vec<usize>| parts.iter().map(|&part| values[part]).sum::<f64>() / parts.len() as f64;
        let pairs: Vec<[f64; 2]> = halves().map(|half| half.each_ref().map(mean)).collect();
        let all = values.iter().sum::<f64>() / PARTS as f64;
        let squares: f64 = values.iter().map(|x| (x - all).powi(2)).sum();
        let exact = (squares / (PARTS * (PARTS - 1)) as f64).sqrt();
        assert!((of_halves(&pairs) / exact - 1.0).abs() < 1e-12, "{} {exact}", of_halves(&pairs));
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values = [3.0, 5.0, 4.0, 8.0, 1.0];
        let sum: f64 = values.iter().sum();
        let replicates: Vec<f64> = values.iter().map(|x| (sum - x) / 4.0).collect();
        let variance: f64 = values.iter().map(|x| (x - sum / 5.0).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(&replicates) - (variance / 5.0).sqrt()).abs() < 1e-12);
    }
}
