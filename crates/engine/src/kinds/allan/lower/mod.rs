//! Lowering of a noise model to records: from Q, N, B, … in ″ and s to the words of a [`Recipe`].
//!
//! ```text
//! Asked ─ model ─▶ Model ─ fixed ─▶ Fixed ─┬─ drift, levels ─▶ Recipe
//!                                         └─ theory ─▶ Theory
//! ```
//!
//! Words, unit of angle and headroom: `docs/dev/numerics.md`, "Synthetic records".

pub(crate) mod fixed;
pub mod theory;

use core::f64::consts::PI;

use crate::key::Unrepresentable;
use crate::kinds::allan::lower::fixed::Fixed;
pub use crate::kinds::allan::lower::theory::Theory;
use crate::kinds::gap_fill::lower::words_of;
use crate::motion::record::{MOTION_BITS, MOTION_UNITS};
use crate::tally::Id;
use sagnac_kernel::allan;
use sagnac_kernel::recipe::{Level, Recipe};
use sagnac_theory::allan::terms::{Row, Source, Term};
use sagnac_theory::allan::{Difference, Estimator, Part, Process, flicker};
use sagnac_theory::drift::Switching;

/// Samples of the longest record of a study, whose drift takes 4 bytes per sample.
pub const MAX_SAMPLES: u64 = 1 << 26;

/// Samples of the longest record that is made sample by sample. One that is longer than those of studies has room for their differences
/// only: its angles wrap over longer times.
pub const MAX_MADE: u64 = (1 << 31) - 64;

/// A request for records.
#[derive(Debug, Clone)]
pub struct Asked<'a> {
    /// Noise process with any parts, but at most one Markov noise and one sine. The octaves of bias instability follow
    /// from the record, whatever the part says.
    pub process: &'a Process,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub readout_lsb: f64,
    /// Constant rate of the gyro, ″/s; it affects only a readout in whole pulses.
    pub mean_rate: f64,
    /// Switching, of a gyro that switches modes.
    pub switching: Option<Switching>,
    /// Number of rate samples N.
    pub samples: u64,
    /// Order and spacing of the differences.
    pub estimator: Estimator,
    /// Averaging factors, ascending.
    pub ms: &'a [u64],
    /// Philox key of the point.
    pub key: [u32; 2],
}

/// Records of a noise model, ready to be made: the words of the kernel with their closed forms.
///
/// The unit of angle and the draws depend on process, readout, rate, switching and length only; another estimator or
/// other averaging factors take other differences of the same angles.
///
/// ```
/// use sagnac_engine::device::Cpu;
/// use sagnac_kernel::width::Width;
/// use sagnac_engine::kinds::allan::lower::{Asked, Records};
/// use sagnac_theory::allan::{Estimator, Part, Process};
///
/// let white = Part::angle_random_walk(0.04);
/// let records = Records::new(&Asked {
///     process: &Process { sample_s: 1.0, parts: vec![white] },
///     readout_lsb: 0.0,
///     mean_rate: 0.0,
///     switching: None,
///     samples: 1000,
///     estimator: Estimator::OVERLAPPING,
///     ms: &[1, 10, 100],
///     key: [1, 2],
/// })?;
/// let sums = Cpu::new(Width::widest(), 1)?.sums(records.recipe(), 0, 1, &|_| {});
/// // σ²(1 s) of one record, and its mean over all records.
/// let (found, expected) = (records.variances(&sums)[0], records.theory(0).value.unwrap());
/// assert!((found / expected - 1.0).abs() < 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Records {
    recipe: Recipe,
    estimator: Estimator,
    sample_s: f64,
    fixed: Fixed,
    /// Whether a ramp, a warm-up or an alternating drift is present.
    curved: bool,
    /// Rate that the angles common to all records lack: that of warm-ups longer than the record, LSB per sample.
    lacking_rate: f64,
    /// Constant rate of the gyro with that of warm-ups longer than the record, ″ per sample.
    constant_rate: f64,
    ms: Vec<u64>,
    terms: Vec<u64>,
    /// Place of each averaging factor in the sums of the kernel.
    places: Vec<usize>,
}

impl Records {
    /// Lowers a noise model.
    ///
    /// # Errors
    /// The noise model cannot be represented; see [`Unrepresentable`].
    pub fn new(asked: &Asked) -> Result<Records, Unrepresentable> {
        Records::up_to(MAX_SAMPLES, asked)
    }

