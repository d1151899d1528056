//! The motion of the base in simulated records: the angle of every sample, in whole numbers.
//!
//! A sample is a function of its number, the number of its record and the key of its point, so it is the same wherever it is made. The
//! angles of all parts are in 2^−32 of the unit of the noise, and their sum is exact.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::NamedSource;
use toml::de::DeTable;

use crate::key::document::{SpanMap, Table, check};
use crate::key::{ParseContext, Unrepresentable, docs};
use crate::motion::filter::Filter;
use crate::motion::keys::{KEYS, MOTION, Phase, Position, read};
use crate::motion::{Frequency, Motion, Profile, Tone, Value, Vibration};
use sagnac_base::diagnostics::{Fault, StudyError, Text, Wrong};
use sagnac_base::quantity::number::significant;
use sagnac_base::text_file::{FolderFiles, InputFiles};
use sagnac_kernel::philox::{Address, Purpose};
use sagnac_kernel::sine::sine;
use sagnac_kernel::word::Scalar;
use sagnac_theory::gap::tick_amplitude;

/// Highest frequency, in sampling rates.
const MAX_RATES: f64 = 10.0;
/// Largest angle of a sample, in its units, whose product with a sine fits 128 bits with room for the sum of all parts.
const MAX_UNITS: f64 = 3.868_562_622_766_813e25; // 2^85
/// 2^64, the units of a phase in a turn.
const TURN: f64 = 18_446_744_073_709_551_616.0;
/// 2^32.
const WORD: f64 = 4_294_967_296.0;

/// log2 of the units of the motion in a unit of the noise, and these units.
pub const MOTION_BITS: u32 = 32;
pub(crate) const MOTION_UNITS: f64 = WORD;

/// The records to which a motion is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// Time from one sample to the next, s.
    pub sample_s: f64,
    /// Number of samples of a record.
    pub count: u64,
    /// Unit of the angle of the noise, ″.
    pub lsb_arcsec: f64,
    /// Key of the point of the records.
    pub key: [u32; 2],
}

/// A motion in whole numbers, for records of the same length and rate.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordMotion {
    samples: Samples,
    tones: Vec<Tone>,
    filter: Option<Filter>,
    profile: Option<Replay>,
    /// Path of the file of the profile, where that of the motion is known.
    file: Option<PathBuf>,
    /// Angle of a sample at the constant rate.
    rate: i128,
    /// Angle through which the acceleration turns in a sample from rest, in 2^−32 units.
    acceleration: i128,
}

/// The angles of the samples of a profile, of which records are parts.
#[derive(Debug, Clone, PartialEq)]
struct Replay {
    angles: Arc<[i128]>,
    position: Position,
}

/// A tone of a record: the rate is `amplitude` · sin(2π(`frequency_hz` · t + `turns`)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnTone {
    /// Amplitude of the rate, ″/s.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the start of the record, turns.
    pub turns: f64,
}

