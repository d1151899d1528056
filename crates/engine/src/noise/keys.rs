//! The keys of `[noise]` and of noise.toml, with their settings.

use crate::key::holds::{Holds, measure};
use crate::key::row::{Key, keys};
use crate::key::setting::{self, Setting};
use crate::noise::lock_in::LockIn;
use crate::noise::{Noise, Switching};
use sagnac_base::quantity::units::{Dimension, Quantity};
use sagnac_theory::allan::Term;

const ANGLES: Holds = measure(&[Dimension::Angle], 0.0, 1e6, "0 to 1e6 arcsec");
const RATES: Holds = measure(&[Dimension::DriftRate], 0.0, 1e6, "0 to 1e6 deg/h");
const SIGNED_RATES: Holds = measure(&[Dimension::DriftRate], -1e6, 1e6, "-1e6 to 1e6 deg/h");
const TIMES: Holds = measure(&[Dimension::Time], 1e-6, 1e9, "1e-6 s to 1e9 s");
const N: Holds = measure(&[Dimension::AngleRandomWalk], 0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)");
const K: Holds = measure(&[Dimension::RateRandomWalk], 0.0, 1e9, "0 to 6e10 deg/h/sqrt(h)");
const R: Holds = measure(&[Dimension::AngularAcceleration], -1e9, 1e9, "-3.6e12 to 3.6e12 deg/h/h");
const SINES: Holds =
    measure(&[Dimension::Frequency], 1e-9, 1e6, "1e-9 Hz to 1e6 Hz, and at most half the sampling rate");
const THRESHOLDS: Holds =
    measure(&[Dimension::Rate], 1e-9, 1e6, "1e-9 to 1e6 arcsec/s, and below the dither rate");
const SCALE_FACTORS: Holds = measure(&[Dimension::ScaleFactor], 1e-6, 1e6, "1e-6 to 1e6 arcsec/pulse");
const DITHERS: Holds =
    measure(&[Dimension::Rate, Dimension::Angle], 1e-6, 1e9, "1e-6 to 1e9 arcsec/s, or arcsec");
const DITHER_FREQUENCIES: Holds = measure(&[Dimension::Frequency], 1e-3, 1e6, "1e-3 to 1e6 Hz");

