//! The noise of a gyro: its coefficients, its lock-in, its keys and their reading.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use toml::de::DeTable;

use crate::key::document::{SpanMap, Table, check};
use crate::key::sweep::{self, Sweep, SweepTarget};
use crate::key::{Key, ParseContext, ValueType, docs, keys, measure};
use sagnac_base::diagnostics::{Fault, StudyError, Text, Wrong};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity, round_12};
use sagnac_base::text_file::{InputFiles, MAX_TOML, read_text};
use sagnac_theory::allan::{Difference, Part, Process, Term, flicker};
use sagnac_theory::drift::{self, Magnetic};
use sagnac_theory::lock_in::{self, MIN_SPREAD, Premise, dither_rate};

/// Coefficients of terms, with readout and switching; 0 means absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Coefficient and shape of each term in ″ and s, in the order of [`Term::EVERY`]; `None` for an absent term.
    terms: [Option<[f64; 2]>; Term::EVERY.len()],
    /// Lock-in of a dithered gyro, which adds to the angle random walk.
    pub lock_in: Option<LockIn>,
    /// Angle of a pulse where whole pulses are read, ″.
    pub readout_lsb: f64,
    /// Switching, of a gyro that switches modes.
    pub switching: Option<Switching>,
}

/// A gyro that switches modes from the start of the record; 0 means absent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Switching {
    /// Requested interval, s; records switch after the nearest whole number of samples.
    pub interval_s: f64,
    /// Magnetic drift A, ″/s.
    pub magnetic: f64,
    /// Time constant of the warm-up τ, s; without it, the magnetic drift is A + Ω_m0 from the start.
    pub warm_up_s: Option<f64>,
    /// Initial magnetic drift Ω_m0, ″/s.
    pub initial_magnetic: f64,
    /// Amplitude of the fill residuals D, ″.
    pub residual: f64,
    /// Standard deviation of the noise in fill residuals, ″.
    pub residual_noise: f64,
}

impl Switching {
    /// Whether a switch has no effect.
    pub(crate) fn is_nothing(&self) -> bool {
        [self.magnetic, self.initial_magnetic, self.residual, self.residual_noise].iter().all(|x| *x == 0.0)
    }

    /// Samples of `sample_s` from one switch to the next.
    pub fn interval(&self, sample_s: f64) -> u64 {
        libm::round(self.interval_s / sample_s) as u64
    }

    /// Bound of |Ω_m|, which goes from Ω_m0 to A + Ω_m0, ″/s.
    fn largest_rate(&self) -> f64 {
        self.initial_magnetic.abs().max((self.magnetic + self.initial_magnetic).abs())
    }

    /// Rms of the fill residual of a switch, D sin φ plus noise, ″.
    fn residual_rms(&self) -> f64 {
        libm::sqrt(0.5 * self.residual * self.residual + self.residual_noise * self.residual_noise)
    }

    /// N² of the residuals of all switches, ″²/s.
    pub fn residual_density(&self) -> f64 {
        let rms = self.residual_rms();
        if self.interval_s > 0.0 { rms * rms / self.interval_s } else { 0.0 }
    }

    /// A, τ and Ω_m0; without a warm-up all of it is in Ω_m0.
    fn drift(&self) -> Magnetic {
        match self.warm_up_s {
            Some(time_s) => Magnetic { amplitude: self.magnetic, time_s, initial: self.initial_magnetic },
            None => Magnetic { amplitude: 0.0, time_s: 1.0, initial: self.magnetic + self.initial_magnetic },
        }
    }
}

impl Noise {
    /// Coefficient and shape of a term; 0 where the term is absent. The angle random walk includes that of lock-in, from
    /// which it is independent, in quadrature.
    pub fn of(&self, term: Term) -> [f64; 2] {
        let [size, shape] = self.given(term);
        match self.lock_in {
            Some(lock_in) if term == Term::AngleRandomWalk => {
                [round_12(libm::hypot(size, lock_in.gyro().angle_random_walk())), shape]
            }
            _ => [size, shape],
        }
    }

