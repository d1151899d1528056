//! The keys that hold a physical value: what each accepts, within which limits, and what it sets.
//!
//! A new key that sweeps may vary is one entry here.

use toml::Spanned;

use super::diagnose::{Fault, choices};
use super::inputs::{Amplitude, Inputs, TickNoise};
use super::scalar::{self, Scalar};
use super::units::{Dimension, Quantity};

/// Longest gap, ticks.
pub(super) const LONGEST_GAP: i64 = 64;

/// A key with a physical value.
#[derive(Debug)]
pub struct Key {
    /// As in study files and column names: `motion.frequency`.
    pub name: &'static str,
    /// For axes and reports: `Vibration frequency`.
    pub label: &'static str,
    accepts: &'static [Dimension],
    /// Lowest and highest value in base units, and the same for people.
    limits: (f64, f64, &'static str),
    set: fn(&mut Inputs, Quantity),
}

pub(super) static TICK: Key = Key {
    name: "gyro.tick",
    label: "Tick",
    accepts: &[Dimension::Time],
    limits: (1e-6, 1e3, "1 µs to 1000 s"),
    set: |inputs, tick| inputs.tick_s = tick.value,
};

pub(super) static NOISE_STD: Key = Key {
    name: "gyro.tick_noise.std",
    label: "Tick noise σ",
    accepts: &[Dimension::Angle],
    limits: (0.0, 1e6, "0 to 1e6 arcsec"),
    set: |inputs, sigma| inputs.tick_noise = TickNoise::Std(sigma.value),
};

pub(super) static NOISE_THREE_SIGMA: Key = Key {
    name: "gyro.tick_noise.three_sigma",
    label: "Tick noise 3σ",
    accepts: &[Dimension::Angle],
    limits: (0.0, 3e6, "0 to 3e6 arcsec"),
    set: |inputs, three_sigma| inputs.tick_noise = TickNoise::from_three_sigma(three_sigma.value),
};

pub(super) static NOISE_RANDOM_WALK: Key = Key {
    name: "gyro.tick_noise.angle_random_walk",
    label: "Angle random walk",
    accepts: &[Dimension::AngleRandomWalk],
    limits: (0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)"),
    set: |inputs, n| inputs.tick_noise = TickNoise::AngleRandomWalk(n.value),
};

pub(super) static AMPLITUDE: Key = Key {
    name: "motion.amplitude",
    label: "Vibration amplitude",
    accepts: &[Dimension::Rate, Dimension::Angle],
    limits: (0.0, 1e9, "0 to 1e9 arcsec/s, or an angle of 0 to 1e9 arcsec"),
    set: |inputs, amplitude| {
        inputs.amplitude = match amplitude.dimension {
            Dimension::Angle => Amplitude::Angle(amplitude.value),
            _ => Amplitude::Rate(amplitude.value),
        }
    },
};

pub(super) static FREQUENCY: Key = Key {
    name: "motion.frequency",
    label: "Vibration frequency",
    accepts: &[Dimension::Frequency],
    limits: (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most 10 times the tick rate"),
    set: |inputs, frequency| inputs.frequency_hz = frequency.value,
};

pub(super) static GAP_TICKS: Key = Key {
    name: "switching.gap_ticks",
    label: "Lost ticks n",
    accepts: &[Dimension::Count],
    limits: (1.0, LONGEST_GAP as f64, "1 to 64"),
    // Within its limits a count converts exactly.
    set: |inputs, n| inputs.gap_ticks = n.value as u32,
};

/// Every key that a sweep may vary.
static KEYS: [&Key; 7] =
    [&TICK, &NOISE_STD, &NOISE_THREE_SIGMA, &NOISE_RANDOM_WALK, &AMPLITUDE, &FREQUENCY, &GAP_TICKS];

/// The keys of a study that no sweep can vary, and what they are.
const FIXED: [(&str, &str); 12] = [
    ("title", "is text"),
    ("question", "is text"),
    ("kind", "is text"),
    ("streams", "is text"),
    ("seed", "holds for the whole study"),
    ("trials", "holds for the whole study"),
    ("gyro.tick_noise", "is a table"),
    ("motion.phase", "is text"),
    ("switching.fillers", "is a list"),
    ("switching.fit_ticks", "is a list"),
    ("switching.extrapolation_ticks", "is a list"),
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
        // The forms of the noise are the third part of a name.
        self.name.match_indices('.').nth(1).map_or(self.name, |(end, _)| &self.name[..end])
    }

    /// Whether the key holds whole numbers.
    pub(super) fn is_whole(&self) -> bool {
        self.accepts == [Dimension::Count]
    }

    /// The value written for this key.
    pub(super) fn read(&self, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
        let (low, high, limits) = self.limits;
        if self.is_whole() {
            let count = scalar::whole(self.name, given, low as i64..=high as i64)?;
            return Ok(Quantity::new(count as f64, Dimension::Count));
        }
        let quantity = scalar::quantity(self.name, given, self.accepts)?;
        if (low..=high).contains(&quantity.value) {
            return Ok(quantity);
        }
        let label = match quantity.value {
            x if x < 0.0 => "negative",
            x if x < low => "too small",
            _ => "too large",
        };
        let message = format!("{} = {quantity} is out of range", self.name);
        Err(Fault::new(given.span(), message, label, format!("accepted: {limits}")))
    }

    /// Puts a value that [`Key::read`] gave, or one between two such, into `inputs`.
    pub(super) fn set(&self, inputs: &mut Inputs, value: Quantity) {
        (self.set)(inputs, value);
    }
}