keys! {
    /// Every key of the noise.
    pub(crate) static KEYS;
    /// The noise of the gyro, by the coefficients of IEEE Std 647 and 952; absent parts are 0. `sagnac allan` writes
    /// such tables as noise.toml. A gap-fill study may have it instead of gyro.tick_noise.
    pub NOISE = "noise", "", Fixed, Holds::Table, "[noise]\nangle_random_walk = \"0.00048 deg/sqrt(h)\"";
    /// Path of a noise.toml, relative to the folder of the study; keys in the study replace those in the file.
    pub FILE = "noise.file", "noise file", Choice, Holds::File, r#"file = "noise.toml""#;
    /// Quantization noise Q, rms error of the angle: "0.11 arcsec".
    QUANTIZATION = "noise.quantization", "quantization noise Q", Condition, ANGLES, r#"quantization = "0.11 arcsec""#;
    /// Angle of a pulse, if the gyro counts whole pulses: "0.38 arcsec".
    pub READOUT_LSB = "noise.readout_lsb", "pulse weight", Condition, ANGLES, r#"readout_lsb = "0.38 arcsec""#;
    /// Angle random walk N: "0.00048 deg/sqrt(h)".
    ANGLE_RANDOM_WALK = "noise.angle_random_walk", "angle random walk N", Condition, N, r#"angle_random_walk = "0.00048 deg/sqrt(h)""#;
    /// Lock-in of a ring laser gyro with a randomized dither, which adds N = Ω_L √(q/(2πΩ_D)) to angle_random_walk in
    /// quadrature: Ω_L the threshold, q the scale factor, Ω_D the amplitude of the dither's rate.
    pub LOCK_IN = "noise.lock_in", "", Fixed, Holds::Table, r#"lock_in = { threshold = "180 arcsec/s", scale_factor = "2 arcsec/pulse", dither_amplitude = "100 deg/s", dither_frequency = "400 Hz" }"#;
    /// Lock-in threshold Ω_L, the input rate up to which the gyro is locked without dither: "180 arcsec/s".
    LOCK_IN_THRESHOLD = "noise.lock_in.threshold", "lock-in threshold", Condition, THRESHOLDS, r#"threshold = "180 arcsec/s""#, required;
    /// Angle of one period of the beat: "2 arcsec/pulse".
    LOCK_IN_SCALE = "noise.lock_in.scale_factor", "scale factor", Condition, SCALE_FACTORS, r#"scale_factor = "2 arcsec/pulse""#, required;
    /// Amplitude of the dither, of its rate or of its angle: "100 deg/s" or "2.4 arcmin".
    DITHER_AMPLITUDE = "noise.lock_in.dither_amplitude", "dither amplitude", Condition, DITHERS, r#"dither_amplitude = "100 deg/s""#, required;
    /// Dither frequency, from which the rate of an amplitude of the angle follows: "400 Hz".
    DITHER_FREQUENCY = "noise.lock_in.dither_frequency", "dither frequency", Condition, DITHER_FREQUENCIES, r#"dither_frequency = "400 Hz""#, required;
    /// Bias instability B, the flat level of the curve divided by 0.664: "0.00164 deg/h".
    BIAS_INSTABILITY = "noise.bias_instability", "bias instability B", Condition, RATES, r#"bias_instability = "0.00164 deg/h""#;
    /// Rate random walk K: "0.001 deg/h/sqrt(h)".
    RATE_RANDOM_WALK = "noise.rate_random_walk", "rate random walk K", Condition, K, r#"rate_random_walk = "0.001 deg/h/sqrt(h)""#;
    /// Rate ramp R: "0.0001 deg/h/h".
    RATE_RAMP = "noise.rate_ramp", "rate ramp R", Condition, R, r#"rate_ramp = "0.0001 deg/h/h""#;
    /// Exponentially correlated noise of the rate.
    MARKOV = "noise.markov", "", Fixed, Holds::Table, r#"markov = { amplitude = "0.002 deg/h", time = "300 s" }"#;
    /// Rms of the Markov noise: "0.002 deg/h".
    MARKOV_AMPLITUDE = "noise.markov.amplitude", "rms of the Markov noise", Condition, RATES, r#"amplitude = "0.002 deg/h""#, required;
    /// Correlation time: "300 s".
    MARKOV_TIME = "noise.markov.time", "correlation time", Condition, TIMES, r#"time = "300 s""#, required;
    /// A sine of the rate, with a random phase in each record.
    SINE = "noise.sine", "", Fixed, Holds::Table, r#"sine = { amplitude = "0.01 deg/h", frequency = "0.01 Hz" }"#;
    /// Peak of the sine: "0.01 deg/h".
    SINE_AMPLITUDE = "noise.sine.amplitude", "peak of the sine", Condition, RATES, r#"amplitude = "0.01 deg/h""#, required;
    /// Frequency of the sine: "0.01 Hz".
    SINE_FREQUENCY = "noise.sine.frequency", "frequency of the sine", Condition, SINES, r#"frequency = "0.01 Hz""#, required;
    /// An exponential decay of the rate from the start of the record.
    WARM_UP = "noise.warm_up", "", Fixed, Holds::Table, r#"warm_up = { amplitude = "0.1 deg/h", time = "20 min" }"#;
    /// Rate of the warm-up at the start: "0.1 deg/h".
    WARM_UP_AMPLITUDE = "noise.warm_up.amplitude", "warm-up", Condition, SIGNED_RATES, r#"amplitude = "0.1 deg/h""#, required;
    /// Time constant: "20 min".
    WARM_UP_TIME = "noise.warm_up.time", "time of the warm-up", Condition, TIMES, r#"time = "20 min""#, required;
    /// Mode switches, the first one interval after the start of the record, and their effects on the angle.
    pub SWITCHING = "noise.switching", "", Fixed, Holds::Table, r#"switching = { interval = "40 s", residual = "10 arcsec" }"#;
    /// Time from one switch to the next: "40 s". It is rounded to a whole number of samples.
    pub INTERVAL = "noise.switching.interval", "interval between switches", Choice, TIMES, r#"interval = "40 s""#, required;
    /// Magnetic drift A of a warm gyro, whose sign every switch reverses: "14 arcsec/s".
    pub MAGNETIC = "noise.switching.magnetic", "magnetic drift A", Condition, SIGNED_RATES, r#"magnetic = "14 arcsec/s""#;
    /// Time constant with which A builds up from the start: "50 min". If absent, A is present from the start.
    pub SWITCHING_WARM_UP = "noise.switching.warm_up_time", "time of the magnetic warm-up", Condition, TIMES, r#"warm_up_time = "50 min""#;
    /// Magnetic drift that is present from the start, to which A is added: "0.1 deg/h".
    pub INITIAL_MAGNETIC = "noise.switching.initial_magnetic", "magnetic drift Ω_m0 at the start", Condition, SIGNED_RATES, r#"initial_magnetic = "0.1 deg/h""#;
    /// Amplitude D of the residual that the filler leaves at a switch, D sin φ with a random φ at each: "10 arcsec".
    pub RESIDUAL = "noise.switching.residual", "amplitude of fill residuals D", Condition, ANGLES, r#"residual = "10 arcsec""#;
    /// Standard deviation of the additional noise of the residual: "2 arcsec".
    pub RESIDUAL_NOISE = "noise.switching.residual_noise", "noise of fill residuals", Condition, ANGLES, r#"residual_noise = "2 arcsec""#;
}

