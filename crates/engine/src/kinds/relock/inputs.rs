//! The path-length control loop after a mode switch: its inputs and their keys, for every kind of study that uses it.

use crate::key::row::{Holds, Reading, keys, measure, unlimited, words};
use crate::key::sweep::Setting;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::Fault;
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock_ticks::MAX_TICKS;

words! {
    /// The half-period of the bias at the beginning of a tick.
    pub enum FirstHalf {
        /// The sign of Z(11).
        Negative = "negative",
        /// The opposite sign.
        Positive = "positive",
    }
}

words! {
    /// The compensation of the ticks after a switch.
    pub enum Compensation {
        /// No compensation.
        None = "none",
        /// Compensation by the frequency of the bias, from the second tick on: Z(11).
        Frequency = "frequency",
        /// Compensation by the detuning: Z(13).
        Detuning = "detuning",
    }
}

/// Relock after a mode switch; 0 means absent. Detunings are fractions of the wavelength. Every number has 12
/// significant digits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Relock {
    /// Nominal miss Δλ0.
    pub miss: f64,
    /// Standard deviation of the initial detuning due to the half-wave voltage.
    pub half_wave_error: f64,
    /// Step of the DAC; the initial detuning is off by up to half of it to either side.
    pub dac_step: f64,
    /// Hysteresis to either side.
    pub hysteresis: f64,
    /// Time constant of the loop τ_L, s.
    pub loop_s: f64,
    /// Bias frequency f0, Hz.
    pub bias_frequency_hz: f64,
    /// Pulse weight, ″.
    pub pulse_weight_arcsec: f64,
    /// Curvature χ.
    pub curvature: f64,
    /// Standard deviation of the relative error of f0.
    pub temperature_error: f64,
    /// Standard deviation of the noise of the detuning.
    pub adc_noise: f64,
    /// Step of the ADC; 0 means exact.
    pub adc_step: f64,
    /// Step of the count, in periods.
    pub count_step: f64,
    /// Number of ticks followed after the loop closes.
    pub ticks: u32,
    /// Half-period of the bias that comes first, which determines the sign of the apparent rotation.
    pub first_half: FirstHalf,
    /// Gain of the detuning signal A_I/Δλ.
    pub signal_gain: Option<f64>,
}

impl Relock {
    /// The fraction q^2m of the angle of infinitely many ticks that comes after the last one followed.
    pub fn late(&self, tick_s: f64) -> f64 {
        libm::exp(-2.0 * f64::from(self.ticks) * tick_s / self.loop_s)
    }

    /// The angle of infinitely many ticks for the nominal initial detuning, ″: χ f0 Δλ0² (τ_L/2)(1 − q)/(1 + q).
    pub fn whole_angle(&self, tick_s: f64) -> f64 {
        let bias = self.bias_frequency_hz * self.pulse_weight_arcsec;
        0.5 * self.curvature
            * bias
            * self.miss
            * self.miss
            * self.loop_s
            * libm::tanh(0.5 * tick_s / self.loop_s)
    }

    /// Bound of the drawn |Δλ0|.
    pub fn largest_miss(&self) -> f64 {
        self.miss.abs() + REACH * self.half_wave_error + 0.5 * self.dac_step + self.hysteresis
    }

    /// The sign of the apparent rotation.
    pub fn sign(&self) -> f64 {
        match self.first_half {
            FirstHalf::Negative => 1.0,
            FirstHalf::Positive => -1.0,
        }
    }

