//! The minimum-variance gap filler: the best linear unbiased estimate of the gap for a known motion and noise.
//!
//! Its weights solve `[K + σ²I, 1; 1ᵀ, 0] [w; λ] = [k; n]`, where K is the covariance of the motion between the ticks
//! that it reads and k that of each tick with the sum over the gap. The constraint Σw = n keeps a constant rate exact.
//! Everything is computed in a fixed order with `libm`, so the weights are the same on every machine.
//!
//! ```
//! use sagnac::theory::minimum_variance::{Band, error_variance, minimum_variance_weights};
//!
//! // 12000 ″/s at 18 to 22 Hz, σ = 1.6/3 ″ a tick, n = 3, the default ticks.
//! let (ticks, sigma) = ([-1, 0, 4, 5], 1.6 / 3.0);
//! let covariance = Band { low_hz: 18.0, high_hz: 22.0 }.covariance(12000.0, 0.005, 7);
//! let weights = minimum_variance_weights(&ticks, 3, &covariance, &[sigma * sigma]).unwrap();
//! assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
//! assert!((error_variance(&ticks, &weights, 3, &covariance, sigma).sqrt() - 3.79).abs() < 0.005);
//! ```

use core::f64::consts::TAU;

use crate::theory::cholesky::{definite, solve};
use crate::theory::gap::tick_amplitude;
use crate::theory::lags::Lags;
use crate::theory::quadrature::means;

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
    /// Covariance of the angles of two ticks, ″², at distances 0 … `lags` − 1.
    ///
    /// `rate_amplitude` is A_Ω in ″/s, `tick_s` is T. The result is the mean over the band of (A_Ω T sinc νT)²/2 · cos
    /// 2πν·lag·T, by quadrature in panels of at most one turn each, accurate to 1e-12 of the variance.
    pub fn covariance(&self, rate_amplitude: f64, tick_s: f64, lags: impl Into<Lags>) -> Vec<f64> {
        self.by_lag(lags.into(), tick_s, |nu| rate_amplitude * tick_amplitude(tick_s, nu * tick_s))
    }

    /// The same covariance for a fixed amplitude A of the angle, ″: the peak angle of a tick is A_Ω T sinc νT with A_Ω
    /// = 2πνA.
    pub fn covariance_of_angle(&self, amplitude: f64, tick_s: f64, lags: impl Into<Lags>) -> Vec<f64> {
        self.by_lag(lags.into(), tick_s, |nu| amplitude * TAU * nu * tick_amplitude(tick_s, nu * tick_s))
    }

    fn by_lag(&self, lags: Lags, tick_s: f64, peak: impl Fn(f64) -> f64) -> Vec<f64> {
        let turns = (self.high_hz - self.low_hz) * tick_s * (lags.resolved as f64 + 1.0);
        let panels = 1.0 + libm::ceil(turns);
        let lags: Vec<f64> = (0..lags.computed).map(|lag| lag as f64).collect();
        means(self.low_hz, self.high_hz, panels, lags.len(), |nu, terms| {
            let square = 0.5 * peak(nu) * peak(nu);
            for (term, lag) in terms.iter_mut().zip(&lags) {
                *term = square * libm::cos(TAU * nu * tick_s * lag);
            }
        })
    }
}

/// Weights on `ticks` with the least error over the gap 1 … n, for motion of this `covariance` by lag and for `noise`
/// on the readings, given by lag too: `[σ²]` for independent noise. Lags that are not given have no noise.
///
/// `None` where the covariance of the ticks is singular to working precision, because the noise is too small relative
/// to the motion to determine the weights. `covariance` must cover the distances between all ticks and the gap.
pub fn minimum_variance_weights(
    ticks: &[i32],
    gap_ticks: u32,
    covariance: &[f64],
    noise: &[f64],
) -> Option<Vec<f64>> {
    let between = |a: i32, b: i32| covariance[a.abs_diff(b) as usize];
    let of_noise = |a: i32, b: i32| noise.get(a.abs_diff(b) as usize).copied().unwrap_or(0.0);
    let count = ticks.len();
    let factor = definite(count, |i, j| between(ticks[i], ticks[j]) + of_noise(ticks[i], ticks[j]))?;
    let gap = |&tick: &i32| (1..=gap_ticks as i32).map(|j| between(tick, j)).sum();
    let best = solve(&factor, ticks.iter().map(gap).collect());
    let ones = solve(&factor, vec![1.0; count]);
    let short = f64::from(gap_ticks) - best.iter().sum::<f64>();
    let share = short / ones.iter().sum::<f64>();
    Some(best.iter().zip(&ones).map(|(best, one)| best + share * one).collect())
}

