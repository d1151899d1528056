//! The closing of the path-length control loop after a mode switch, and the apparent rotation that it causes: Z(1), Z(2),
//! Z(10)–Z(13).
//!
//! Detunings Δλ are fractions of the wavelength. Rates are in the unit of f0, which is ″/s where that is Hz × pulse
//! weight. Tick i = 1 is the first after the loop closes; its first half has the larger detuning. Signs are those for
//! the negative half-period first. χ in Z(11) and the exponents of Z(12) for i > 1 are corrected: see docs/explain/errata.md.
//!
//! ```
//! use sagnac_theory::relock::{Relock, drift_from_detuning, drift_from_frequency};
//!
//! // 80 kHz at 2.6 ″ a period, χ = 40, a miss of 0.059 λ, a loop of 12 ms.
//! let relock = Relock { tick_s: 0.005, loop_s: 0.012, bias: 208_000.0, curvature: 40.0, miss: 0.059 };
//! let drift = relock.apparent_drift(2);
//! assert!((relock.apparent_drift(1) * 0.005 - 20.2).abs() < 0.1);
//! let by_detuning = drift_from_detuning(relock.bias, relock.curvature, relock.detuning_means(2));
//! let by_frequency = drift_from_frequency(relock.bias_error(1), relock.bias_error(2), 2);
//! assert!([by_detuning, by_frequency].iter().all(|found| (found.unwrap() / drift - 1.0).abs() < 1e-9));
//! ```

/// A relock with a single exponential.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relock {
    /// Tick T, s.
    pub tick_s: f64,
    /// Time constant of the loop τ_L, s.
    pub loop_s: f64,
    /// Bias frequency f0, as a rate.
    pub bias: f64,
    /// Curvature χ.
    pub curvature: f64,
    /// Initial detuning Δλ0.
    pub miss: f64,
}

impl Relock {
    /// q = e^{−T/τ_L}.
    pub fn decay(&self) -> f64 {
        libm::exp(-self.tick_s / self.loop_s)
    }

    /// Δλ = Δλ0 e^{−t/τ_L}, Z(10).
    pub fn detuning(&self, t: f64) -> f64 {
        self.miss * libm::exp(-t / self.loop_s)
    }

    /// f = f0 (1 − χΔλ²), Z(2).
    pub fn bias_at(&self, t: f64) -> f64 {
        let detuning = self.detuning(t);
        self.bias * (1.0 - self.curvature * detuning * detuning)
    }

    /// Fraction of the bias that is lost in each half of a tick, relative to T/2: χΔλ0² (τ_L/T)(1 − q) q^{2(i−1)}, and
    /// q times that.
    pub fn lost(&self, tick: u32) -> [f64; 2] {
        let q = self.decay();
        let first = self.curvature
            * self.miss
            * self.miss
            * (self.loop_s / self.tick_s)
            * -libm::expm1(-self.tick_s / self.loop_s)
            * libm::pow(q, f64::from(2 * (tick - 1)));
        [first, first * q]
    }

    /// ΔΩ_i = (χ f0 Δλ0² τ_L/2T) q^{2(i−1)} (1 − q)², Z(11).
    pub fn apparent_drift(&self, tick: u32) -> f64 {
        let [first, second] = self.lost(tick);
        0.5 * self.bias * (first - second)
    }

    /// y_i = f_i − f0 = −(χ f0 Δλ0² τ_L/2T) q^{2(i−1)} (1 − q²).
    pub fn bias_error(&self, tick: u32) -> f64 {
        let [first, second] = self.lost(tick);
        -0.5 * self.bias * (first + second)
    }

    /// Mean detunings over the halves of a tick, Z(12): Δλ0 (2τ_L/T)(1 − √q) q^{i−1}, and √q times that.
    pub fn detuning_means(&self, tick: u32) -> [f64; 2] {
        let half = 0.5 * self.tick_s / self.loop_s;
        let first = self.miss / half * -libm::expm1(-half) * libm::pow(self.decay(), f64::from(tick - 1));
        [first, first * libm::exp(-half)]
    }
}

/// Z(1): A_I = 4 a_I Δλ c/Δν, with `gain` = 4 a_I c/Δν.
pub fn detuning_signal(gain: f64, detuning: f64) -> f64 {
    gain * detuning
}

/// From frequency, i ≥ 2: q = (y_i/y_1)^{1/2(i−1)}, ΔΩ_i = −y_i (1 − q)/(1 + q). `None` where y_1 or y_i is not below
/// 0, or where they do not decay.
pub fn drift_from_frequency(first: f64, error: f64, tick: u32) -> Option<f64> {
    let q = libm::pow(error / first, 0.5 / f64::from(tick - 1));
    (tick > 1 && first < error && error < 0.0).then(|| -error * (1.0 - q) / (1.0 + q))
}

/// From detuning, Z(13) in Z(11): ΔΩ_i = χ f0 h⁺² (−ln r)(1 + r)²/4 with r = h⁻/h⁺. `None` where r is not between 0 and 1.
pub fn drift_from_detuning(bias: f64, curvature: f64, means: [f64; 2]) -> Option<f64> {
    let [first, second] = means;
    let r = second / first;
    let drift = curvature * bias * first * first * -libm::log(r) * (1.0 + r) * (1.0 + r) / 4.0;
    (0.0 < r && r < 1.0).then_some(drift)
}

