//! Lock-in of a ring laser gyro and the dither that keeps it out of lock-in: mean output rate, dynamic lock-in zones and
//! angle random walk.
//!
//! Backscatter couples the two beams, so that the beat phase ψ follows ψ̇ = K [Ω + Ω_D cos ω_d t + Ω_L sin ψ] with
//! K = 2π/q. Angles are in ″, rates in ″/s. Zones and angle random walk are of first order in the lock-in threshold Ω_L.
//!
//! ```
//! use sagnac_theory::lock_in::{LockIn, Premise, mean_rate};
//!
//! // A threshold of 180 ″/s: a rate of 100 ″/s is locked, one of 300 ″/s is read as 240 ″/s.
//! assert_eq!(mean_rate(100.0, 180.0), 0.0);
//! assert_eq!(mean_rate(300.0, 180.0), 240.0);
//! // Dithered by 100 °/s at 400 Hz with 2 ″ per pulse, it leaves 0.0028 °/√h.
//! let gyro = LockIn { threshold: 180.0, scale_factor: 2.0, dither_rate: 360_000.0, dither_frequency: 400.0 };
//! assert!((gyro.angle_random_walk() / 60.0 - 0.0028).abs() < 5e-5);
//! assert_eq!(gyro.failing_premises(0.02, 37.0), []);
//! assert_eq!(gyro.failing_premises(0.0, 37.0), [Premise::Independent]);
//! ```

use std::f64::consts::TAU;

/// Least Θ·σ_A/A: zones then have e^{−9/2}, a hundredth of their width, and N is 10^−4 lower. At 1 it would be 20 % lower.
pub const MIN_SPREAD: f64 = 3.0;
/// Least amplitude Θ of the dither in radians of the beat phase: J_k differs from its asymptotic form by about 1/8Θ.
const MIN_AMPLITUDE: f64 = 10.0;
/// Largest input rate as a part of the dither rate: N ∝ (Ω_D² − Ω²)^{−1/4} is then 0.25 % higher.
const MAX_RATE: f64 = 0.1;
/// Largest rms jump of the beat phase at a reversal, in radians: simulated gyros have 0.97 of N at 1 rad, and 0.76 at 2.
const MAX_JUMP: f64 = 0.5;

/// Mean output rate of a gyro without dither, ″/s: sign(Ω) √(Ω² − Ω_L²), and 0 where |Ω| ≤ Ω_L.
pub fn mean_rate(rate: f64, threshold: f64) -> f64 {
    // The product keeps its digits near the edge, where the difference of the squares would lose them.
    let square = (rate.abs() - threshold) * (rate.abs() + threshold);
    if square > 0.0 { libm::copysign(libm::sqrt(square), rate) } else { 0.0 }
}

/// Θ = Ω_D/(f_d q): amplitude of the angle of a sine dither, in radians of the beat phase.
pub fn amplitude(dither_rate: f64, dither_frequency: f64, scale_factor: f64) -> f64 {
    dither_rate / (dither_frequency * scale_factor)
}

/// Ω_D = ω_d A: amplitude of the rate of a sine dither with an amplitude `angle` of the angle, ″/s.
pub fn dither_rate(angle: f64, dither_frequency: f64) -> f64 {
    TAU * dither_frequency * angle
}

/// Scale factor, lock-in threshold and sine dither of a gyro, each above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LockIn {
    /// Lock-in threshold Ω_L, ″/s.
    pub threshold: f64,
    /// Angle q of one period of the beat, ″ per pulse.
    pub scale_factor: f64,
    /// Amplitude Ω_D of the dither's rate, ″/s.
    pub dither_rate: f64,
    /// Dither frequency f_d, Hz.
    pub dither_frequency: f64,
}

impl LockIn {
    /// Θ = Ω_D/(f_d q), in radians of the beat phase.
    pub fn amplitude(&self) -> f64 {
        amplitude(self.dither_rate, self.dither_frequency, self.scale_factor)
    }

    /// Ω_k = k f_d q: centre of dynamic lock-in zone `k`, and the output rate everywhere in it, ″/s.
    pub fn zone_centre(&self, k: i32) -> f64 {
        f64::from(k) * self.dither_frequency * self.scale_factor
    }

    /// Ω_L |J_k(Θ)|: half width of dynamic lock-in zone `k` where the dither is not randomized, ″/s.
    pub fn zone_half_width(&self, k: i32) -> f64 {
        self.threshold * libm::jn(k, self.amplitude()).abs()
    }

    /// N = Ω_L √(q/(2πΩ_D)), ″/√s: angle random walk where the dither is randomized.
    ///
    /// The rate passes through 0 with the acceleration ω_d Ω_D at 2 f_d reversals a second. By stationary phase, each turns
    /// the angle by Ω_L √(2π/α) sin(ψ ± π/4) with α = K ω_d Ω_D, and ψ is uniform.
    pub fn angle_random_walk(&self) -> f64 {
        self.threshold * libm::sqrt(self.scale_factor / (TAU * self.dither_rate))
    }