    /// Lowers a noise model for records of up to [`MAX_MADE`] samples, of which [`Records::increments`] are taken.
    ///
    /// # Errors
    /// It fails where [`Records::new`] does, and for noise that long records cannot have: what takes an angle for each sample, and
    /// bias instability beyond 2^27 samples.
    pub fn of_any_length(asked: &Asked) -> Result<Records, Unrepresentable> {
        let has_flicker = asked.process.parts.iter().any(|part| part.term == Term::BiasInstability);
        if has_flicker && flicker::octaves(asked.samples).is_none() {
            let found = format_args!("a record of {} samples is too long for it", asked.samples);
            let help = "take up to 2^27 samples: 134217728";
            return Err(Unrepresentable::new("noise.bias_instability", found, help));
        }
        Records::up_to(MAX_MADE, asked)
    }

    fn up_to(most: u64, asked: &Asked) -> Result<Records, Unrepresentable> {
        let Asked { samples, estimator, ms, .. } = *asked;
        if !(2..=most).contains(&samples) {
            return Err(too_long(samples, most));
        }
        let terms: Vec<u64> = ms.iter().map(|&m| estimator.terms(samples, m)).collect();
        if ms.is_empty() {
            let help = "give at least one averaging time";
            return Err(Unrepresentable::new("allan.tau", "no averaging time is given", help));
        }
        if let Some(at) = terms.iter().position(|&terms| terms == 0) {
            let found = format!(
                "an averaging time of {} samples has no difference in a record of {samples}, which needs {} of them",
                ms[at],
                estimator.difference.spans()
            );
            return Err(Unrepresentable::new("allan.tau", found, "leave it out, or take a longer record"));
        }
        let model = Model::new(asked)?;
        let fixed = Fixed::new(&model)?;
        if samples > MAX_SAMPLES && (model.is_curved() || fixed.rate != 0) {
            let found = format_args!(
                "a record of {samples} samples is too long for a ramp, a warm-up, an alternating drift or a constant rate in pulses"
            );
            let help = "take up to 2^26 samples: 67108864; a rate and an acceleration can be a motion";
            return Err(Unrepresentable::new("noise", found, help));
        }
        let (levels, places) = levels(estimator, ms);
        let recipe = Recipe {
            key: asked.key,
            samples: samples as u32,
            white: fixed.white,
            rate_scale: fixed.rate_scale,
            walk: fixed.walk,
            flicker: fixed.flicker.clone(),
            markov: fixed.markov,
            sine: fixed.sine,
            quantization: fixed.quantization,
            pulse: fixed.pulse,
            switching: fixed.switching,
            drift: fixed::angles(&model, &fixed),
            order: match estimator.difference {
                Difference::Second => 2,
                Difference::Third => 3,
            },
            levels,
        };
        let unfinished: f64 = model.unfinished().map(WarmUp::rate).sum();
        let lacking_rate = match fixed.pulse {
            Some(_) => 0.0,
            None => unfinished / fixed.lsb_arcsec,
        };
        Ok(Records {
            recipe,
            estimator,
            sample_s: asked.process.sample_s,
            fixed,
            curved: model.is_curved(),
            lacking_rate,
            constant_rate: asked.mean_rate * asked.process.sample_s + unfinished,
            ms: ms.to_vec(),
            terms,
            places,
        })
    }

    /// The recipe for the kernel.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Rate that the angles common to all records lack because it affects no difference, LSB per sample.
    pub(crate) fn lacking_rate(&self) -> f64 {
        self.lacking_rate
    }

    /// The words of the noise.
    pub(crate) fn fixed(&self) -> &Fixed {
        &self.fixed
    }

    /// Averaging factors, as given.
    pub fn ms(&self) -> &[u64] {
        &self.ms
    }

    /// Number of differences in a record at each averaging factor.
    pub fn terms(&self) -> &[u64] {
        &self.terms
    }

    /// The unit of angle, ″.
    pub fn lsb_arcsec(&self) -> f64 {
        self.fixed.lsb_arcsec
    }

    /// The angles between the samples of the record `number`, ″, in their order. They contain the constant rate, and their
    /// variances are those of the record's sums.
    pub fn increments(&self, number: u64) -> impl Iterator<Item = f64> {
        self.of_read(self.recipe.angles(number))
    }

