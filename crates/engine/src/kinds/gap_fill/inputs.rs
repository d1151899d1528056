//! The physical inputs of one point, in ″ and s.

use std::sync::Arc;

use crate::filler::Specification;
use crate::motion::Motion;
use sagnac_base::quantity::units::round_12;

/// The inputs on which the motion, the noise and the gap of one point depend. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Tick T, s.
    pub tick_s: f64,
    /// White noise of the ticks.
    pub tick_noise: TickNoise,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub readout_lsb: f64,
    /// Angle that the relock adds to the ticks n+1, n+2, …, ″.
    pub relock: Vec<f64>,
    /// Motion of the base.
    pub motion: Motion,
    /// Motion on which fillers are judged instead of that of the base.
    pub specification: Option<Arc<Specification>>,
    /// Number of lost ticks n.
    pub gap_ticks: u32,
}

/// Noise of the angle of one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TickNoise {
    /// Standard deviation σ, ″.
    Std(f64),
    /// Angle random walk N, ″/√s.
    AngleRandomWalk(f64),
}

impl TickNoise {
    /// The noise with the given three standard deviations, ″.
    pub(crate) fn from_three_sigma(three_sigma: f64) -> TickNoise {
        TickNoise::Std(round_12(three_sigma / 3.0))
    }
}

impl Inputs {
    /// σ of the noise of one tick, ″: as given, or N·√T.
    pub fn sigma_arcsec(&self) -> f64 {
        match self.tick_noise {
            TickNoise::Std(sigma) => sigma,
            TickNoise::AngleRandomWalk(n) => n * libm::sqrt(self.tick_s),
        }
    }

    /// Covariance of the errors of readings at lags 0 and 1, ″², from noise and whole pulses.
    pub fn noise_covariance(&self) -> [f64; 2] {
        // A reading of whole pulses is wrong by the difference of two fractions, and neighbours share one of them.
        let fraction = self.readout_lsb * self.readout_lsb / 12.0;
        let sigma = self.sigma_arcsec();
        [sigma * sigma + 2.0 * fraction, -fraction]
    }

    /// Whether the base is at rest and nothing is added to the ticks.
    pub(crate) fn is_nothing(&self) -> bool {
        let added = self.relock.iter().any(|angle| *angle != 0.0);
        self.motion == Motion::default() && self.sigma_arcsec() == 0.0 && self.readout_lsb == 0.0 && !added
    }

    /// Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid tick (our reading of Z(20)). `None`
    /// unless the motion is one tone of fixed frequency.
    pub fn dt_nu(&self) -> Option<f64> {
        let (_, frequency_hz) = self.motion.single_tone()?;
        Some((f64::from(self.gap_ticks) + 1.0) / 2.0 * self.tick_s * frequency_hz)
    }

    /// A_Ω·T/σ, the ratio of the angle of a tick at the peak of the rate to the standard deviation of its noise. `None`
    /// without noise, and unless the motion is one tone of fixed frequency and amplitude.
    pub fn amplitude_noise(&self) -> Option<f64> {
        let (rate, _) = self.motion.single_tone()?;
        let sigma = self.sigma_arcsec();
        (sigma > 0.0).then(|| rate * self.tick_s / sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Tone;

    #[test]
    fn derived_quantities_follow_the_theory() {
        let mut inputs = Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::AngleRandomWalk(2.0),
            readout_lsb: 0.0,
            relock: vec![],
            motion: Motion::of_tone(Tone::of_angle(90.0, 20.0)),
            specification: None,
            gap_ticks: 3,
        };
        assert!((inputs.sigma_arcsec() - 0.141_421_356).abs() < 1e-9);
        assert!((inputs.motion.single_tone().unwrap().0 - 11_309.733_553).abs() < 1e-6);
        assert!((inputs.dt_nu().unwrap() - 0.2).abs() < 1e-15);
        inputs.tick_noise = TickNoise::from_three_sigma(1.6);
        inputs.motion = Motion::of_tone(Tone::of_rate(12000.0, 20.0));
        assert_eq!(
            (inputs.sigma_arcsec(), inputs.motion.single_tone()),
            (0.533_333_333_333, Some((12000.0, 20.0)))
        );
    }
}