    /// Half width of dynamic lock-in zone `k` that is left where the dither's amplitude varies by `amplitude_noise` (σ_A/A,
    /// independent in each half-cycle between zero crossings of the angle), ″/s: Ω_L |J_k(Θ)| e^{−(Θσ_A/A)²/2}.
    ///
    /// A reversal is at the beat phase ±Θ(1 + σ_A/A · z) from that of the zero crossings, which the noise leaves where they are.
    /// The mean of sin ψ over z is what locks.
    pub fn remaining_half_width(&self, k: i32, amplitude_noise: f64) -> f64 {
        let spread = self.amplitude() * amplitude_noise;
        self.zone_half_width(k) * libm::exp(-0.5 * spread * spread)
    }

    /// N outside the zones where the dither's amplitude varies by `amplitude_noise`, ″/√s: [`LockIn::angle_random_walk`] times
    /// √(1 − e^{−(Θσ_A/A)²}).
    ///
    /// The variance of sin ψ at a reversal over z is ½(1 − e^{−(Θσ_A/A)²}), averaged over a beat phase that goes on turning. The
    /// mean, which makes the zones, turns with it and walks nowhere.
    pub fn partial_angle_random_walk(&self, amplitude_noise: f64) -> f64 {
        let spread = self.amplitude() * amplitude_noise;
        self.angle_random_walk() * libm::sqrt(-libm::expm1(-spread * spread))
    }

    /// Rms of the jump of the beat phase at one reversal, 2πN/(q√(2f_d)), in radians.
    pub fn jump(&self) -> f64 {
        TAU * self.angle_random_walk() / (self.scale_factor * libm::sqrt(2.0 * self.dither_frequency))
    }

    /// The premises of [`LockIn::angle_random_walk`] that fail at an input rate, where the dither's amplitude varies by
    /// `amplitude_noise` (σ_A/A) from half-cycle to half-cycle; empty where the closed form holds.
    pub fn failing_premises(&self, amplitude_noise: f64, rate: f64) -> Vec<Premise> {
        let premises = [
            (Premise::Independent, self.amplitude() * amplitude_noise >= MIN_SPREAD),
            (Premise::Separate, self.amplitude() >= MIN_AMPLITUDE),
            (Premise::SlowInput, rate.abs() <= MAX_RATE * self.dither_rate),
            (Premise::Weak, self.jump() <= MAX_JUMP),
        ];
        premises.into_iter().filter(|(_, holds)| !holds).map(|(premise, _)| premise).collect()
    }
}

/// A premise of the closed form of the angle random walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Premise {
    /// The jumps at the reversals are independent: Θ·σ_A/A ≥ 3.
    Independent,
    /// The reversals do not overlap: Θ ≥ 10.
    Separate,
    /// The input rate is below a tenth of the dither rate.
    SlowInput,
    /// A jump changes the beat phase by little: at most 0.5 rad rms.
    Weak,
}