    /// The angles of [`Records::increments`] from the `unread` angles of the record, which a
    /// [device](crate::device::samples) made.
    pub fn increments_of(&self, number: u64, unread: impl Iterator<Item = u32>) -> impl Iterator<Item = f64> {
        let (start, pulse) = (self.recipe.start(number), self.fixed.pulse);
        let read = move |angle: u32| pulse.map_or(angle, |bits| angle.wrapping_add(start) & (u32::MAX << bits));
        self.of_read(self.drifted(unread).map(read))
    }

    fn of_read(&self, angles: impl Iterator<Item = u32>) -> impl Iterator<Item = f64> {
        let (whole, omitted) = self.constant();
        steps(angles, whole).map(move |step| step as f64 * self.fixed.lsb_arcsec + omitted)
    }

    /// The angles with the drift common to all records.
    fn drifted(&self, unread: impl Iterator<Item = u32>) -> impl Iterator<Item = u32> {
        let drift = self.recipe.drift.iter().copied().chain(std::iter::repeat(0));
        unread.zip(drift).map(|(angle, drift)| angle.wrapping_add(drift))
    }

    /// The angles of [`Records::increments`] for a gyro that also turns by the angles `turned` in each sample, in
    /// 2^−[`MOTION_BITS`] of the unit of angle. Whole pulses are those of the sum, which is exact.
    pub fn turned_increments(
        &self,
        number: u64,
        turned: impl Iterator<Item = i128>,
    ) -> impl Iterator<Item = f64> {
        self.turned_increments_of(number, self.recipe.unread().angles(number), turned)
    }

    /// The angles of [`Records::turned_increments`] from the `unread` angles of the record, which a
    /// [device](crate::device::samples) made.
    pub fn turned_increments_of(
        &self,
        number: u64,
        unread: impl Iterator<Item = u32>,
        turned: impl Iterator<Item = i128>,
    ) -> impl Iterator<Item = f64> {
        let (whole, omitted) = self.constant();
        let (angles, start) = (self.drifted(unread), self.recipe.start(number));
        let pulse = self.fixed.pulse;
        let unit = self.fixed.lsb_arcsec;
        let (mut angle, mut read) = (i128::from(start) << MOTION_BITS, 0);
        steps(angles, whole).zip(turned).map(move |(step, turned)| {
            let step = (step << MOTION_BITS) + turned;
            let Some(bits) = pulse else {
                return step as f64 * (unit / MOTION_UNITS) + omitted;
            };
            angle += step;
            let before = std::mem::replace(&mut read, angle >> (MOTION_BITS + bits));
            ((read - before) << bits) as f64 * unit
        })
    }

    /// The constant rate in whole units of angle per sample where whole pulses are read, from which angles that wrap differ
    /// little, and ″ per sample otherwise.
    fn constant(&self) -> (i128, f64) {
        match self.fixed.pulse {
            Some(_) => (libm::round(self.constant_rate / self.fixed.lsb_arcsec) as i128, 0.0),
            None => (0, self.constant_rate),
        }
    }

    /// The estimates of one record, (″/s)², for each averaging factor, from its sums as the kernel returns them.
    pub fn variances(&self, sums: &[u128]) -> Vec<f64> {
        let one = |(at, &place): (usize, &usize)| {
            sums[place] as f64 / self.terms[at] as f64 * self.variance_of_square(at)
        };
        self.places.iter().enumerate().map(one).collect()
    }

    /// The variance at `ms[at]` that corresponds to a mean square of 1 LSB², (″/s)².
    fn variance_of_square(&self, at: usize) -> f64 {
        let per_tau = self.fixed.lsb_arcsec / (self.sample_s * self.ms[at] as f64);
        per_tau * per_tau / self.estimator.difference.divisor()
    }