/// Apparent drift of a tick after a mode switch in the paper, °/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelockRow {
    /// Without compensation.
    pub measured: f64,
    /// Computed from the frequency of the bias; absent for the first tick.
    pub by_frequency: Option<f64>,
    /// Computed from the detuning.
    pub by_detuning: f64,
}

/// Tables 1 and 2 of the paper, ticks 1 to 4. The ratios of the measured drifts do not fit a single exponential.
pub const RELOCK_TABLES: [RelockRow; 4] = [
    RelockRow { measured: 4056.0, by_frequency: None, by_detuning: 3720.0 },
    RelockRow { measured: 2956.0, by_frequency: Some(2399.0), by_detuning: 2385.0 },
    RelockRow { measured: 1306.0, by_frequency: Some(497.0), by_detuning: 1480.0 },
    RelockRow { measured: 207.0, by_frequency: Some(178.0), by_detuning: 278.0 },
];

/// Tick T of [`RELOCK_TABLES`], s.
pub const RELOCK_TICK_S: f64 = 0.005;

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: f64 = 0.005;

    fn near(found: f64, expected: f64, what: &str) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{what}: {found}, not {expected}");
    }

    #[test]
    fn the_reference_is_met_to_1e_9() {
        let csv = include_str!("../../../tests/data/relock.csv");
        assert_eq!(csv.lines().count(), 17);
        for line in csv.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            // χ f0 Δλ0² = 1.
            let relock = Relock { tick_s: row[0], loop_s: row[1], bias: 4.0, curvature: 0.25, miss: 1.0 };
            let tick = row[2] as u32;
            let [plus, minus] = relock.detuning_means(tick);
            near(relock.apparent_drift(tick), row[3], line);
            near(relock.bias_error(tick), row[4], line);
            near(plus, row[5], line);
            near(minus, row[6], line);
        }
    }

    #[test]
    fn both_compensations_give_back_the_drift_of_one_exponential() {
        for loop_s in [0.002, 0.0055, 0.012, 0.0315, 0.2] {
            let relock = Relock { tick_s: TICK, loop_s, bias: 2e5, curvature: 50.0, miss: -0.05 };
            for tick in 1..=8 {
                let expected = relock.apparent_drift(tick);
                let of_detuning =
                    drift_from_detuning(relock.bias, relock.curvature, relock.detuning_means(tick));
                near(of_detuning.unwrap(), expected, "detuning");
                if tick > 1 {
                    let [first, error] = [1, tick].map(|tick| relock.bias_error(tick));
                    near(drift_from_frequency(first, error, tick).unwrap(), expected, "frequency");
                }
            }
        }
    }

    #[test]
    fn halves_are_means_of_the_detuning_and_of_its_square() {
        let relock = Relock { tick_s: TICK, loop_s: 0.007, bias: 3.0, curvature: 2.0, miss: 0.1 };
        let steps = 20_000;
        for tick in [1, 3] {
            for half in 0..2 {
                let from = TICK * (f64::from(tick - 1) + 0.5 * f64::from(half));
                let mean = |of: &dyn Fn(f64) -> f64| {
                    let at = |k: i32| from + 0.5 * TICK * (f64::from(k) + 0.5) / f64::from(steps);
                    (0..steps).map(|k| of(at(k))).sum::<f64>() / f64::from(steps)
                };
                let half = half as usize;
                near(relock.detuning_means(tick as u32)[half], mean(&|t| relock.detuning(t)), "detuning");
                near(3.0 * (1.0 - relock.lost(tick as u32)[half]), mean(&|t| relock.bias_at(t)), "bias");
            }
        }
    }

    #[test]
    fn what_is_no_decay_is_not_compensated() {
        for (first, error) in [(1.0, 0.5), (-1.0, -1.0), (-1.0, -1.5), (-1.0, 0.0), (-1.0, 0.2)] {
            assert_eq!(drift_from_frequency(first, error, 2), None, "{first}, {error}");
        }
        assert_eq!(drift_from_frequency(-1.0, -0.5, 1), None);
        for means in [[1.0, 1.0], [1.0, 1.2], [1.0, -0.5], [0.0, 0.5], [1.0, 0.0]] {
            assert_eq!(drift_from_detuning(1.0, 1.0, means), None, "{means:?}");
        }
    }

    #[test]
    fn the_signal_is_proportional_to_the_detuning() {
        assert_eq!(detuning_signal(3.0, -0.05), -0.15000000000000002);
    }

    #[test]
    fn the_relock_tables_add_up_as_the_paper_says() {
        let mean = |of: fn(&RelockRow) -> f64| RELOCK_TABLES.iter().map(of).sum::<f64>() / 4.0;
        let means = [
            mean(|row| row.measured),
            mean(|row| row.measured - row.by_frequency.unwrap_or(0.0)),
            mean(|row| row.measured - row.by_detuning),
        ];
        assert_eq!(means.map(libm::floor), [2131.0, 1362.0, 165.0]);
        // Angles over four ticks: 43 ″, 27 ″, 3.3 ″.
        let angles = means.map(|mean| libm::round(4.0 * mean * RELOCK_TICK_S * 10.0) / 10.0);
        assert_eq!(angles, [42.6, 27.3, 3.3]);
    }
}