impl RecordMotion {
    /// Reads a motion: the keys of `[motion]` of a study, in such a table or by themselves. `name` is the path of the file that has
    /// the `text`, beside which the files lie that it names.
    ///
    /// # Errors
    /// The text is no motion, or the motion cannot be represented in such samples.
    pub fn parse(name: &str, text: &str, samples: Samples) -> Result<RecordMotion, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        let folder = FolderFiles(Path::new(name).parent().unwrap_or(Path::new("")).to_owned());
        RecordMotion::of_text(text.inner(), &folder, samples).map_err(|wrong| wrong.within(&text))
    }

    fn of_text(text: &str, folder: &FolderFiles, samples: Samples) -> Result<RecordMotion, Wrong> {
        let mut root = DeTable::parse(text).map_err(|error| Fault::from_syntax("the motion", &error))?;
        if !root.get_ref().contains_key(MOTION.name) {
            docs::replace(MOTION.name, root.get_mut());
        }
        let within = Table::root("", &root).get(&MOTION).and_then(|motion| motion.table());
        let table = within.unwrap_or_else(|| Table::root(MOTION.name, &root));
        check(&table, KEYS, &|_, _| None)?;
        let files = InputFiles::new(folder);
        let (places, notes) = (SpanMap::new(&[]), vec![]);
        let mut reading = ParseContext { table, sweeps: &[], files: &files, places, notes, precision: None };
        let mut motion = read(&mut reading)?;
        if let Some(vibration) = motion.vibration.take() {
            check_alias(&vibration, samples.sample_s, &reading.places)?;
            vibration.add_to(&mut motion);
        }
        let refused = |Unrepresentable { key, message, help }: Unrepresentable| {
            Fault::new(reading.places.blame(&[key, "motion"]), message, "not in such samples", help)
        };
        let lowered = RecordMotion::new(&motion, samples).map_err(refused)?;
        let file = motion.profile.map(|profile| files.path(&profile.file));
        Ok(RecordMotion { file, ..lowered })
    }

    /// Lowers a motion, whose vibration is among its tones or its Gaussian motion. Phases, rate and acceleration are those at the start
    /// of a record.
    ///
    /// # Errors
    /// A frequency is too high for the samples, a spectrum too narrow, a profile too short, or a rate too large.
    pub fn new(motion: &Motion, samples: Samples) -> Result<RecordMotion, Unrepresentable> {
        let Samples { sample_s, lsb_arcsec, .. } = samples;
        let unit = lsb_arcsec / WORD;
        for tone in &motion.tones {
            let highest = tone.band().high_hz;
            check_frequency("motion.frequency", highest, sample_s)?;
            let rate = tone.amplitude.value.scale() * tone.rate_factor(highest);
            check_rate("motion.amplitude", rate * RAYLEIGH_REACH, sample_s, unit)?;
        }
        if let Some(gaussian) = &motion.gaussian {
            let key = gaussian.key();
            check_frequency(key, gaussian.frequencies_hz()[1], sample_s)?;
            check_rate(key, libm::sqrt(gaussian.variance()) * GAUSSIAN_REACH, sample_s, unit)?;
        }
        let end_s = sample_s * samples.count as f64;
        let rates = motion.rate.abs() + motion.acceleration.abs() * end_s;
        check_rate("motion.rate", rates, sample_s, unit)?;
        let filter = motion.gaussian.as_ref().map(|gaussian| Filter::new(gaussian, sample_s, unit));
        let profile = motion.profile.as_ref().map(|profile| Replay::new(profile, samples));
        Ok(RecordMotion {
            samples,
            tones: motion.tones.clone(),
            filter: filter.transpose()?.flatten(),
            profile: profile.transpose()?,
            file: None,
            rate: libm::round(motion.rate * sample_s / unit) as i128,
            acceleration: libm::round(0.5 * motion.acceleration * sample_s * sample_s / unit * WORD) as i128,
        })
    }

    /// Lets every record begin where its profile does.
    pub fn start_with_profile(&mut self) {
        if let Some(replay) = &mut self.profile {
            replay.angles = replay.angles.iter().take(self.samples.count as usize).copied().collect();
        }
    }

    /// The angles of the samples of the record `number` from the sample `first` on, each in 2^−32 of the unit of the noise.
    pub fn increments(&self, number: u64, first: u64) -> impl Iterator<Item = i128> {
        let address = Address::new(self.samples.key, number);
        let tones: Vec<Turning> =
            self.drawn(&address).into_iter().map(|tone| Turning::new(tone, self.samples)).collect();
        let start = self.profile.as_ref().map_or(0, |replay| replay.start(&address, self.samples.count));
        let (mut block, mut of_block) = (vec![], None);
        (first..self.samples.count).map(move |sample| {
            let mut angle = self.rate + ((self.acceleration * (2 * i128::from(sample) + 1)) >> 32);
            angle += tones.iter().map(|tone| tone.angle(sample)).sum::<i128>();
            if let Some(filter) = &self.filter {
                let length = filter.block() as u64;
                if of_block != Some(sample / length) {
                    of_block = Some(sample / length);
                    block = filter.angles(&address, sample / length);
                }
                angle += block[(sample % length) as usize];
            }
            if let Some(replay) = &self.profile {
                angle += replay.angles[(start + sample) as usize];
            }
            angle
        })
    }

    /// The path of the file that the [parsed](RecordMotion::parse) text of a motion names.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// A unit of the angles, ″.
    pub fn unit_arcsec(&self) -> f64 {
        self.samples.lsb_arcsec / WORD
    }

    /// The tones of the record `number`.
    pub fn tones(&self, number: u64) -> Vec<DrawnTone> {
        self.drawn(&Address::new(self.samples.key, number))
    }

    fn drawn(&self, address: &Address<Scalar>) -> Vec<DrawnTone> {
        // A word as a number strictly between 0 and 1.
        let fraction = |word: Scalar| (f64::from(word.0) + 0.5) / WORD;
        let draw = |(place, tone): (usize, &Tone)| {
            let phase = address.draw(Purpose::NoiseAfterAndPhase, place / 2)[2 + place % 2];
            let words = address.draw(Purpose::Tone, place);
            let frequency_hz = match tone.frequency {
                Frequency::Fixed(frequency_hz) => frequency_hz,
                Frequency::Band(band) => band.low_hz + (band.high_hz - band.low_hz) * fraction(words[2]),
            };
            let value = match tone.amplitude.value {
                Value::Fixed(value) => value,
                Value::Uniform([low, high]) => low + (high - low) * fraction(words[0]),
                Value::Rayleigh(scale) => scale * libm::sqrt(-2.0 * libm::log(fraction(words[0]))),
            };
            let turns = match tone.phase {
                Phase::Uniform => f64::from(phase.0) / WORD,
                Phase::ZeroCrossing => 0.0,
                Phase::Extremum => 0.25,
            };
            DrawnTone { amplitude: value * tone.rate_factor(frequency_hz), frequency_hz, turns }
        };
        self.tones.iter().enumerate().map(draw).collect()
    }
}