    /// Coefficient and shape of a term as its own keys give them; 0 where they are absent.
    pub(crate) fn given(&self, term: Term) -> [f64; 2] {
        self.terms[term as usize].unwrap_or_default()
    }

    /// Whether the term is present: a term with a shape by its table, another one by a coefficient other than 0.
    pub fn has(&self, term: Term) -> bool {
        match term.has_shape() {
            true => self.terms[term as usize].is_some(),
            false => self.of(term)[0] != 0.0,
        }
    }

    /// The noise without one of its terms as its own keys give them.
    pub(crate) fn without(&self, term: Term) -> Noise {
        let mut without = self.clone();
        without.terms[term as usize] = None;
        without
    }

    /// Sets the coefficient (0) or the shape (1) of a term, which creates an absent term.
    pub(crate) fn set(&mut self, term: Term, place: usize, value: f64) {
        self.terms[term as usize].get_or_insert_default()[place] = value;
    }

    /// The switches of records with samples of `sample_s`; `None` where they have no effect.
    pub fn switched(&self, sample_s: f64) -> Option<drift::Switching> {
        let switching = self.switching.filter(|switching| !switching.is_nothing())?;
        Some(drift::Switching {
            interval: switching.interval(sample_s),
            magnetic: switching.drift(),
            residual: switching.residual,
            residual_noise: switching.residual_noise,
        })
    }

    /// The process of records of `samples` rates, each `sample_s` long, without readout and switches, for which there
    /// is no [`Part`].
    ///
    /// Records too long for the octaves of flicker get the largest number; they are refused elsewhere.
    pub fn process(&self, sample_s: f64, samples: u64) -> Process {
        let octaves = flicker::octaves(samples).unwrap_or(flicker::MAX_OCTAVES);
        let there = Term::EVERY.into_iter().filter_map(|term| {
            let [size, shape] = self.of(term);
            let shape = if term.has_shape() { shape } else { 1.0 };
            (size != 0.0).then(|| term.of_coefficient(size, shape, octaves))
        });
        // Parts common to all records come last.
        let is_trend = |part: &Part| part.trend(Difference::Second, sample_s, 1).is_some();
        let (trends, random): (Vec<Part>, Vec<Part>) = there.partition(is_trend);
        Process { sample_s, parts: [random, trends].concat() }
    }

    /// The inputs that determine the draws, key by key in base units; absent parts have no line.
    pub(crate) fn canonical(&self) -> String {
        let terms = Term::EVERY.into_iter().filter(|term| self.of(*term)[0] != 0.0).flat_map(|term| {
            // Identities keep the first name of a key, so that earlier results stay.
            let key = match term {
                Term::Quantization => "quantisation",
                _ => term.row().key.trim_start_matches("noise."),
            };
            let [size, of_shape] = self.of(term);
            match term.shape() {
                None => vec![(key.to_owned(), size)],
                Some(shape) => {
                    vec![(format!("{key}.amplitude"), size), (format!("{key}.{}", shape.key), of_shape)]
                }
            }
        });
        let switching = self.switching.filter(|switching| !switching.is_nothing()).unwrap_or_default();
        let warm_up_s = switching.warm_up_s.filter(|_| switching.magnetic != 0.0).unwrap_or(0.0);
        let others = [
            ("readout_lsb", self.readout_lsb),
            ("switching.initial_magnetic", switching.initial_magnetic),
            ("switching.interval", switching.interval_s),
            ("switching.magnetic", switching.magnetic),
            ("switching.residual", switching.residual),
            ("switching.residual_noise", switching.residual_noise),
            ("switching.warm_up_time", warm_up_s),
        ];
        let others = others.map(|(key, value)| (key.to_owned(), value));
        let given = terms.chain(others).filter(|(_, value)| *value != 0.0);
        let mut lines: Vec<String> = given.map(|(key, value)| format!("{key}={value:.11e}\n")).collect();
        lines.sort();
        lines.concat()
    }

