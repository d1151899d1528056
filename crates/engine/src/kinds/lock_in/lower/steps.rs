//! The steps of the integration, from bounds of their error.
//!
//! The midpoint rule with n steps in a period of the dither replaces the lock-in of zone k, J_k(Θ), by Σ J_{k+mn}(Θ) over all
//! whole m, because the samples of an angle that turns n times more look the same. J_ν(Θ) falls faster than any exponential
//! once ν exceeds Θ: it is below 10^−9 for ν = Θ + 8 Θ^{1/3}. The steps of a period tell the largest amplitude from its alias
//! by that bound, and half of them that of nearly every half-cycle, so that an integration with half the steps shows the error
//! of this one. Where the amplitude changes, at the zero crossings, a sum of samples differs from the integral by up to its
//! next term, which n ≥ 2.2 Θ keeps below 10^−4 of a jump at a reversal. Where a sample ends the sum, the kernel adds that
//! term. The explicit step of the lock-in itself errs by π²c² of c. `docs/dev/numerics.md` has the derivations.

use core::f64::consts::{PI, TAU};

use crate::key::row::{Refusal, shown};
use crate::kinds::lock_in::inputs::{DITHER_RATE, RATE, SAMPLE, THRESHOLD};
use crate::kinds::lock_in::point::Times;
use crate::kinds::lock_in::{Dither, Inputs, motion};
use sagnac_kernel::lock_in::ROUND;
use sagnac_kernel::normal::REACH;

/// Fewest steps of a period for each radian of the dither.
const STEPS_PER_RADIAN: f64 = 2.2;
/// Multiples of Θ^{1/3} by which the steps exceed Θ.
const TAIL: f64 = 8.0;
/// Standard deviations of Θ that half of the steps must still tell from an alias: all but one of 30,000 half-cycles.
const USUAL: f64 = 4.0;
/// Fewest steps of a period.
const MIN_STEPS: f64 = 64.0;
/// Most lock-in of a step, in radians of the beat phase, with dither. What the sums of steps are off by at a zero crossing is a
/// part of it.
const MAX_KICK: f64 = 0.003;
/// Inverse of the most lock-in of a step without dither, in turns.
const STEPS_PER_TURN: f64 = 2048.0;
/// Most rounds from one sample of the kernel to the next, so that a chunk takes less than 60,000 rounds of loops.
const MAX_ROUNDS: u64 = 880;
/// Rounds of a half-cycle without dither, which is the time between changes of the rate.
const STATIC_HALF: f64 = 8.0;
/// Time over which the largest rate of a profile is measured, s.
const MEASURED_S: f64 = 0.001;
/// ″ of half a turn of the dither's phase.
const HALF_TURN: f64 = 648_000.0;
/// Most steps of a record.
const MAX_STEPS: f64 = 1e12;

/// The steps of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// Rounds of a half-cycle.
    pub(crate) half: u64,
    /// Rounds from one sample of the kernel to the next.
    pub(crate) interval: f64,
    /// Samples of the kernel in one of the record.
    pub(crate) division: u64,
    /// Length of a step, s.
    pub(crate) step_s: f64,
}

impl Steps {
    pub(crate) fn new(inputs: &Inputs, times: &Times) -> Result<Steps, Refusal> {
        let steps = match &inputs.dither {
            Some(dither) => dithered(inputs, dither, times)?,
            None => undithered(inputs, times)?,
        };
        let count = times.length_s() / steps.step_s;
        if count > MAX_STEPS {
            let found =
                format!("the record takes {} steps, and the most are {}", shown(count), shown(MAX_STEPS));
            return Err(Refusal::new("record.length", found, "take a shorter record"));
        }
        Ok(steps)
    }

    /// Steps of a record.
    pub(crate) fn count(&self, times: &Times) -> f64 {
        times.length_s() / self.step_s
    }
}

