//! Why a relock cannot be sampled.

use crate::quantity::number::significant;

/// Why a relock cannot be sampled. Each message names the key to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RelockError {
    /// No detuning to relock from.
    #[error("relock.miss is 0, and so are its errors: there is nothing to relock")]
    NoMiss,
    /// So large a miss that f = f0 (1 − χΔλ²) is 0 or less.
    #[error(
        "relock.curvature: a miss of up to {} leaves no bias, χ·Δλ² = {}",
        significant(*largest, 4),
        significant(*part, 4)
    )]
    NoBias {
        /// Δλ0 with its errors, part of the wavelength.
        largest: f64,
        /// χΔλ² of it.
        part: f64,
    },
    /// A loop that hardly moves while it is looked at.
    #[error(
        "relock.loop_time = {} s does not settle in the ticks that it is followed for, of {} s",
        significant(*loop_s, 6),
        significant(*tick_s, 6)
    )]
    LoopTooSlow {
        /// τ_L, s.
        loop_s: f64,
        /// T, s.
        tick_s: f64,
    },
    /// A loop that is done before the second tick.
    #[error("relock.loop_time = {} s is over within the first tick, of {} s", significant(*loop_s, 6), significant(*tick_s, 6))]
    LoopTooFast {
        /// τ_L, s.
        loop_s: f64,
        /// T, s.
        tick_s: f64,
    },
    /// Too few periods to measure a frequency by.
    #[error("relock.bias_frequency: {} counts in half a tick, less than one", significant(*counts, 6))]
    BiasTooSlow {
        /// In half a tick.
        counts: f64,
    },
    /// More periods than the phase of the beat has bits for.
    #[error("relock.bias_frequency: {} counts in a tick are too many for 32-bit arithmetic", significant(*counts, 6))]
    BiasTooFast {
        /// In a tick.
        counts: f64,
    },
    /// An error that has too few units beside the miss.
    #[error("{key}: {} is lost beside detunings of up to {} in 32-bit arithmetic", significant(*found, 6), significant(*largest, 6))]
    TooSmall {
        /// To change.
        key: &'static str,
        /// Its value, part of the wavelength.
        found: f64,
        /// Δλ0 with its errors.
        largest: f64,
    },
}

impl RelockError {
    /// The key of the study that has to change.
    pub fn key(&self) -> &'static str {
        match self {
            RelockError::NoMiss => "relock.miss",
            RelockError::NoBias { .. } => "relock.curvature",
            RelockError::LoopTooSlow { .. } | RelockError::LoopTooFast { .. } => "relock.loop_time",
            RelockError::BiasTooSlow { .. } | RelockError::BiasTooFast { .. } => "relock.bias_frequency",
            RelockError::TooSmall { key, .. } => key,
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            RelockError::NoMiss => "give a miss, or one of half_wave_error, dac_step and hysteresis",
            RelockError::NoBias { .. } => {
                "make the miss, its errors or the curvature smaller: Z(2) holds for small detunings"
            }
            RelockError::LoopTooSlow { .. } => "accepted: up to 100 ticks; the paper's values are 1 to 6",
            RelockError::LoopTooFast { .. } => "accepted: from a 20th of a tick",
            RelockError::BiasTooSlow { .. } => {
                "make relock.bias_frequency or gyro.tick larger, or relock.count_step smaller, 0 for none"
            }
            RelockError::BiasTooFast { .. } => {
                "make gyro.tick smaller, or relock.count_step larger, or 0 for none"
            }
            RelockError::TooSmall { .. } => "make it larger, or 0; or what is large beside it smaller",
        }
    }
}