    /// The angle, ″, that each part of the rate except the angle random walk can accumulate in a time, with at most one
    /// switch; rms for noise and residuals.
    pub(crate) fn over(&self, time_s: f64) -> Vec<(&'static str, f64)> {
        let turned = |term: Term| (term.row().name[1], (term.row().forms.turned)(self.of(term)[0], time_s));
        let switching = [
            ("alternating drift", self.switching.map_or(0.0, |switching| switching.largest_rate() * time_s)),
            ("fill residuals", self.switching.map_or(0.0, |switching| switching.residual_rms())),
        ];
        let all = Term::EVERY.into_iter().map(turned).chain(switching);
        all.filter(|(_, angle)| *angle != 0.0).collect()
    }
}

/// °/√h of 1 ″/√s.
const DEG_PER_SQRT_H: f64 = 1.0 / 60.0;
/// Least amplitude of the dither, in radians of the beat phase, for which the closed form is taken at all.
const MIN_AMPLITUDE: f64 = 1.0;

/// A gyro whose lock-in becomes angle random walk, as its dither is randomized.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LockIn {
    /// Lock-in threshold Ω_L, ″/s.
    pub threshold: f64,
    /// Scale factor q, ″ per pulse.
    pub scale_factor: f64,
    /// Amplitude of the dither: of its rate, ″/s, or of its angle, ″.
    pub dither_amplitude: f64,
    /// Whether the amplitude is that of the angle.
    pub of_angle: bool,
    /// Dither frequency, Hz.
    pub dither_hz: f64,
}

impl LockIn {
    /// The gyro with the amplitude of its dither as a rate.
    pub fn gyro(&self) -> lock_in::LockIn {
        lock_in::LockIn {
            threshold: self.threshold,
            scale_factor: self.scale_factor,
            dither_rate: match self.of_angle {
                true => dither_rate(self.dither_amplitude, self.dither_hz),
                false => self.dither_amplitude,
            },
            dither_frequency: self.dither_hz,
        }
    }

    /// Refuses a dither that leaves the gyro locked, or that is too small for the closed form to mean anything.
    pub(crate) fn check(&self, places: &SpanMap) -> Result<(), Fault> {
        let gyro = self.gyro();
        let [threshold, rate, theta] =
            [gyro.threshold, gyro.dither_rate, gyro.amplitude()].map(|value| significant(value, 3));
        if gyro.threshold >= gyro.dither_rate {
            let message = format!(
                "noise.lock_in.threshold = {} ″/s is not below the dither rate of {rate} arcsec/s",
                significant(gyro.threshold, 6)
            );
            let help =
                format!("the gyro would stay locked; give a dither_amplitude far above {threshold} arcsec/s");
            let names = ["noise.lock_in.threshold", "noise.lock_in", FILE.name, "noise"];
            return places.refuse(&names, message, "locked", help);
        }
        if gyro.amplitude() < MIN_AMPLITUDE {
            let message = format!("noise.lock_in: the dither turns the beat phase by only {theta} rad");
            let help = "the closed form of N needs 1 rad or more, dither rate / (frequency · scale factor); raise \
                        dither_amplitude, or sample the gyro in a study of kind = \"lock-in\"";
            let names = ["noise.lock_in.dither_amplitude", "noise.lock_in", FILE.name, "noise"];
            return places.refuse(&names, message, "too small", help);
        }
        Ok(())
    }
}

