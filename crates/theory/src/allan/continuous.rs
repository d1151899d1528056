//! The Allan variance of continuous noise, for curves in charts: the model A(4) with Markov noise and a sine.
//!
//! Records are sampled, and their Allan variance differs at small m; compare them with
//! [`Process::expected`](crate::allan::process::Process::expected).

use crate::allan::part::Part;

/// The term of one part at `tau_s`, (″/s)²: 3Q²/τ², N²/τ, (2 ln2/π)B², K²τ/3, R²τ²/2 — A(4). It is (q_cT_c)²/τ·[1 −
/// (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})] for Markov noise, and Ω_0²(sin²πfτ/πfτ)² for a sine.
///
/// `None` for a warm-up, whose Allan variance depends on the length of the record.
pub fn allan_variance(part: &Part, tau_s: f64) -> Option<f64> {
    (part.term.row().continuous)(part, tau_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::estimator::Difference;

    #[test]
    fn the_papers_gyros_have_the_curves_of_the_reference() {
        let gyros =
            [("LGK-400", [0.24, 0.00067 * 60.0, 0.00192]), ("LGV-1", [0.11, 0.00048 * 60.0, 0.00164])];
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/allan_model.csv"));
        assert_eq!(text.lines().count(), 27);
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let (tau, expected): (f64, f64) = (cells[1].parse().unwrap(), cells[2].parse().unwrap());
            let (_, [q, n, b]) = gyros.iter().find(|(name, _)| *name == cells[0]).unwrap();
            let parts = [Part::quantization(*q), Part::angle_random_walk(*n), Part::bias_instability(*b, 24)];
            let found = libm::sqrt(parts.iter().filter_map(|part| allan_variance(part, tau)).sum());
            assert!((found / expected - 1.0).abs() < 1e-11, "{line}: {found}");
        }
    }

    #[test]
    fn finely_sampled_noise_is_the_continuous_one() {
        let parts = [
            Part::quantization(0.2),
            Part::angle_random_walk(0.2),
            Part::rate_random_walk(0.2),
            Part::markov(0.2, 3.0),
            Part::sine(0.2, 0.3),
        ];
        for part in parts {
            for tau in [0.01, 1.0, 2.5, 41.0] {
                let m = 100_000;
                let sampled = part.variance(Difference::Second, tau / m as f64, m) / (2.0 * tau * tau);
                let found = allan_variance(&part, tau).unwrap();
                assert!((found / sampled - 1.0).abs() < 1e-8, "{part:?} at {tau}: {found}, not {sampled}");
            }
        }
        assert_eq!(allan_variance(&Part::warm_up(1.0, 1.0), 1.0), None);
    }
}
