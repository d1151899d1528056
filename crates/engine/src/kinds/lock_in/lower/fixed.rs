//! The words of a gyro with lock-in, and the proof that they fit.

use core::f64::consts::{PI, TAU};
use core::ops::Range;

use crate::key::{Unrepresentable, shown};
use crate::kinds::lock_in::lower::{self, Steps, largest};
use crate::kinds::lock_in::{AMPLITUDE_NOISE, DITHER_RATE, Inputs, LENGTH, Readout, THRESHOLD, Times};
use crate::motion::Motion;
use sagnac_kernel::lock_in::{KICKS, LockIn, ROUND, Readout as Angle, SHORT_SINE};
use sagnac_kernel::normal::REACH;
use sagnac_kernel::recipe::Level;

/// A turn in units of 2^−32 and 2^−64 turns.
const WORD: f64 = 4_294_967_296.0;
const WIDE: f64 = WORD * WORD;
/// Units of standard deviations.
const SIGMA_UNITS: f64 = 16.0;
/// Most LSB of the largest angle and four times the dither's. Where the rate is at most R, second differences in a record of length T
/// are at most R·T and third ones 4/3 of it; those of the dither are at most 4 and 8 times its angle. All stay below 2^29.
const MAX_ANGLE: f64 = 268_435_456.0; // 2^28
/// Most bits of the lock-in beyond a word, and least units of it in a step.
const MAX_FINE: f64 = 31.0;
const MIN_KICK: f64 = 1024.0;
/// Largest phase of a step at a zero crossing, rad, with which the end of a sum of steps is known.
const MAX_TURN: f64 = 1.9 * PI;
/// Quarters of a unit.
const END_UNITS: f64 = 4.0;
/// Fewest units of a standard deviation that is not 0.
const MIN_SIGMA: f64 = 50.0;
/// Coarsest LSB, in pulses.
const COARSEST: f64 = 0.02;
/// Most half-cycles of a record with motion, each of which has a word.
const MAX_HALVES: u64 = 1 << 26;
/// ″ of a turn of the dither's phase.
const ARCSEC_PER_TURN: f64 = 1_296_000.0;

/// Words that follow from a point, and their units.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fixed {
    pub(crate) steps: Steps,
    /// Unit of angle, ″.
    pub(crate) lsb_arcsec: f64,
    /// Time from one sample of the kernel to the next, s.
    pub(crate) kernel_sample_s: f64,
    /// Lock-in of a step, turns.
    kick: f64,
    fine: u32,
    lsb: u32,
    /// Amplitude of the dither, turns; 0 without dither.
    amplitude: f64,
    amplitude_bits: u32,
    /// Time of a half-cycle, s.
    half_s: f64,
}