/// A note on the angle random walk by lock-in of some gyros, each at its input rate in ″/s, with the limits of the closed
/// form; `None` for no gyro.
pub(crate) fn note(gyros: impl Iterator<Item = (LockIn, f64)>) -> Option<String> {
    let (mut walks, mut spreads, mut failing) = (vec![], vec![], Vec::<Premise>::new());
    for (lock_in, rate) in gyros {
        let gyro = lock_in.gyro();
        walks.push(DEG_PER_SQRT_H * gyro.angle_random_walk());
        spreads.push(100.0 * MIN_SPREAD / gyro.amplitude());
        // The studies do not say how their dither is randomized: the note states what is presumed.
        for premise in gyro.failing_premises(f64::INFINITY, rate) {
            if !failing.contains(&premise) {
                failing.push(premise);
            }
        }
    }
    let least = walks.iter().copied().reduce(f64::min)?;
    let most = walks.iter().copied().fold(least, f64::max);
    let spread = spreads.into_iter().fold(0.0, f64::max);
    let [least, most, spread] = [least, most, spread].map(|value| significant(value, 3));
    let walk = if least == most { most } else { format!("{least} to {most}") };
    let limits: String =
        failing.iter().map(|premise| format!("; it is inaccurate here: {}", premise.failure())).collect();
    Some(format!(
        "noise.lock_in adds an angle random walk of {walk} °/√h in quadrature, by the closed form for a randomized dither, \
         whose amplitude varies by at least {spread} % from half-cycle to half-cycle{limits}"
    ))
}

/// The keys of what switches leave in a record.
static LEFT_BY_SWITCHES: [&str; 4] =
    [MAGNETIC.name, INITIAL_MAGNETIC.name, RESIDUAL.name, RESIDUAL_NOISE.name];

/// Refuses sweeps over absent parts of any of the `noises` of a study, switches without effect, and a warm-up without a
/// drift.
///
/// # Errors
/// The first such sweep or noise.
pub(crate) fn check_sweeps(noises: &[&Noise], places: &SpanMap, sweeps: &[Sweep]) -> Result<(), Fault> {
    for sweep in sweeps {
        for noise in noises {
            sweep::check_applies(sweep, *noise, &SETTINGS, "[noise]")?;
        }
    }
    let is_swept = |names: &[&str]| sweeps.iter().any(|sweep| names.contains(&sweep.key.name));
    let refuse =
        |names: &[&str], message, label, help| Err(Fault::new(places.written(names), message, label, help));
    for switching in noises.iter().filter_map(|noise| noise.switching) {
        if switching.is_nothing() && !is_swept(&LEFT_BY_SWITCHES) {
            let message = "[noise.switching] has switches without effect";
            let help = "give magnetic = \"14 arcsec/s\", initial_magnetic, residual = \"10 arcsec\" or \
                        residual_noise, not 0; or leave the table out";
            let names = ["noise.switching", FILE.name, "noise"];
            return refuse(&names, message, "no drift and no residual", help);
        }
        let warms_up = switching.warm_up_s.is_some() || is_swept(&[SWITCHING_WARM_UP.name]);
        if warms_up && switching.magnetic == 0.0 && !is_swept(&[MAGNETIC.name]) {
            let message = "noise.switching.warm_up_time is given without magnetic";
            let help = "give magnetic = \"14 arcsec/s\", or leave warm_up_time out: initial_magnetic is there at once";
            let names = [SWITCHING_WARM_UP.name, FILE.name, "noise"];
            return refuse(&names, message, "nothing warms up", help);
        }
    }
    Ok(())
}

const ANGLES: ValueType = measure(&[Dimension::Angle], 0.0, 1e6, "0 to 1e6 arcsec");
const RATES: ValueType = measure(&[Dimension::DriftRate], 0.0, 1e6, "0 to 1e6 deg/h");
const SIGNED_RATES: ValueType = measure(&[Dimension::DriftRate], -1e6, 1e6, "-1e6 to 1e6 deg/h");
const TIMES: ValueType = measure(&[Dimension::Time], 1e-6, 1e9, "1e-6 s to 1e9 s");
const N: ValueType = measure(&[Dimension::AngleRandomWalk], 0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)");
const K: ValueType = measure(&[Dimension::RateRandomWalk], 0.0, 1e9, "0 to 6e10 deg/h/sqrt(h)");
const R: ValueType = measure(&[Dimension::AngularAcceleration], -1e9, 1e9, "-3.6e12 to 3.6e12 deg/h/h");
const SINES: ValueType =
    measure(&[Dimension::Frequency], 1e-9, 1e6, "1e-9 Hz to 1e6 Hz, and at most half the sampling rate");
