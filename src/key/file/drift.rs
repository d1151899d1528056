//! `[drift]` and `[run]` as users write them.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::key::file::ValueSchema;
use crate::key::scalar::Scalar;

/// The drift of a gyro that switches modes; what is absent is not there. Spreads are standard deviations from run to run,
/// normally distributed.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriftTable {
    /// A = A_qm·A_T, the magnetic drift that comes with the warm-up: "14 arcsec/s".
    #[serde(default)]
    #[schemars(with = "String", extend("examples" = ["14 arcsec/s"]))]
    pub(crate) magnetic: Option<Spanned<Scalar>>,
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) magnetic_spread: Option<Spanned<Scalar>>,
    /// τ, time constant of the warm-up: "3000 s".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) warm_up_time: Option<Spanned<Scalar>>,
    /// As a part of it, its logarithm being normally distributed: "5 %".
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) warm_up_time_spread: Option<Spanned<Scalar>>,
    /// Ω_nm, which does not change its sign: "0.05 arcsec/s".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) non_magnetic: Option<Spanned<Scalar>>,
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) non_magnetic_spread: Option<Spanned<Scalar>>,
    /// Ω_m0, the magnetic drift from the start.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) initial_magnetic: Option<Spanned<Scalar>>,
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) initial_magnetic_spread: Option<Spanned<Scalar>>,
    /// N, of kind = "switched-run": "0.003 deg/sqrt(h)".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) angle_random_walk: Option<Spanned<Scalar>>,
    /// δP_max, the largest error of the angle at a switch: "10 arcsec". Of kind = "switched-run" where no fillers give it: the
    /// amplitude of a residual that is a sine of the phase of the switch.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) residual_max: Option<Spanned<Scalar>>,
}

/// A whole run.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunTable {
    /// t, from switching on: "1 h".
    #[schemars(with = "String", extend("examples" = ["1 h"]))]
    pub(crate) duration: Spanned<Scalar>,
    /// Times at which the angle is wanted besides the end, of kind = "switched-run": ["10 min", "30 min"].
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub(crate) times: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// How many runs are kept as trajectories, of kind = "switched-run"; none if absent.
    #[serde(default)]
    #[schemars(with = "i64", range(min = 0, max = 1000))]
    pub(crate) trajectories: Option<Spanned<Scalar>>,
}
