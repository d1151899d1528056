//! `[suspension]` and `[motion.suspension]` as users write them.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::key::file::ValueSchema;
use crate::key::file::motion::Ends;
use crate::key::scalar::Scalar;

/// The suspension of a gyro: one that is known by name, or its modes.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SuspensionTable {
    /// "LGK-400" or "LGV-1": frequencies as published, Q factors and responses assumed.
    #[serde(default)]
    #[schemars(with = "String", extend("examples" = ["LGK-400"]))]
    pub(crate) gyro: Option<Spanned<Scalar>>,
    /// Or its modes, the useful one first.
    #[serde(default)]
    #[schemars(with = "Vec<ModeTable>", length(min = 1, max = 16))]
    pub(crate) modes: Option<Spanned<Vec<Spanned<ModeTable>>>>,
    /// Frequency of the vibration: "380 Hz". Absent where it is swept.
    #[serde(default)]
    #[schemars(with = "String", extend("examples" = ["380 Hz"]))]
    pub(crate) frequency: Option<Spanned<Scalar>>,
}

/// A mode, a second-order resonance.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModeTable {
    /// Natural frequency: "380 Hz".
    #[schemars(with = "String", extend("examples" = ["380 Hz"]))]
    pub(crate) frequency: Spanned<Scalar>,
    /// Q factor, a number.
    #[schemars(with = "ValueSchema", extend("examples" = [100]))]
    pub(crate) q: Spanned<Scalar>,
    /// Amplitude of the rate per acceleration at resonance, of this mode alone; negative where it turns the other way:
    /// "20000 arcsec/s/g".
    #[schemars(with = "String", extend("examples" = ["20000 arcsec/s/g"]))]
    pub(crate) response: Spanned<Scalar>,
}

/// Vibration of the base through the suspension of the gyro: a sine or random, and only one of them.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct VibrationTable {
    /// As suspension.gyro.
    #[serde(default)]
    #[schemars(with = "String", extend("examples" = ["LGK-400"]))]
    pub(crate) gyro: Option<Spanned<Scalar>>,
    /// As suspension.modes.
    #[serde(default)]
    #[schemars(with = "Vec<ModeTable>", length(min = 1, max = 16))]
    pub(crate) modes: Option<Spanned<Vec<Spanned<ModeTable>>>>,
    /// A sine of random phase.
    #[serde(default)]
    #[schemars(with = "VibrationSineTable")]
    pub(crate) sine: Option<Spanned<VibrationSineTable>>,
    /// Stationary Gaussian vibration.
    #[serde(default)]
    #[schemars(with = "VibrationRandomTable")]
    pub(crate) random: Option<Spanned<VibrationRandomTable>>,
    /// Whether resonances and vibration may lie above half the tick rate, and so show in the ticks at lower frequencies.
    // Else the schema would give null, which TOML does not have, as the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "bool")]
    pub(crate) alias: Option<Spanned<bool>>,
}

/// A sine of the acceleration.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct VibrationSineTable {
    /// Amplitude: "1 g".
    #[schemars(with = "String", extend("examples" = ["1 g"]))]
    pub(crate) acceleration: Spanned<Scalar>,
    /// "700 Hz".
    #[schemars(with = "String", extend("examples" = ["700 Hz"]))]
    pub(crate) frequency: Spanned<Scalar>,
}

/// A random acceleration.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct VibrationRandomTable {
    /// One-sided power spectral density of the acceleration, straight lines in log–log between its points and nothing
    /// outside: [["20 Hz", "0.01 g^2/Hz"], ["2000 Hz", "0.01 g^2/Hz"]].
    #[schemars(with = "Vec<[String; 2]>")]
    pub(crate) psd: Spanned<Vec<Spanned<Ends>>>,
    /// Standard deviation that the density is scaled to: "5 g". The area under it if absent.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rms: Option<Spanned<Scalar>>,
}
