//! The minimum-variance gap filler: the best linear unbiased estimate of the gap for a known motion and noise.
//!
//! Its weights solve `[K + R, 1; 1ᵀ, 0] [w; λ] = [k; n]`, where K is the covariance of the motion between the ticks that
//! it reads, k that of each tick with the sum over the gap, and R that of the noise. The constraint Σw = n keeps a
//! constant rate exact. K of a narrow band is singular in 53 bits, so the same weights are computed as those of least
//! squares from the rows of the ticks, which keeps twice the digits. Everything is computed in a fixed order with `libm`,
//! so the weights are the same on every machine.
//!
//! ```
//! use sagnac_theory::lines::of_ticks;
//! use sagnac_theory::minimum_variance::{Band, minimum_variance_weights};
//! use sagnac_theory::quadrature::Rule;
//! use sagnac_theory::rows::TickRows;
//!
//! // 12000 ″/s at 18 to 22 Hz, σ = 1.6/3 ″ a tick, n = 3, the default ticks.
//! let (ticks, sigma) = ([-1, 0, 4, 5], 1.6 / 3.0);
//! let lines = Band { low_hz: 18.0, high_hz: 22.0 }.lines(7.0 * 0.005, Rule::Sparse);
//! let motion = TickRows::of_lines(&of_ticks(&lines, 0.005), 3, 2).scaled(12000.0 / 2_f64.sqrt());
//! let weights = minimum_variance_weights(&ticks, 3, &motion, &[sigma * sigma]).unwrap();
//! assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
//! let noise: f64 = weights.iter().map(|w| w * w * sigma * sigma).sum();
//! assert!(((motion.error_variance(&ticks, &weights, 3) + noise).sqrt() - 3.79).abs() < 0.005);
//! ```

use crate::cholesky::{definite, solve_transposed, whiten};
use crate::lines::Line;
use crate::quadrature::Rule;
use crate::rows::{Rows, TickRows, dot, triangular};

/// A vibration of random phase whose frequency is uniformly distributed over a band; for a single frequency both ends
/// are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub low_hz: f64,
    /// Upper end, Hz.
    pub high_hz: f64,
}

impl Band {
    /// A power of 1, spread over the band, as lines with which covariances are right to rounding up to a distance of
    /// `longest_s`.
    pub fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        let Band { low_hz, high_hz } = *self;
        let width = high_hz - low_hz;
        if width == 0.0 {
            return vec![Line { frequency_hz: low_hz, power: 1.0 }];
        }
        let mut lines = Vec::new();
        rule.integrate(low_hz, high_hz, width * longest_s, |frequency_hz, weight| {
            lines.push(Line { frequency_hz, power: weight / width });
        });
        lines
    }
}

/// Smallest part of a tick, relative to its rms, that is not determined by other ticks; anything below is rounding.
const MIN_PART: f64 = 1e-12;

