//! Why a relock cannot be sampled.

use crate::table::significant;

/// Why a relock cannot be sampled. Each message names the key to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RelockError {
    #[error("relock.miss is 0, and so are its errors: there is nothing to relock")]
    NoMiss,
    #[error(
        "relock.curvature: a miss of up to {} leaves no bias, χ·Δλ² = {}",
        significant(*largest, 4),
        significant(*part, 4)
    )]
    NoBias { largest: f64, part: f64 },
    #[error(
        "relock.loop_time = {} s does not settle in the ticks that it is followed for, of {} s",
        significant(*loop_s, 6),
        significant(*tick_s, 6)
    )]
    LoopTooSlow { loop_s: f64, tick_s: f64 },
    #[error("relock.loop_time = {} s is over within the first tick, of {} s", significant(*loop_s, 6), significant(*tick_s, 6))]
    LoopTooFast { loop_s: f64, tick_s: f64 },
    #[error("relock.bias_frequency: {} counts in half a tick, less than one", significant(*counts, 6))]
    BiasTooSlow { counts: f64 },
    #[error("relock.bias_frequency: {} counts in a tick are too many for 32-bit arithmetic", significant(*counts, 6))]
    BiasTooFast { counts: f64 },
    #[error("{key}: {} is lost beside detunings of up to {} in 32-bit arithmetic", significant(*found, 6), significant(*largest, 6))]
    TooSmall { key: &'static str, found: f64, largest: f64 },
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