impl Fixed {
    pub(crate) fn new(inputs: &Inputs, times: &Times, steps: Steps) -> Result<Fixed, Unrepresentable> {
        let q = inputs.scale_factor;
        let kick = inputs.threshold * steps.step_s / q;
        // A round adds at most ROUND·c, which stays below 2^31 units.
        let fine = libm::floor(libm::log2(0.499 / (ROUND as f64 * kick)));
        if fine < 0.0 {
            let found =
                format!("a step of the integration locks by {} turns, and the most are 0.03", shown(kick));
            return Err(Unrepresentable::new(THRESHOLD.name, found, "take a lower threshold"));
        }
        let (half_s, count) = ((steps.half * ROUND as u64) as f64 * steps.step_s, steps.count(times));
        let beam = inputs.beam_noise / q * libm::sqrt(half_s);
        // The noise of the beam in a half-cycle has a word of its own.
        let fine = if beam > 0.0 {
            libm::fmin(fine, libm::floor(-libm::log2(2.0 * SIGMA_UNITS * beam)))
        } else {
            fine
        };
        // The largest angle, in turns: the lock-in of all steps, and the noise of the beam.
        let largest_angle = kick * count + 2.0 * REACH * beam * libm::sqrt(count);
        if fine < 0.0 {
            let found =
                format!("the beam turns by {} turns in a half-cycle, and the most are 0.03", shown(beam));
            return Err(Unrepresentable::new("lock_in.beam_noise", found, "take less noise of the beam"));
        }
        let (amplitude, amplitude_bits, dither) = match &inputs.dither {
            Some(dither) => {
                let amplitude = dither.rate / (TAU * dither.frequency_hz * q);
                let most = amplitude * largest(dither, times) * 1.001;
                let bits = libm::fmin(libm::floor(31.0 - libm::log2(most)), 32.0);
                if bits < 12.0 {
                    let found =
                        format!("the dither turns the beat by {} turns, and the most are 5e5", shown(most));
                    return Err(Unrepresentable::new(DITHER_RATE.name, found, "take a lower dither rate"));
                }
                (amplitude, bits, if dither.readout == Readout::Stripped { 0.0 } else { most })
            }
            None => (0.0, 32.0, 0.0),
        };
        // The LSB is 2^(lsb − 32 − fine) turns, and no smaller than the unit in which the dither is read.
        let needed = libm::ceil(libm::log2((largest_angle + 4.0 * dither) / MAX_ANGLE) + 32.0);
        let needed = if dither > 0.0 { libm::fmax(needed, 34.0 - amplitude_bits) } else { needed };
        // The finest units in which an LSB still has at most 31 bits.
        let fine = libm::fmin(libm::fmin(fine, MAX_FINE), 31.0 - needed);
        let fine = libm::fmin(fine, libm::floor(62.0 - libm::log2(largest_angle * WORD + 1.0)));
        let lsb = libm::fmax(needed + fine, 0.0);
        let turns = libm::exp2(lsb - 32.0 - fine);
        if fine < 0.0 || turns > COARSEST || kick * libm::exp2(32.0 + fine) < MIN_KICK {
            let found = format!(
                "over {} s the lock-in can turn the angle by {} pulses, of which 32 bits show {} at the least",
                shown(times.length_s()),
                shown(largest_angle + dither),
                shown((largest_angle + 4.0 * dither) / MAX_ANGLE)
            );
            return Err(Unrepresentable::new(LENGTH.name, found, "take a shorter record"));
        }
        let kernel_sample_s = times.sample_s / steps.division as f64;
        Ok(Fixed {
            steps,
            lsb_arcsec: turns * q,
            kernel_sample_s,
            kick,
            fine: fine as u32,
            lsb: lsb as u32,
            amplitude,
            amplitude_bits: amplitude_bits as u32,
            half_s,
        })
    }

