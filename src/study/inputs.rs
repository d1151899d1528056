//! The physical inputs of one point, in ″ and s.

use std::f64::consts::TAU;

use super::file::{Filler, Kind, Phase, Streams};
use super::units::round_12;

/// All that the motion, the noise and the gap of one point depend on. Every number has 12 significant digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// T, s.
    pub tick_s: f64,
    pub tick_noise: TickNoise,
    pub amplitude: Amplitude,
    /// ν, Hz.
    pub frequency_hz: f64,
    pub phase: Phase,
    /// n.
    pub gap_ticks: u32,
}

/// Noise of the angle of one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TickNoise {
    /// σ, ″.
    Std(f64),
    /// N, ″/√s.
    AngleRandomWalk(f64),
}

/// Amplitude of the vibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amplitude {
    /// A_Ω, ″/s.
    Rate(f64),
    /// Of the angle, ″.
    Angle(f64),
}

impl TickNoise {
    /// From three standard deviations, ″.
    pub(super) fn from_three_sigma(three_sigma: f64) -> TickNoise {
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

    /// A_Ω, ″/s: as given, or the amplitude of the angle times 2πν.
    pub fn rate_amplitude(&self) -> f64 {
        match self.amplitude {
            Amplitude::Rate(rate) => rate,
            Amplitude::Angle(angle) => angle * TAU * self.frequency_hz,
        }
    }

    /// Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid tick (our reading of Z(20)).
    pub fn dt_nu(&self) -> f64 {
        (f64::from(self.gap_ticks) + 1.0) / 2.0 * self.tick_s * self.frequency_hz
    }
}

impl Filler {
    /// Every filler, by order.
    pub const ALL: [Filler; 3] = [Filler::Const, Filler::Linear, Filler::Quadratic];

    /// Order of the polynomial.
    pub fn order(self) -> usize {
        match self {
            Filler::Const => 0,
            Filler::Linear => 1,
            Filler::Quadratic => 2,
        }
    }

    /// As study files and tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Filler::Const => "const",
            Filler::Linear => "linear",
            Filler::Quadratic => "quadratic",
        }
    }
}

impl Kind {
    /// As study files call it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::GapFill => "gap-fill",
        }
    }
}

impl Streams {
    /// As study files call it.
    pub fn name(self) -> &'static str {
        match self {
            Streams::Independent => "independent",
            Streams::Common => "common",
        }
    }
}

impl Phase {
    /// As study files call it.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Uniform => "uniform",
            Phase::ZeroCrossing => "zero-crossing",
            Phase::Extremum => "extremum",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derived_quantities_follow_the_theory() {
        let mut inputs = Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::AngleRandomWalk(2.0),
            amplitude: Amplitude::Angle(90.0),
            frequency_hz: 20.0,
            phase: Phase::Uniform,
            gap_ticks: 3,
        };
        assert!((inputs.sigma_arcsec() - 0.141_421_356).abs() < 1e-9);
        assert!((inputs.rate_amplitude() - 11_309.733_553).abs() < 1e-6);
        assert!((inputs.dt_nu() - 0.2).abs() < 1e-15);
        inputs.tick_noise = TickNoise::from_three_sigma(1.6);
        inputs.amplitude = Amplitude::Rate(12000.0);
        assert_eq!((inputs.sigma_arcsec(), inputs.rate_amplitude()), (0.533_333_333_333, 12000.0));
    }
}
