//! The keys of motions and suspensions, and their reading.

use std::sync::Arc;

use crate::key::document::{SpannedValue, Table};
use crate::key::sweep::{SweepTarget, SweepValue};
use crate::key::{Key, ParseContext, ValueType, keys, measure, unlimited, words};
use crate::motion::{
    self, Acceleration, Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value, Vibration,
};
use sagnac_base::diagnostics::{Fault, Wrong, choices};
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::text_file::MAX_RECORD;
use sagnac_kernel::gap_fill::shape::MAX_TONES;
use sagnac_records::record::Record;
use sagnac_theory::minimum_variance::Band;
use sagnac_theory::vibration::{Mode, NAMES, Psd, Suspension};

words! {
    /// Phase of the rate at the middle of the gap.
    pub enum Phase {
        /// A random phase, different in each trial.
        Uniform = "uniform",
        /// The rate passes through zero.
        ZeroCrossing = "zero-crossing",
        /// The rate is greatest.
        Extremum = "extremum",
    }
}

words! {
    /// The place of the gap in a recorded profile.
    pub enum Position {
        /// A random place.
        Random = "random",
        /// Each tick in turn; the number of trials is rounded up to whole replays.
        Every = "every",
    }
}

words! {
    /// The rate of a recorded profile between its samples.
    pub enum Interpolation {
        /// The rate has no power above half the sampling rate: a windowed sinc.
        BandLimited = "band-limited",
        /// Straight lines from sample to sample.
        Linear = "linear",
    }
}

words! {
    /// The part of a recorded profile from which fillers are designed.
    pub enum Design {
        /// The first half. If a filler is designed from it, all fillers are judged on the second half.
        FirstHalf = "first-half",
        /// The whole record, on which the fillers are judged too.
        Whole = "whole",
    }
}