/// Weights on `ticks` with the least error over the gap 1 … n, for this motion and for `noise` on the readings, given as
/// its covariance by lag: `[σ²]` for independent noise. Lags that are not given have no noise.
///
/// `None` where the ticks determine each other to working precision, because the noise is too small relative to the
/// motion to determine the weights.
pub fn minimum_variance_weights(
    ticks: &[i32],
    gap_ticks: u32,
    motion: &TickRows,
    noise: &[f64],
) -> Option<Vec<f64>> {
    let count = ticks.len();
    let gap = motion.gap(gap_ticks);
    let width = ticks.iter().map(|&tick| motion.tick(tick).len()).fold(gap.len(), usize::max);
    let own = if noise.iter().any(|x| *x != 0.0) {
        let between = |i: usize, j: usize| noise.get(ticks[i].abs_diff(ticks[j]) as usize).copied();
        definite(count, |i, j| between(i, j).unwrap_or(0.0))?
    } else {
        vec![]
    };
    // The row of a reading: that of the motion, then that of its noise. The last row is that of the gap.
    let mut rows = Rows::with_capacity(count + 1, width + count);
    for (k, &tick) in ticks.iter().enumerate() {
        rows.push(motion.tick(tick), width, own.get(k).map_or(&[], |own| own));
    }
    rows.push(&gap, width, &[]);
    let triangle = triangular(&rows);
    let is_determined =
        |(k, row): (usize, &[f64])| row.len() == k + 1 && row[k] > MIN_PART * libm::sqrt(dot(row, row));
    if !triangle.iter().take(count).enumerate().all(is_determined) {
        return None;
    }
    let factor: Vec<&[f64]> = triangle.iter().take(count).collect();
    let best = solve_transposed(&factor, triangle.row(count)[..count].to_vec());
    let ones = solve_transposed(&factor, whiten(&factor, vec![1.0; count]));
    let short = f64::from(gap_ticks) - best.iter().sum::<f64>();
    let share = short / ones.iter().sum::<f64>();
    Some(best.iter().zip(&ones).map(|(best, one)| best + share * one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::{covariance, of_ticks};
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    const TICK_S: f64 = 0.005;
    const RATE: f64 = 12000.0;
    const SIGMA: f64 = 1.6 / 3.0;

    fn fit_ticks(name: &str, n: i32) -> Vec<i32> {
        match name {
            "4" => vec![-1, 0, n + 1, n + 2],
            "8+2" => (-7..=0).chain(n + 1..=n + 2).collect(),
            "8+8" => (-7..=0).chain(n + 1..=n + 8).collect(),
            "20+20" => (-19..=0).chain(n + 1..=n + 20).collect(),
            _ => panic!("no ticks are called {name}"),
        }
    }

    fn motion(band: Band, n: u32) -> TickRows {
        let lines = of_ticks(&band.lines(TICK_S * 64.0, Rule::Sparse), TICK_S);
        TickRows::of_lines(&lines, n, 20).triangular().scaled(RATE * core::f64::consts::FRAC_1_SQRT_2)
    }

    fn rms_of(ticks: &[i32], weights: &[f64], n: u32, motion: &TickRows) -> f64 {
        let noise: f64 = weights.iter().map(|w| w * w * SIGMA * SIGMA).sum();
        libm::sqrt(motion.error_variance(ticks, weights, n) + noise)
    }

    fn design(band: Band, n: u32, name: &str) -> (Vec<f64>, f64) {
        let (ticks, motion) = (fit_ticks(name, n as i32), motion(band, n));
        let weights = minimum_variance_weights(&ticks, n, &motion, &[SIGMA * SIGMA]).unwrap();
        let rms = rms_of(&ticks, &weights, n, &motion);
        (weights, rms)
    }

    #[test]
    fn errors_gains_and_largest_weights_are_those_of_the_reference() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gap_minimum_variance.csv");
        let mut rows = 0;
        for record in csv::Reader::from_path(path).unwrap().records().map(Result::unwrap) {
            let number = |field: usize| record[field].parse::<f64>().unwrap();
            let band = Band { low_hz: number(0), high_hz: number(1) };
            let (weights, rms) = design(band, number(2) as u32, &record[3]);
            let gain = libm::sqrt(weights.iter().map(|w| w * w).sum());
            let largest = weights.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
            // The reference integrates its bands by the trapezoidal rule in 4000 steps, which moves weights by 3e-6.
            for (found, expected) in [(rms, number(4)), (gain, number(5)), (largest, number(6))] {
                assert!((found / expected - 1.0).abs() < 5e-6, "{record:?}: {found}, not {expected}");
            }
            rows += 1;
        }
        assert_eq!(rows, 36);
    }

    #[test]
    fn many_ticks_on_both_sides_bridge_a_wide_band_at_the_price_of_large_weights() {
        let (_, rms) = design(Band { low_hz: 1.0, high_hz: 60.0 }, 3, "20+20");
        assert!((rms - 9.3).abs() < 0.05, "{rms}");
    }

    #[test]
    fn a_filler_tuned_to_one_frequency_is_fragile() {
        let at_19 = motion(Band { low_hz: 19.0, high_hz: 19.0 }, 3);
        for (name, expected) in [("8+2", 21.6), ("4", 3.3)] {
            let (weights, _) = design(Band { low_hz: 20.0, high_hz: 20.0 }, 3, name);
            let rms = rms_of(&fit_ticks(name, 3), &weights, 3, &at_19);
            assert!((rms - expected).abs() < 0.05, "{name}: {rms}");
        }
    }

    #[test]
    fn no_weights_near_by_are_better() {
        let band = Band { low_hz: 18.0, high_hz: 22.0 };
        for name in ["8+2", "20+20"] {
            let (ticks, motion) = (fit_ticks(name, 3), motion(band, 3));
            let (weights, rms) = design(band, 3, name);
            assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
            for i in 1..weights.len() {
                for step in [-1e-3, 1e-3] {
                    let mut other = weights.clone();
                    other[0] -= step;
                    other[i] += step;
                    assert!(rms_of(&ticks, &other, 3, &motion) > rms, "{name}: weight {i}, {step}");
                }
            }
        }
    }

    /// The variance is a quadratic form of the weights: where both ways along a line rise, its lowest point is between them.
    #[test]
    fn for_random_motions_ticks_and_gaps_no_weights_with_their_sum_are_better() {
        let mut rng = StdRng::seed_from_u64(44);
        for case in 0..100 {
            let n = rng.random_range(1..=20_u32);
            let after = n.cast_signed() + 1..=n.cast_signed() + 12;
            let ticks: Vec<i32> =
                (-12..=0).chain(after).filter(|tick| *tick == 0 || rng.random::<f64>() < 0.5).collect();
            let low_hz = rng.random_range(0.1..90.0);
            let band = Band { low_hz, high_hz: low_hz + rng.random_range(0.0..10.0) };
            let rate = libm::exp10(rng.random_range(0.0..5.0));
            let lines = of_ticks(&band.lines(TICK_S * 64.0, Rule::Sparse), TICK_S);
            let motion = TickRows::of_lines(&lines, n, 13).triangular().scaled(rate);
            let sigma = libm::exp10(rng.random_range(-3.0..1.0));
            let weights = minimum_variance_weights(&ticks, n, &motion, &[sigma * sigma]).unwrap();
            let sum: f64 = weights.iter().sum();
            assert!((sum / f64::from(n) - 1.0).abs() < 1e-9, "case {case}: a sum of {sum} for {n} ticks");
            let variance = |weights: &[f64]| {
                let noise: f64 = weights.iter().map(|w| w * w * sigma * sigma).sum();
                motion.error_variance(&ticks, weights, n) + noise
            };
            let least = variance(&weights);
            for _ in 0..20 {
                let step: Vec<f64> = ticks.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
                let mean = step.iter().sum::<f64>() / step.len() as f64;
                let moved = [-0.1, 0.1].map(|size| {
                    let other: Vec<f64> =
                        weights.iter().zip(&step).map(|(w, step)| w + size * (step - mean)).collect();
                    variance(&other)
                });
                // The rises are equal up to rounding of weights and variances, which motion far above the noise enlarges.
                let [down, up] = moved.map(|moved| moved - least);
                assert!(
                    ticks.len() == 1 || (down > 0.0 && (up / down - 1.0).abs() < 0.04),
                    "case {case}, {band:?}, {ticks:?}: {least} ″² rises by {down} and {up}"
                );
            }
        }
    }

    #[test]
    fn a_band_is_the_mean_of_its_frequencies() {
        let band = Band { low_hz: 1.0, high_hz: 60.0 };
        let of = |band: Band, lag: usize| {
            let lines = of_ticks(&band.lines(TICK_S * 40.0, Rule::Sparse), TICK_S);
            covariance(&lines, 40)[lag]
        };
        let steps = 20_000;
        for lag in [0, 1, 7, 39] {
            let at = |k: usize| {
                let nu = 1.0 + 59.0 * (k as f64 + 0.5) / steps as f64;
                of(Band { low_hz: nu, high_hz: nu }, lag)
            };
            let mean = (0..steps).map(at).sum::<f64>() / steps as f64;
            let found = of(band, lag);
            assert!((found - mean).abs() < 1e-6 * of(band, 0), "lag {lag}: {found}, not {mean}");
        }
    }

    #[test]
    fn motion_without_noise_on_more_ticks_than_it_has_freedoms_is_singular() {
        let tone = motion(Band { low_hz: 20.0, high_hz: 20.0 }, 3);
        assert_eq!(minimum_variance_weights(&fit_ticks("4", 3), 3, &tone, &[]), None);
        assert!(minimum_variance_weights(&[0, 4], 3, &tone, &[]).is_some());
        assert_eq!(minimum_variance_weights(&[0, 4], 3, &TickRows::default(), &[]), None);
    }
}
