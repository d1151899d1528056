//! `[record]`, `[noise]` and `[allan]` as users write them.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::key::file::either::Either;
use crate::key::scalar::Scalar;

/// The record of a gyro at rest.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RecordTable {
    /// From one sample to the next: "1 s".
    #[schemars(with = "String", extend("examples" = ["1 s"]))]
    pub(crate) sample: Spanned<Scalar>,
    /// From the first sample to the last: "9 h". Taken as the nearest whole number of samples.
    #[schemars(with = "String", extend("examples" = ["9 h"]))]
    pub(crate) length: Spanned<Scalar>,
    /// Constant rate, such as the Earth's on the input axis: "10 deg/h". Only a readout in whole pulses sees it.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rate: Option<Spanned<Scalar>>,
}

/// The noise of the gyro, by the coefficients of IEEE Std 647 and 952; what is absent is not there. `sagnac allan` writes
/// such tables as noise.toml.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseTable {
    /// A noise.toml, from the folder of the study; keys beside it replace those in it.
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "String")]
    pub(crate) file: Option<Spanned<String>>,
    /// Quantisation noise Q, rms error of the angle: "0.11 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) quantisation: Option<Spanned<Scalar>>,
    /// Angle of a pulse, where whole pulses are read: "0.38 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) readout_lsb: Option<Spanned<Scalar>>,
    /// N: "0.00048 deg/sqrt(h)".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) angle_random_walk: Option<Spanned<Scalar>>,
    /// B, the flat level over 0.664: "0.00164 deg/h".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) bias_instability: Option<Spanned<Scalar>>,
    /// K: "0.001 deg/h/sqrt(h)".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rate_random_walk: Option<Spanned<Scalar>>,
    /// R: "0.0001 deg/h/h".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rate_ramp: Option<Spanned<Scalar>>,
    #[serde(default)]
    #[schemars(with = "MarkovTable")]
    pub(crate) markov: Option<Spanned<MarkovTable>>,
    #[serde(default)]
    #[schemars(with = "SineTable")]
    pub(crate) sine: Option<Spanned<SineTable>>,
    #[serde(default)]
    #[schemars(with = "WarmUpTable")]
    pub(crate) warm_up: Option<Spanned<WarmUpTable>>,
    #[serde(default)]
    #[schemars(with = "SwitchingNoiseTable")]
    pub(crate) switching: Option<Spanned<SwitchingNoiseTable>>,
}

/// Exponentially correlated noise of the rate.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MarkovTable {
    /// Its rms: "0.002 deg/h".
    #[schemars(with = "String")]
    pub(crate) amplitude: Spanned<Scalar>,
    /// Correlation time: "300 s".
    #[schemars(with = "String")]
    pub(crate) time: Spanned<Scalar>,
}

/// A sine of the rate, with a random phase in each record.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SineTable {
    /// Its peak: "0.01 deg/h".
    #[schemars(with = "String")]
    pub(crate) amplitude: Spanned<Scalar>,
    /// "0.01 Hz".
    #[schemars(with = "String")]
    pub(crate) frequency: Spanned<Scalar>,
}

/// An exponential decay of the rate from the start of the record on.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WarmUpTable {
    /// The rate at the start: "0.1 deg/h".
    #[schemars(with = "String")]
    pub(crate) amplitude: Spanned<Scalar>,
    /// Time constant: "20 min".
    #[schemars(with = "String")]
    pub(crate) time: Spanned<Scalar>,
}

/// A gyro that switches modes, the first time one interval after the start of the record: what that leaves in its angle.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SwitchingNoiseTable {
    /// From one switch to the next: "40 s". Taken as the nearest whole number of samples.
    #[schemars(with = "String", extend("examples" = ["40 s"]))]
    pub(crate) interval: Spanned<Scalar>,
    /// Magnetic drift A of a warm gyro, which turns its sign with every switch: "14 arcsec/s".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) magnetic: Option<Spanned<Scalar>>,
    /// Time constant with which A comes in from the start on: "50 min"; it is there at once if absent.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) warm_up_time: Option<Spanned<Scalar>>,
    /// Magnetic drift at the start, which A adds to: "0.1 deg/h".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) initial_magnetic: Option<Spanned<Scalar>>,
    /// Amplitude D of what the filler leaves at a switch, D sin φ with a random φ at each: "10 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) residual: Option<Spanned<Scalar>>,
    /// Standard deviation of the noise that it leaves beside that: "2 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) residual_noise: Option<Spanned<Scalar>>,
}

/// What is estimated of each record.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AllanTable {
    /// Averaging times: "octave", "decade10", "decade20", or ["1 s", "10 s"]; octave if absent.
    #[serde(default)]
    #[schemars(with = "Either<Vec<String>>", extend("examples" = ["octave"]))]
    pub(crate) tau: Option<Spanned<Either<Vec<Spanned<Scalar>>>>>,
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "EstimatorName")]
    pub(crate) estimator: Option<Spanned<EstimatorName>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Overlap")]
    pub(crate) overlap: Option<Spanned<Overlap>>,
    /// Coefficients fitted to each record: "auto", those of Q, N, B, K, R that it supports; or some of "Q", "N", "B", "K",
    /// "R", "markov", "sine"; none if absent.
    #[serde(default)]
    #[schemars(with = "Either<Vec<String>>", extend("examples" = ["auto"]))]
    pub(crate) fit: Option<Spanned<Either<Vec<Spanned<Scalar>>>>>,
}

/// Which variance is estimated; "overlapping" if absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum EstimatorName {
    /// Allan variance of all second differences.
    Overlapping,
    /// Allan variance of groups side by side.
    NonOverlapping,
    /// Overlapping Hadamard variance, which does not see a ramp.
    Hadamard,
}

/// How many of the overlapping differences are taken; "m/64" if absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
pub(crate) enum Overlap {
    /// All of them.
    #[serde(rename = "full")]
    Full,
    /// 64 in an averaging time, which widens the scatter by less than 0.2 %.
    #[serde(rename = "m/64")]
    Part64,
}