/// Variance of the error of given weights for such a motion and noise, ″².
pub fn error_variance(ticks: &[i32], weights: &[f64], gap_ticks: u32, covariance: &[f64], sigma: f64) -> f64 {
    let all: Vec<(i32, f64)> = ticks
        .iter()
        .copied()
        .zip(weights.iter().copied())
        .chain((1..=gap_ticks as i32).map(|tick| (tick, -1.0)))
        .collect();
    let mut motion = 0.0;
    for &(a, u) in &all {
        for &(b, v) in &all {
            motion += u * v * covariance[a.abs_diff(b) as usize];
        }
    }
    motion + sigma * sigma * weights.iter().map(|w| w * w).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn design(band: Band, n: u32, name: &str) -> (Vec<f64>, f64) {
        let ticks = fit_ticks(name, n as i32);
        let covariance = band.covariance(RATE, TICK_S, 64);
        let weights = minimum_variance_weights(&ticks, n, &covariance, &[SIGMA * SIGMA]).unwrap();
        let rms = libm::sqrt(error_variance(&ticks, &weights, n, &covariance, SIGMA));
        (weights, rms)
    }

    #[test]
    fn errors_gains_and_largest_weights_are_those_of_the_reference() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gap_minimum_variance.csv");
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
        let at_19 = Band { low_hz: 19.0, high_hz: 19.0 }.covariance(RATE, TICK_S, 64);
        for (name, expected) in [("8+2", 21.6), ("4", 3.3)] {
            let (weights, _) = design(Band { low_hz: 20.0, high_hz: 20.0 }, 3, name);
            let rms = libm::sqrt(error_variance(&fit_ticks(name, 3), &weights, 3, &at_19, SIGMA));
            assert!((rms - expected).abs() < 0.05, "{name}: {rms}");
        }
    }

    #[test]
    fn no_weights_near_by_are_better() {
        let band = Band { low_hz: 18.0, high_hz: 22.0 };
        let (ticks, covariance) = (fit_ticks("8+2", 3), band.covariance(RATE, TICK_S, 64));
        let (weights, rms) = design(band, 3, "8+2");
        assert!((weights.iter().sum::<f64>() - 3.0).abs() < 1e-12);
        for i in 1..weights.len() {
            for step in [-1e-3, 1e-3] {
                let mut other = weights.clone();
                other[0] -= step;
                other[i] += step;
                assert!(
                    error_variance(&ticks, &other, 3, &covariance, SIGMA) > rms * rms,
                    "weight {i}, {step}"
                );
            }
        }
    }

    #[test]
    fn a_band_is_the_mean_of_its_frequencies() {
        let band = Band { low_hz: 1.0, high_hz: 60.0 };
        let found = band.covariance(RATE, TICK_S, 40);
        let steps = 200_000;
        for lag in [0, 1, 7, 39] {
            let at = |k: usize| {
                let nu = 1.0 + 59.0 * (k as f64 + 0.5) / steps as f64;
                Band { low_hz: nu, high_hz: nu }.covariance(RATE, TICK_S, lag + 1)[lag]
            };
            let mean = (0..steps).map(at).sum::<f64>() / steps as f64;
            assert!((found[lag] - mean).abs() < 1e-6 * found[0], "lag {lag}: {}, not {mean}", found[lag]);
        }
    }

    #[test]
    fn motion_without_noise_on_more_ticks_than_it_has_freedoms_is_singular() {
        let tone = Band { low_hz: 20.0, high_hz: 20.0 }.covariance(RATE, TICK_S, 64);
        assert_eq!(minimum_variance_weights(&fit_ticks("4", 3), 3, &tone, &[]), None);
        assert!(minimum_variance_weights(&[0, 4], 3, &tone, &[]).is_some());
        assert_eq!(minimum_variance_weights(&[0, 4], 3, &[0.0; 64], &[]), None);
    }
}