    /// The recipe of the kernel.
    pub(crate) fn recipe(
        &self,
        inputs: &Inputs,
        times: &Times,
        key: [u32; 2],
        samples: u64,
        order: u32,
        levels: Vec<Level>,
    ) -> Result<LockIn, Unrepresentable> {
        let Fixed { steps, fine, .. } = *self;
        let unit = libm::exp2(f64::from(32 + fine));
        let of_amplitude = libm::exp2(f64::from(self.amplitude_bits));
        let dither = inputs.dither.clone().unwrap_or_default();
        let part = |key: &'static str, part: f64| {
            let word = part * self.amplitude * of_amplitude * SIGMA_UNITS;
            match () {
                () if part > 0.0 && word < MIN_SIGMA => {
                    let found = format!("{} of the amplitude is lost in 32 bits", shown(part));
                    Err(Unrepresentable::new(key, found, "make it larger, or 0"))
                }
                () => Ok(libm::round(word) as u32),
            }
        };
        let amplitude_noise = [
            part(AMPLITUDE_NOISE.name, dither.amplitude_noise)?,
            part("dither.amplitude_walk", dither.amplitude_walk)?,
        ];
        let phase_noise = libm::round(dither.phase_noise / ARCSEC_PER_TURN * WORD * SIGMA_UNITS) as u32;
        let beam = inputs.beam_noise / inputs.scale_factor * libm::sqrt(self.half_s) * unit * SIGMA_UNITS;
        let per_step = |rate: f64| rate * steps.step_s / inputs.scale_factor * WIDE;
        // The change of a half-cycle comes at its end: half of it is there from the start, so that the angles at the ends are right.
        let change = inputs.ramp * self.half_s;
        let interval = libm::round(steps.interval * WORD) as u64;
        let period = if inputs.dither.is_some() { dither.frequency_hz * self.kernel_sample_s } else { 0.0 };
        let readout = match inputs.readout() {
            Readout::Stripped => Angle::Stripped,
            Readout::Dithered => Angle::Dithered,
            Readout::Demodulated => Angle::Demodulated,
        };
        let dither_lsb = match readout {
            Angle::Stripped => 0,
            _ => self.amplitude_bits + self.lsb - 2 - 32 - fine,
        };
        Ok(LockIn {
            key,
            samples: samples as u32,
            interval: [interval as u32, (interval >> 32) as u32],
            half: steps.half as u32,
            kick: kick_words(self.kick * unit),
            fine,
            end: if times.periods > 0 { self.end(unit) } else { 0 },
            rate: libm::round(per_step(inputs.rate + 0.5 * change)) as i128 as u64,
            ramp: libm::round(per_step(change)) as i128 as u64,
            amplitude: libm::round(self.amplitude * of_amplitude) as u32,
            amplitude_bits: self.amplitude_bits,
            amplitude_noise,
            phase_noise,
            beam: libm::round(beam) as u32,
            lsb: self.lsb,
            readout,
            dither_lsb,
            sample_phase: libm::round((period - libm::floor(period)) * WIDE) as u128 as u64,
            third: (samples as u32).div_ceil(3),
            table: self.table(inputs, phase_noise > 0).into(),
            motion: false,
            order,
            levels,
        })
    }

    /// What the integral of the lock-in up to a zero crossing has beyond the sum of steps, in quarters of these units: a sum of
    /// steps of v radians ends with 1/(2 sin ½v), its integral with 1/v.
    fn end(&self, unit: f64) -> u32 {
        let turn = TAU * PI * self.amplitude / (self.steps.half as f64 * ROUND as f64);
        if turn <= 0.0 || turn > MAX_TURN {
            return 0;
        }
        let beyond = 0.5 / libm::sin(0.5 * turn) - 1.0 / turn;
        libm::round(END_UNITS * self.kick * unit * beyond) as u32
    }

    /// Adds the motion of the base to a recipe; returns its mean rate between the middles of the first and the last third of the
    /// record, ″/s.
    pub(crate) fn add_motion(
        &self,
        motion: &Motion,
        scale_factor: f64,
        recipe: &mut LockIn,
    ) -> Result<f64, Unrepresentable> {
        let count = recipe.half_cycles();
        if count > MAX_HALVES {
            let found = format!(
                "the record has {} half-cycles, and with [motion] the most are {MAX_HALVES}",
                shown(count as f64)
            );
            return Err(Unrepresentable::new(LENGTH.name, found, "take a shorter record"));
        }
        let interval = self.steps.interval / self.steps.half as f64;
        let needed = libm::ceil(f64::from(recipe.samples) * interval) as usize;
        let angles = lower::angles(motion, self.half_s, needed)?;
        // The words of the half-cycles are differences of rounded angles, so that their sum does not drift.
        let unit = WORD / scale_factor / (self.steps.half as f64 * ROUND as f64);
        let rounded = |angle: f64| libm::round(angle * unit) as i64;
        let words = angles.windows(2).map(|ends| rounded(ends[1]).wrapping_sub(rounded(ends[0])) as u32);
        let mut table: Vec<u32> = recipe.table.iter().copied().chain(words).collect();
        // Half-cycles after the record.
        table.resize(table.len() + count as usize - needed, 0);
        (recipe.table, recipe.motion) = (table.into(), true);
        let at = |sample: u32| {
            let place = f64::from(sample) * interval;
            let before = (place as usize).min(needed - 1);
            angles[before] + (place - before as f64) * (angles[before + 1] - angles[before])
        };
        let mean = |samples: Range<u32>| samples.map(at).sum::<f64>() / f64::from(recipe.third);
        let LockIn { samples, third, .. } = *recipe;
        let apart = f64::from(samples + 1 - third) * self.kernel_sample_s;
        Ok((mean(samples + 1 - third..samples + 1) - mean(0..third)) / apart)
    }

    /// The sine of the dither in the middle of each step of a half-cycle and, where it has noise, the phase there.
    fn table(&self, inputs: &Inputs, phases: bool) -> Vec<u32> {
        if inputs.dither.is_none() {
            return vec![];
        }
        let steps = self.steps.half as usize * ROUND;
        let turn = |step: usize| (step as f64 + 0.5) / steps as f64;
        let sine =
            |step| libm::fmin(libm::round(libm::sin(PI * turn(step)) * 0.5 * WORD), 2_147_483_647.0) as u32;
        let phase = |step| libm::round(0.5 * turn(step) * WORD) as u32;
        let sines = (0..steps).map(sine);
        match phases {
            true => sines.chain((0..steps).map(phase)).collect(),
            false => sines.collect(),
        }
    }
}

/// The words of the polynomial of c·sin ψ, with c in units of the lock-in: sin(πz/2)/z in z² whose square is taken in units of
/// 2^−30, for a product with z in units of 2^−31.
fn kick_words(c: f64) -> [u32; KICKS] {
    core::array::from_fn(|k| {
        let term = f64::from(SHORT_SINE[k]) / libm::exp2(31.0 + k as f64);
        libm::round(2.0 * c * term * libm::exp2(2.0 * k as f64)) as u32
    })
}
