//! `[relock]` as users write it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::key::file::ValueSchema;
use crate::key::scalar::Scalar;
use crate::kinds::relock::inputs::Compensation;

/// The perimeter loop after a mode switch: where it starts, and what is measured while it settles. Detunings are parts of the
/// wavelength, numbers without unit; what is absent is 0.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RelockTable {
    /// Δλ0, the detuning that a switch leaves: 0.05.
    #[schemars(with = "ValueSchema", extend("examples" = [0.05]))]
    pub(crate) miss: Spanned<Scalar>,
    /// Error of the half-wave voltage U_λ/2: standard deviation of the miss, normally distributed.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) half_wave_error: Option<Spanned<Scalar>>,
    /// Step of the DAC: the miss is evenly spread by half of it to either side.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) dac_step: Option<Spanned<Scalar>>,
    /// Hysteresis of the piezo: the miss is evenly spread by it to either side.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) hysteresis: Option<Spanned<Scalar>>,
    /// τ_L, time constant of the closed loop: "12 ms".
    #[schemars(with = "String", extend("examples" = ["12 ms"]))]
    pub(crate) loop_time: Spanned<Scalar>,
    /// f0, frequency of the bias at no detuning: "80 kHz".
    #[schemars(with = "String", extend("examples" = ["80 kHz"]))]
    pub(crate) bias_frequency: Spanned<Scalar>,
    /// Angle of a period of the beat: "2.6 arcsec".
    #[schemars(with = "String", extend("examples" = ["2.6 arcsec"]))]
    pub(crate) pulse_weight: Spanned<Scalar>,
    /// χ of f = f0 (1 − χΔλ²), Z(2): 40.
    #[schemars(with = "ValueSchema", extend("examples" = [40]))]
    pub(crate) curvature: Spanned<Scalar>,
    /// Error of f0 from its temperature curve, standard deviation as a part of it: "0.1 %".
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) temperature_error: Option<Spanned<Scalar>>,
    /// Noise of the mean detuning over half a tick, standard deviation.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) adc_noise: Option<Spanned<Scalar>>,
    /// Step of the ADC, to which that is rounded.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) adc_step: Option<Spanned<Scalar>>,
    /// What is counted of the beat in half a tick, in periods: whole ones, 1, if absent; 0 for no rounding.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) count_step: Option<Spanned<Scalar>>,
    /// Ticks from the closing of the loop on, 1 to 8; 4 if absent.
    #[serde(default)]
    #[schemars(with = "i64", range(min = 1, max = 8))]
    pub(crate) ticks: Option<Spanned<Scalar>>,
    #[serde(default)]
    pub(crate) first_half: FirstHalf,
    /// What is taken off the ticks, of kind = "switched-run"; "none" if absent. Kind = "relock" compares all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Compensation")]
    pub(crate) compensation: Option<Spanned<Compensation>>,
    /// A_I/Δλ of Z(1), 4·a_I·c/Δν, in any unit; a column of its signal.
    #[serde(default)]
    #[schemars(with = "ValueSchema")]
    pub(crate) signal_gain: Option<Spanned<Scalar>>,
}

/// Which half-period of the bias a tick begins with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstHalf {
    /// The sign of Z(11).
    #[default]
    Negative,
    /// The opposite sign.
    Positive,
}