/// The setting of the coefficient (0) or the shape (1) of a term. A term with a shape can be swept only where its table
/// is present.
macro_rules! of_term {
    ($key:ident, $term:ident, $place:literal) => {
        Setting::of(
            &$key,
            |noise| !Term::$term.has_shape() || noise.has(Term::$term),
            |noise, given| noise.set(Term::$term, $place, given.value),
        )
    };
}

/// The settings of the coefficients; the first key of an absent part creates it.
pub(crate) static SETTINGS: [Setting<Noise>; 22] = [
    of_term!(QUANTIZATION, Quantization, 0),
    Setting::new(&READOUT_LSB, |noise, lsb| noise.readout_lsb = lsb.value),
    of_term!(ANGLE_RANDOM_WALK, AngleRandomWalk, 0),
    Setting::of(&LOCK_IN_THRESHOLD, locks_in, |noise, rate| of_lock_in(noise).threshold = rate.value),
    Setting::of(&LOCK_IN_SCALE, locks_in, |noise, scale| of_lock_in(noise).scale_factor = scale.value),
    Setting::of(&DITHER_AMPLITUDE, locks_in, |noise, amplitude| {
        let lock_in = of_lock_in(noise);
        lock_in.dither_amplitude = amplitude.value;
        lock_in.of_angle = amplitude.dimension == Dimension::Angle;
    }),
    Setting::of(&DITHER_FREQUENCY, locks_in, |noise, frequency| {
        of_lock_in(noise).dither_hz = frequency.value;
    }),
    of_term!(BIAS_INSTABILITY, BiasInstability, 0),
    of_term!(RATE_RANDOM_WALK, RateRandomWalk, 0),
    of_term!(RATE_RAMP, RateRamp, 0),
    of_term!(MARKOV_AMPLITUDE, Markov, 0),
    of_term!(MARKOV_TIME, Markov, 1),
    of_term!(SINE_AMPLITUDE, Sine, 0),
    of_term!(SINE_FREQUENCY, Sine, 1),
    of_term!(WARM_UP_AMPLITUDE, WarmUp, 0),
    of_term!(WARM_UP_TIME, WarmUp, 1),
    Setting::of(&INTERVAL, switches, |noise, time| of_switching(noise).interval_s = time.value),
    Setting::of(&MAGNETIC, switches, |noise, rate| of_switching(noise).magnetic = rate.value),
    Setting::of(&SWITCHING_WARM_UP, switches, |noise, time| {
        of_switching(noise).warm_up_s = Some(time.value);
    }),
    Setting::of(&INITIAL_MAGNETIC, switches, |noise, rate| of_switching(noise).initial_magnetic = rate.value),
    Setting::of(&RESIDUAL, switches, |noise, d| of_switching(noise).residual = d.value),
    Setting::of(&RESIDUAL_NOISE, switches, |noise, sigma| of_switching(noise).residual_noise = sigma.value),
];

fn locks_in(noise: &Noise) -> bool {
    noise.lock_in.is_some()
}

fn of_lock_in(noise: &mut Noise) -> &mut LockIn {
    noise.lock_in.get_or_insert_default()
}

/// The coefficients of a noise, by the keys that set them.
pub(crate) fn coefficient_values(noise: &Noise) -> Vec<(&'static Key, Quantity)> {
    let coefficient = |term: Term| {
        let key = term.row().key;
        let names = [key.to_owned(), format!("{key}.amplitude")];
        let key = setting::keys(&SETTINGS).find(|key| names.iter().any(|name| name == key.name))?;
        let dimension = key.holds.measured()?.accepts.first()?;
        let [size, _] = noise.given(term);
        Some((key, Quantity::new(size, *dimension)))
    };
    Term::EVERY.into_iter().filter_map(coefficient).collect()
}

/// The values of a noise that a decision may change: the coefficients and those of mode switches, by the keys that set them. What a
/// change of the interval does depends on whether an even number of intervals fits into the times of a study, so that it is none.
pub(crate) fn values(noise: &Noise) -> Vec<(&'static Key, Quantity)> {
    let switching = noise.switching.iter().flat_map(|switching| {
        [
            (&MAGNETIC, switching.magnetic, Dimension::DriftRate),
            (&SWITCHING_WARM_UP, switching.warm_up_s.unwrap_or(0.0), Dimension::Time),
            (&INITIAL_MAGNETIC, switching.initial_magnetic, Dimension::DriftRate),
            (&RESIDUAL, switching.residual, Dimension::Angle),
            (&RESIDUAL_NOISE, switching.residual_noise, Dimension::Angle),
        ]
    });
    let switching = switching.map(|(key, value, dimension)| (key, Quantity::new(value, dimension)));
    coefficient_values(noise).into_iter().chain(switching).collect()
}

fn switches(noise: &Noise) -> bool {
    noise.switching.is_some()
}

fn of_switching(noise: &mut Noise) -> &mut Switching {
    noise.switching.get_or_insert_default()
}