/// Bounds of Rayleigh-distributed amplitudes and of Gaussian motion, in their scales.
const RAYLEIGH_REACH: f64 = 7.0;
const GAUSSIAN_REACH: f64 = 16.0;

/// A tone from sample to sample.
struct Turning {
    /// Angle of a sample at the peak of the rate.
    peak: i128,
    /// Phase in the middle of sample 0, and its change from sample to sample, in 2^−64 turns.
    start: u64,
    step: u64,
}

impl Turning {
    fn new(tone: DrawnTone, samples: Samples) -> Turning {
        let Samples { sample_s, lsb_arcsec, .. } = samples;
        let turns = tone.frequency_hz * sample_s;
        let phase = |turns: f64| libm::round((turns - libm::floor(turns)) * TURN) as u128 as u64;
        let peak = tone.amplitude * tick_amplitude(sample_s, turns) / (lsb_arcsec / WORD);
        Turning {
            peak: libm::round(peak) as i128,
            start: phase(tone.turns).wrapping_add(phase(0.5 * turns)),
            step: phase(turns),
        }
    }

    /// The angle of a sample.
    fn angle(&self, sample: u64) -> i128 {
        let phase = self.start.wrapping_add(self.step.wrapping_mul(sample));
        // To the nearest of 2^32 phases.
        let word = (phase.wrapping_add(1 << 31) >> 32) as u32;
        (self.peak * i128::from(sine(Scalar(word)).0 as i32) + (1 << 29)) >> 30
    }
}