    /// Identity of the sums: a digest of all words that determine them, of their unit, and of the kernel's version.
    pub fn digest(&self) -> Id {
        let Recipe {
            key,
            samples,
            white,
            rate_scale,
            walk,
            ref flicker,
            markov,
            sine,
            quantization,
            pulse,
            switching,
            ref drift,
            order,
            ref levels,
        } = self.recipe;
        let mut words = vec![allan::VERSION, key[0], key[1], samples, white, rate_scale, walk, quantization];
        words.push(flicker.len() as u32);
        words.extend(flicker);
        words.push(markov.is_some().into());
        words.extend(markov.iter().flatten());
        words.push(sine.is_some().into());
        words.extend(sine.iter().flatten());
        words.push(pulse.is_some().into());
        words.extend(pulse);
        words.push(drift.len() as u32);
        words.extend(Id::of_words(drift.iter().copied()).0.chunks_exact(4).map(|bytes| {
            let [a, b, c, d] = [bytes[0], bytes[1], bytes[2], bytes[3]];
            u32::from_le_bytes([a, b, c, d])
        }));
        words.push(order);
        for level in levels {
            words.extend([level.stride, level.spans.len() as u32]);
            words.extend(&level.spans);
        }
        words.extend(words_of(self.fixed.lsb_arcsec));
        words.extend(words_of(self.sample_s));
        // Records without switching keep their earlier identity.
        words.extend(switching.iter().flatten());
        Id::of_words(words)
    }
}

/// The differences of angles that wrap, which are near `whole`.
fn steps(mut angles: impl Iterator<Item = u32>, whole: i128) -> impl Iterator<Item = i128> {
    let wrapped = whole as u32;
    let mut before = angles.next().unwrap_or_default();
    angles.map(move |angle| {
        let beside = angle.wrapping_sub(before).wrapping_sub(wrapped) as i32;
        before = angle;
        whole + i128::from(beside)
    })
}

/// The levels for some averaging factors, grouped by stride in ascending order and, within one stride, in the given
/// order; and the place of each factor in the sums.
pub(crate) fn levels(estimator: Estimator, ms: &[u64]) -> (Vec<Level>, Vec<usize>) {
    let mut order: Vec<usize> = (0..ms.len()).collect();
    order.sort_by_key(|&at| estimator.stride(ms[at]));
    let mut levels: Vec<Level> = Vec::new();
    let mut places = vec![0; ms.len()];
    for (place, &at) in order.iter().enumerate() {
        places[at] = place;
        let stride = estimator.stride(ms[at]) as u32;
        let span = ms[at] as u32 / stride;
        match levels.last_mut() {
            Some(level) if level.stride == stride => level.spans.push(span),
            _ => levels.push(Level { stride, spans: vec![span] }),
        }
    }
    (levels, places)
}

/// Number of standard deviations for which differences and rates have room.
pub(crate) const DEVIATIONS: f64 = 16.0;

/// The requested model, with angles in ″ and times in samples.
pub(crate) struct Model {
    pub(crate) samples: u64,
    pub(crate) noise: Noise,
    pub(crate) sine: Option<Sine>,
    /// Acceleration, ″ per sample².
    pub(crate) ramp: f64,
    pub(crate) warm_ups: Vec<WarmUp>,
    pub(crate) switching: Option<Switching>,
    /// Range of the angle of its alternating drift, ″.
    pub(crate) sawtooth: f64,
    pub(crate) readout_lsb: f64,
    /// Constant rate, ″ per sample; 0 where no readout is affected by it.
    pub(crate) mean_rate: f64,
}

/// The random parts, as standard deviations in some unit of angle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noise {
    /// Noise of every angle.
    pub(crate) quantization: f64,
    /// Noise of every increment.
    pub(crate) white: f64,
    /// Noise of the rate in each octave of holds, from octave 0 on; empty without flicker.
    pub(crate) octaves: Vec<f64>,
    /// Step of the rate random walk.
    pub(crate) walk: f64,
    pub(crate) markov: Option<Markov>,
}

/// Markov noise of the rate: r_k = e^{−decay}·r_{k−1} + …, with the stationary standard deviation `sigma`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Markov {
    pub(crate) sigma: f64,
    pub(crate) decay: f64,
}

/// A sine of the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sine {
    pub(crate) amplitude: f64,
    /// Turns per sample.
    pub(crate) turns: f64,
}

/// A warm-up angle, reach·(1 − e^{−decay·k}), ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WarmUp {
    pub(crate) reach: f64,
    pub(crate) decay: f64,
}

