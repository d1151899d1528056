//! Why records cannot be made.

use crate::kinds::allan::lower::MOST_SAMPLES;
use crate::quantity::number::significant;

/// Why records cannot be made. Each message names the key to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordsError {
    /// A record of one sample, or longer than 2^26.
    #[error("record.length: {samples} samples; a record has 2 to {MOST_SAMPLES}")]
    Length {
        /// That it would have.
        samples: u64,
    },
    /// An empty list of averaging times.
    #[error("allan.tau: no averaging time is asked for")]
    NoAveraging,
    /// An averaging time that no record of this length has.
    #[error(
        "allan.tau: an averaging time of {m} samples has no difference in a record of {samples}, which needs {spans} of \
         them"
    )]
    Averaging {
        /// In samples.
        m: u64,
        /// Of the record.
        samples: u64,
        /// Averaging times in a difference: 2, or 3 of Hadamard.
        spans: u64,
    },
    /// No switch falls into the record, or more than one into a sample.
    #[error("noise.switching.interval: switches {interval} samples apart in a record of {samples}")]
    Interval {
        /// Samples between switches.
        interval: u64,
        /// Of the record.
        samples: u64,
    },
    /// A value that has no meaning: negative, or not finite.
    #[error("{key}: {what} {found} is not possible")]
    Impossible {
        /// To change.
        key: &'static str,
        /// What it is.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// More than one Markov noise or sine.
    #[error("{key}: a record has at most one of them")]
    Several {
        /// To change.
        key: &'static str,
    },
    /// There is nothing to sample.
    #[error("noise: all of it is 0, and there is no readout")]
    Nothing,
    /// A part has too few units beside the rest.
    #[error("{key}: {what} of {} {unit} {lost}", significant(*found, 6))]
    TooSmall {
        /// To change.
        key: &'static str,
        /// What it is.
        what: &'static str,
        /// Its value, in `unit`.
        found: f64,
        /// As in the message.
        unit: &'static str,
        /// Beside what.
        lost: Lost,
    },
    /// A sine whose phase stands still from sample to sample.
    #[error(
        "noise.sine: {} periods a sample are too near a whole number: from sample to sample the phase must turn by more \
         than 2^-26",
        significant(*turns, 12)
    )]
    SineTooSlow {
        /// Periods in a sample.
        turns: f64,
    },
    /// Markov noise that loses less in a sample than a unit.
    #[error(
        "noise.markov: a correlation time of {} samples is too long for 32-bit arithmetic, which takes 2 * 10^7",
        significant(*samples, 6)
    )]
    MarkovTooSlow {
        /// Correlation time.
        samples: f64,
    },
    /// A pulse that has too few units.
    #[error(
        "noise.readout_lsb: a pulse of {} ″ is less than 16 units of {} ″ of the 32-bit arithmetic that the angles of the \
         record leave",
        significant(*readout_lsb, 6),
        significant(*unit_arcsec, 3)
    )]
    ReadoutTooFine {
        /// Angle of a pulse, ″.
        readout_lsb: f64,
        /// The finest unit that there is room for, ″.
        unit_arcsec: f64,
    },
}

/// What a quantity with too few units is lost beside.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "is lost beside differences of the angle of up to {} ″ over {samples} samples in 32-bit arithmetic",
    significant(*whole_arcsec, 6)
)]
pub struct Lost {
    /// The largest angle that the unit has to hold, ″.
    pub whole_arcsec: f64,
    /// Of the record.
    pub samples: u64,
}

impl RecordsError {
    /// The key of the study that has to change.
    pub fn key(&self) -> &'static str {
        match self {
            RecordsError::Length { .. } => "record.length",
            RecordsError::NoAveraging | RecordsError::Averaging { .. } => "allan.tau",
            RecordsError::Interval { .. } => "noise.switching.interval",
            RecordsError::Impossible { key, .. }
            | RecordsError::Several { key }
            | RecordsError::TooSmall { key, .. } => key,
            RecordsError::Nothing => "noise",
            RecordsError::SineTooSlow { .. } => "noise.sine",
            RecordsError::MarkovTooSlow { .. } => "noise.markov",
            RecordsError::ReadoutTooFine { .. } => "noise.readout_lsb",
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            RecordsError::Length { .. } => "take a shorter record, or a longer sample",
            RecordsError::NoAveraging => "give at least one averaging time",
            RecordsError::Averaging { .. } => "leave it out, or take a longer record",
            RecordsError::Interval { .. } => "switch at least once in the record, after one sample or more",
            RecordsError::Impossible { .. } => {
                "give a finite number that is not negative, and times, frequencies and samples above 0"
            }
            RecordsError::Several { .. } => "leave one of them out",
            RecordsError::Nothing => "give at least one noise that is not 0",
            RecordsError::TooSmall { .. } => {
                "make it larger, or 0; or what is large beside it smaller, or the record shorter"
            }
            RecordsError::SineTooSlow { .. } => "take another frequency, or a rate ramp in its place",
            RecordsError::MarkovTooSlow { .. } => "take a rate random walk in its place",
            RecordsError::ReadoutTooFine { .. } => {
                "leave readout_lsb out if pulses as fine as this change nothing; or take a shorter record"
            }
        }
    }
}