impl Replay {
    fn new(profile: &Profile, samples: Samples) -> Result<Replay, Unrepresentable> {
        let Samples { sample_s, count, lsb_arcsec, .. } = samples;
        let angles = profile.tick_angles(sample_s);
        if (angles.len() as u64) < count {
            let found = format!(
                "the profile lasts for {} samples of {} s, and a record for {count}",
                angles.len(),
                significant(sample_s, 6)
            );
            let help = "take a shorter length, or a longer profile";
            return Err(Unrepresentable::new("motion.profile", found, help));
        }
        let largest = angles.iter().fold(0.0, |largest: f64, angle| largest.max(angle.abs()));
        let unit = lsb_arcsec / WORD;
        check_rate("motion.profile", largest / sample_s, sample_s, unit)?;
        let angles = angles.iter().map(|angle| libm::round(angle / unit) as i128).collect();
        Ok(Replay { angles, position: profile.position })
    }

    /// The sample of the profile at which a record starts.
    fn start(&self, address: &Address<Scalar>, count: u64) -> u64 {
        let places = self.angles.len() as u64 - count + 1;
        match self.position {
            Position::Random => (u64::from(address.draw(Purpose::Position, 0)[0].0) * places) >> 32,
            Position::Every => (u64::from(address.high) << 32 | u64::from(address.low.0)) % places,
        }
    }
}

/// Refuses vibration above half the sampling rate where aliasing is not allowed.
fn check_alias(vibration: &Vibration, sample_s: f64, places: &SpanMap) -> Result<(), Fault> {
    let modes = vibration.suspension.modes().iter().map(|mode| mode.frequency_hz);
    let highest = modes.fold(vibration.highest_hz(), f64::max);
    if vibration.alias || highest * sample_s <= 0.5 {
        return Ok(());
    }
    let [highest, half] = [highest, 0.5 / sample_s].map(|hz| significant(hz, 6));
    let message = format!("motion.suspension reaches {highest} Hz, above {half} Hz, half the sampling rate");
    let help = "add alias = true to motion.suspension: it then shows in the samples at a lower frequency, as in those of a gyro; \
                or take a higher rate";
    Err(Fault::new(places.blame(&["motion.suspension"]), message, "would be aliased", help))
}

fn check_frequency(key: &'static str, highest_hz: f64, sample_s: f64) -> Result<(), Unrepresentable> {
    if highest_hz * sample_s <= MAX_RATES {
        return Ok(());
    }
    let [highest, most] = [highest_hz, MAX_RATES / sample_s].map(|hz| significant(hz, 6));
    let found = format!("{highest} Hz is more than {most} Hz, ten times the sampling rate");
    Err(Unrepresentable::new(key, found, "take a higher rate"))
}

