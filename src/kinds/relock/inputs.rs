//! The perimeter loop after a mode switch: its inputs and their keys, for every kind of study that has it.

use crate::kernel::normal::REACH;
use crate::kernel::relock_ticks::MAX_TICKS;
use crate::key::holds::{Holds, measure, unlimited, words};
use crate::key::reading::Reading;
use crate::key::row::keys;
use crate::key::setting::Setting;
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;

words! {
    /// Which half-period of the bias a tick begins with.
    pub enum FirstHalf {
        /// The sign of Z(11).
        Negative = "negative",
        /// The opposite sign.
        Positive = "positive",
    }
}

words! {
    /// What is taken off the ticks after a switch.
    pub enum Compensation {
        /// Nothing.
        None = "none",
        /// From the frequency of the bias, from the second tick on: Z(11).
        Frequency = "frequency",
        /// From the detuning: Z(13).
        Detuning = "detuning",
    }
}

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

const MISSES: Holds = measure(&[Dimension::Ratio], -1.0, 1.0, "-1 to 1, parts of the wavelength");
const DETUNINGS: Holds = measure(&[Dimension::Ratio], 0.0, 1.0, "0 to 1, parts of the wavelength");
const TIMES: Holds = measure(&[Dimension::Time], 1e-6, 1e3, "1 µs to 1000 s");
const BIASES: Holds = measure(&[Dimension::Frequency], 1e-3, 1e9, "0.001 Hz to 1e9 Hz");
const PULSES: Holds = measure(&[Dimension::Angle], 1e-6, 1e6, "1e-6 to 1e6 arcsec");
const CURVATURES: Holds = measure(&[Dimension::Ratio], 1e-6, 1e9, "1e-6 to 1e9");
const PARTS: Holds = measure(&[Dimension::Ratio], 0.0, 0.05, "0 to 0.05, or 0 % to 5 %");
const COUNTS: Holds = measure(&[Dimension::Ratio], 0.0, 1e6, "0 to 1e6 periods");

keys! {
    /// The keys of the loop.
    pub(crate) static KEYS;
    /// The perimeter loop after a mode switch: where it starts, and what is measured while it settles. Detunings are parts of the
    /// wavelength, numbers without unit; what is absent is 0.
    pub(crate) RELOCK = "relock", "", Holds::Table, "[relock]\nmiss = 0.05\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40";
    /// Δλ0, the detuning that a switch leaves: 0.05.
    MISS = "relock.miss", "miss Δλ0", MISSES, "miss = 0.05", required;
    /// Error of the half-wave voltage U_λ/2: standard deviation of the miss, normally distributed.
    HALF_WAVE = "relock.half_wave_error", "error of U_λ/2", DETUNINGS, "half_wave_error = 0.005";
    /// Step of the DAC: the miss is evenly spread by half of it to either side.
    DAC_STEP = "relock.dac_step", "step of the DAC", DETUNINGS, "dac_step = 0.002";
    /// Hysteresis of the piezo: the miss is evenly spread by it to either side.
    HYSTERESIS = "relock.hysteresis", "hysteresis of the piezo", DETUNINGS, "hysteresis = 0.005";
    /// τ_L, time constant of the closed loop: "12 ms".
    LOOP_TIME = "relock.loop_time", "time constant of the loop", TIMES, r#"loop_time = "12 ms""#, required;
    /// f0, frequency of the bias at no detuning: "80 kHz".
    BIAS = "relock.bias_frequency", "frequency of the bias", BIASES, r#"bias_frequency = "80 kHz""#, required;
    /// Angle of a period of the beat: "2.6 arcsec".
    PULSE = "relock.pulse_weight", "pulse weight", PULSES, r#"pulse_weight = "2.6 arcsec""#, required;
    /// χ of f = f0 (1 − χΔλ²), Z(2): 40.
    CURVATURE = "relock.curvature", "curvature χ", CURVATURES, "curvature = 40", required;
    /// Error of f0 from its temperature curve, standard deviation as a part of it: "0.1 %".
    TEMPERATURE = "relock.temperature_error", "error of f0", PARTS, r#"temperature_error = "0.1 %""#;
    /// Noise of the mean detuning over half a tick, standard deviation.
    ADC_NOISE = "relock.adc_noise", "noise of the detuning", DETUNINGS, "adc_noise = 0.0001";
    /// Step of the ADC, to which that is rounded.
    ADC_STEP = "relock.adc_step", "step of the ADC", DETUNINGS, "adc_step = 0.0002";
    /// What is counted of the beat in half a tick, in periods: whole ones, 1, if absent; 0 for no rounding.
    COUNT_STEP = "relock.count_step", "step of the count", COUNTS, "count_step = 1";
    /// Ticks from the closing of the loop on, 1 to 8; 4 if absent.
    TICKS = "relock.ticks", "", Holds::Whole(1, MAX_TICKS as i64), "ticks = 4";
    /// Which half-period of the bias a tick begins with; the negative one if absent.
    FIRST_HALF = "relock.first_half", "", Holds::Word(FirstHalf::WORDS), r#"first_half = "negative""#;
}

keys! {
    /// What is only of kind = "relock".
    pub(crate) static SIGNAL_KEYS;
    /// A_I/Δλ of Z(1), 4·a_I·c/Δν, in any unit; a column of its signal.
    SIGNAL_GAIN = "relock.signal_gain", "", unlimited(&[Dimension::Ratio]), "signal_gain = 20";
}

/// What each key sets.
pub(crate) static SETTINGS: [Setting<Relock>; 12] = [
    Setting::new(&MISS, |relock, miss| relock.miss = miss.value),
    Setting::new(&HALF_WAVE, |relock, error| relock.half_wave_error = error.value),
    Setting::new(&DAC_STEP, |relock, step| relock.dac_step = step.value),
    Setting::new(&HYSTERESIS, |relock, hysteresis| relock.hysteresis = hysteresis.value),
    Setting::new(&LOOP_TIME, |relock, time| relock.loop_s = time.value),
    Setting::new(&BIAS, |relock, frequency| relock.bias_frequency_hz = frequency.value),
    Setting::new(&PULSE, |relock, weight| relock.pulse_weight_arcsec = weight.value),
    Setting::new(&CURVATURE, |relock, curvature| relock.curvature = curvature.value),
    Setting::new(&TEMPERATURE, |relock, error| relock.temperature_error = error.value),
    Setting::new(&ADC_NOISE, |relock, noise| relock.adc_noise = noise.value),
    Setting::new(&ADC_STEP, |relock, step| relock.adc_step = step.value),
    Setting::new(&COUNT_STEP, |relock, step| relock.count_step = step.value),
];

/// Ticks where none are written: the paper's.
const PAPER_TICKS: u32 = 4;

/// The relock that is written.
pub(crate) fn read(reading: &mut Reading) -> Result<Relock, Fault> {
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
        ticks: PAPER_TICKS,
        first_half: FirstHalf::of(reading.get(&FIRST_HALF)),
        signal_gain: None,
    };
    reading.set(&mut relock, &SETTINGS)?;
    reading.note(&[&TICKS]);
    if let Some(ticks) = reading.get(&TICKS) {
        relock.ticks = ticks.whole()? as u32;
    }
    if let Some(gain) = reading.get(&SIGNAL_GAIN) {
        relock.signal_gain = Some(gain.quantity()?.value);
    }
    Ok(relock)
}
