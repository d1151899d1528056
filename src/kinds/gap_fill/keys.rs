//! The keys of a gap-fill study that hold a physical value: what each accepts, within which limits, and what it sets.
//!
//! A new key that sweeps may vary is one entry here.

use crate::kernel::gap_fill::shape::MAX_SIDE;
use crate::key::setting::{Key, Setting};
use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use crate::motion::vibration::{RANDOM_RMS, SINE_ACCELERATION, SINE_FREQUENCY};
use crate::motion::{Frequency, Gaussian, Value};
use crate::quantity::units::Dimension;

/// Longest gap, ticks.
pub(crate) const LONGEST_GAP: i64 = MAX_SIDE as i64;

pub(crate) static TICK: Setting<Inputs> = Setting {
    key: Key {
        name: "gyro.tick",
        label: "tick",
        accepts: &[Dimension::Time],
        limits: (1e-6, 1e3, "1 µs to 1000 s"),
    },
    applies: always,
    set: |inputs, tick| inputs.tick_s = tick.value,
};

pub(crate) static NOISE_STD: Setting<Inputs> = Setting {
    key: Key {
        name: "gyro.tick_noise.std",
        label: "tick noise σ",
        accepts: &[Dimension::Angle],
        limits: (0.0, 1e6, "0 to 1e6 arcsec"),
    },
    applies: always,
    set: |inputs, sigma| inputs.tick_noise = TickNoise::Std(sigma.value),
};

pub(crate) static NOISE_THREE_SIGMA: Setting<Inputs> = Setting {
    key: Key {
        name: "gyro.tick_noise.three_sigma",
        label: "tick noise 3σ",
        accepts: &[Dimension::Angle],
        limits: (0.0, 3e6, "0 to 3e6 arcsec"),
    },
    applies: always,
    set: |inputs, three_sigma| inputs.tick_noise = TickNoise::from_three_sigma(three_sigma.value),
};

pub(crate) static NOISE_RANDOM_WALK: Setting<Inputs> = Setting {
    key: Key {
        name: "gyro.tick_noise.angle_random_walk",
        label: "angle random walk",
        accepts: &[Dimension::AngleRandomWalk],
        limits: (0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)"),
    },
    applies: always,
    set: |inputs, n| inputs.tick_noise = TickNoise::AngleRandomWalk(n.value),
};

pub(crate) static READOUT_LSB: Setting<Inputs> = Setting {
    key: Key {
        name: "gyro.readout_lsb",
        label: "pulse weight",
        accepts: &[Dimension::Angle],
        limits: (1e-6, 1e6, "1e-6 to 1e6 arcsec"),
    },
    applies: always,
    set: |inputs, lsb| inputs.readout_lsb = lsb.value,
};

pub(crate) static AMPLITUDE: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.amplitude",
        label: "vibration amplitude",
        accepts: &[Dimension::Rate, Dimension::Angle],
        limits: (0.0, 1e9, "0 to 1e9 arcsec/s, or an angle of 0 to 1e9 arcsec"),
    },
    applies: |inputs| matches!(inputs.motion.tones[..], [tone] if matches!(tone.amplitude.value, Value::Fixed(_))),
    set: |inputs, amplitude| {
        if let [tone] = &mut inputs.motion.tones[..] {
            tone.amplitude.value = Value::Fixed(amplitude.value);
            tone.amplitude.of_angle = amplitude.dimension == Dimension::Angle;
        }
    },
};

pub(crate) static FREQUENCY: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.frequency",
        label: "vibration frequency",
        accepts: &[Dimension::Frequency],
        limits: (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most 10 times the tick rate"),
    },
    applies: |inputs| matches!(inputs.motion.tones[..], [tone] if matches!(tone.frequency, Frequency::Fixed(_))),
    set: |inputs, frequency| {
        if let [tone] = &mut inputs.motion.tones[..] {
            tone.frequency = Frequency::Fixed(frequency.value);
        }
    },
};

/// Limits of the ends of a band.
const BAND: (f64, f64, &str) = (1e-9, 1e7, "1e-9 Hz to 1e7 Hz, and at most half the tick rate");

static FREQUENCY_LOW: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.frequency.low",
        label: "lower frequency",
        accepts: &[Dimension::Frequency],
        limits: BAND,
    },
    applies: has_frequency_band,
    set: |inputs, low| {
        if let [tone] = &mut inputs.motion.tones[..]
            && let Frequency::Band(band) = &mut tone.frequency
        {
            band.low_hz = low.value;
        }
    },
};

static FREQUENCY_HIGH: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.frequency.high",
        label: "upper frequency",
        accepts: &[Dimension::Frequency],
        limits: BAND,
    },
    applies: has_frequency_band,
    set: |inputs, high| {
        if let [tone] = &mut inputs.motion.tones[..]
            && let Frequency::Band(band) = &mut tone.frequency
        {
            band.high_hz = high.value;
        }
    },
};

pub(crate) static GAUSSIAN_RMS: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.gaussian.rms",
        label: "rms rate",
        accepts: &[Dimension::Rate],
        limits: (0.0, 1e9, "0 to 1e9 arcsec/s"),
    },
    applies: has_gaussian_band,
    set: |inputs, new| {
        if let Some(Gaussian::Band { rms, .. }) = &mut inputs.motion.gaussian {
            *rms = new.value;
        }
    },
};

static GAUSSIAN_LOW: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.gaussian.low",
        label: "lower frequency",
        accepts: &[Dimension::Frequency],
        limits: BAND,
    },
    applies: has_gaussian_band,
    set: |inputs, low| {
        if let Some(Gaussian::Band { band, .. }) = &mut inputs.motion.gaussian {
            band.low_hz = low.value;
        }
    },
};

static GAUSSIAN_HIGH: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.gaussian.high",
        label: "upper frequency",
        accepts: &[Dimension::Frequency],
        limits: BAND,
    },
    applies: has_gaussian_band,
    set: |inputs, high| {
        if let Some(Gaussian::Band { band, .. }) = &mut inputs.motion.gaussian {
            band.high_hz = high.value;
        }
    },
};

pub(crate) static RATE: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.rate",
        label: "constant rate",
        accepts: &[Dimension::Rate],
        limits: (-1e9, 1e9, "-1e9 to 1e9 arcsec/s"),
    },
    applies: always,
    set: |inputs, rate| inputs.motion.rate = rate.value,
};

pub(crate) static ACCELERATION: Setting<Inputs> = Setting {
    key: Key {
        name: "motion.acceleration",
        label: "angular acceleration",
        accepts: &[Dimension::AngularAcceleration],
        limits: (-1e12, 1e12, "-1e12 to 1e12 arcsec/s^2"),
    },
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

pub(crate) static GAP_TICKS: Setting<Inputs> = Setting {
    key: Key {
        name: "switching.gap_ticks",
        label: "lost ticks n",
        accepts: &[Dimension::Count],
        limits: (1.0, LONGEST_GAP as f64, "1 to 64"),
    },
    applies: always,
    // Within its limits a count converts exactly.
    set: |inputs, n| inputs.gap_ticks = n.value as u32,
};

/// Every key that a sweep may vary.
pub(crate) static SETTINGS: [&Setting<Inputs>; 18] = [
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
    &SINE_ACCELERATION,
    &SINE_FREQUENCY,
    &RANDOM_RMS,
    &GAP_TICKS,
];