/// Refuses a rate, ″/s, of which a sample has too many units of `unit` ″.
fn check_rate(key: &'static str, rate: f64, sample_s: f64, unit: f64) -> Result<(), Unrepresentable> {
    if rate * sample_s <= MAX_UNITS * unit {
        return Ok(());
    }
    let found = format!("{} arcsec/s is too fast beside such noise", significant(rate, 6));
    Err(Unrepresentable::new(key, found, "take a slower motion, or more noise"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const SAMPLES: Samples = Samples { sample_s: 0.004, count: 40_000, lsb_arcsec: 1e-6, key: [3, 4] };

    fn motion(text: &str) -> RecordMotion {
        RecordMotion::parse("motion.toml", text, SAMPLES)
            .unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
    }

    fn angles(motion: &RecordMotion, number: u64, first: u64) -> Vec<f64> {
        motion.increments(number, first).map(|units| units as f64 * SAMPLES.lsb_arcsec / WORD).collect()
    }

    #[test]
    fn tones_are_the_sines_of_their_truth() {
        let text = "rate = \"3 deg/h\"\nacceleration = \"-2 arcsec/s^2\"\n\
                    tones = [{ amplitude = \"12000 arcsec/s\", frequency = \"20 Hz\", phase = \"extremum\" },\n\
                    { amplitude = { uniform = [\"2 arcsec\", \"4 arcsec\"] }, frequency = [\"0.1 Hz\", \"0.3 Hz\"] },\n\
                    { amplitude = { rayleigh = \"5 arcsec/s\" }, frequency = \"310 Hz\" }]";
        let motion = motion(text);
        for number in [0, 9, 1 << 33] {
            let tones = motion.tones(number);
            assert_eq!((tones[0].frequency_hz, tones[0].turns), (20.0, 0.25));
            assert!((0.1..0.3).contains(&tones[1].frequency_hz), "{tones:?}");
            let of_angle = tones[1].amplitude / (TAU * tones[1].frequency_hz);
            assert!((2.0..4.0).contains(&of_angle), "{tones:?}");
            // Closed form of the integral of the rate.
            let angle = |sample: f64| {
                let t = sample * SAMPLES.sample_s;
                let turned = |tone: &DrawnTone| {
                    let omega = TAU * tone.frequency_hz;
                    let phase = TAU * tone.turns;
                    2.0 * tone.amplitude / omega * (0.5 * omega * t).sin() * (0.5 * omega * t + phase).sin()
                };
                3.0 * t - t * t + tones.iter().map(turned).sum::<f64>()
            };
            let mut sum = 0.0;
            for (sample, found) in angles(&motion, number, 0).into_iter().enumerate() {
                let expected = angle(sample as f64 + 1.0) - angle(sample as f64);
                assert!((found - expected).abs() < 1e-6, "{number} {sample}: {found}, not {expected}");
                sum += found;
            }
            let expected = angle(SAMPLES.count as f64);
            // The sine of the kernel is off by up to 2^−29.5, of 48″ in each sample.
            assert!((sum - expected).abs() < 2e-3, "{number}: {sum}, not {expected}");
        }
        assert_ne!(motion.tones(0), motion.tones(1));
    }

    #[test]
    fn a_sample_is_the_same_wherever_it_is_made() {
        let text = "tones = [{ amplitude = \"90 arcsec\", frequency = \"20 Hz\" }]\n\
                    gaussian = { rms = \"100 arcsec/s\", band = [\"15 Hz\", \"40 Hz\"] }";
        let motion = motion(text);
        let all: Vec<i128> = motion.increments(5, 0).collect();
        assert_eq!(all.len(), 40_000);
        for first in [1, 2047, 2048, 31_337] {
            let found: Vec<i128> = motion.increments(5, first).take(300).collect();
            assert_eq!(found, all[first as usize..][..300], "{first}");
        }
        assert_ne!(motion.increments(6, 0).take(9).collect::<Vec<_>>(), all[..9]);
    }

    /// Mean periodogram of Hann-windowed segments, one-sided, ″²/Hz of increments.
    fn density(angles: &[f64], length: usize, hz: f64) -> f64 {
        let window = |k: usize| (std::f64::consts::PI * (k as f64 + 0.5) / length as f64).sin().powi(2);
        let norm: f64 = (0..length).map(|k| window(k).powi(2)).sum();
        let segments = angles.chunks_exact(length);
        let count = segments.len() as f64;
        let power = |segment: &[f64]| {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, angle) in segment.iter().enumerate() {
                let (sin, cos) = (TAU * hz * SAMPLES.sample_s * k as f64).sin_cos();
                re += angle * window(k) * cos;
                im += angle * window(k) * sin;
            }
            2.0 * SAMPLES.sample_s * (re * re + im * im) / norm
        };
        segments.map(power).sum::<f64>() / count
    }

    #[test]
    fn gaussian_motion_has_the_density_that_is_asked_for() {
        let text =
            "gaussian = { psd = [[\"10 Hz\", \"4 (arcsec/s)^2/Hz\"], [\"40 Hz\", \"1 (arcsec/s)^2/Hz\"]] }";
        let motion = motion(text);
        let records: Vec<f64> = (0..10).flat_map(|number| angles(&motion, number, 0)).collect();
        // Density of the rate 40/f, times that of a sample.
        let sinc = |x: f64| x.sin() / x;
        for hz in [12.0, 17.0, 25.0, 33.0, 38.0] {
            let tick = SAMPLES.sample_s * sinc(std::f64::consts::PI * hz * SAMPLES.sample_s);
            let expected = 40.0 / hz * tick * tick;
            let found = density(&records, 500, hz);
            // 800 segments: 3.5 % each, and 1 % of the power is elsewhere.
            assert!((found / expected - 1.0).abs() < 0.15, "{hz}: {found}, not {expected}");
        }
        let least = 1.0 / 40.0 * SAMPLES.sample_s.powi(2);
        for hz in [0.0, 3.0, 60.0, 100.0] {
            let found = density(&records, 500, hz);
            assert!(found < 0.01 * least, "{hz}: {found}");
        }
        let variance = records.iter().map(|angle| angle * angle).sum::<f64>() / records.len() as f64;
        // ∫ 40/f (T sinc πfT)² df by a sum of 3000 parts.
        let part = |k: i32| {
            let hz = 10.0 + 0.01 * (f64::from(k) + 0.5);
            0.01 * 40.0 / hz * (SAMPLES.sample_s * sinc(std::f64::consts::PI * hz * SAMPLES.sample_s)).powi(2)
        };
        let expected: f64 = (0..3000).map(part).sum();
        // 1600 s of a band of some 25 Hz: 40000 independent pairs.
        assert!((variance / expected - 1.0).abs() < 0.03, "{variance}, not {expected}");
        let fourth = records.iter().map(|angle| angle.powi(4)).sum::<f64>() / records.len() as f64;
        assert!((fourth / (3.0 * variance * variance) - 1.0).abs() < 0.05, "{fourth}");
    }

    #[test]
    fn vibration_turns_the_gyro_through_its_suspension_and_a_table_is_read_too() {
        let modes = "modes = [{ frequency = \"30 Hz\", q = 10, response = \"500 arcsec/s/g\" }]";
        let text = format!(
            "[motion]\nsuspension = {{ {modes}, sine = {{ acceleration = \"2 g\", frequency = \"30 Hz\" }} }}"
        );
        let tones = motion(&text).tones(0);
        assert!((tones[0].amplitude - 1000.0).abs() < 1e-6 && tones[0].frequency_hz == 30.0, "{tones:?}");
        let psd = "psd = [[\"5 Hz\", \"0.01 g^2/Hz\"], [\"100 Hz\", \"0.01 g^2/Hz\"]]";
        let random = motion(&format!("suspension = {{ {modes}, random = {{ {psd} }} }}"));
        let records: Vec<f64> = (0..4).flat_map(|number| angles(&random, number, 0)).collect();
        let resonance = density(&records, 1000, 30.0) / density(&records, 1000, 60.0);
        // Gains 500 and 500/10/√(3² + 0.2²), with (sinc 0.12π/sinc 0.24π)²; smoothed by a window of 0.4 Hz.
        assert!((500.0..1200.0).contains(&resonance), "{resonance}");
        let fast = "suspension = { modes = [{ frequency = \"300 Hz\", q = 10, response = \"500 arcsec/s/g\" }], sine = { acceleration = \"2 g\", frequency = \"30 Hz\" } }";
        let refused = RecordMotion::parse("motion.toml", fast, SAMPLES).unwrap_err().render(false, 120);
        assert!(refused.contains("half the sampling rate") && refused.contains("alias = true"), "{refused}");
    }

    #[test]
    fn what_samples_cannot_show_is_refused_at_its_place() {
        for (text, why) in [
            ("amplitude = \"1 deg/s\"\nfrequency = \"3 kHz\"", "ten times the sampling rate"),
            ("gaussian = { rms = \"1 deg/s\", band = [\"20 Hz\", \"20.01 Hz\"] }", "too narrow"),
            ("amplitude = \"1 deg/s\"", "frequency is missing"),
            ("amplitud = \"1 deg/s\"", "unknown key"),
            ("", "there is no motion"),
            ("profile = { file = \"none.csv\" }", "cannot read the record"),
        ] {
            let refused = RecordMotion::parse("motion.toml", text, SAMPLES).unwrap_err().render(false, 120);
            assert!(refused.contains(why) && refused.contains("motion.toml"), "{text}: {refused}");
        }
    }
}
