//! Lowering of a gyro with lock-in: from thresholds and rates to the words of the kernel, and the proof that they fit.
//!
//! Words are read as the kernel uses them: the lock-in of a step at a quarter turn, the number of steps of a half-cycle and of a
//! sample, the amplitude of the dither and the noise of the beam. Time is that of the samples, and angles are in the LSB of the
//! table. None of what lowering computed on the way to the words is used.
//!
//! The midpoint rule with n steps in a period of the dither replaces the lock-in of zone k, J_k(Θ), by Σ J_{k+mn}(Θ) over all
//! whole m, because the samples of an angle that turns n times more look the same. J_ν(Θ) falls faster than any exponential
//! once ν exceeds Θ: it is below 10^−9 for ν = Θ + 8 Θ^{1/3}. The steps of a period tell the largest amplitude from its alias
//! by that bound, and half of them that of nearly every half-cycle, so that an integration with half the steps shows the error
//! of this one. Where the amplitude changes, at the zero crossings, a sum of samples differs from the integral by up to its
//! next term, which n ≥ 2.2 Θ keeps below 10^−4 of a jump at a reversal. Where a sample ends the sum, the kernel adds that
//! term. The explicit step of the lock-in itself errs by π²c² of c. `docs/dev/numerics.md` has the derivations.

pub(crate) mod fixed;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::key::sweep::SweepTarget;
use crate::key::{Key, ParseContext, Streams, Unrepresentable, shown};
use crate::kinds::allan::lower::levels;
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::lock_in::lower::fixed::Fixed;
use crate::kinds::lock_in::{DITHER_RATE, Dither, Inputs, Point, RATE, Readout, SAMPLE, THRESHOLD, Times};
use crate::kinds::plan::identity;
use crate::motion::keys::{
    AMPLITUDE, FREQUENCY, INTERPOLATION, MOTION, OF_SEVERAL, PHASE, PROFILE, PROFILE_FILE, Phase, TONES,
};
use crate::motion::{Amplitude, Frequency, Motion, Tone, Value, keys};
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::quantity::Dimension;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::lock_in::{LockIn, OTHER_VALUES, ROUND, VERSION};
use sagnac_kernel::normal::REACH;
use sagnac_theory::allan::{Difference, Estimator};
use sagnac_theory::lock_in::{LockIn as LockInTheory, Premise, mean_rate};

/// Gyros of one point, ready to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Gyros {
    recipe: LockIn,
    fixed: Fixed,
    estimator: Estimator,
    /// Averaging times, s, with the number of differences at each and its place in the sums of the kernel.
    averaged: Vec<(f64, u64, usize)>,
    /// Mean input rate between the middles of the first and the last third of the record, ″/s.
    pub(crate) input_rate: f64,
    /// Relative difference of N in closed form for the words from that for the inputs, where there is one.
    pub representation: Option<f64>,
    /// Address of the values of the gyros in the store.
    pub(crate) address: Address,
}

