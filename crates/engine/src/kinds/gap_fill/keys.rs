//! The keys specific to gap-fill studies, and the settings of their inputs except the motion.

use crate::filler::read::GAP_TICKS;
use crate::key::row::{Holds, keys, measure};
use crate::key::sweep::Setting;
use crate::kinds::TICK;
use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use sagnac_base::quantity::units::Dimension;

const ANGLES: Holds = measure(&[Dimension::Angle], 0.0, 1e6, "0 to 1e6 arcsec");
const THREE_SIGMAS: Holds = measure(&[Dimension::Angle], 0.0, 3e6, "0 to 3e6 arcsec");
const N: Holds = measure(&[Dimension::AngleRandomWalk], 0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)");
const PULSES: Holds = measure(&[Dimension::Angle], 1e-6, 1e6, "1e-6 to 1e6 arcsec");
const RELOCKS: Holds = measure(&[Dimension::Angle], -1e6, 1e6, "-1e6 to 1e6 arcsec");
const TABLE: Holds = Holds::Table;

keys! {
    /// The keys of the gyro, except its tick.
    pub(crate) static KEYS;
    /// The gyro.
    pub GYRO = "gyro", "", Fixed, TABLE, "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"0.53 arcsec\" }";
    /// Noise of the angle of one tick, independent from tick to tick, in exactly one of three forms. Leave it out if
    /// [noise] gives the noise.
    pub TICK_NOISE = "gyro.tick_noise", "", Fixed, Holds::OneOf, "tick_noise = { std = \"0.53 arcsec\" }   # std = \"0 arcsec\" if there is no noise, for example with readout_lsb alone";
    /// Standard deviation, an angle: "0.53 arcsec".
    NOISE_STD = "gyro.tick_noise.std", "tick noise σ", Condition, ANGLES, r#"std = "0.53 arcsec""#;
    /// Three standard deviations, an angle: "1.6 arcsec".
    NOISE_THREE_SIGMA = "gyro.tick_noise.three_sigma", "tick noise 3σ", Condition, THREE_SIGMAS, r#"three_sigma = "1.6 arcsec""#;
    /// Angle random walk N, from which the standard deviation is N·√tick: "0.003 deg/sqrt(h)".
    pub NOISE_RANDOM_WALK = "gyro.tick_noise.angle_random_walk", "angle random walk", Condition, N, r#"angle_random_walk = "0.003 deg/sqrt(h)""#;
    /// Angle of a pulse, if the gyro counts whole pulses: "3.2 arcsec". If absent, the readout is not quantized.
    pub READOUT_LSB = "gyro.readout_lsb", "pulse weight", Condition, PULSES, r#"readout_lsb = "3.2 arcsec""#;
    /// Angles that the uncorrected relock adds to the ticks n+1, n+2, …: ["20.3 arcsec", "14.8 arcsec"].
    pub RELOCK = "gyro.relock", "", Fixed, Holds::List(&RELOCKS), r#"relock = ["20.3 arcsec", "14.8 arcsec"]"#;
}

/// The settings that can be swept, except the motion.
pub(crate) static SETTINGS: [Setting<Inputs>; 6] = [
    Setting::new(&TICK, |inputs, tick| inputs.tick_s = tick.value),
    Setting::new(&NOISE_STD, |inputs, sigma| inputs.tick_noise = TickNoise::Std(sigma.value)),
    Setting::new(&NOISE_THREE_SIGMA, |inputs, three_sigma| {
        inputs.tick_noise = TickNoise::from_three_sigma(three_sigma.value);
    }),
    Setting::new(&NOISE_RANDOM_WALK, |inputs, n| inputs.tick_noise = TickNoise::AngleRandomWalk(n.value)),
    Setting::new(&READOUT_LSB, |inputs, lsb| inputs.readout_lsb = lsb.value),
    // Within its limits a count converts exactly.
    Setting::new(&GAP_TICKS, |inputs, n| inputs.gap_ticks = n.value as u32),
];