impl Premise {
    /// What fails where the premise fails, for notes.
    pub fn failure(self) -> &'static str {
        match self {
            Premise::Independent => {
                "the amplitude noise is less than 3 rad of the beat phase, so the reversals of the dither are correlated and \
                 lock-in zones partly remain"
            }
            Premise::Separate => {
                "the dither's amplitude is less than 10 rad of the beat phase, so its reversals overlap"
            }
            Premise::SlowInput => {
                "the input rate is above a tenth of the dither rate, so the rate reverses with another acceleration"
            }
            Premise::Weak => {
                "the threshold is so large that one reversal changes the beat phase by more than 0.5 rad rms"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// The gyro of docs/dev/equations.md.
    const GYRO: LockIn =
        LockIn { threshold: 180.0, scale_factor: 2.0, dither_rate: 360_000.0, dither_frequency: 400.0 };

    fn near(found: f64, expected: f64, relative: f64) {
        assert!((found / expected - 1.0).abs() < relative, "{found} instead of {expected}");
    }

    #[test]
    fn the_beat_without_dither_is_a_hyperbola_with_a_dead_band() {
        for rate in [-180.0, -17.0, 0.0, 179.999, 180.0] {
            assert_eq!(mean_rate(rate, 180.0), 0.0, "{rate}");
        }
        assert_eq!(mean_rate(500.0, 300.0), 400.0);
        assert_eq!(mean_rate(-500.0, 300.0), -400.0);
        assert_eq!(mean_rate(-500.0, 0.0), -500.0);
        // √(2 Ω_L δ) just above the edge.
        near(mean_rate(180.0 * (1.0 + 1e-12), 180.0), 180.0 * libm::sqrt(2e-12), 1e-4);
    }

    /// The time of one beat, ∫ dψ/ψ̇ over a turn, gives the same mean rate.
    #[test]
    fn the_beat_without_dither_is_that_of_the_integrated_period() {
        let steps = 4096;
        for rate in [181.0, 200.0, 360.0, 5000.0] {
            let slowness = |step: i32| {
                let psi = TAU * (f64::from(step) + 0.5) / f64::from(steps);
                1.0 / (rate + 180.0 * libm::sin(psi))
            };
            let mean = (0..steps).map(slowness).sum::<f64>() / f64::from(steps);
            near(mean_rate(rate, 180.0), 1.0 / mean, 1e-10);
        }
    }

    #[test]
    fn the_checked_gyro_has_its_angle_random_walk() {
        near(GYRO.angle_random_walk(), 0.1693, 3e-4);
        near(GYRO.amplitude(), 450.0, 1e-12);
        // 450 rad of the beat phase are 71.6 pulses.
        near(dither_rate(450.0 / TAU * 2.0, 400.0), GYRO.dither_rate, 1e-12);
        // Ω_L² q/(4π f_d Ω_D) is the variance of a jump, of which there are 2 f_d a second.
        let jump = 180.0 * 180.0 * 2.0 / (4.0 * PI * 400.0 * 360_000.0);
        near(GYRO.jump(), libm::sqrt(jump) * PI, 1e-12);
    }

    /// Values of J_k(Θ) from Abramowitz and Stegun, tables 9.1, 9.2 and 9.4.
    #[test]
    fn zones_have_the_widths_of_tabulated_bessel_functions() {
        let of = |theta: f64| LockIn { dither_rate: theta * 800.0, ..GYRO };
        let table = [
            (0, 1.0, 0.765_197_686_558),
            (0, 5.0, -0.177_596_771_314),
            (0, 10.0, -0.245_935_764_451),
            (1, 1.0, 0.440_050_585_745),
            (1, 5.0, -0.327_579_137_591),
            (1, 10.0, 0.043_472_746_169),
            (2, 10.0, 0.254_630_313_685),
            (3, 5.0, 0.364_831_230_614),
            (10, 10.0, 0.207_486_106_633),
            (20, 10.0, 1.151_336_925e-5),
        ];
        for (k, theta, bessel) in table {
            near(of(theta).zone_half_width(k), 180.0 * f64::abs(bessel), 1e-9);
            assert_eq!(of(theta).zone_half_width(-k), of(theta).zone_half_width(k), "zone {k}");
            assert_eq!(of(theta).zone_centre(k), 800.0 * f64::from(k));
        }
        // The zone at rest vanishes at the first root of J_0.
        assert!(of(2.404_825_557_695_773).zone_half_width(0) < 1e-12);
    }

    /// Over amplitudes on a fine grid of quantiles of the noise, at reversals of a phase that turns.
    #[test]
    fn noise_of_the_amplitude_takes_from_the_zones_what_it_gives_to_the_walk() {
        let (parts, phases) = (4000, 32);
        let quantile = |part: i32| (f64::from(part) + 0.5) / f64::from(parts);
        let normal = |p: f64| std::f64::consts::SQRT_2 * statrs::function::erf::erf_inv(2.0 * p - 1.0);
        let noises: Vec<f64> = (0..parts).map(|part| normal(quantile(part))).collect();
        for spread in [0.3, 1.0, 2.0] {
            let (mut means, mut variances) = (0.0, 0.0);
            for phase in 0..phases {
                let psi = TAU * (f64::from(phase) + 0.5) / f64::from(phases);
                let sines = noises.iter().map(|z| libm::sin(psi + spread * z));
                let (sum, squares) =
                    sines.fold((0.0, 0.0), |(sum, squares), sine| (sum + sine, squares + sine * sine));
                let mean = sum / f64::from(parts);
                means += 2.0 * mean * mean / f64::from(phases);
                variances += 2.0 * (squares / f64::from(parts) - mean * mean) / f64::from(phases);
            }
            let noise = spread / 450.0;
            near(GYRO.remaining_half_width(3, noise) / GYRO.zone_half_width(3), libm::sqrt(means), 1e-3);
            near(
                GYRO.partial_angle_random_walk(noise) / GYRO.angle_random_walk(),
                libm::sqrt(variances),
                1e-3,
            );
        }
        assert_eq!(GYRO.remaining_half_width(0, 0.0), GYRO.zone_half_width(0));
        assert_eq!(GYRO.partial_angle_random_walk(0.0), 0.0);
        near(GYRO.partial_angle_random_walk(0.02), GYRO.angle_random_walk(), 1e-12);
    }

    #[test]
    fn each_premise_fails_by_name() {
        assert_eq!(GYRO.failing_premises(3.001 / 450.0, 36_000.0), []);
        assert_eq!(GYRO.failing_premises(2.99 / 450.0, 0.0), [Premise::Independent]);
        assert_eq!(GYRO.failing_premises(0.02, -36_001.0), [Premise::SlowInput]);
        let strong = LockIn { threshold: 5000.0, ..GYRO };
        assert_eq!(strong.failing_premises(0.02, 0.0), [Premise::Weak]);
        let small = LockIn { threshold: 1.0, dither_rate: 7900.0, ..GYRO };
        assert_eq!(small.failing_premises(0.4, 0.0), [Premise::Separate]);
        for premise in [Premise::Independent, Premise::Separate, Premise::SlowInput, Premise::Weak] {
            assert!(!premise.failure().is_empty());
        }
    }
}
