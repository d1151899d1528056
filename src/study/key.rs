//! The keys that hold a physical value: what each accepts, within which limits, and what it sets.
//!
//! A new key that sweeps may vary is one entry here.

use crate::kernel::launch::MAX_SIDE;
use std::ops::Range;

use toml::Spanned;

use super::diagnose::{Fault, choices};
use super::inputs::{Inputs, TickNoise};
use super::motion::{Frequency, Gaussian, Value};
use super::scalar::{self, Scalar};
use super::units::{Dimension, Quantity};

/// Longest gap, ticks.
pub(super) const LONGEST_GAP: i64 = MAX_SIDE as i64;

/// A key with a physical value.
#[derive(Debug)]
pub struct Key {
    /// As in study files and column names: `motion.frequency`.
    pub name: &'static str,
    /// For axes and reports: `vibration frequency`.
    pub label: &'static str,
    accepts: &'static [Dimension],
    /// Lowest and highest value in base units, and the same for people.
    limits: (f64, f64, &'static str),
    /// Whether inputs have what the key sets.
    applies: fn(&Inputs) -> bool,
    set: fn(&mut Inputs, Quantity),
}

pub(super) static TICK: Key = Key {
    name: "gyro.tick",
    label: "tick",
    accepts: &[Dimension::Time],
    limits: (1e-6, 1e3, "1 µs to 1000 s"),
    applies: always,
    set: |inputs, tick| inputs.tick_s = tick.value,
};

pub(super) static NOISE_STD: Key = Key {
    name: "gyro.tick_noise.std",
    label: "tick noise σ",
    accepts: &[Dimension::Angle],
    limits: (0.0, 1e6, "0 to 1e6 arcsec"),
    applies: always,
    set: |inputs, sigma| inputs.tick_noise = TickNoise::Std(sigma.value),
};

pub(super) static NOISE_THREE_SIGMA: Key = Key {
    name: "gyro.tick_noise.three_sigma",
    label: "tick noise 3σ",
    accepts: &[Dimension::Angle],
    limits: (0.0, 3e6, "0 to 3e6 arcsec"),
    applies: always,
    set: |inputs, three_sigma| inputs.tick_noise = TickNoise::from_three_sigma(three_sigma.value),
};

pub(super) static NOISE_RANDOM_WALK: Key = Key {
    name: "gyro.tick_noise.angle_random_walk",
    label: "angle random walk",
    accepts: &[Dimension::AngleRandomWalk],
    limits: (0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)"),
    applies: always,
    set: |inputs, n| inputs.tick_noise = TickNoise::AngleRandomWalk(n.value),
};

pub(super) static READOUT_LSB: Key = Key {
    name: "gyro.readout_lsb",
    label: "pulse weight",
    accepts: &[Dimension::Angle],
    limits: (1e-6, 1e6, "1e-6 to 1e6 arcsec"),
    applies: always,
    set: |inputs, lsb| inputs.readout_lsb = lsb.value,
};

pub(super) static AMPLITUDE: Key = Key {
    name: "motion.amplitude",
    label: "vibration amplitude",
    accepts: &[Dimension::Rate, Dimension::Angle],
    limits: (0.0, 1e9, "0 to 1e9 arcsec/s, or an angle of 0 to 1e9 arcsec"),
    applies: |inputs| matches!(inputs.motion.tones[..], [tone] if matches!(tone.amplitude.value, Value::Fixed(_))),
    set: |inputs, amplitude| {
        if let [tone] = &mut inputs.motion.tones[..] {
            tone.amplitude.value = Value::Fixed(amplitude.value);
            tone.amplitude.of_angle = amplitude.dimension == Dimension::Angle;
        }
    },
};

pub(super) static FREQUENCY: Key = Key {
    name: "motion.frequency",
    label: "vibration frequency",
    accepts: &[Dimension::Frequency],
    limits: (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most 10 times the tick rate"),
    applies: |inputs| matches!(inputs.motion.tones[..], [tone] if matches!(tone.frequency, Frequency::Fixed(_))),
    set: |inputs, frequency| {
        if let [tone] = &mut inputs.motion.tones[..] {
            tone.frequency = Frequency::Fixed(frequency.value);
        }
    },
};

/// Limits of the ends of a band.
const BAND: (f64, f64, &str) = (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most half the tick rate");

static FREQUENCY_LOW: Key = Key {
    name: "motion.frequency.low",
    label: "lower frequency",
    accepts: &[Dimension::Frequency],
    limits: BAND,
    applies: has_frequency_band,
    set: |inputs, low| {
        if let [tone] = &mut inputs.motion.tones[..]
            && let Frequency::Band(band) = &mut tone.frequency
        {
            band.low_hz = low.value;
        }
    },
};

static FREQUENCY_HIGH: Key = Key {
    name: "motion.frequency.high",
    label: "upper frequency",
    accepts: &[Dimension::Frequency],
    limits: BAND,
    applies: has_frequency_band,
    set: |inputs, high| {
        if let [tone] = &mut inputs.motion.tones[..]
            && let Frequency::Band(band) = &mut tone.frequency
        {
            band.high_hz = high.value;
        }
    },
};

pub(super) static GAUSSIAN_RMS: Key = Key {
    name: "motion.gaussian.rms",
    label: "rms rate",
    accepts: &[Dimension::Rate],
    limits: (0.0, 1e9, "0 to 1e9 arcsec/s"),
    applies: has_gaussian_band,
    set: |inputs, new| {
        if let Some(Gaussian::Band { rms, .. }) = &mut inputs.motion.gaussian {
            *rms = new.value;
        }
    },
};

static GAUSSIAN_LOW: Key = Key {
    name: "motion.gaussian.low",
    label: "lower frequency",
    accepts: &[Dimension::Frequency],
    limits: BAND,
    applies: has_gaussian_band,
    set: |inputs, low| {
        if let Some(Gaussian::Band { band, .. }) = &mut inputs.motion.gaussian {
            band.low_hz = low.value;
        }
    },
};

static GAUSSIAN_HIGH: Key = Key {
    name: "motion.gaussian.high",
    label: "upper frequency",
    accepts: &[Dimension::Frequency],
    limits: BAND,
    applies: has_gaussian_band,
    set: |inputs, high| {
        if let Some(Gaussian::Band { band, .. }) = &mut inputs.motion.gaussian {
            band.high_hz = high.value;
        }
    },
};

pub(super) static RATE: Key = Key {
    name: "motion.rate",
    label: "constant rate",
    accepts: &[Dimension::Rate],
    limits: (-1e9, 1e9, "-1e9 to 1e9 arcsec/s"),
    applies: always,
    set: |inputs, rate| inputs.motion.rate = rate.value,
};

pub(super) static ACCELERATION: Key = Key {
    name: "motion.acceleration",
    label: "angular acceleration",
    accepts: &[Dimension::AngularAcceleration],
    limits: (-1e12, 1e12, "-1e12 to 1e12 arcsec/s^2"),
    applies: always,
    set: |inputs, acceleration| inputs.motion.acceleration = acceleration.value,
};

fn always(_: &Inputs) -> bool {
    true
}

fn has_frequency_band(inputs: &Inputs) -> bool {
    matches!(inputs.motion.tones[..], [tone] if matches!(tone.frequency, Frequency::Band(_)))
}

fn has_gaussian_band(inputs: &Inputs) -> bool {
    matches!(inputs.motion.gaussian, Some(Gaussian::Band { .. }))
}

pub(super) static GAP_TICKS: Key = Key {
    name: "switching.gap_ticks",
    label: "lost ticks n",
    accepts: &[Dimension::Count],
    limits: (1.0, LONGEST_GAP as f64, "1 to 64"),
    applies: always,
    // Within its limits a count converts exactly.
    set: |inputs, n| inputs.gap_ticks = n.value as u32,
};

/// Every key that a sweep may vary.
static KEYS: [&Key; 15] = [
    &TICK,
    &NOISE_STD,
    &NOISE_THREE_SIGMA,
    &NOISE_RANDOM_WALK,
    &READOUT_LSB,
    &AMPLITUDE,
    &FREQUENCY,
    &FREQUENCY_LOW,
    &FREQUENCY_HIGH,
    &GAUSSIAN_RMS,
    &GAUSSIAN_LOW,
    &GAUSSIAN_HIGH,
    &RATE,
    &ACCELERATION,
    &GAP_TICKS,
];

/// The keys of a study that no sweep can vary, and what they are.
const FIXED: [(&str, &str); 18] = [
    ("title", "is text"),
    ("question", "is text"),
    ("kind", "is text"),
    ("streams", "is text"),
    ("seed", "holds for the whole study"),
    ("trials", "holds for the whole study"),
    ("precision", "holds for the whole study"),
    ("gyro.tick_noise", "is a table"),
    ("gyro.relock", "is a list"),
    ("motion.phase", "is text"),
    ("motion.tones", "is a list"),
    ("motion.gaussian", "is a table"),
    ("motion.profile", "is a table"),
    ("switching.fillers", "is a list"),
    ("switching.fit_ticks", "is a list"),
    ("switching.extrapolation_ticks", "is a list"),
    ("switching.errors", "is a list"),
    ("chart", "is a table"),
];

impl Key {
    /// The key a sweep names.
    pub(super) fn find(name: &Spanned<String>) -> Result<&'static Key, Fault> {
        let wanted = name.get_ref();
        if let Some(key) = KEYS.into_iter().find(|key| key.name == wanted) {
            return Ok(key);
        }
        let sweepable = KEYS.map(|key| key.name);
        if let Some((_, what)) = FIXED.iter().find(|(fixed, _)| fixed == wanted) {
            let message = format!("{wanted} {what} and cannot be swept");
            let help = format!("sweepable keys are {}", sweepable.join(", "));
            return Err(Fault::new(name.span(), message, *what, help));
        }
        let message = format!("there is no key `{wanted}` to sweep");
        Err(Fault::new(name.span(), message, "unknown key", choices(wanted, &sweepable)))
    }

    /// What the key sets: keys with the same target exclude each other.
    pub(super) fn target(&self) -> &'static str {
        // The noise has several forms.
        if self.name.starts_with("gyro.tick_noise") { "gyro.tick_noise" } else { self.name }
    }

    /// Refuses a sweep over what the inputs do not have.
    pub(super) fn check_applies(&self, inputs: &Inputs, sweep: Range<usize>) -> Result<(), Fault> {
        if (self.applies)(inputs) {
            return Ok(());
        }
        let message = format!("{} is swept, but the motion has none", self.name);
        let applying: Vec<&str> =
            KEYS.iter().filter(|key| (key.applies)(inputs)).map(|key| key.name).collect();
        let help = format!("this study has {}", applying.join(", "));
        Err(Fault::new(sweep, message, "not in this study", help))
    }

    /// Whether the key holds whole numbers.
    pub(super) fn is_whole(&self) -> bool {
        self.accepts == [Dimension::Count]
    }

    /// The value written for this key.
    pub(super) fn read(&self, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
        self.read_as(self.name, given)
    }

    /// The same for a value of this kind that is written under another `name`.
    pub(super) fn read_as(&self, name: &str, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
        let (low, high, limits) = self.limits;
        if self.is_whole() {
            let count = scalar::whole(name, given, low as i64..=high as i64)?;
            return Ok(Quantity::new(count as f64, Dimension::Count));
        }
        let quantity = scalar::quantity(name, given, self.accepts)?;
        if (low..=high).contains(&quantity.value) {
            return Ok(quantity);
        }
        let label = match quantity.value {
            x if x < 0.0 && low >= 0.0 => "negative",
            x if x < low => "too small",
            _ => "too large",
        };
        let message = format!("{name} = {quantity} is out of range");
        Err(Fault::new(given.span(), message, label, format!("accepted: {limits}")))
    }

    /// Puts a value that [`Key::read`] gave, or one between two such, into `inputs`.
    pub(super) fn set(&self, inputs: &mut Inputs, value: Quantity) {
        (self.set)(inputs, value);
    }
}