const THRESHOLDS: ValueType =
    measure(&[Dimension::Rate], 1e-9, 1e6, "1e-9 to 1e6 arcsec/s, and below the dither rate");
const SCALE_FACTORS: ValueType = measure(&[Dimension::ScaleFactor], 1e-6, 1e6, "1e-6 to 1e6 arcsec/pulse");
const DITHERS: ValueType =
    measure(&[Dimension::Rate, Dimension::Angle], 1e-6, 1e9, "1e-6 to 1e9 arcsec/s, or arcsec");
const DITHER_FREQUENCIES: ValueType = measure(&[Dimension::Frequency], 1e-3, 1e6, "1e-3 to 1e6 Hz");

keys! {
    /// Every key of the noise.
    pub(crate) static KEYS;
    /// The noise of the gyro, by the coefficients of IEEE Std 647 and 952; absent parts are 0. `sagnac allan` writes
    /// such tables as noise.toml. A gap-fill study may have it instead of gyro.tick_noise.
    pub NOISE = "noise", "", Fixed, ValueType::Table, "[noise]\nangle_random_walk = \"0.00048 deg/sqrt(h)\"";
    /// Path of a noise.toml, relative to the folder of the study; keys in the study replace those in the file.
    pub FILE = "noise.file", "noise file", Choice, ValueType::File, r#"file = "noise.toml""#;
    /// Quantization noise Q, rms error of the angle: "0.11 arcsec".
    QUANTIZATION = "noise.quantization", "quantization noise Q", Condition, ANGLES, r#"quantization = "0.11 arcsec""#;
    /// Angle of a pulse, if the gyro counts whole pulses: "0.38 arcsec".
    pub READOUT_LSB = "noise.readout_lsb", "pulse weight", Condition, ANGLES, r#"readout_lsb = "0.38 arcsec""#;
    /// Angle random walk N: "0.00048 deg/sqrt(h)".
    ANGLE_RANDOM_WALK = "noise.angle_random_walk", "angle random walk N", Condition, N, r#"angle_random_walk = "0.00048 deg/sqrt(h)""#;
    /// Lock-in of a ring laser gyro with a randomized dither, which adds N = Ω_L √(q/(2πΩ_D)) to angle_random_walk in
    /// quadrature: Ω_L the threshold, q the scale factor, Ω_D the amplitude of the dither's rate.
    pub(crate) LOCK_IN = "noise.lock_in", "", Fixed, ValueType::Table, r#"lock_in = { threshold = "180 arcsec/s", scale_factor = "2 arcsec/pulse", dither_amplitude = "100 deg/s", dither_frequency = "400 Hz" }"#;
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
    MARKOV = "noise.markov", "", Fixed, ValueType::Table, r#"markov = { amplitude = "0.002 deg/h", time = "300 s" }"#;
    /// Rms of the Markov noise: "0.002 deg/h".
    MARKOV_AMPLITUDE = "noise.markov.amplitude", "rms of the Markov noise", Condition, RATES, r#"amplitude = "0.002 deg/h""#, required;
    /// Correlation time: "300 s".
    MARKOV_TIME = "noise.markov.time", "correlation time", Condition, TIMES, r#"time = "300 s""#, required;
    /// A sine of the rate, with a random phase in each record.
    SINE = "noise.sine", "", Fixed, ValueType::Table, r#"sine = { amplitude = "0.01 deg/h", frequency = "0.01 Hz" }"#;
    /// Peak of the sine: "0.01 deg/h".
    SINE_AMPLITUDE = "noise.sine.amplitude", "peak of the sine", Condition, RATES, r#"amplitude = "0.01 deg/h""#, required;
    /// Frequency of the sine: "0.01 Hz".
    SINE_FREQUENCY = "noise.sine.frequency", "frequency of the sine", Condition, SINES, r#"frequency = "0.01 Hz""#, required;
    /// An exponential decay of the rate from the start of the record.
    WARM_UP = "noise.warm_up", "", Fixed, ValueType::Table, r#"warm_up = { amplitude = "0.1 deg/h", time = "20 min" }"#;
    /// Rate of the warm-up at the start: "0.1 deg/h".
    WARM_UP_AMPLITUDE = "noise.warm_up.amplitude", "warm-up", Condition, SIGNED_RATES, r#"amplitude = "0.1 deg/h""#, required;
    /// Time constant: "20 min".
    WARM_UP_TIME = "noise.warm_up.time", "time of the warm-up", Condition, TIMES, r#"time = "20 min""#, required;
    /// Mode switches, the first one interval after the start of the record, and their effects on the angle.
    pub(crate) SWITCHING = "noise.switching", "", Fixed, ValueType::Table, r#"switching = { interval = "40 s", residual = "10 arcsec" }"#;
    /// Time from one switch to the next: "40 s". It is rounded to a whole number of samples.
    pub INTERVAL = "noise.switching.interval", "interval between switches", Choice, TIMES, r#"interval = "40 s""#, required;
    /// Magnetic drift A of a warm gyro, whose sign every switch reverses: "14 arcsec/s".
    pub MAGNETIC = "noise.switching.magnetic", "magnetic drift A", Condition, SIGNED_RATES, r#"magnetic = "14 arcsec/s""#;
    /// Time constant with which A builds up from the start: "50 min". If absent, A is present from the start.
    pub(crate) SWITCHING_WARM_UP = "noise.switching.warm_up_time", "time of the magnetic warm-up", Condition, TIMES, r#"warm_up_time = "50 min""#;
    /// Magnetic drift that is present from the start, to which A is added: "0.1 deg/h".
    pub(crate) INITIAL_MAGNETIC = "noise.switching.initial_magnetic", "magnetic drift Ω_m0 at the start", Condition, SIGNED_RATES, r#"initial_magnetic = "0.1 deg/h""#;
    /// Amplitude D of the residual that the filler leaves at a switch, D sin φ with a random φ at each: "10 arcsec".
    pub RESIDUAL = "noise.switching.residual", "amplitude of fill residuals D", Condition, ANGLES, r#"residual = "10 arcsec""#;
    /// Standard deviation of the additional noise of the residual: "2 arcsec".
    pub(crate) RESIDUAL_NOISE = "noise.switching.residual_noise", "noise of fill residuals", Condition, ANGLES, r#"residual_noise = "2 arcsec""#;
}

