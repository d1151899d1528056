//! The perimeter loop after a mode switch: its inputs and their keys, for every kind of study that has it.

use serde::Deserialize;
use toml::Spanned;

use crate::kernel::normal::REACH;
use crate::kernel::relock_ticks::MAX_TICKS;
use crate::key::file::relock::{FirstHalf, RelockTable};
use crate::key::scalar::{self, Scalar};
use crate::key::setting::{Key, Setting};
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;
use crate::source::place::Places;

/// Relock after a mode switch; 0 is absent. Detunings are parts of the wavelength. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Relock {
    /// Δλ0.
    pub miss: f64,
    /// Standard deviation.
    pub half_wave_error: f64,
    /// A whole step; the miss is off by up to half of it to either side.
    pub dac_step: f64,
    /// To either side.
    pub hysteresis: f64,
    /// τ_L, s.
    pub loop_s: f64,
    /// f0, Hz.
    pub bias_frequency_hz: f64,
    /// ″.
    pub pulse_weight_arcsec: f64,
    /// χ.
    pub curvature: f64,
    /// Standard deviation as a part of f0.
    pub temperature_error: f64,
    /// Standard deviation.
    pub adc_noise: f64,
    /// A whole step; 0 is exact.
    pub adc_step: f64,
    /// Periods.
    pub count_step: f64,
    /// From the closing of the loop on.
    pub ticks: u32,
    /// Which half of the bias comes first: it gives the sign of what is faked.
    pub first_half: FirstHalf,
    /// A_I/Δλ.
    pub signal_gain: Option<f64>,
}

/// What is taken off the ticks after a switch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compensation {
    /// Nothing.
    #[default]
    None,
    /// From the frequency of the bias, from the second tick on: Z(11).
    Frequency,
    /// From the detuning: Z(13).
    Detuning,
}

impl Compensation {
    /// All of them, as tables list them.
    pub const ALL: [Compensation; 3] = [Compensation::None, Compensation::Frequency, Compensation::Detuning];

    /// As study files and tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Compensation::None => "none",
            Compensation::Frequency => "frequency",
            Compensation::Detuning => "detuning",
        }
    }
}

impl Relock {
    /// The part q^2m of the angle of all ticks ever that comes after the last that is followed.
    pub fn late(&self, tick_s: f64) -> f64 {
        libm::exp(-2.0 * f64::from(self.ticks) * tick_s / self.loop_s)
    }

    /// The angle of all ticks ever, ″: χ f0 Δλ0² (τ_L/2)(1 − q)/(1 + q) of the miss as it should be.
    pub fn whole_angle(&self, tick_s: f64) -> f64 {
        let bias = self.bias_frequency_hz * self.pulse_weight_arcsec;
        0.5 * self.curvature
            * bias
            * self.miss
            * self.miss
            * self.loop_s
            * libm::tanh(0.5 * tick_s / self.loop_s)
    }

    /// The largest |Δλ0| that is drawn.
    pub fn largest_miss(&self) -> f64 {
        self.miss.abs() + REACH * self.half_wave_error + 0.5 * self.dac_step + self.hysteresis
    }

    /// The sign of the faked rotation.
    pub fn sign(&self) -> f64 {
        match self.first_half {
            FirstHalf::Negative => 1.0,
            FirstHalf::Positive => -1.0,
        }
    }

    /// All that determines draws and truth, as lines of a text: not how many ticks are looked at, nor the gain.
    pub fn identity(&self) -> String {
        let Relock { miss, half_wave_error, dac_step, hysteresis, loop_s, bias_frequency_hz, .. } = self;
        let Relock {
            pulse_weight_arcsec, curvature, temperature_error, adc_noise, adc_step, count_step, ..
        } = self;
        format!(
            "miss={miss:.11e}\nhalf_wave_error={half_wave_error:.11e}\ndac_step={dac_step:.11e}\n\
             hysteresis={hysteresis:.11e}\nloop_s={loop_s:.11e}\nbias_frequency_hz={bias_frequency_hz:.11e}\n\
             pulse_weight_arcsec={pulse_weight_arcsec:.11e}\ncurvature={curvature:.11e}\n\
             temperature_error={temperature_error:.11e}\nadc_noise={adc_noise:.11e}\nadc_step={adc_step:.11e}\n\
             count_step={count_step:.11e}\nfirst_half={:?}\n",
            self.first_half
        )
    }
}

/// Declares the setting of a number.
macro_rules! setting {
    ($name:ident, $key:literal, $label:literal, $dimension:ident, $limits:expr, $field:ident) => {
        static $name: Setting<Relock> = Setting {
            key: Key { name: $key, label: $label, accepts: &[Dimension::$dimension], limits: $limits },
            applies: |_| true,
            set: |relock, quantity| relock.$field = quantity.value,
        };
    };
}