impl Model {
    pub(crate) fn new(asked: &Asked) -> Result<Model, Unrepresentable> {
        let t0 = at_least("record.sample", "a sample of", asked.process.sample_s, f64::MIN_POSITIVE)?;
        let readout_lsb = at_least("noise.readout_lsb", "a pulse of", asked.readout_lsb, 0.0)?;
        let mean_rate = at_least("record.rate", "a rate of", asked.mean_rate, f64::MIN)?;
        let mut model = Model {
            samples: asked.samples,
            noise: Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, markov: None },
            sine: None,
            ramp: 0.0,
            warm_ups: vec![],
            switching: None,
            sawtooth: 0.0,
            readout_lsb,
            mean_rate: if readout_lsb > 0.0 { mean_rate * t0 } else { 0.0 },
        };
        for part in &asked.process.parts {
            let Row { key, size: (what, least), ref shape, .. } = *part.term.row();
            at_least(key, what, part.size, least)?;
            if let Some(shape) = shape {
                at_least(key, shape.what, part.shape, f64::MIN_POSITIVE)?;
            }
            for source in part.sources(t0, asked.samples) {
                model.add(key, source)?;
            }
        }
        if let Some(switching) = asked.switching {
            let switching = checked(switching, asked.samples)?.per_sample(t0);
            model.sawtooth = switching.sawtooth_range(asked.samples);
            model.switching = Some(switching);
        }
        Ok(model)
    }

    /// Adds the source of noise given by the key `key`.
    fn add(&mut self, key: &'static str, source: Source) -> Result<(), Unrepresentable> {
        let noise = &mut self.noise;
        let join = |into: &mut f64, sigma: f64| *into = libm::hypot(*into, sigma);
        let only = |is_second: bool| match is_second {
            true => {
                Err(Unrepresentable::new(key, "a record has at most one of them", "leave one of them out"))
            }
            false => Ok(()),
        };
        match source {
            Source::Errors(sigma) => join(&mut noise.quantization, sigma),
            Source::White(sigma) => join(&mut noise.white, sigma),
            Source::Walk(sigma) => join(&mut noise.walk, sigma),
            Source::Holds(sigmas) if sigmas.iter().any(|sigma| *sigma != 0.0) => {
                noise.octaves.resize(noise.octaves.len().max(sigmas.len()), 0.0);
                noise.octaves.iter_mut().zip(sigmas).for_each(|(octave, sigma)| join(octave, sigma));
            }
            Source::Markov { sigma, decay } if sigma > 0.0 => {
                only(noise.markov.replace(Markov { sigma, decay }).is_some())?;
            }
            Source::Sine { amplitude, turns } if amplitude > 0.0 => {
                only(self.sine.replace(Sine { amplitude, turns }).is_some())?;
            }
            Source::Ramp(ramp) => self.ramp += ramp,
            Source::Decay { reach, decay } if reach != 0.0 => self.warm_ups.push(WarmUp { reach, decay }),
            Source::Holds(_) | Source::Markov { .. } | Source::Sine { .. } | Source::Decay { .. } => {}
        }
        Ok(())
    }

    /// The longest averaging factor for which the record has a difference, and for which it has room; 0 if there is none.
    pub(crate) fn longest(&self, difference: Difference) -> u64 {
        self.samples.min(MAX_SAMPLES) / difference.spans()
    }

    /// Whether all records share more than a constant rate.
    pub(crate) fn is_curved(&self) -> bool {
        self.ramp != 0.0 || !self.warm_ups.is_empty() || self.sawtooth != 0.0
    }

    /// Bound of all differences of ramp, warm-up and alternating drift, ″. Those of the first two grow with m, and fall
    /// along the record.
    pub(crate) fn trend(&self, difference: Difference) -> f64 {
        let m = self.longest(difference) as f64;
        let power = f64::from(difference.spans() as u32);
        let ramp = if difference == Difference::Second { libm::fabs(self.ramp) * m * m } else { 0.0 };
        let warm_up =
            |one: &WarmUp| libm::fabs(one.reach) * libm::pow(libm::fabs(libm::expm1(-one.decay * m)), power);
        // As many angles are added as subtracted.
        let sawtooth = self.sawtooth * 0.5 * reach(difference);
        ramp + self.warm_ups.iter().map(warm_up).sum::<f64>() + sawtooth
    }

    /// Bound of all differences of the record, ″.
    pub(crate) fn whole(&self, difference: Difference) -> f64 {
        let m = self.longest(difference);
        if m == 0 {
            return 0.0;
        }
        let jumps = self.switching.and_then(|switching| switching.jumps());
        let jumps = jumps.map_or(0.0, |jumps| jumps.largest_variance(difference, m));
        let noise = DEVIATIONS * libm::sqrt(self.noise.variance(difference, m) + jumps);
        let sine = self.sine.map_or(0.0, |sine| sine.largest(difference, m));
        // Some of the readings are too low by up to a pulse.
        let pulses = 0.5 * self.readout_lsb * reach(difference);
        noise + sine + self.trend(difference) + pulses
    }
}

