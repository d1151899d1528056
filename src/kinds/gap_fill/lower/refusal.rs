//! Why a point cannot be sampled.

use crate::quantity::number::significant;

/// Why a point cannot be sampled. Each message names the parameter to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LowerError {
    /// The noise of a tick has fewer than 50 of its units.
    #[error("gyro.tick_noise: {} ″ of noise per tick {lost}", significant(*sigma_arcsec, 6))]
    NoiseTooSmall {
        /// Its standard deviation, ″.
        sigma_arcsec: f64,
        /// Why there are no finer ones.
        lost: Lost,
    },
    /// The motion of a tick has fewer than 512 of its units.
    #[error("{key}: {} ″ of motion per tick {lost}", significant(*tick_arcsec, 6))]
    MotionTooSmall {
        /// To change.
        key: &'static str,
        /// Its peak, ″.
        tick_arcsec: f64,
        /// Why there are no finer ones.
        lost: Lost,
    },
    /// Fewer ticks than the polynomial has coefficients.
    #[error("switching.fillers: `{filler}` does not determine its polynomial from ticks {ticks:?}")]
    Singular {
        /// Its name.
        filler: String,
        /// Numbers of the ticks.
        ticks: Vec<i32>,
    },
    /// Motion without noise that fewer ticks determine than the filler has: many weights would be equally good.
    #[error(
        "gyro.tick_noise: the covariance of the ticks of `{filler}` is singular, a noise of {} ″ is too small beside the \
         motion to choose weights by",
        significant(*sigma_arcsec, 6)
    )]
    SingularCovariance {
        /// Its name.
        filler: String,
        /// The noise of a tick, ″.
        sigma_arcsec: f64,
    },
    /// Weights too large for a sum in 64 bits.
    #[error(
        "switching.fillers: the weighted sum of the {error} of `{filler}` reaches 2^{bits:.0}, more than its 64-bit sum can hold"
    )]
    TooLarge {
        /// Its name.
        filler: String,
        /// Which of its errors.
        error: &'static str,
        /// Log2 of the largest sum.
        bits: f64,
    },
    /// A pulse that has no whole unit.
    #[error(
        "gyro.readout_lsb: a pulse of {} ″ is less than a unit of {} ″ of the 32-bit arithmetic that this motion leaves",
        significant(*readout_lsb, 6),
        significant(*unit_arcsec, 3)
    )]
    ReadoutTooFine {
        /// Angle of a pulse, ″.
        readout_lsb: f64,
        /// The finest unit that there is room for, ″.
        unit_arcsec: f64,
    },
    /// No place of the record has room for the gap and its ticks.
    #[error(
        "motion.profile: the record `{file}` has {ticks} whole ticks, too few for a gap of {gap_ticks} with {margin} ticks on \
         either side"
    )]
    ProfileTooShort {
        /// Of the record.
        file: String,
        /// Whole ticks in it.
        ticks: usize,
        /// n.
        gap_ticks: u32,
        /// Ticks kept free on either side.
        margin: usize,
    },
    /// More ticks than places can be drawn evenly.
    #[error("motion.profile: the record `{file}` has {ticks} ticks, more than {most}")]
    ProfileTooLong {
        /// Of the record.
        file: String,
        /// Whole ticks in it.
        ticks: usize,
        /// That there may be.
        most: usize,
    },
}

/// Why a quantity has too few units in the fixed point of a tick.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Lost {
    /// The other quantities are so large that they take all 32 bits.
    #[error("are lost beside motion and noise of up to {} ″ per tick in 32-bit arithmetic", significant(*whole_arcsec, 6))]
    Beside {
        /// Of a tick, ″.
        whole_arcsec: f64,
    },
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