const DETUNING: (f64, f64, &str) = (0.0, 1.0, "0 to 1, parts of the wavelength");

setting!(MISS, "relock.miss", "miss Δλ0", Ratio, (-1.0, 1.0, "-1 to 1, parts of the wavelength"), miss);
setting!(HALF_WAVE, "relock.half_wave_error", "error of U_λ/2", Ratio, DETUNING, half_wave_error);
setting!(DAC_STEP, "relock.dac_step", "step of the DAC", Ratio, DETUNING, dac_step);
setting!(HYSTERESIS, "relock.hysteresis", "hysteresis of the piezo", Ratio, DETUNING, hysteresis);
setting!(
    LOOP_TIME,
    "relock.loop_time",
    "time constant of the loop",
    Time,
    (1e-6, 1e3, "1 µs to 1000 s"),
    loop_s
);
setting!(
    BIAS,
    "relock.bias_frequency",
    "frequency of the bias",
    Frequency,
    (1e-3, 1e9, "0.001 Hz to 1e9 Hz"),
    bias_frequency_hz
);
setting!(
    PULSE,
    "relock.pulse_weight",
    "pulse weight",
    Angle,
    (1e-6, 1e6, "1e-6 to 1e6 arcsec"),
    pulse_weight_arcsec
);
setting!(CURVATURE, "relock.curvature", "curvature χ", Ratio, (1e-6, 1e9, "1e-6 to 1e9"), curvature);
setting!(
    TEMPERATURE,
    "relock.temperature_error",
    "error of f0",
    Ratio,
    (0.0, 0.05, "0 to 0.05, or 0 % to 5 %"),
    temperature_error
);
setting!(ADC_NOISE, "relock.adc_noise", "noise of the detuning", Ratio, DETUNING, adc_noise);
setting!(ADC_STEP, "relock.adc_step", "step of the ADC", Ratio, DETUNING, adc_step);
setting!(
    COUNT_STEP,
    "relock.count_step",
    "step of the count",
    Ratio,
    (0.0, 1e6, "0 to 1e6 periods"),
    count_step
);

/// Every key of it that a sweep may vary.
pub(crate) static SETTINGS: [&Setting<Relock>; 12] = [
    &MISS,
    &HALF_WAVE,
    &DAC_STEP,
    &HYSTERESIS,
    &LOOP_TIME,
    &BIAS,
    &PULSE,
    &CURVATURE,
    &TEMPERATURE,
    &ADC_NOISE,
    &ADC_STEP,
    &COUNT_STEP,
];

/// Ticks where none are written: the paper's.
const TICKS: u32 = 4;

/// The relock that is written.
pub(crate) fn read(table: &RelockTable, places: &mut Places) -> Result<Relock, Fault> {
    let mut relock = Relock {
        miss: 0.0,
        half_wave_error: 0.0,
        dac_step: 0.0,
        hysteresis: 0.0,
        loop_s: 0.0,
        bias_frequency_hz: 0.0,
        pulse_weight_arcsec: 0.0,
        curvature: 0.0,
        temperature_error: 0.0,
        adc_noise: 0.0,
        adc_step: 0.0,
        count_step: 1.0,
        ticks: TICKS,
        first_half: table.first_half,
        signal_gain: None,
    };
    let written: [(&Setting<Relock>, Option<&Spanned<Scalar>>); 12] = [
        (&MISS, Some(&table.miss)),
        (&HALF_WAVE, table.half_wave_error.as_ref()),
        (&DAC_STEP, table.dac_step.as_ref()),
        (&HYSTERESIS, table.hysteresis.as_ref()),
        (&LOOP_TIME, Some(&table.loop_time)),
        (&BIAS, Some(&table.bias_frequency)),
        (&PULSE, Some(&table.pulse_weight)),
        (&CURVATURE, Some(&table.curvature)),
        (&TEMPERATURE, table.temperature_error.as_ref()),
        (&ADC_NOISE, table.adc_noise.as_ref()),
        (&ADC_STEP, table.adc_step.as_ref()),
        (&COUNT_STEP, table.count_step.as_ref()),
    ];
    for (setting, value) in written {
        if let Some(value) = value {
            (setting.set)(&mut relock, setting.read(value)?);
            places.add(setting.name, value.span());
        }
    }
    if let Some(ticks) = &table.ticks {
        relock.ticks = scalar::whole("relock.ticks", ticks, 1..=MAX_TICKS as i64)? as u32;
        places.add("relock.ticks", ticks.span());
    }
    if let Some(gain) = &table.signal_gain {
        relock.signal_gain = Some(scalar::ratio("relock.signal_gain", gain)?.value);
    }
    Ok(relock)
}