fn dithered(inputs: &Inputs, dither: &Dither, times: &Times) -> Result<Steps, Refusal> {
    let period = dither.frequency_hz * inputs.scale_factor;
    let nominal = dither.rate / period;
    let beats = most_rate(inputs, times) / period;
    let beyond = |theta: f64| theta + TAIL * libm::cbrt(theta) + beats;
    // The phase at a reversal changes the rate at the zero crossings as the amplitude does.
    let phase_noise = PI * dither.phase_noise / HALF_TURN;
    let theta = nominal * largest(dither, times) * (1.0 + REACH * phase_noise);
    let spread = libm::hypot(dither.spread(times.length_s()), phase_noise);
    let told = libm::fmax(beyond(theta), 2.0 * beyond(nominal * (1.0 + USUAL * spread)));
    let kick = TAU * inputs.threshold / (period * MAX_KICK);
    let least = libm::fmax(libm::fmax(STEPS_PER_RADIAN * nominal, told), libm::fmax(kick, MIN_STEPS));
    let half = libm::ceil(inputs.refinement * least / (2 * ROUND) as f64);
    if 2.0 * half > MAX_ROUNDS as f64 {
        let found = format!(
            "a period of the dither takes {} steps, and the most are {}",
            shown(2.0 * half * ROUND as f64),
            MAX_ROUNDS * ROUND as u64
        );
        let (key, help) = match () {
            () if kick >= least => (THRESHOLD.name, "take a lower threshold, or a higher dither frequency"),
            () if beats >= theta => (RATE.name, "take a lower input rate, or a higher dither frequency"),
            () => (DITHER_RATE.name, "take a lower dither rate, or a higher dither frequency"),
        };
        return Err(Refusal::new(key, found, help));
    }
    let half = half as u64;
    let step_s = 1.0 / (dither.frequency_hz * (2 * half * ROUND as u64) as f64);
    if times.periods > 0 {
        let division = times.periods / divisor(times.periods, MAX_ROUNDS / (2 * half));
        let interval = (2 * half * (times.periods / division)) as f64;
        return Ok(Steps { half, interval, division, step_s });
    }
    let rounds = times.sample_s * dither.frequency_hz * (2 * half) as f64;
    divided(half, rounds, step_s)
}

fn undithered(inputs: &Inputs, times: &Times) -> Result<Steps, Refusal> {
    let fastest = libm::fmax(libm::sqrt(most_rate(inputs, times) * inputs.threshold), inputs.threshold);
    let rate = libm::fmax(
        STEPS_PER_TURN * fastest / inputs.scale_factor,
        8.0 * most_rate(inputs, times) / inputs.scale_factor,
    );
    // Whole quarters, so that half or twice as many rounds have their half-cycles, with the same draws, at the same times.
    let quarters = libm::ceil(rate * times.sample_s / (4 * ROUND) as f64);
    let rounds = libm::fmax(libm::round(inputs.refinement * 4.0 * quarters), 1.0);
    let half = libm::fmax(libm::round(inputs.refinement * STATIC_HALF), 1.0);
    let step_s = times.sample_s / (rounds * ROUND as f64);
    divided(half as u64, rounds, step_s)
}

/// Samples of the kernel with whole rounds where the record has them, and few enough rounds.
fn divided(half: u64, rounds: f64, step_s: f64) -> Result<Steps, Refusal> {
    if rounds < 1.0 {
        let found = format!("a sample lasts {} of the shortest part of the integration", shown(rounds));
        return Err(Refusal::new(SAMPLE.name, found, "take a longer sampling time"));
    }
    let division = libm::ceil(rounds / MAX_ROUNDS as f64);
    Ok(Steps { half, interval: rounds / division, division: division as u64, step_s })
}

/// The largest divisor of `whole` that is at most `most`.
fn divisor(whole: u64, most: u64) -> u64 {
    (1..=most.min(whole)).rev().find(|&part| whole.is_multiple_of(part)).unwrap_or(1)
}

/// The largest amplitude of the dither that is drawn, relative to its own.
pub(crate) fn largest(dither: &Dither, times: &Times) -> f64 {
    let halves = 2.0 * dither.frequency_hz * times.length_s() + 4.0;
    let walk = dither.amplitude_walk * libm::sqrt(halves);
    1.0 + REACH * dither.amplitude_noise + REACH * walk
}

/// The largest input rate, ″/s.
pub(crate) fn most_rate(inputs: &Inputs, times: &Times) -> f64 {
    let end = inputs.rate + inputs.ramp * times.length_s();
    let of_motion = inputs.motion.as_ref().map_or(0.0, |motion| motion::most_rate(motion, MEASURED_S));
    libm::fmax(libm::fabs(inputs.rate), libm::fabs(end)) + of_motion
}