    /// Everything that determines draws and truth, as lines of text, without the number of ticks followed and the gain.
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

const MISSES: Holds = measure(&[Dimension::Ratio], -1.0, 1.0, "-1 to 1, in fractions of the wavelength");
const DETUNINGS: Holds = measure(&[Dimension::Ratio], 0.0, 1.0, "0 to 1, in fractions of the wavelength");
const TIMES: Holds = measure(&[Dimension::Time], 1e-6, 1e3, "1 µs to 1000 s");
const BIASES: Holds = measure(&[Dimension::Frequency], 1e-3, 1e9, "0.001 Hz to 1e9 Hz");
const PULSES: Holds = measure(&[Dimension::Angle], 1e-6, 1e6, "1e-6 to 1e6 arcsec");
const CURVATURES: Holds = measure(&[Dimension::Ratio], 1e-6, 1e9, "1e-6 to 1e9");
const PARTS: Holds = measure(&[Dimension::Ratio], 0.0, 0.05, "0 to 0.05, or 0 % to 5 %");
const COUNTS: Holds = measure(&[Dimension::Ratio], 0.0, 1e6, "0 to 1e6 periods");

keys! {
    /// The keys of the loop.
    pub(crate) static KEYS;
    /// The path-length control loop after a mode switch: its initial detuning, and the measurements made while it settles.
    /// Detunings are fractions of the wavelength, without unit; absent values are 0.
    pub RELOCK = "relock", "", Fixed, Holds::Table, "[relock]\nmiss = 0.05\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40";
    /// Detuning Δλ0 left by a switch: 0.05.
    MISS = "relock.initial_detuning", "initial detuning Δλ0", Choice, MISSES, "initial_detuning = 0.05", required;
    /// Error of the half-wave voltage U_λ/2: standard deviation of the initial detuning, normally distributed.
    HALF_WAVE = "relock.half_wave_error", "error of U_λ/2", Choice, DETUNINGS, "half_wave_error = 0.005";
    /// Step of the DAC: the initial detuning is uniformly distributed over half a step to either side.
    DAC_STEP = "relock.dac_step", "step of the DAC", Choice, DETUNINGS, "dac_step = 0.002";
    /// Hysteresis of the piezo: the initial detuning is uniformly distributed over this value to either side.
    HYSTERESIS = "relock.hysteresis", "hysteresis of the piezo", Choice, DETUNINGS, "hysteresis = 0.005";
    /// Time constant τ_L of the closed loop: "12 ms".
    LOOP_TIME = "relock.loop_time", "time constant of the loop", Choice, TIMES, r#"loop_time = "12 ms""#, required;
    /// Frequency f0 of the bias at zero detuning: "80 kHz".
    pub BIAS = "relock.bias_frequency", "frequency of the bias", Fixed, BIASES, r#"bias_frequency = "80 kHz""#, required;
    /// Angle of a period of the beat: "2.6 arcsec".
    PULSE = "relock.pulse_weight", "pulse weight", Choice, PULSES, r#"pulse_weight = "2.6 arcsec""#, required;
    /// Curvature χ in f = f0 (1 − χΔλ²), Z(2): 40.
    CURVATURE = "relock.curvature", "curvature χ", Choice, CURVATURES, "curvature = 40", required;
    /// Standard deviation of the error of f0 from its temperature curve, relative to f0: "0.1 %".
    TEMPERATURE = "relock.temperature_error", "error of f0", Choice, PARTS, r#"temperature_error = "0.1 %""#;
    /// Standard deviation of the noise of the mean detuning over half a tick.
    ADC_NOISE = "relock.adc_noise", "noise of the detuning", Condition, DETUNINGS, "adc_noise = 0.0001";
    /// Step of the ADC, to which the mean detuning is rounded.
    ADC_STEP = "relock.adc_step", "step of the ADC", Choice, DETUNINGS, "adc_step = 0.0002";
    /// Step in which the periods of the beat in half a tick are counted. 1 counts whole periods, and 0 does not round;
    /// 1 if absent.
    COUNT_STEP = "relock.count_step", "step of the count", Choice, COUNTS, "count_step = 1";
    /// Number of ticks followed after the loop closes, 1 to 8; 4 if absent.
    TICKS = "relock.ticks", "", Fixed, Holds::Whole(1, MAX_TICKS as i64), "ticks = 4";
    /// Half-period of the bias with which a tick begins; the negative one if absent.
    FIRST_HALF = "relock.first_half", "", Fixed, Holds::Word(FirstHalf::WORDS), r#"first_half = "negative""#;
}

keys! {
    /// The keys that only studies of kind = "relock" have.
    pub(crate) static SIGNAL_KEYS;
    /// Gain A_I/Δλ of Z(1), 4·a_I·c/Δν, in any unit; adds a column with the signal.
    SIGNAL_GAIN = "relock.signal_gain", "", Fixed, unlimited(&[Dimension::Ratio]), "signal_gain = 20";
}

/// The settings of these keys.
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

/// Default number of ticks, as in the paper.
const PAPER_TICKS: u32 = 4;

/// Reads the relock.
pub(crate) fn read(reading: &mut Reading) -> Result<Relock, Fault> {
    let first_half = FirstHalf::of(reading.get(&FIRST_HALF));
    let mut relock = Relock { count_step: 1.0, ticks: PAPER_TICKS, first_half, ..Relock::default() };
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