impl Gyros {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Unrepresentable`].
    pub fn new(
        point: &Point,
        estimator: Estimator,
        seed: u64,
        streams: Streams,
    ) -> Result<Gyros, Unrepresentable> {
        let Point { inputs, times, .. } = point;
        let steps = Steps::new(inputs, times)?;
        let motion = inputs.motion.as_ref().map_or(String::new(), |motion| format!("motion={motion:?}\n"));
        let text = format!(
            "sample_s={:.11e}\nsamples={}\n{}{motion}",
            times.sample_s,
            times.samples,
            inputs.canonical()
        );
        let (of_draws, key) = identity("lock-in", seed, streams, &text);
        // Other steps take the same draws, but are another point.
        let id = match inputs.refinement {
            1.0 => of_draws,
            other => identity("lock-in", seed, streams, &format!("{text}refinement={other:.11e}\n")).0,
        };
        let ms: Vec<u64> = times.ms.iter().map(|m| m * steps.division).collect();
        let samples = times.samples * steps.division;
        let (levels, places) = levels(estimator, &ms);
        let order = match estimator.difference {
            Difference::Second => 2,
            Difference::Third => 3,
        };
        let fixed = Fixed::new(inputs, times, steps)?;
        let mut recipe = fixed.recipe(inputs, times, key, samples, order, levels)?;
        let mut input_rate = inputs.rate + 0.5 * inputs.ramp * times.length_s();
        if let Some(motion) = &inputs.motion {
            input_rate += fixed.add_motion(motion, inputs.scale_factor, &mut recipe)?;
        }
        let physical = angle_random_walk(point);
        let lowered = physical.map(|_| LoweredTheory::new(&recipe, times, fixed.lsb_arcsec));
        if let Some((lowered, physical)) = lowered.zip(physical) {
            lowered.check(physical)?;
        }
        let representation = sampling::representation(lowered.map(|lowered| lowered.walk), physical, 0.0);
        let averaged = times.ms.iter().zip(&ms).zip(places);
        let averaged = averaged.map(|((m, &of_kernel), place)| {
            (times.sample_s * *m as f64, estimator.terms(samples, of_kernel), place)
        });
        let averaged: Vec<(f64, u64, usize)> = averaged.collect();
        let words = digest(&recipe).into_iter().chain(words_of(fixed.lsb_arcsec));
        let address = Address {
            point: id,
            estimate: Id::from_text(&format!("estimate\n{estimator:?}\nms={:?}\n", times.ms)),
            digest: Id::of_words(words),
        };
        Ok(Gyros { recipe, fixed, estimator, averaged, input_rate, representation, address })
    }

    /// The recipe for the kernel.
    pub fn recipe(&self) -> &LockIn {
        &self.recipe
    }

    /// The unit of angle, ″.
    pub fn lsb_arcsec(&self) -> f64 {
        self.fixed.lsb_arcsec
    }

    /// The angles by which the output of a gyro departs from its input in each sample of its record, LSB.
    pub fn departures(&self, number: u64) -> impl Iterator<Item = i32> {
        let angles = self.recipe.trace(number).angles.into_iter();
        let angles: Vec<i32> = angles.step_by(self.fixed.steps.division as usize).collect();
        (1..angles.len()).map(move |sample| angles[sample].wrapping_sub(angles[sample - 1]))
    }

    /// Length of a step of the integration, s.
    pub fn step_s(&self) -> f64 {
        self.fixed.steps.step_s
    }

    /// The variances of one gyro, (″/s)², for each averaging time, from its values as the kernel returns them.
    pub fn variances(&self, values: &[u128]) -> Vec<f64> {
        let one = |&(tau_s, terms, place): &(f64, u64, usize)| {
            let per_tau = self.fixed.lsb_arcsec / tau_s;
            values[place] as f64 / terms as f64 * per_tau * per_tau / self.estimator.difference.divisor()
        };
        self.averaged.iter().map(one).collect()
    }

    /// The mean output rate of one gyro, ″/s, from its values: that between the middles of the first and the last third of the record,
    /// whose angles are averaged, so that a beat that is cut off hardly counts.
    pub fn mean_rate(&self, values: &[u128]) -> f64 {
        let others = &values[values.len() - OTHER_VALUES..];
        let LockIn { samples, third, .. } = self.recipe;
        let difference = (others[1] as u64).wrapping_sub(others[0] as u64) as i64;
        let apart = f64::from(samples + 1 - third) * self.fixed.kernel_sample_s;
        self.input_rate + difference as f64 / f64::from(third) * self.fixed.lsb_arcsec / apart
    }

    /// Bound of the deviation of N at an averaging time due to the rounding of the angle, ″/√s, where N is about `walk`.
    pub(crate) fn rounding(&self, tau_s: f64, walk: f64) -> f64 {
        // Each angle is rounded down: a variance of LSB²/12, of which a difference of second order has six.
        let variance = 0.25 * self.fixed.lsb_arcsec * self.fixed.lsb_arcsec / tau_s;
        libm::sqrt(walk * walk + variance) - walk
    }

    /// Integers of a gyro.
    pub(crate) fn width(&self) -> usize {
        self.recipe.values()
    }

    /// The recipe, to be shared.
    pub(crate) fn shared(&self) -> Arc<dyn Recorded> {
        Arc::new(self.recipe.clone())
    }
}

/// All words that determine the values of gyros, with the version of the kernel.
fn digest(recipe: &LockIn) -> Vec<u32> {
    let LockIn { table, levels, motion, readout, .. } = recipe;
    let mut words = vec![VERSION, u32::from(*motion), *readout as u32, recipe.order];
    // The dispatch has every other word.
    words.extend(recipe.parameters(0, 1, [0, 1]));
    words.push(table.len() as u32);
    words.extend(table.iter());
    for level in levels {
        words.extend([level.stride, level.spans.len() as u32]);
    }
    words
}

/// A zone of dynamic lock-in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Zone {
    /// Its number k.
    pub(crate) number: i32,
    /// Its centre, ″/s.
    pub(crate) centre: f64,
    /// Its half width without noise of the dither, ″/s.
    pub(crate) half_width: f64,
}

/// Largest number of a zone whose width is computed.
const MAX_ZONES: f64 = 1e6;

impl Zone {
    /// The zone whose centre is nearest to `rate`, ″/s; none without dither.
    pub(crate) fn nearest(inputs: &Inputs, rate: f64) -> Option<Zone> {
        let gyro = inputs.gyro()?;
        let number = libm::round(rate / gyro.zone_centre(1));
        if libm::fabs(number) > MAX_ZONES {
            return None;
        }
        let number = number as i32;
        Some(Zone { number, centre: gyro.zone_centre(number), half_width: gyro.zone_half_width(number) })
    }
}

/// Why the angle random walk has no closed form at a point; empty where it has one, `None` without dither.
pub(crate) fn failing(point: &Point) -> Option<Vec<Premise>> {
    let (inputs, gyro) = (&point.inputs, point.inputs.gyro()?);
    let spread = inputs.dither.as_ref()?.spread(point.times.length_s());
    Some(gyro.failing_premises(spread, inputs.rate))
}

/// The angle random walk from lock-in and the noise of the beam, ″/√s.
pub(crate) fn angle_random_walk(point: &Point) -> Option<f64> {
    let holds = failing(point)?.is_empty() && is_plain(&point.inputs);
    let of_lock_in = point.inputs.gyro().as_ref().map(LockInTheory::angle_random_walk)?;
    holds.then(|| libm::hypot(of_lock_in, point.inputs.beam_noise))
}

/// The mean output rate, ″/s: without dither, and in a zone that no noise breaks up.
pub(crate) fn mean_output(point: &Point) -> Option<f64> {
    let inputs = &point.inputs;
    if inputs.ramp != 0.0 || inputs.beam_noise > 0.0 || inputs.motion.is_some() {
        return None;
    }
    let Some(dither) = &inputs.dither else { return Some(mean_rate(inputs.rate, inputs.threshold)) };
    let is_quiet = dither.spread(point.times.length_s()) == 0.0 && dither.phase_noise == 0.0;
    let zone = Zone::nearest(inputs, inputs.rate)?;
    // Half widths are of first order in Ω_L; the second order shifts the edges.
    let shift = inputs.threshold * inputs.threshold / (2.0 * inputs.gyro()?.zone_centre(1));
    let inside = libm::fabs(inputs.rate - zone.centre) + shift < INSIDE * zone.half_width;
    (is_quiet && inside).then_some(zone.centre)
}

/// Part of a zone's half width in which a gyro locks within a record.
const INSIDE: f64 = 0.9;

/// Whether the angle that is put out is the one of the closed form.
fn is_plain(inputs: &Inputs) -> bool {
    inputs.readout() == Readout::Stripped && inputs.ramp == 0.0 && inputs.motion.is_none()
}

/// Relative error of the polynomial at a quarter turn, 2^−19.7, and of the steps of a sample, whose last bit is 2^−32 rounds.
const POLYNOMIAL: f64 = 1.3e-6;

/// N of the words, ″/√s, with the bound of its deviation from that of the inputs due to the rounding of words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoweredTheory {
    pub(crate) walk: f64,
    pub(crate) bound: f64,
}

impl LoweredTheory {
    /// The theory of a gyro with dither, whose angles have the LSB `lsb_arcsec`.
    pub(crate) fn new(recipe: &LockIn, times: &Times, lsb_arcsec: f64) -> LoweredTheory {
        let [fraction, whole] = recipe.interval.map(f64::from);
        let steps = f64::from(recipe.samples) * (whole + fraction / WORD) * ROUND as f64;
        let step_s = times.samples as f64 * times.sample_s / steps;
        let half_s = f64::from(recipe.half) * ROUND as f64 * step_s;
        // ″ of a unit of the lock-in and of a turn.
        let unit = lsb_arcsec / libm::exp2(f64::from(recipe.lsb));
        let turn = unit * libm::exp2(32.0 + f64::from(recipe.fine));
        let kick = kick(recipe);
        let dither_frequency = 0.5 / half_s;
        let amplitude = turn * f64::from(recipe.amplitude) / libm::exp2(f64::from(recipe.amplitude_bits));
        let gyro = LockInTheory {
            threshold: kick * unit / step_s,
            scale_factor: turn,
            dither_rate: TAU * dither_frequency * amplitude,
            dither_frequency,
        };
        // A unit of the word of the beam's noise.
        let of_beam = unit / 16.0 / libm::sqrt(half_s);
        let (lock_in, beam) = (gyro.angle_random_walk(), of_beam * f64::from(recipe.beam));
        // N ∝ c/√A, for the half units of c's terms and of A, which has at least 2^11 units.
        let of_kick = KICK_ROUNDING / kick + POLYNOMIAL;
        let of_amplitude = 0.2501 / f64::from(recipe.amplitude);
        let of_lock_in = (1.0 + of_kick) * (1.0 + of_amplitude) - 1.0;
        LoweredTheory { walk: libm::hypot(lock_in, beam), bound: lock_in * of_lock_in + 0.5 * of_beam }
    }

    /// # Errors
    /// N differs from `physical`, that of the inputs, by more than the rounding of words explains.
    pub(crate) fn check(&self, physical: f64) -> Result<(), Unrepresentable> {
        // A difference that is not a number is refused.
        if (self.walk - physical).abs() <= self.bound {
            return Ok(());
        }
        let found = format!(
            "the angle random walk is {} arcsec/sqrt(s) for the integers that would be sampled and {} arcsec/sqrt(s) for the \
             inputs, which rounding to {} arcsec/sqrt(s) does not explain",
            shown(self.walk),
            shown(physical),
            shown(self.bound)
        );
        Err(Unrepresentable::new(
            THRESHOLD.name,
            found,
            "this is a fault of the program: please report the study",
        ))
    }
}

/// 2^32.
const WORD: f64 = 4_294_967_296.0;

/// Half a unit of each word of [`kick`].
const KICK_ROUNDING: f64 = 0.25 * (1.0 + 1.0 / 4.0 + 1.0 / 16.0 + 1.0 / 64.0);

/// The lock-in of a step at a quarter turn, in its unit: the kernel's polynomial at z = 2^31, where the word of z² is a quarter of a
/// whole one and that of z half of one.
fn kick(recipe: &LockIn) -> f64 {
    0.5 * recipe.kick.iter().rev().fold(0.0, |sum, word| f64::from(*word) - 0.25 * sum)
}

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
    pub(crate) fn new(inputs: &Inputs, times: &Times) -> Result<Steps, Unrepresentable> {
        let steps = match &inputs.dither {
            Some(dither) => dithered(inputs, dither, times)?,
            None => undithered(inputs, times)?,
        };
        let count = times.length_s() / steps.step_s;
        if count > MAX_STEPS {
            let found =
                format!("the record takes {} steps, and the most are {}", shown(count), shown(MAX_STEPS));
            return Err(Unrepresentable::new("record.length", found, "take a shorter record"));
        }
        Ok(steps)
    }

    /// Steps of a record.
    pub(crate) fn count(&self, times: &Times) -> f64 {
        times.length_s() / self.step_s
    }
}

fn dithered(inputs: &Inputs, dither: &Dither, times: &Times) -> Result<Steps, Unrepresentable> {
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
        return Err(Unrepresentable::new(key, found, help));
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

fn undithered(inputs: &Inputs, times: &Times) -> Result<Steps, Unrepresentable> {
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
fn divided(half: u64, rounds: f64, step_s: f64) -> Result<Steps, Unrepresentable> {
    if rounds < 1.0 {
        let found = format!("a sample lasts {} of the shortest part of the integration", shown(rounds));
        return Err(Unrepresentable::new(SAMPLE.name, found, "take a longer sampling time"));
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
fn most_rate(inputs: &Inputs, times: &Times) -> f64 {
    let end = inputs.rate + inputs.ramp * times.length_s();
    let of_motion = inputs.motion.as_ref().map_or(0.0, |motion| max_motion_rate(motion, MEASURED_S));
    libm::fmax(libm::fabs(inputs.rate), libm::fabs(end)) + of_motion
}

/// The keys of the motion that this kind of study has.
pub(crate) fn keys() -> Vec<&'static Key> {
    let tone = [OF_SEVERAL.amplitude, OF_SEVERAL.frequency, OF_SEVERAL.phase];
    let own = [&MOTION, &AMPLITUDE, &FREQUENCY, &PHASE, &TONES, &PROFILE, &PROFILE_FILE, &INTERPOLATION];
    own.into_iter().chain(tone).collect()
}

/// The settings of a single tone.
pub(crate) static SETTINGS: [SweepTarget<Inputs>; 2] = [
    SweepTarget::where_it_applies(&AMPLITUDE, has_one_tone, |inputs, new| {
        let of_angle = new.dimension == Dimension::Angle;
        with_tone(inputs, |tone| tone.amplitude = Amplitude { of_angle, value: Value::Fixed(new.value) });
    }),
    SweepTarget::where_it_applies(&FREQUENCY, has_one_tone, |inputs, new| {
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
pub(crate) fn read_motion(reading: &mut ParseContext) -> Result<Option<Motion>, Wrong> {
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
fn max_motion_rate(motion: &Motion, tick_s: f64) -> f64 {
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
pub(crate) fn angles(motion: &Motion, step_s: f64, count: usize) -> Result<Vec<f64>, Unrepresentable> {
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
            return Err(Unrepresentable::new(
                "motion.profile",
                found,
                "take a shorter record, or a longer profile",
            ));
        }
        let mut sum = 0.0;
        for (angle, tick) in angles[1..].iter_mut().zip(ticks) {
            sum += tick;
            *angle += sum;
        }
    }
    Ok(angles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::Streams;
    use crate::kinds::lock_in::verify::checked;
    use crate::kinds::lock_in::{Dither, Inputs, Point};
    use sagnac_theory::allan::Estimator;

    /// The words are those of one gyro and the inputs those of another.
    #[test]
    fn words_that_do_not_stand_for_an_input_are_refused_by_name() {
        let point = |inputs: Inputs| {
            let times = Times { sample_s: 0.0025, periods: 1, samples: 4000, ms: vec![1] };
            Point { swept: vec![], inputs, times }
        };
        // Noise of the beam as large as that of lock-in.
        let inputs = Inputs { beam_noise: 0.17, ..checked() };
        let own = point(inputs.clone());
        let gyros = Gyros::new(&own, Estimator::OVERLAPPING, 1, Streams::Independent).unwrap();
        let lowered = LoweredTheory::new(gyros.recipe(), &own.times, gyros.lsb_arcsec());
        let checked = |inputs: Inputs| lowered.check(angle_random_walk(&point(inputs)).unwrap());
        assert_eq!(checked(inputs.clone()), Ok(()));
        let with = |change: fn(&mut Dither)| {
            let mut inputs = inputs.clone();
            inputs.dither.as_mut().into_iter().for_each(change);
            inputs
        };
        let most = 2.0 * lowered.bound / lowered.walk;
        assert!(most < 1e-3, "{most}");
        let changed = [
            ("threshold", Inputs { threshold: 180.0 * 1.002, ..inputs.clone() }),
            ("scale factor", Inputs { scale_factor: 2.0 * 1.004, ..inputs.clone() }),
            ("noise of the beam", Inputs { beam_noise: 0.17 * 1.002, ..inputs.clone() }),
            ("dither rate", with(|dither| dither.rate *= 1.004)),
        ];
        for (name, inputs) in changed {
            let refused = checked(inputs).map_err(|refusal| refusal.key);
            assert_eq!(refused, Err("lock_in.threshold"), "{name}");
        }
    }
}
