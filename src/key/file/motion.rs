//! `[motion]` as users write it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::key::file::either::Either;
use crate::key::file::suspension::VibrationTable;
use crate::key::scalar::Scalar;

/// Two ends, the lower one first.
pub(crate) type Ends = Vec<Spanned<Scalar>>;

/// The motion of the base: one tone (amplitude, frequency, phase) or several, Gaussian motion, vibration
/// through the suspension, or a recorded profile; a constant rate and an angular acceleration on top.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MotionTable {
    /// Amplitude of the rate, "12000 arcsec/s", or of the angle, "90 arcsec", then times 2πν at each point; or drawn for
    /// each trial.
    #[serde(default)]
    #[schemars(with = "Either<AmplitudeTable>", extend("examples" = ["12000 arcsec/s", "90 arcsec"]))]
    pub(crate) amplitude: Option<Spanned<Either<AmplitudeTable>>>,
    /// Frequency ν of the vibration, "20 Hz"; or the band it is drawn from for each trial, ["18 Hz", "22 Hz"].
    #[serde(default)]
    #[schemars(with = "Either<Vec<String>>", extend("examples" = ["20 Hz"]))]
    pub(crate) frequency: Option<Spanned<Either<Ends>>>,
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Phase")]
    pub(crate) phase: Option<Spanned<Phase>>,
    /// Several tones of independent phases, at most 8, instead of one.
    #[serde(default)]
    #[schemars(with = "Vec<ToneTable>")]
    pub(crate) tones: Option<Spanned<Vec<Spanned<ToneTable>>>>,
    /// Stationary Gaussian motion.
    #[serde(default)]
    #[schemars(with = "GaussianTable")]
    pub(crate) gaussian: Option<Spanned<GaussianTable>>,
    /// A recorded motion that is replayed.
    #[serde(default)]
    #[schemars(with = "ProfileTable")]
    pub(crate) profile: Option<Spanned<ProfileTable>>,
    /// Vibration of the base, as the gyro turns under it on its suspension.
    #[serde(default)]
    #[schemars(with = "VibrationTable")]
    pub(crate) suspension: Option<Spanned<VibrationTable>>,
    /// Constant rate on top: "10 deg/s".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rate: Option<Spanned<Scalar>>,
    /// Constant angular acceleration on top, the rate being meant at the middle of the gap: "100 deg/s^2".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) acceleration: Option<Spanned<Scalar>>,
}

/// One tone of several.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToneTable {
    /// As motion.amplitude.
    #[schemars(with = "Either<AmplitudeTable>")]
    pub(crate) amplitude: Spanned<Either<AmplitudeTable>>,
    /// As motion.frequency.
    #[schemars(with = "Either<Vec<String>>")]
    pub(crate) frequency: Spanned<Either<Ends>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Phase")]
    pub(crate) phase: Option<Spanned<Phase>>,
}

/// An amplitude that is drawn for each trial, in one of two ways.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub(crate) struct AmplitudeTable {
    /// Evenly between two ends: ["8000 arcsec/s", "12000 arcsec/s"].
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub(crate) uniform: Option<Spanned<Ends>>,
    /// Rayleigh-distributed with this scale, the standard deviation of the rate; the phase is then uniform.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rayleigh: Option<Spanned<Scalar>>,
}

/// Phase of the rate at the middle of the gap.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Random, another in each trial.
    #[default]
    Uniform,
    /// The rate passes through zero.
    ZeroCrossing,
    /// The rate is greatest.
    Extremum,
}

/// Stationary Gaussian motion: of rms and band, or of a density.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GaussianTable {
    /// Standard deviation of the rate: "8485 arcsec/s".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rms: Option<Spanned<Scalar>>,
    /// Band over which it is spread evenly: ["18 Hz", "22 Hz"].
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub(crate) band: Option<Spanned<Ends>>,
    /// One-sided power spectral density of the rate, straight lines in log–log between its points and nothing outside:
    /// [["1 Hz", "10 (deg/s)^2/Hz"], ["50 Hz", "0.1 (deg/s)^2/Hz"]].
    #[serde(default)]
    #[schemars(with = "Vec<[String; 2]>")]
    pub(crate) psd: Option<Spanned<Vec<Spanned<Ends>>>>,
}

/// A recorded motion.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProfileTable {
    /// CSV file with columns of time and rate, their units in brackets in the header; beside the study file.
    #[schemars(with = "String")]
    pub(crate) file: Spanned<String>,
    #[serde(default)]
    pub(crate) position: Position,
}

/// Where in a recorded profile the gap falls.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Position {
    /// Anywhere, at random.
    #[default]
    Random,
    /// At every tick in turn; the trials are rounded up to whole replays.
    Every,
}