pub(crate) const RATES: ValueType = measure(&[Dimension::Rate], 0.0, 1e9, "0 to 1e9 arcsec/s");
pub(crate) const AMPLITUDES: ValueType = measure(
    &[Dimension::Rate, Dimension::Angle],
    0.0,
    1e9,
    "0 to 1e9 arcsec/s, or an angle of 0 to 1e9 arcsec",
);
/// Limits of the frequency of a motion, and of the ends of a band from which one is drawn.
pub(crate) const FREQUENCIES: ValueType =
    measure(&[Dimension::Frequency], 1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most 10 times the tick rate");
const ACCELERATIONS: ValueType = measure(&[Dimension::Acceleration], 0.0, 1e6, "0 to 1e6 g");

const ONE_AMPLITUDE: ValueType = ValueType::Either(&[AMPLITUDES, ValueType::OneOf]);
const ONE_FREQUENCY: ValueType = ValueType::Either(&[FREQUENCIES, ValueType::Pair(&FREQUENCIES)]);

keys! {
    /// Every key of the motion.
    pub(crate) static KEYS;
    /// The motion of the base: one tone (amplitude, frequency, phase) or several, Gaussian motion, vibration through
    /// the suspension, or a recorded profile; a constant rate and an angular acceleration can be added.
    pub MOTION = "motion", "", Fixed, ValueType::Table, "[motion]\namplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"";
    /// Amplitude of the rate, "12000 arcsec/s", or of the angle, "90 arcsec"; an amplitude of the angle is multiplied
    /// by 2πν at each point. A table draws the amplitude for each trial.
    pub(crate) AMPLITUDE = "motion.amplitude", "vibration amplitude", Condition, ONE_AMPLITUDE, r#"amplitude = "12000 arcsec/s""#;
    /// Drawn uniformly between two ends: ["8000 arcsec/s", "12000 arcsec/s"].
    UNIFORM = "motion.amplitude.uniform", "", Fixed, ValueType::Pair(&AMPLITUDES), r#"uniform = ["8000 arcsec/s", "12000 arcsec/s"]"#;
    /// Rayleigh-distributed with this scale, the standard deviation of the rate; the phase is then uniform.
    RAYLEIGH = "motion.amplitude.rayleigh", "", Fixed, AMPLITUDES, r#"rayleigh = "8000 arcsec/s""#;
    /// Frequency ν of the vibration, "20 Hz"; or the band from which it is drawn for each trial, ["18 Hz", "22 Hz"].
    pub FREQUENCY = "motion.frequency", "vibration frequency", Condition, ONE_FREQUENCY, r#"frequency = "20 Hz""#;
    /// Phase of the rate at the middle of the gap; uniform if absent.
    pub PHASE = "motion.phase", "", Fixed, ValueType::Word(Phase::WORDS), r#"phase = "uniform""#;
    /// Several tones with independent phases, at most 8, instead of a single one.
    pub TONES = "motion.tones", "", Fixed, ValueType::List(&ValueType::Table), r#"tones = [{ amplitude = "12000 arcsec/s", frequency = "20 Hz" }]"#;
    /// Like motion.amplitude.
    TONE_AMPLITUDE = "motion.tones.amplitude", "", Fixed, ONE_AMPLITUDE, r#"amplitude = "12000 arcsec/s""#, required;
    /// Like motion.amplitude.uniform.
    TONE_UNIFORM = "motion.tones.amplitude.uniform", "", Fixed, ValueType::Pair(&AMPLITUDES), r#"uniform = ["8000 arcsec/s", "12000 arcsec/s"]"#;
    /// Like motion.amplitude.rayleigh.
    TONE_RAYLEIGH = "motion.tones.amplitude.rayleigh", "", Fixed, AMPLITUDES, r#"rayleigh = "8000 arcsec/s""#;
    /// Like motion.frequency.
    TONE_FREQUENCY = "motion.tones.frequency", "", Fixed, ONE_FREQUENCY, r#"frequency = "20 Hz""#, required;
    /// Like motion.phase.
    TONE_PHASE = "motion.tones.phase", "", Fixed, ValueType::Word(Phase::WORDS), r#"phase = "uniform""#;
    /// Stationary Gaussian motion, given by rms and band or by a density.
    pub GAUSSIAN = "motion.gaussian", "", Fixed, ValueType::Table, r#"gaussian = { rms = "8485 arcsec/s", band = ["18 Hz", "22 Hz"] }"#;
    /// Standard deviation of the rate: "8485 arcsec/s".
    pub(crate) GAUSSIAN_RMS = "motion.gaussian.rms", "rms rate", Condition, RATES, r#"rms = "8485 arcsec/s""#;
    /// Band over which the power is spread evenly: ["18 Hz", "22 Hz"].
    pub(crate) GAUSSIAN_BAND = "motion.gaussian.band", "", Fixed, ValueType::Pair(&FREQUENCIES), r#"band = ["18 Hz", "22 Hz"]"#;
    /// One-sided power spectral density of the rate, with straight lines in log–log between its points and nothing
    /// outside: [["1 Hz", "10 (deg/s)^2/Hz"], ["50 Hz", "0.1 (deg/s)^2/Hz"]].
    pub(crate) GAUSSIAN_PSD = "motion.gaussian.psd", "", Fixed, ValueType::List(&ValueType::Pair(&ValueType::Any)), r#"psd = [["1 Hz", "10 (deg/s)^2/Hz"], ["50 Hz", "0.1 (deg/s)^2/Hz"]]"#;
    /// A recorded motion to be replayed.
    pub PROFILE = "motion.profile", "", Fixed, ValueType::Table, r#"profile = { file = "base.csv" }"#;
    /// CSV file with columns of time and rate, whose units stand in brackets in the header; the path is relative to the
    /// study file.
    pub(crate) PROFILE_FILE = "motion.profile.file", "", Fixed, ValueType::File, r#"file = "base.csv""#, required;
    /// Place of the gap in the recorded profile; random if absent.
    pub(crate) POSITION = "motion.profile.position", "", Fixed, ValueType::Word(Position::WORDS), r#"position = "random""#;
    /// Rate between the samples of the recorded profile; band-limited if absent. Take "linear" if the record has jumps.
    pub(crate) INTERPOLATION = "motion.profile.interpolation", "", Fixed, ValueType::Word(Interpolation::WORDS), r#"interpolation = "band-limited""#;
    /// Part of the recorded profile from which minimum-variance fillers without a band are designed; the first half if
    /// absent, and all fillers are then judged on the second half.
    pub(crate) DESIGN = "motion.profile.design", "", Fixed, ValueType::Word(Design::WORDS), r#"design = "whole""#;
    /// Vibration of the base that turns the gyro through its suspension: either a sine or random.
    pub SUSPENSION = "motion.suspension", "", Fixed, ValueType::Table, r#"suspension = { gyro = "LGK-400", sine = { acceleration = "1 g", frequency = "700 Hz" }, alias = true }"#;
    /// Suspension of "LGK-400" or "LGV-1": frequencies as published, Q factors and responses assumed.
    pub GYRO = "motion.suspension.gyro", "gyro", Choice, GYROS, r#"gyro = "LGK-400""#;
    /// Modes of the suspension instead of a name, the useful one first.
    pub(crate) MODES = "motion.suspension.modes", "", Fixed, ValueType::List(&ValueType::Table), r#"modes = [{ frequency = "380 Hz", q = 100, response = "20000 arcsec/s/g" }]"#;
    /// Natural frequency: "380 Hz".
    pub(crate) MODE_FREQUENCY = "motion.suspension.modes.frequency", "", Fixed, MODE_FREQUENCIES, r#"frequency = "380 Hz""#, required;
    /// Q factor, a number.
    pub(crate) MODE_Q = "motion.suspension.modes.q", "", Fixed, QS, "q = 100", required;
    /// Amplitude of the rate per acceleration at resonance, for this mode alone; negative where it turns the other way:
    /// "20000 arcsec/s/g".
    pub(crate) MODE_RESPONSE = "motion.suspension.modes.response", "", Fixed, RESPONSES, r#"response = "20000 arcsec/s/g""#, required;
    /// A sine of random phase.
    pub SINE = "motion.suspension.sine", "", Fixed, ValueType::Table, r#"sine = { acceleration = "1 g", frequency = "700 Hz" }"#;
    /// Amplitude of the acceleration: "1 g".
    pub(crate) SINE_ACCELERATION = "motion.suspension.sine.acceleration", "amplitude of the acceleration", Condition, ACCELERATIONS, r#"acceleration = "1 g""#, required;
    /// Frequency of the vibration: "700 Hz".
    pub(crate) SINE_FREQUENCY = "motion.suspension.sine.frequency", "vibration frequency", Condition, FREQUENCIES, r#"frequency = "700 Hz""#, required;
    /// Stationary Gaussian vibration.
    pub RANDOM = "motion.suspension.random", "", Fixed, ValueType::Table, r#"random = { psd = [["20 Hz", "0.01 g^2/Hz"], ["2000 Hz", "0.01 g^2/Hz"]] }"#;
    /// One-sided power spectral density of the acceleration, with straight lines in log–log between its points and
    /// nothing outside: [["20 Hz", "0.01 g^2/Hz"], ["2000 Hz", "0.01 g^2/Hz"]].
    pub(crate) RANDOM_PSD = "motion.suspension.random.psd", "", Fixed, ValueType::List(&ValueType::Pair(&ValueType::Any)), r#"psd = [["20 Hz", "0.01 g^2/Hz"], ["2000 Hz", "0.01 g^2/Hz"]]"#, required;
    /// Standard deviation to which the density is scaled: "5 g". If absent, the density is used as it is.
    pub(crate) RANDOM_RMS = "motion.suspension.random.rms", "rms acceleration", Condition, ACCELERATIONS, r#"rms = "5 g""#;
    /// Whether resonances and vibration may lie above half the tick rate, so that they appear in the ticks at lower
    /// frequencies.
    pub(crate) ALIAS = "motion.suspension.alias", "", Fixed, ValueType::Flag, "alias = true";
    /// Constant rate added to the motion: "10 deg/s".
    pub RATE = "motion.rate", "constant rate", Condition, measure(&[Dimension::Rate], -1e9, 1e9, "-1e9 to 1e9 arcsec/s"), r#"rate = "10 deg/s""#;
    /// Constant angular acceleration added to the motion; motion.rate is then the rate at the middle of the gap: "100
    /// deg/s^2".
    pub(crate) ACCELERATION = "motion.acceleration", "angular acceleration", Condition, measure(&[Dimension::AngularAcceleration], -1e12, 1e12, "-1e12 to 1e12 arcsec/s^2"), r#"acceleration = "100 deg/s^2""#;
}

keys! {
    /// The ends of bands, which occur only in sweeps.
    pub(crate) static ENDS;
    /// The lower end of the band from which a tone is drawn.
    pub(crate) FREQUENCY_LOW = "motion.frequency.low", "lower frequency", Condition, FREQUENCIES, r#"low = "18 Hz""#;
    /// The upper end of the band from which a tone is drawn.
    pub(crate) FREQUENCY_HIGH = "motion.frequency.high", "upper frequency", Condition, FREQUENCIES, r#"high = "22 Hz""#;
    /// The lower end of the band of Gaussian motion.
    GAUSSIAN_LOW = "motion.gaussian.low", "lower frequency", Condition, FREQUENCIES, r#"low = "18 Hz""#;
    /// The upper end of the band of Gaussian motion.
    GAUSSIAN_HIGH = "motion.gaussian.high", "upper frequency", Condition, FREQUENCIES, r#"high = "22 Hz""#;
}

/// The density of a rate spectrum, whose reader sets the limits.
const RATE_DENSITIES: ValueType = unlimited(&[Dimension::RateDensity]);
pub(crate) const ACCELERATION_DENSITIES: ValueType = unlimited(&[Dimension::AccelerationDensity]);

/// The keys of a tone.
pub(crate) struct ToneKeys {
    pub(crate) amplitude: &'static Key,
    pub(crate) uniform: &'static Key,
    pub(crate) rayleigh: &'static Key,
    pub(crate) frequency: &'static Key,
    pub(crate) phase: &'static Key,
}

/// The keys of a single tone.
const ONE: ToneKeys = ToneKeys {
    amplitude: &AMPLITUDE,
    uniform: &UNIFORM,
    rayleigh: &RAYLEIGH,
    frequency: &FREQUENCY,
    phase: &PHASE,
};

/// The keys of one of several tones.
pub(crate) const OF_SEVERAL: ToneKeys = ToneKeys {
    amplitude: &TONE_AMPLITUDE,
    uniform: &TONE_UNIFORM,
    rayleigh: &TONE_RAYLEIGH,
    frequency: &TONE_FREQUENCY,
    phase: &TONE_PHASE,
};

/// The settings of a motion that can be swept, except the gyro on whose suspension it acts.
pub(crate) static SETTINGS: [SweepTarget<Motion>; 12] = [
    SweepTarget::where_it_applies(
        &AMPLITUDE,
        |motion| matches!(motion.tones[..], [tone] if matches!(tone.amplitude.value, Value::Fixed(_))),
        |motion, new| {
            if let [tone] = &mut motion.tones[..] {
                let of_angle = new.dimension == Dimension::Angle;
                tone.amplitude = Amplitude { of_angle, value: Value::Fixed(new.value) };
            }
        },
    ),
    SweepTarget::where_it_applies(
        &FREQUENCY,
        |motion| matches!(motion.tones[..], [tone] if matches!(tone.frequency, Frequency::Fixed(_))),
        |motion, new| {
            if let [Tone { frequency: Frequency::Fixed(nu), .. }] = &mut motion.tones[..] {
                *nu = new.value;
            }
        },
    ),
    SweepTarget::where_it_applies(&FREQUENCY_LOW, has_drawn_frequency, |motion, low| {
        drawn_frequency(motion).into_iter().for_each(|band| band.low_hz = low.value);
    }),
    SweepTarget::where_it_applies(&FREQUENCY_HIGH, has_drawn_frequency, |motion, high| {
        drawn_frequency(motion).into_iter().for_each(|band| band.high_hz = high.value);
    }),
    SweepTarget::where_it_applies(&GAUSSIAN_RMS, has_gaussian_band, |motion, new| {
        gaussian_band(motion).into_iter().for_each(|(rms, _)| *rms = new.value);
    }),
    SweepTarget::where_it_applies(&GAUSSIAN_LOW, has_gaussian_band, |motion, low| {
        gaussian_band(motion).into_iter().for_each(|(_, band)| band.low_hz = low.value);
    }),
    SweepTarget::where_it_applies(&GAUSSIAN_HIGH, has_gaussian_band, |motion, high| {
        gaussian_band(motion).into_iter().for_each(|(_, band)| band.high_hz = high.value);
    }),
    SweepTarget::new(&RATE, |motion, rate| motion.rate = rate.value),
    SweepTarget::new(&ACCELERATION, |motion, acceleration| motion.acceleration = acceleration.value),
    SweepTarget::where_it_applies(&SINE_ACCELERATION, is_shaken_by_a_sine, |motion, acceleration| {
        if let Some(Acceleration::Sine { amplitude_g, .. }) = acceleration_of(motion) {
            *amplitude_g = acceleration.value;
        }
    }),
    SweepTarget::where_it_applies(&SINE_FREQUENCY, is_shaken_by_a_sine, |motion, frequency| {
        if let Some(Acceleration::Sine { frequency_hz, .. }) = acceleration_of(motion) {
            *frequency_hz = frequency.value;
        }
    }),
    SweepTarget::where_it_applies(
        &RANDOM_RMS,
        |motion| {
            matches!(&motion.vibration, Some(Vibration { acceleration: Acceleration::Random { .. }, .. }))
        },
        |motion, rms| {
            if let Some(Acceleration::Random { rms_g, .. }) = acceleration_of(motion) {
                *rms_g = Some(rms.value);
            }
        },
    ),
];

fn has_drawn_frequency(motion: &Motion) -> bool {
    matches!(motion.tones[..], [tone] if matches!(tone.frequency, Frequency::Band(_)))
}

fn drawn_frequency(motion: &mut Motion) -> Option<&mut Band> {
    match &mut motion.tones[..] {
        [Tone { frequency: Frequency::Band(band), .. }] => Some(band),
        _ => None,
    }
}

fn has_gaussian_band(motion: &Motion) -> bool {
    matches!(motion.gaussian, Some(Gaussian::Band { .. }))
}

fn gaussian_band(motion: &mut Motion) -> Option<(&mut f64, &mut Band)> {
    match &mut motion.gaussian {
        Some(Gaussian::Band { rms, band }) => Some((rms, band)),
        _ => None,
    }
}

fn is_shaken_by_a_sine(motion: &Motion) -> bool {
    matches!(&motion.vibration, Some(Vibration { acceleration: Acceleration::Sine { .. }, .. }))
}

fn acceleration_of(motion: &mut Motion) -> Option<&mut Acceleration> {
    motion.vibration.as_mut().map(|vibration| &mut vibration.acceleration)
}

/// The accepted forms of a motion, for messages.
const FORMS: &str = "accepted: amplitude and frequency; tones = [{ amplitude = …, frequency = … }, …]; gaussian = { rms \
                     = …, band = […] }; profile = { file = … }; suspension = { gyro = …, sine = … }; rate or acceleration";

/// Reads the motion and records the place of each key.
pub(crate) fn read(reading: &mut ParseContext) -> Result<Motion, Wrong> {
    let mut motion = Motion { tones: tones(reading)?, ..Motion::default() };
    reading.note(&[&TONES, &AMPLITUDE, &FREQUENCY, &GAUSSIAN, &PROFILE, &RATE, &ACCELERATION]);
    motion.gaussian = reading.get(&GAUSSIAN).map(|table| gaussian(table, reading)).transpose()?;
    motion.vibration = motion::read(reading)?;
    if let Some(vibration) = &motion.vibration {
        check_beside(&motion, vibration, reading)?;
    }
    if let Some(profile) = reading.get(&PROFILE) {
        if !motion.tones.is_empty() || motion.gaussian.is_some() || motion.vibration.is_some() {
            let message = "motion.profile excludes other vibration, as the record is the whole motion";
            return Err(profile.fault(message, "besides another motion", "leave one of them out").into());
        }
        motion.profile = Some(read_profile(reading)?);
    }
    for (key, to) in [(&RATE, &mut motion.rate), (&ACCELERATION, &mut motion.acceleration)] {
        if let Some(written) = reading.get(key) {
            *to = written.quantity()?.value;
        }
    }
    let written = [&RATE, &ACCELERATION].into_iter().any(|key| reading.get(key).is_some());
    if motion == Motion::default() && !written {
        let message = "[motion] is empty: there is no motion";
        let span = reading.table.span_of(&MOTION).unwrap_or_default();
        let help = format!("{FORMS}; rate = \"0 deg/s\" for none");
        return Err(Fault::new(span, message, "nothing here", help).into());
    }
    Ok(motion)
}

/// Refuses a vibration that conflicts with another part of the motion.
fn check_beside(motion: &Motion, vibration: &Vibration, reading: &ParseContext) -> Result<(), Fault> {
    let message = match vibration.acceleration {
        Acceleration::Random { .. } if motion.gaussian.is_some() => {
            "motion.suspension.random conflicts with motion.gaussian".to_owned()
        }
        Acceleration::Sine { .. } if motion.tones.len() >= MAX_TONES => {
            format!("motion.suspension.sine is one tone more than the {MAX_TONES} that a motion may have")
        }
        _ => return Ok(()),
    };
    let span = reading.table.span_of(motion::KEYS.table).unwrap_or_default();
    Err(Fault::new(span, message, "besides another motion", "leave one of them out"))
}

fn tones(reading: &ParseContext) -> Result<Vec<Tone>, Fault> {
    let single = [&AMPLITUDE, &FREQUENCY, &PHASE].map(|key| reading.get(key));
    if let Some(tones) = reading.get(&TONES) {
        if let Some(single) = single.into_iter().flatten().next() {
            let message = "motion.tones conflicts with the amplitude, frequency or phase of a single tone";
            return Err(single.fault(message, "besides tones", "put it into tones, or leave tones out"));
        }
        let list = tones.items();
        let (message, label) = match list.len() {
            0 => ("motion.tones is empty".to_owned(), "no tones"),
            count if count > MAX_TONES => {
                (format!("motion.tones has {count} tones, more than {MAX_TONES}"), "too many tones")
            }
            _ => {
                let tables = list.iter().filter_map(SpannedValue::table);
                return tables.map(|table| read_tone(&table, &OF_SEVERAL)).collect();
            }
        };
        return Err(tones.fault(message, label, format!("accepted: 1 to {MAX_TONES} tones")));
    }
    match single {
        [Some(_), Some(_), _] => Ok(vec![read_tone(&reading.table, &ONE)?]),
        [Some(only), None, _] => Err(lacking(only, &FREQUENCY)),
        [None, Some(only), _] | [None, None, Some(only)] => Err(lacking(only, &AMPLITUDE)),
        [None, None, None] => Ok(vec![]),
    }
}

fn lacking(only: SpannedValue, key: &Key) -> Fault {
    let message = format!("{} is missing: a tone has an amplitude and a frequency", key.name);
    only.fault(message, "only this one", format!("add for example {}", key.example))
}

fn read_tone(table: &Table, keys: &ToneKeys) -> Result<Tone, Fault> {
    let frequency = table.needed(keys.frequency)?;
    let frequency = match frequency.is_list() {
        true => Frequency::Band(band(frequency)?),
        false => Frequency::Fixed(frequency.quantity()?.value),
    };
    let (quantity, value) = if let Some(ends) = table.get(keys.uniform) {
        let [low, high] = pair(ends)?;
        (low, Value::Uniform([low.value, high.value]))
    } else if let Some(scale) = table.get(keys.rayleigh) {
        let scale = scale.quantity()?;
        (scale, Value::Rayleigh(scale.value))
    } else {
        let amplitude = table.needed(keys.amplitude)?.quantity()?;
        (amplitude, Value::Fixed(amplitude.value))
    };
    let written = table.get(keys.phase);
    let phase = Phase::from_value(written);
    if let (Value::Rayleigh(_), Some(written), true) = (value, written, phase != Phase::Uniform) {
        let message =
            "a Rayleigh-distributed amplitude goes with a random phase: it is narrow-band Gaussian motion";
        let help = "leave the phase out, or draw the amplitude uniformly";
        return Err(written.fault(message, "a fixed phase", help));
    }
    let amplitude = Amplitude { of_angle: quantity.dimension == Dimension::Angle, value };
    Ok(Tone { amplitude, frequency, phase })
}

/// Reads two values, the lower one first.
fn pair(ends: SpannedValue) -> Result<[Quantity; 2], Fault> {
    let name = ends.key.name;
    let items = ends.items().iter().map(SpannedValue::quantity).collect::<Result<Vec<_>, _>>()?;
    let [low, high] = items[..] else {
        return Err(ends.fault(format!("{name} needs two ends"), "not two values", ends.key.example));
    };
    if low.dimension != high.dimension {
        let message = format!("{name} mixes a rate and an angle");
        return Err(ends.fault(message, "two kinds", "write both as rates, or both as angles"));
    }
    if low.value > high.value {
        let message = format!("{name} runs from {low} down to {high}");
        return Err(ends.fault(message, "backwards", "write the lower end first"));
    }
    Ok([low, high])
}

/// Reads a band of frequencies.
pub(crate) fn band(ends: SpannedValue) -> Result<Band, Fault> {
    let [low, high] = pair(ends)?;
    Ok(Band { low_hz: low.value, high_hz: high.value })
}

fn gaussian(table: SpannedValue, reading: &ParseContext) -> Result<Gaussian, Fault> {
    match [&GAUSSIAN_RMS, &GAUSSIAN_BAND, &GAUSSIAN_PSD].map(|key| reading.get(key)) {
        [Some(rms), Some(ends), None] => Ok(Gaussian::Band { rms: rms.quantity()?.value, band: band(ends)? }),
        [None, None, Some(psd)] => Ok(Gaussian::Psd(Arc::new(read_psd(psd, &RATE_DENSITIES)?))),
        _ => {
            let message = "motion.gaussian needs rms and band, or psd";
            let help =
                format!("accepted: {}, or gaussian = {{ {} }}", GAUSSIAN.example, GAUSSIAN_PSD.example);
            Err(table.fault(message, "neither of the two", help))
        }
    }
}

fn read_profile(reading: &ParseContext) -> Result<Profile, Wrong> {
    let file = reading.table.needed(&PROFILE_FILE)?;
    let path = reading.files.path(file.text());
    let text = reading.files.text(file.text(), MAX_RECORD).map_err(|error| {
        let message = format!("cannot read the record {}: {error}", path.display());
        let help = "give the path, from the folder of the study, of a record (CSV, UTF-8) with the columns \
                    `time [s]` and `rate [deg/s]`";
        file.fault(message, "not readable", help)
    })?;
    let record = Record::parse(&path.display().to_string(), &text)?;
    let position = Position::from_value(reading.get(&POSITION));
    let interpolation = Interpolation::from_value(reading.get(&INTERPOLATION));
    let design = Design::from_value(reading.get(&DESIGN));
    Ok(Profile { file: file.text().to_owned(), record: Arc::new(record), position, interpolation, design })
}

/// Reads a density row by row, each a frequency and a value that `densities` accepts.
pub(crate) fn read_psd(written: SpannedValue, densities: &ValueType) -> Result<Psd, Fault> {
    let (rows, key) = (written.items(), written.key.name);
    let mut points: Vec<[f64; 2]> = Vec::new();
    for row in &rows {
        let [frequency, density] = row.items()[..] else { continue };
        let (nu, value) = (frequency.read(&FREQUENCIES)?, density.read(densities)?);
        if value.value <= 0.0 {
            let message = format!("{key} has a density of {value} at {nu}");
            let label = if value.value < 0.0 { "negative" } else { "zero" };
            let help = "accepted: densities above 0; outside the frequencies given there is no motion";
            return Err(density.fault(message, label, help));
        }
        if points.last().is_some_and(|last| last[0] >= nu.value) {
            let message = format!("{key} does not rise at {nu}");
            return Err(frequency.fault(message, "not above the one before", "sort the rows by frequency"));
        }
        points.push([nu.value, value.value]);
    }
    if points.len() < 2 {
        let message = format!("{key} has {} rows", points.len());
        return Err(written.fault(message, "too few", "give two rows or more: the ends of a line each"));
    }
    // Faults that `Psd::new` would find have already been refused with their place.
    Psd::new(points)
        .map_err(|error| written.fault(error.to_string(), "not a spectrum", "sort the rows by frequency"))
}

/// Most modes of a suspension.
const MAX_MODES: usize = 16;

/// The gyros whose suspensions are known.
pub(crate) const GYROS: ValueType = ValueType::Name(&NAMES);
pub(crate) const MODE_FREQUENCIES: ValueType =
    measure(&[Dimension::Frequency], 1e-3, 1e6, "1e-3 Hz to 1e6 Hz");
pub(crate) const QS: ValueType = measure(&[Dimension::Ratio], 0.5, 1e4, "0.5 to 10000");
pub(crate) const RESPONSES: ValueType =
    measure(&[Dimension::RatePerAcceleration], -1e9, 1e9, "-1e9 to 1e9 arcsec/s/g");

/// The keys of a table that describes a suspension.
pub(crate) struct SuspensionKeys {
    pub(crate) table: &'static Key,
    pub(crate) gyro: &'static Key,
    pub(crate) modes: &'static Key,
    /// The frequency, Q factor and response of each mode.
    pub(crate) mode: [&'static Key; 3],
}

impl SuspensionKeys {
    /// Reads the suspension; where only a sweep names suspensions, the first of them.
    pub(crate) fn read(&self, reading: &ParseContext) -> Result<Arc<Suspension>, Fault> {
        let (gyro, modes) = (reading.get(self.gyro), reading.get(self.modes));
        let swept = reading.sweep(self.gyro);
        if let (Some(modes), Some(_)) = (modes, swept) {
            let message = format!("{} conflicts with a sweep over {}", self.modes.name, self.gyro.name);
            return Err(modes.fault(message, "another suspension", "leave one of them out"));
        }
        let suspension = match (gyro, modes, swept.and_then(|sweep| sweep.values.first())) {
            (Some(gyro), None, _) => known(gyro)?,
            (None, Some(modes), _) => Suspension::new(self.read_modes(modes)?),
            (None, None, Some(SweepValue::Name(name))) => {
                Suspension::named(name).unwrap_or(Suspension::new(vec![]))
            }
            _ => {
                let message = format!("{} needs exactly one of gyro, modes", self.table.name);
                let help = format!("accepted: {}, or {}", self.gyro.example, self.modes.example);
                let span = reading.table.span_of(self.table).unwrap_or_default();
                return Err(Fault::new(span, message, "not exactly one", help));
            }
        };
        Ok(Arc::new(suspension))
    }

    /// States that all properties of a named suspension except its frequencies are assumed; `None` where modes are
    /// given.
    pub(crate) fn assumed(&self, reading: &ParseContext) -> Option<String> {
        let names: Vec<String> = match (reading.sweep(self.gyro), reading.get(self.gyro)) {
            (Some(sweep), _) => sweep.values.iter().map(SweepValue::to_string).collect(),
            (None, Some(gyro)) => vec![gyro.text().to_owned()],
            (None, None) => vec![],
        };
        (!names.is_empty()).then(|| {
            format!(
                "Q factors and responses of the suspension of {} are assumed: only the frequencies are published",
                names.join(" and ")
            )
        })
    }

    /// Replaces a suspension by that of the gyro of this name, which a sweep selects.
    pub(crate) fn set(suspension: &mut Arc<Suspension>, name: &str) {
        Suspension::named(name).into_iter().for_each(|named| *suspension = Arc::new(named));
    }

    fn read_modes(&self, modes: SpannedValue) -> Result<Vec<Mode>, Fault> {
        let items = modes.items();
        let count = items.len();
        if !(1..=MAX_MODES).contains(&count) {
            let message = format!("{} has {count} modes", self.modes.name);
            let label = if count == 0 { "no modes" } else { "too many modes" };
            return Err(modes.fault(message, label, format!("accepted: 1 to {MAX_MODES} modes")));
        }
        let mode = |table| {
            let value = |key| crate::key::document::Table::needed(&table, key)?.quantity().map(|q| q.value);
            let [frequency, q, response] = self.mode;
            Ok(Mode { frequency_hz: value(frequency)?, q: value(q)?, response: value(response)? })
        };
        items.iter().filter_map(SpannedValue::table).map(mode).collect()
    }
}

fn known(gyro: SpannedValue) -> Result<Suspension, Fault> {
    Suspension::named(gyro.text()).ok_or_else(|| {
        let message = format!("{}: there is no suspension {gyro}", gyro.key.name);
        let help = format!("{}; or give its modes", choices(gyro.text(), &NAMES));
        gyro.fault(message, "not one of the names", help)
    })
}
