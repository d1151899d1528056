//! Why a point cannot be sampled.

use crate::table::significant;

/// Why a point cannot be sampled. Each message names the parameter to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LowerError {
    #[error("gyro.tick_noise: {} ″ of noise per tick {lost}", significant(*sigma_arcsec, 6))]
    NoiseTooSmall { sigma_arcsec: f64, lost: Lost },
    #[error("{key}: {} ″ of motion per tick {lost}", significant(*tick_arcsec, 6))]
    MotionTooSmall { key: &'static str, tick_arcsec: f64, lost: Lost },
    #[error("switching.fillers: `{filler}` does not determine its polynomial from ticks {ticks:?}")]
    Singular { filler: String, ticks: Vec<i32> },
    #[error(
        "gyro.tick_noise: the covariance of the ticks of `{filler}` is singular, a noise of {} ″ is too small beside the \
         motion to choose weights by",
        significant(*sigma_arcsec, 6)
    )]
    SingularCovariance { filler: String, sigma_arcsec: f64 },
    #[error(
        "switching.fillers: the weighted sum of the {error} of `{filler}` reaches 2^{bits:.0}, more than its 64-bit sum can hold"
    )]
    TooLarge { filler: String, error: &'static str, bits: f64 },
    #[error(
        "gyro.readout_lsb: a pulse of {} ″ is less than a unit of {} ″ of the 32-bit arithmetic that this motion leaves",
        significant(*readout_lsb, 6),
        significant(*unit_arcsec, 3)
    )]
    ReadoutTooFine { readout_lsb: f64, unit_arcsec: f64 },
    #[error(
        "motion.profile: the record `{file}` has {ticks} whole ticks, too few for a gap of {gap_ticks} with {margin} ticks on \
         either side"
    )]
    ProfileTooShort { file: String, ticks: usize, gap_ticks: u32, margin: usize },
    #[error("motion.profile: the record `{file}` has {ticks} ticks, more than {most}")]
    ProfileTooLong { file: String, ticks: usize, most: usize },
}

/// Why a quantity has too few units in the fixed point of a tick.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Lost {
    /// The other quantities are so large that they take all 32 bits.
    #[error("are lost beside motion and noise of up to {} ″ per tick in 32-bit arithmetic", significant(*whole_arcsec, 6))]
    Beside { whole_arcsec: f64 },
    /// There is no finer unit.
    #[error("are too few units of 2^-24 ″, the finest unit of angle")]
    BelowFinest,
}

impl LowerError {
    /// The key of the study that has to change.
    pub fn key(&self) -> &'static str {
        match self {
            LowerError::NoiseTooSmall { .. } | LowerError::SingularCovariance { .. } => "gyro.tick_noise",
            LowerError::MotionTooSmall { key, .. } => key,
            LowerError::Singular { .. } | LowerError::TooLarge { .. } => "switching.fillers",
            LowerError::ReadoutTooFine { .. } => "gyro.readout_lsb",
            LowerError::ProfileTooShort { .. } | LowerError::ProfileTooLong { .. } => "motion.profile",
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            LowerError::NoiseTooSmall { .. } => "make the noise larger, or 0",
            LowerError::MotionTooSmall { lost: Lost::BelowFinest, .. } => "make the motion larger, or 0",
            LowerError::MotionTooSmall { .. } => {
                "make the motion larger, or 0; or the noise smaller, or the gap shorter"
            }
            LowerError::Singular { .. } => "give it more ticks, or a lower order",
            LowerError::SingularCovariance { .. } => {
                "give the noise that the gyro really has, fewer fit ticks, or a wider band to design for"
            }
            LowerError::TooLarge { .. } => {
                "leave the filler out, move its ticks nearer to the gap, or shorten the gap"
            }
            LowerError::ReadoutTooFine { .. } => {
                "leave readout_lsb out: pulses as fine as this change nothing"
            }
            LowerError::ProfileTooShort { .. } => "record for longer, or take a shorter tick or gap",
            LowerError::ProfileTooLong { .. } => "cut the record, or take a longer tick",
        }
    }
}
