//! The input of a gyro from `[motion]`: tones, or a recorded profile from its start.

use std::f64::consts::TAU;

use crate::key::row::{Key, Reading, Refusal, shown};
use crate::key::sweep::Setting;
use crate::kinds::lock_in::Inputs;
use crate::motion::keys::{
    AMPLITUDE, FREQUENCY, INTERPOLATION, MOTION, OF_SEVERAL, PHASE, PROFILE, PROFILE_FILE, Phase, TONES,
};
use crate::motion::{Amplitude, Frequency, Motion, Tone, Value, keys};
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::{Fault, Wrong};

/// The keys of the motion that this kind of study has.
pub(crate) fn keys() -> Vec<&'static Key> {
    let tone = [OF_SEVERAL.amplitude, OF_SEVERAL.frequency, OF_SEVERAL.phase];
    let own = [&MOTION, &AMPLITUDE, &FREQUENCY, &PHASE, &TONES, &PROFILE, &PROFILE_FILE, &INTERPOLATION];
    own.into_iter().chain(tone).collect()
}

/// The settings of a single tone.
pub(crate) static SETTINGS: [Setting<Inputs>; 2] = [
    Setting::of(&AMPLITUDE, has_one_tone, |inputs, new| {
        let of_angle = new.dimension == Dimension::Angle;
        with_tone(inputs, |tone| tone.amplitude = Amplitude { of_angle, value: Value::Fixed(new.value) });
    }),
    Setting::of(&FREQUENCY, has_one_tone, |inputs, new| {
        with_tone(inputs, |tone| tone.frequency = Frequency::Fixed(new.value));
    }),
];

fn has_one_tone(inputs: &Inputs) -> bool {
    inputs.motion.as_ref().is_some_and(|motion| motion.tones.len() == 1)
}

fn with_tone(inputs: &mut Inputs, set: impl FnOnce(&mut Tone)) {
    if let Some([tone]) = inputs.motion.as_mut().map(|motion| &mut motion.tones[..]) {
        set(tone);
    }
}

/// Reads the motion, which is the same in every gyro.
pub(crate) fn read_motion(reading: &mut Reading) -> Result<Option<Motion>, Wrong> {
    if reading.get(&MOTION).is_none() {
        return Ok(None);
    }
    let motion = keys::read(reading)?;
    if motion.tones.iter().any(|tone| fixed(tone).is_none()) {
        let span = reading.table.span_of(&MOTION).unwrap_or_default();
        let message = "[motion] has a tone whose amplitude or frequency is drawn for each trial";
        let help =
            "give one amplitude and one frequency: in a study of lock-in all gyros have the same motion";
        return Err(Fault::new(span, message, "drawn", help).into());
    }
    if motion.tones.iter().any(|tone| tone.phase == Phase::Uniform) {
        reading.notes.push(
            "a tone of [motion] without a phase starts at a zero crossing, in every gyro: only the beat has a random phase"
                .to_owned(),
        );
    }
    Ok(Some(motion))
}

/// Amplitude of the rate, ″/s, and frequency, Hz, of a tone that has one of each.
fn fixed(tone: &Tone) -> Option<[f64; 2]> {
    match (tone.amplitude.value, tone.frequency) {
        (Value::Fixed(amplitude), Frequency::Fixed(nu)) => Some([amplitude * tone.rate_factor(nu), nu]),
        _ => None,
    }
}

/// The largest rate of the motion, ″/s, at most; that of a profile is measured over `tick_s`.
pub(crate) fn most_rate(motion: &Motion, tick_s: f64) -> f64 {
    let tones: f64 = motion.tones.iter().filter_map(fixed).map(|[rate, _]| rate).sum();
    let of_profile = motion.profile.as_ref().map_or(0.0, |profile| {
        profile.tick_angles(tick_s).into_iter().map(libm::fabs).fold(0.0, libm::fmax) / tick_s
    });
    tones + of_profile
}

/// The angles of the motion, ″, at `count` + 1 times `step_s` apart.
///
/// # Errors
/// A recorded profile is too short.
pub(crate) fn angles(motion: &Motion, step_s: f64, count: usize) -> Result<Vec<f64>, Refusal> {
    let of_tone = |tone: &Tone, s: f64| {
        let [rate, nu] = fixed(tone).unwrap_or_default();
        match tone.phase {
            Phase::Extremum => rate / (TAU * nu) * libm::sin(TAU * nu * s),
            Phase::Uniform | Phase::ZeroCrossing => {
                let half = libm::sin(0.5 * TAU * nu * s);
                rate / (TAU * nu) * 2.0 * half * half
            }
        }
    };
    let at = |k: usize| motion.tones.iter().map(|tone| of_tone(tone, k as f64 * step_s)).sum();
    let mut angles: Vec<f64> = (0..=count).map(at).collect();
    if let Some(profile) = &motion.profile {
        let ticks = profile.tick_angles(step_s);
        if ticks.len() < count {
            let found = format!(
                "the profile lasts {} s, and the record {} s",
                shown(profile.record.duration_s()),
                shown(count as f64 * step_s)
            );
            return Err(Refusal::new("motion.profile", found, "take a shorter record, or a longer profile"));
        }
        let mut sum = 0.0;
        for (angle, tick) in angles[1..].iter_mut().zip(ticks) {
            sum += tick;
            *angle += sum;
        }
    }
    Ok(angles)
}