/// The setting of the coefficient (0) or the shape (1) of a term. A term with a shape can be swept only where its table
/// is present.
macro_rules! of_term {
    ($key:ident, $term:ident, $place:literal) => {
        SweepTarget::where_it_applies(
            &$key,
            |noise| !Term::$term.has_shape() || noise.has(Term::$term),
            |noise, given| noise.set(Term::$term, $place, given.value),
        )
    };
}

/// The settings of the coefficients; the first key of an absent part creates it.
pub(crate) static SETTINGS: [SweepTarget<Noise>; 22] = [
    of_term!(QUANTIZATION, Quantization, 0),
    SweepTarget::new(&READOUT_LSB, |noise, lsb| noise.readout_lsb = lsb.value),
    of_term!(ANGLE_RANDOM_WALK, AngleRandomWalk, 0),
    SweepTarget::where_it_applies(&LOCK_IN_THRESHOLD, locks_in, |noise, rate| {
        of_lock_in(noise).threshold = rate.value
    }),
    SweepTarget::where_it_applies(&LOCK_IN_SCALE, locks_in, |noise, scale| {
        of_lock_in(noise).scale_factor = scale.value
    }),
    SweepTarget::where_it_applies(&DITHER_AMPLITUDE, locks_in, |noise, amplitude| {
        let lock_in = of_lock_in(noise);
        lock_in.dither_amplitude = amplitude.value;
        lock_in.of_angle = amplitude.dimension == Dimension::Angle;
    }),
    SweepTarget::where_it_applies(&DITHER_FREQUENCY, locks_in, |noise, frequency| {
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
    SweepTarget::where_it_applies(&INTERVAL, switches, |noise, time| {
        of_switching(noise).interval_s = time.value
    }),
    SweepTarget::where_it_applies(&MAGNETIC, switches, |noise, rate| {
        of_switching(noise).magnetic = rate.value
    }),
    SweepTarget::where_it_applies(&SWITCHING_WARM_UP, switches, |noise, time| {
        of_switching(noise).warm_up_s = Some(time.value);
    }),
    SweepTarget::where_it_applies(&INITIAL_MAGNETIC, switches, |noise, rate| {
        of_switching(noise).initial_magnetic = rate.value
    }),
    SweepTarget::where_it_applies(&RESIDUAL, switches, |noise, d| of_switching(noise).residual = d.value),
    SweepTarget::where_it_applies(&RESIDUAL_NOISE, switches, |noise, sigma| {
        of_switching(noise).residual_noise = sigma.value
    }),
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
        let mut keys = SETTINGS.iter().map(|setting| setting.key);
        let key = keys.find(|key| names.iter().any(|name| name == key.name))?;
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

/// The noise of each file of a sweep over files, by the name of the file in the sweep.
pub(crate) type NoiseFiles = Arc<[(String, Noise)]>;

/// The noise of a study, or that of each file of a sweep over files.
pub(crate) fn all<'n>(noise: &'n Noise, files: &'n NoiseFiles) -> Vec<&'n Noise> {
    if files.is_empty() { vec![noise] } else { files.iter().map(|(_, noise)| noise).collect() }
}

/// The noise of each file of a sweep over files, combined with the keys `written` in the study, which take precedence.
///
/// # Errors
/// A file cannot be read, or is no noise.
pub(crate) fn swept_files(
    reading: &mut ParseContext,
    written: &[(&'static SweepTarget<Noise>, Quantity)],
) -> Result<NoiseFiles, Wrong> {
    let mut files = Vec::new();
    for (name, file) in reading.sweep(&FILE).into_iter().flat_map(Sweep::named_files) {
        let (mut noise, notes) = read_file(file.get_ref(), file.span(), reading.files)?;
        reading.notes.extend(notes);
        written.iter().for_each(|(setting, quantity)| (setting.set)(&mut noise, *quantity));
        files.push((name, noise));
    }
    Ok(files.into())
}

/// The noise of a table, with the settings written in addition to a file.
pub(crate) struct WrittenNoise {
    pub(crate) noise: Noise,
    pub(crate) written: Vec<(&'static SweepTarget<Noise>, Quantity)>,
}

/// Reads the noise, including that of a file, and records the place of each key.
pub(crate) fn read(reading: &mut ParseContext) -> Result<WrittenNoise, Wrong> {
    let mut noise = match reading.get(&FILE) {
        Some(file) => {
            let (noise, notes) = read_file(file.text(), file.span(), reading.files)?;
            reading.notes.extend(notes);
            noise
        }
        None => Noise::default(),
    };
    // The table comes before its keys, so that an error about the whole points at it.
    reading.note(&[&NOISE, &FILE, &LOCK_IN, &SWITCHING]);
    let written = reading.set(&mut noise, &SETTINGS)?;
    Ok(WrittenNoise { noise, written })
}

/// Reads the noise file of this name, which is a `[noise]` table by itself; the name is at `span` of the study.
fn read_file(name: &str, span: Range<usize>, files: &InputFiles) -> Result<(Noise, Vec<String>), Wrong> {
    let path = files.path(name);
    let text = files.text(name, MAX_TOML).map_err(|error| {
        let message = format!("cannot read the noise {}: {error}", path.display());
        let help = "give the path of a noise.toml, relative to the folder of the study; `sagnac allan` writes such files from records";
        Fault::new(span, message, "named here", help)
    })?;
    let text: Text = Arc::new(NamedSource::new(path.display().to_string(), text.to_string()));
    parse(text.inner()).map_err(|fault| Wrong::Elsewhere(fault.within(&text)))
}

impl Noise {
    /// Reads a noise.toml by itself, and returns its text too.
    ///
    /// # Errors
    /// The file cannot be read, or is no noise.
    pub fn read(path: &Path) -> Result<(Noise, String), StudyError> {
        let text = read_text(path, MAX_TOML).map_err(|error| {
            let help = "give the path of a noise.toml, as `sagnac allan` writes it from a record";
            StudyError::unreadable("the noise", path, &error, help)
        })?;
        Ok((Noise::parse(&path.display().to_string(), &text)?, text))
    }

    /// Parses the text of a noise.toml, which is called `name` in errors.
    ///
    /// # Errors
    /// The text is no noise.
    pub fn parse(name: &str, text: &str) -> Result<Noise, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        parse(text.inner()).map(|(noise, _)| noise).map_err(|fault| fault.within(&text))
    }
}

/// The noise of a text, with notes on former names.
fn parse(text: &str) -> Result<(Noise, Vec<String>), Fault> {
    let mut root = DeTable::parse(text).map_err(|error| Fault::from_syntax("the noise", &error))?;
    let notes = docs::replace(NOISE.name, root.get_mut());
    let table = Table::root(NOISE.name, &root);
    check(&table, KEYS, &|_, _| None)?;
    if let Some(file) = table.get(&FILE) {
        return Err(file.fault("a noise file names another noise file", "here", "copy its keys instead"));
    }
    let mut noise = Noise::default();
    for setting in &SETTINGS {
        if let Some(given) = table.get(setting.key) {
            (setting.set)(&mut noise, given.quantity()?);
        }
    }
    Ok((noise, notes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_theory::allan::Term;

    /// A gyro that is dithered by 100 °/s.
    const BY_RATE: LockIn = LockIn {
        threshold: 180.0,
        scale_factor: 2.0,
        dither_amplitude: 360_000.0,
        of_angle: false,
        dither_hz: 400.0,
    };

    #[test]
    fn an_amplitude_of_the_angle_is_the_same_dither_as_that_of_its_rate() {
        let by_angle = LockIn {
            dither_amplitude: 360_000.0 / (std::f64::consts::TAU * 400.0),
            of_angle: true,
            ..BY_RATE
        };
        let walks = [BY_RATE, by_angle].map(|lock_in| lock_in.gyro().angle_random_walk());
        assert!((walks[0] - 0.16926).abs() < 1e-5, "{walks:?}");
        assert!((walks[1] / walks[0] - 1.0).abs() < 1e-14, "{walks:?}");
    }

    #[test]
    fn lock_in_adds_to_the_angle_random_walk_in_quadrature() {
        let walk = |noise: &Noise| noise.of(Term::AngleRandomWalk)[0];
        let mut noise = Noise { lock_in: Some(BY_RATE), ..Noise::default() };
        let alone = walk(&noise);
        assert!(
            noise.has(Term::AngleRandomWalk)
                && noise.canonical() == format!("angle_random_walk={alone:.11e}\n")
        );
        noise.set(Term::AngleRandomWalk, 0, 0.2);
        assert!((walk(&noise) - libm::hypot(0.2, alone)).abs() < 1e-12, "{} and {alone}", walk(&noise));
        assert_eq!(noise.given(Term::AngleRandomWalk)[0], 0.2);
        assert_eq!(walk(&noise.without(Term::AngleRandomWalk)), alone);
        noise.lock_in = None;
        assert_eq!(walk(&noise), 0.2);
    }

    #[test]
    fn the_note_has_the_range_of_n_and_the_limits_that_fail() {
        assert_eq!(note(std::iter::empty()), None);
        let half = LockIn { threshold: 90.0, ..BY_RATE };
        let both = note([(BY_RATE, 0.0), (half, 0.0)].into_iter()).unwrap_or_default();
        assert!(
            both.contains("of 0.00141 to 0.00282 °/√h in quadrature") && both.contains("0.667 %"),
            "{both}"
        );
        assert!(!both.contains("inaccurate"), "{both}");
        let fast = note([(BY_RATE, 40_000.0)].into_iter()).unwrap_or_default();
        assert!(fast.contains("inaccurate here: the input rate is above a tenth"), "{fast}");
    }
}