/// Σ|c| of a difference.
pub(crate) fn reach(difference: Difference) -> f64 {
    libm::exp2(difference.spans() as f64)
}

/// Checks that the switching is possible in a record.
fn checked(switching: Switching, samples: u64) -> Result<Switching, Unrepresentable> {
    let Switching { interval, magnetic, residual, residual_noise } = switching;
    if !(1..samples).contains(&interval) {
        let found = format_args!("switches {interval} samples apart in a record of {samples}");
        let help = "switch at least once in the record, after one sample or more";
        return Err(Unrepresentable::new("noise.switching.interval", found, help));
    }
    at_least("noise.switching.magnetic", "a drift of", magnetic.amplitude, f64::MIN)?;
    at_least("noise.switching.initial_magnetic", "a drift of", magnetic.initial, f64::MIN)?;
    at_least("noise.switching.warm_up_time", "a time of", magnetic.time_s, f64::MIN_POSITIVE)?;
    at_least("noise.switching.residual", "an amplitude of", residual, 0.0)?;
    at_least("noise.switching.residual_noise", "a noise of", residual_noise, 0.0)?;
    Ok(switching)
}

/// The refusal of a meaningless value: negative, or not finite.
pub(crate) fn impossible(key: &'static str, what: &str, found: f64) -> Unrepresentable {
    let help = "give a finite number that is not negative, and times, frequencies and samples above 0";
    Unrepresentable::new(key, format_args!("{what} {found} is not possible"), help)
}

/// The refusal of a record of one sample, or of more than `most`.
fn too_long(samples: u64, most: u64) -> Unrepresentable {
    let found = format_args!("{samples} samples; a record has 2 to {most}");
    Unrepresentable::new("record.length", found, "take a shorter record, or a longer sample")
}

/// A finite number that is at least `least`.
fn at_least(key: &'static str, what: &'static str, found: f64, least: f64) -> Result<f64, Unrepresentable> {
    match found.is_finite() && found >= least {
        true => Ok(found),
        false => Err(impossible(key, what, found)),
    }
}

impl Noise {
    /// The parts for which a closed form gives the distribution of every increment: all except holds and random walk.
    pub(crate) fn simple(&self) -> Process {
        let mut parts = vec![Part::quantization(self.quantization), Part::angle_random_walk(self.white)];
        parts.extend(self.markov.map(Markov::part));
        Process { sample_s: 1.0, parts }
    }

    /// Variance of a difference at `m`, which grows with m.
    pub(crate) fn variance(&self, difference: Difference, m: u64) -> f64 {
        let octave = |(o, sigma): (usize, &f64)| sigma * sigma * flicker::mean_square(difference, 1 << o, m);
        self.simple().variance(difference, m)
            + Part::rate_random_walk(self.walk).variance(difference, 1.0, m)
            + self.octaves.iter().enumerate().map(octave).sum::<f64>()
    }

    /// Standard deviation of the rate at the end of a record, without octave 0.
    pub(crate) fn rate(&self, samples: u64) -> f64 {
        let held: f64 = self.octaves.iter().skip(1).map(|sigma| sigma * sigma).sum();
        let markov = self.markov.map_or(0.0, |markov| markov.sigma * markov.sigma);
        libm::sqrt(held + self.walk * self.walk * samples as f64 + markov)
    }
}

impl Markov {
    /// The part in the notation of `theory`, with t0 = 1.
    pub(crate) fn part(self) -> Part {
        Part::markov(self.sigma * libm::sqrt(2.0 * self.decay), 1.0 / self.decay)
    }
}

impl Sine {
    /// The part in the notation of `theory`, with t0 = 1; `None` for a sine that never moves.
    pub(crate) fn part(self) -> Option<Part> {
        let rate = 2.0 * PI * self.turns;
        (rate > 0.0).then_some(Part::sine(self.amplitude * rate, self.turns))
    }

    /// Bound of the differences at all averaging factors up to `m`; |2 sin x| is at most 2 and at most 2x.
    pub(crate) fn largest(self, difference: Difference, m: u64) -> f64 {
        let factor = (2.0 * PI * self.turns * m as f64).min(2.0);
        self.amplitude * libm::pow(factor, difference.spans() as f64)
    }
}
