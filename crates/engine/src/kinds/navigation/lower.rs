//! Lowering of a navigator: the records of its gyros, as those of an Allan curve are lowered, and the whole weights of
//! their increments in each error.
//!
//! ```text
//! Inputs ─┬─ noise ─▶ allan::lower::Records ─▶ Recipe ─┐
//!         └─ task ─▶ theory::navigation: weights or filter ─┴─▶ Navigation, one for each gyro and set of coefficients
//! ```
//!
//! Words, weights and headroom: `docs/dev/numerics.md`, "Errors of a navigator".
//!
//! In the closed form of the words, all parts are normal except sines and the part D sin φ of fill residuals. Mean and covariance hold for these too, and
//! their sum over many switches is nearly normal.
//!
//! Each word is within half its unit of what it stands for, and so is each weight.

use core::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

use rayon::prelude::*;

use crate::key::sensitivity::Uncertain;
use crate::key::{Streams, Unrepresentable, shown, sweep};
use crate::kinds::allan::lower::fixed::Fixed;
use crate::kinds::allan::lower::{Asked, DEVIATIONS, Records};
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::navigation::Navigation;
use crate::kinds::navigation::point::Point;
use crate::kinds::plan::identity;
use crate::noise::{Noise, SETTINGS as NOISE_SETTINGS};
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::navigation::{self, INCREMENT_BITS, WEIGHT_BITS};
use sagnac_kernel::philox::{philox, schedule};
use sagnac_kernel::recipe::Recipe;
use sagnac_kernel::word::Scalar;
use sagnac_theory::allan::Estimator;
use sagnac_theory::allan::terms::Source;
use sagnac_theory::drift::Magnetic;
use sagnac_theory::navigation::{self as closed, Error, Gyro, Weights, of_angles};
use sagnac_theory::quantile::Radial;

/// Roundings of the angle of a sample by less than one LSB each: angle, sine, quantization noise, drift, fill residuals.
const ROUNDINGS: f64 = 5.0;

/// A navigator, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    /// Its errors, in the order of the sums.
    pub errors: &'static [Error],
    /// Its gyros, with those of each set of coefficients after those of the one before.
    pub gyros: Vec<LoweredGyro>,
    /// Number of gyros of a set.
    pub of_set: usize,
}

/// The records of one gyro with one set of coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredGyro {
    /// The gyro.
    pub gyro: Gyro,
    /// The words of the kernel.
    pub navigation: navigation::Navigation,
    /// Address of the sums in the store.
    pub address: Address,
    /// Size of a unit of each sum: ″ for angles, m/s and m.
    pub units: Vec<f64>,
    /// The random parts as given by the words, in LSB and samples.
    pub(crate) noise: closed::Noise,
    /// Bounds of their deviation from those of the inputs.
    pub(crate) deviation: Deviation,
    /// The weights as whole numbers, by errors.
    pub(crate) weights: Vec<Vec<i32>>,
}

impl Lowered {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The noise cannot be represented; see [`Unrepresentable`].
    pub fn new(
        point: &Point,
        study: &Navigation,
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, Unrepresentable> {
        let all = point.inputs.weights();
        let scales = scales(&all);
        let mut gyros = Vec::new();
        for set in 0..study.draws {
            let noise = drawn(point, study, seed, set);
            for (place, weights) in all.iter().enumerate() {
                let whole = whole(weights, &scales);
                let asked = At { point, noise: &noise, set, place };
                gyros.push(asked.lower(weights.gyro, whole, &scales, seed, streams)?);
            }
        }
        Ok(Lowered { errors: point.inputs.task().errors(), gyros, of_set: all.len() })
    }
}

/// The noise of a set of coefficients: the values drawn for it, before those that a sweep gives.
fn drawn(point: &Point, study: &Navigation, seed: u64, set: u64) -> Noise {
    let mut noise = point.inputs.noise.clone();
    let keys = schedule(Id::from_text(&format!("coefficients\nkind=navigation\nseed={seed}\n")).key().map(Scalar));
    for (input, uncertain) in study.uncertain.iter().enumerate() {
        let [word, ..] = philox([set as u32, 0, input as u32, 0].map(Scalar), keys);
        // The middle of one of 2^32 equal parts.
        let level = (f64::from(word.0) + 0.5) / 4_294_967_296.0;
        sweep::set(&mut noise, &NOISE_SETTINGS, &[(uncertain.key.name, Uncertain::at(uncertain, level))]);
    }
    sweep::set(&mut noise, &NOISE_SETTINGS, &point.swept);
    match point.lack {
        Some(lack) => lack.of(noise),
        None => noise,
    }
}

/// Size of a unit of the weights of each error: the power of two with which the largest of them, of all gyros, has
/// [`WEIGHT_BITS`].
fn scales(all: &[Weights]) -> Vec<f64> {
    let errors = all.first().map_or(0, |weights| weights.of_errors.len());
    let largest = |error: usize| {
        let of_gyro = all.iter().flat_map(|weights| &weights.of_errors[error]);
        of_gyro.fold(0.0, |most, weight| libm::fmax(most, libm::fabs(*weight)))
    };
    let scale = |largest: f64| match largest > 0.0 {
        true => libm::exp2(libm::ceil(libm::log2(largest)) - f64::from(WEIGHT_BITS)),
        false => 1.0,
    };
    (0..errors).map(|error| scale(largest(error))).collect()
}

/// The weights in units of their scales.
fn whole(weights: &Weights, scales: &[f64]) -> Vec<Vec<i32>> {
    let of_error = |(weights, scale): (&Vec<f64>, &f64)| {
        weights.iter().map(|weight| libm::round(weight / scale) as i32).collect()
    };
    weights.of_errors.iter().zip(scales).map(of_error).collect()
}

/// A gyro of a set of coefficients of a point.
struct At<'a> {
    point: &'a Point,
    noise: &'a Noise,
    set: u64,
    place: usize,
}

impl At<'_> {
    fn lower(
        &self,
        gyro: Gyro,
        weights: Vec<Vec<i32>>,
        scales: &[f64],
        seed: u64,
        streams: Streams,
    ) -> Result<LoweredGyro, Unrepresentable> {
        let At { point, noise, set, place } = *self;
        let (sample_s, samples) = (point.inputs.sample(), point.inputs.samples());
        let inputs = crate::kinds::navigation::Inputs { noise: noise.clone(), ..point.inputs.clone() };
        let text = format!("{}gyro={gyro:?}\nset={set}\n", inputs.canonical());
        let (id, [a, b]) = identity("navigation", seed, streams, &text);
        // With common random numbers too, gyros and sets have their own.
        let key = Id::of_words([a, b, set as u32, place as u32]).key();
        let process = noise.process(sample_s, samples);
        let records = Records::new(&Asked {
            process: &process,
            readout_lsb: 0.0,
            mean_rate: 0.0,
            switching: noise.switched(sample_s),
            samples,
            estimator: Estimator::OVERLAPPING,
            ms: &[1],
            key,
        })
        .map_err(of_navigation)?;
        let own = Recipe { levels: vec![], drift: with_rate(&records), ..records.recipe().clone() };
        check_increments(records.fixed(), &own)?;
        let units: Vec<f64> = scales.iter().map(|scale| scale * records.lsb_arcsec()).collect();
        let navigation = navigation::Navigation::new(own, &weights)
            .unwrap_or_else(|misfit| unreachable!("lowered weights fit: {misfit}"));
        let of_weights: Vec<u32> = weights.iter().flatten().map(|weight| *weight as u32).collect();
        let mut words = vec![navigation::VERSION];
        words.extend(words_of_id(&records.digest()));
        words.extend(units.iter().flat_map(|unit| words_of(*unit)));
        // Records without such a warm-up keep their earlier identity.
        words.extend(Some(records.lacking_rate()).filter(|rate| *rate != 0.0).into_iter().flat_map(words_of));
        words.extend(&of_weights);
        let (digest, estimate) = (Id::of_words(words), Id::of_words(of_weights));
        Ok(LoweredGyro {
            gyro,
            navigation,
            address: Address { point: id, estimate, digest },
            units,
            noise: sampled_noise(records.fixed()),
            deviation: Deviation::new(records.fixed()),
            weights,
        })
    }
}

/// The angles common to all records, with the initial rate of warm-ups longer than the record, which affects no Allan
/// variance but every error of a navigator.
fn with_rate(records: &Records) -> Arc<[u32]> {
    let (drift, rate) = (&records.recipe().drift, records.lacking_rate());
    if rate == 0.0 {
        return Arc::clone(drift);
    }
    let turned = |k: usize| libm::round(rate * k as f64) as i64 as u32;
    drift.iter().enumerate().map(|(k, angle)| angle.wrapping_add(turned(k))).collect()
}

/// A refusal that names the keys of this kind instead of those of records.
fn of_navigation(refusal: Unrepresentable) -> Unrepresentable {
    let key = match refusal.key {
        "record.length" | "record.sample" => "navigation.sample",
        key => key,
    };
    Unrepresentable { key, message: refusal.message.replacen(refusal.key, key, 1), ..refusal }
}

fn words_of_id(id: &Id) -> impl Iterator<Item = u32> {
    id.0.chunks_exact(4).map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

// Increments have the room of differences.
const _: () = assert!(LIMIT == 1 << INCREMENT_BITS);

/// The proof that no increment of the angle exceeds 2^[`INCREMENT_BITS`]: 16 standard deviations of its random parts, and
/// all of its sine and of what all records share.
fn check_increments(fixed: &Fixed, recipe: &Recipe) -> Result<(), Unrepresentable> {
    let noise = fixed.noise();
    let jumps = fixed.jumps().map_or(0.0, |jumps| jumps.variance);
    let rate = noise.rate(recipe.samples.into());
    let variance =
        noise.white * noise.white + 2.0 * noise.quantization * noise.quantization + rate * rate + jumps;
    let sine = fixed.wave().map_or(0.0, |sine| 2.0 * sine.amplitude);
    let steps =
        recipe.drift.windows(2).map(|pair| f64::from((pair[1].wrapping_sub(pair[0]) as i32).unsigned_abs()));
    let drift = steps.fold(0.0, libm::fmax);
    let largest = DEVIATIONS * libm::sqrt(variance) + sine + drift + 2.0 * ROUNDINGS;
    if largest < LIMIT as f64 {
        return Ok(());
    }
    let found = format!(
        "the angle may change by {}″ within a sample, and its differences over the record leave room for {} arcsec",
        shown(largest * fixed.lsb_arcsec),
        shown(LIMIT as f64 * fixed.lsb_arcsec)
    );
    Err(Unrepresentable::new("noise", found, "take a shorter navigation.sample"))
}

/// The random parts of the lowered words, in LSB and samples.
fn sampled_noise(fixed: &Fixed) -> closed::Noise {
    let noise = fixed.noise();
    // Every angle is rounded down to whole LSB.
    let rounded = if fixed.has_angle() { 1.0 / 12.0 } else { 0.0 };
    closed::Noise {
        errors: libm::sqrt(noise.quantization * noise.quantization + rounded),
        white: noise.white,
        octaves: noise.octaves,
        walk: noise.walk,
        markov: noise.markov.map(|markov| [markov.sigma, markov.decay]),
        sine: fixed.wave().map(|sine| [sine.amplitude, sine.turns]),
        jumps: fixed.jumps().map(|jumps| (jumps.interval as usize, jumps.variance)),
    }
}

impl LoweredGyro {
    /// The weights of an error, in its unit per LSB.
    fn weights_of(&self, error: usize) -> Vec<f64> {
        self.weights[error].iter().map(|weight| f64::from(*weight) * self.units[error]).collect()
    }

    /// The mean of an error: that of the angles common to all records.
    fn mean(&self, weights: &[f64]) -> f64 {
        let drift = &self.navigation.recipe().drift;
        let step = |pair: &[u32]| f64::from(pair[1].wrapping_sub(pair[0]) as i32);
        drift.windows(2).zip(weights).map(|(pair, weight)| step(pair) * weight).sum()
    }
}

impl Lowered {
    /// The distribution of an error, or of two together, for each set of coefficients.
    pub fn distributions(&self, errors: &[usize]) -> Vec<Radial> {
        let of_set = |gyros: &[LoweredGyro]| {
            let (mut mean, mut covariance) = ([0.0; 2], [0.0; 3]);
            for gyro in gyros {
                let weights: Vec<Vec<f64>> = errors.iter().map(|error| gyro.weights_of(*error)).collect();
                for (mean, weights) in mean.iter_mut().zip(&weights) {
                    *mean += gyro.mean(weights);
                }
                covariance[0] += gyro.noise.covariance(&weights[0], &weights[0]);
                if let [first, second] = &weights[..] {
                    covariance[1] += gyro.noise.covariance(first, second);
                    covariance[2] += gyro.noise.covariance(second, second);
                }
            }
            Radial { mean, covariance }
        };
        self.gyros.par_chunks(self.of_set).map(of_set).collect()
    }

    /// Bound of the deviation of an error due to rounding in the kernel, in its unit.
    pub fn rounding(&self, error: usize) -> f64 {
        let of_gyro = |gyro: &LoweredGyro| {
            let angles = of_angles(&gyro.weights_of(error));
            ROUNDINGS * angles.iter().map(|weight| libm::fabs(*weight)).sum::<f64>()
        };
        let of_set = |gyros: &[LoweredGyro]| gyros.iter().map(of_gyro).sum();
        self.gyros.chunks(self.of_set).map(of_set).fold(0.0, libm::fmax)
    }
}

/// The physical theory of a point.
pub(crate) struct PhysicalTheory {
    /// The weights of each gyro, per ″.
    weights: Vec<Weights>,
    /// The noise of each set of coefficients.
    sets: Vec<Set>,
}

/// The noise of a set of coefficients, in ″ and samples.
struct Set {
    random: closed::Noise,
    /// The increments that all records share.
    shared: Vec<f64>,
}

impl PhysicalTheory {
    /// The theory of a point of a study with this seed.
    pub(crate) fn new(point: &Point, study: &Navigation, seed: u64) -> PhysicalTheory {
        let (sample_s, samples) = (point.inputs.sample(), point.inputs.samples());
        let set = |set| Set::new(&drawn(point, study, seed, set), sample_s, samples);
        PhysicalTheory { weights: point.inputs.weights(), sets: (0..study.draws).map(set).collect() }
    }

    /// The rms of some errors together over all sets, in their unit.
    pub(crate) fn rms(&self, errors: &[usize]) -> f64 {
        let of_set = |set: &Set| -> f64 {
            let of_error = |&error: &usize| {
                let (mut mean, mut variance) = (0.0, 0.0);
                for gyro in &self.weights {
                    let weights = &gyro.of_errors[error];
                    mean += set.shared.iter().zip(weights).map(|(step, weight)| step * weight).sum::<f64>();
                    variance += set.random.covariance(weights, weights);
                }
                mean * mean + variance
            };
            errors.iter().map(of_error).sum()
        };
        libm::sqrt(self.sets.iter().map(of_set).sum::<f64>() / self.sets.len() as f64)
    }
}

impl Set {
    /// The parts of the generators that make this noise, and the mode switches.
    fn new(noise: &Noise, t0: f64, samples: u64) -> Set {
        let mut random = closed::Noise::default();
        let (mut ramp, mut decays) = (0.0, Vec::new());
        let join = |into: &mut f64, sigma: f64| *into = libm::hypot(*into, sigma);
        for source in noise.process(t0, samples).parts.iter().flat_map(|part| part.sources(t0, samples)) {
            match source {
                Source::Errors(sigma) => join(&mut random.errors, sigma),
                Source::White(sigma) => join(&mut random.white, sigma),
                Source::Holds(sigmas) => random.octaves = sigmas,
                Source::Walk(sigma) => join(&mut random.walk, sigma),
                Source::Markov { sigma, decay } => random.markov = Some([sigma, decay]),
                Source::Sine { amplitude, turns } => random.sine = Some([amplitude, turns]),
                Source::Ramp(per_square) => ramp += per_square,
                Source::Decay { reach, decay } => decays.push((reach, decay)),
            }
        }
        let switching = noise.switched(t0);
        random.jumps = switching.map(|one| {
            let variance = 0.5 * one.residual * one.residual + one.residual_noise * one.residual_noise;
            (one.interval as usize, variance)
        });
        // The angle reach·(1 − e^{−decay·k}) over a sample, which starts at decay·k = `passed`.
        let decayed = |reach: f64, passed: f64, decay: f64| -reach * libm::exp(-passed) * libm::expm1(-decay);
        let increment = |sample: u64| {
            let k = sample as f64;
            let mut sum = ramp * (k + 0.5);
            sum += decays.iter().map(|(reach, decay)| decayed(*reach, decay * k, *decay)).sum::<f64>();
            if let Some(one) = &switching {
                let Magnetic { amplitude, time_s, initial } = one.magnetic;
                let sign = if (sample / one.interval).is_multiple_of(2) { 1.0 } else { -1.0 };
                let warming = decayed(time_s, t0 * k / time_s, t0 / time_s);
                sum += sign * ((amplitude + initial) * t0 - amplitude * warming);
            }
            sum
        };
        Set { random, shared: (0..samples).map(increment).collect() }
    }
}

/// Largest rounding of an angle common to all records, LSB: that of the angle, and that of the rate of a warm-up.
const DRIFT_ROUNDING: f64 = 1.01;
/// Error of both closed forms in floating point, relative.
const SUM_ERROR: f64 = 1e-9;

/// Bounds of the deviation of the random parts of the words from those of the inputs, in LSB and samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Deviation {
    /// The parts by which variances may be off.
    noise: closed::Noise,
    /// Decays of Markov noise whose loss has half a unit less and more than the word.
    decays: Option<[f64; 2]>,
    /// Deviation of the amplitude of a sine, and of its turns per sample.
    sine: [f64; 2],
}

impl Deviation {
    /// The bounds for some words.
    pub(crate) fn new(fixed: &Fixed) -> Deviation {
        let off = fixed.deviation();
        // Every angle is rounded down to whole LSB.
        let rounded = if fixed.has_angle() { 1.0 / 12.0 } else { 0.0 };
        let jumps = fixed.jumps();
        Deviation {
            noise: closed::Noise {
                errors: libm::sqrt(off.quantization * off.quantization + rounded),
                white: off.white,
                octaves: off.octaves,
                walk: off.walk,
                markov: off.markov.map(|markov| [markov.sigma, markov.decay]),
                sine: None,
                jumps: jumps.map(|jumps| (jumps.interval as usize, fixed.jumps_deviation() * jumps.variance)),
            },
            decays: fixed.decays(),
            sine: fixed.wave_deviation(),
        }
    }
}

/// Bounds of the deviation of an error.
#[derive(Debug, Clone, Copy, Default)]
struct Off {
    /// Rms of a deviation of the error.
    rms: f64,
    /// Deviation of its variance.
    variance: f64,
}

impl LoweredGyro {
    /// The bounds for an error with these weights per LSB, in its unit.
    fn off(&self, error: usize, weights: &[f64]) -> Off {
        let Deviation { noise, decays, sine: [amplitude_off, turns_off] } = &self.deviation;
        let angles = of_angles(weights);
        let mut variance = noise.covariance(weights, weights);
        if let Some(([sigma, decay], decays)) = self.noise.markov.zip(*decays) {
            let alone = |decay: f64| {
                closed::Noise { markov: Some([sigma, decay]), ..closed::Noise::default() }
                    .covariance(weights, weights)
            };
            let own = alone(decay);
            // Half a unit is so little that the variance is a line, but for the higher orders in 1/loss.
            variance +=
                2.0 * decays.map(|decay| libm::fabs(alone(decay) - own)).into_iter().fold(0.0, libm::fmax);
        }
        // Each weight is off by up to half a unit.
        let mut rms = 0.5 * self.units[error] * self.increments(weights.len());
        if let Some([amplitude, turns]) = self.noise.sine {
            let one = closed::Noise { sine: Some([1.0, turns]), ..closed::Noise::default() }
                .covariance(weights, weights);
            let turned =
                angles.iter().enumerate().map(|(k, weight)| k as f64 * libm::fabs(*weight)).sum::<f64>();
            rms += amplitude_off * libm::sqrt(one)
                + FRAC_1_SQRT_2 * (amplitude + amplitude_off) * 2.0 * PI * turns_off * turned;
        }
        if !self.navigation.recipe().drift.is_empty() {
            rms += DRIFT_ROUNDING * angles.iter().map(|weight| libm::fabs(*weight)).sum::<f64>();
        }
        Off { rms, variance }
    }

    /// Bound of the sum of the rms of all increments of the angle, LSB.
    fn increments(&self, samples: usize) -> f64 {
        let closed::Noise { errors, white, octaves, walk, markov, sine, jumps } = &self.noise;
        let square = 2.0 * errors * errors
            + white * white
            + octaves.iter().map(|sigma| sigma * sigma).sum::<f64>()
            + walk * walk * samples as f64
            + markov.map_or(0.0, |[sigma, _]| sigma * sigma)
            + sine.map_or(0.0, |[amplitude, _]| 2.0 * amplitude * amplitude)
            + jumps.map_or(0.0, |(_, variance)| variance);
        let step = |pair: &[u32]| f64::from((pair[1].wrapping_sub(pair[0]) as i32).unsigned_abs());
        let shared: f64 = self.navigation.recipe().drift.windows(2).map(step).sum();
        samples as f64 * libm::sqrt(square) + shared
    }
}

impl Lowered {
    /// Bound of the deviation of the rms of some errors together, `rms` in closed form, from that of the inputs.
    pub(crate) fn representation_bound(&self, errors: &[usize], rms: f64) -> f64 {
        let of_set = |gyros: &[LoweredGyro]| {
            let mut all = Off::default();
            for &error in errors {
                let of_gyros = gyros.iter().map(|gyro| gyro.off(error, &gyro.weights_of(error)));
                let one = of_gyros.fold(Off::default(), |sum, one| Off {
                    rms: sum.rms + one.rms,
                    variance: sum.variance + one.variance,
                });
                all = Off { rms: libm::hypot(all.rms, one.rms), variance: all.variance + one.variance };
            }
            all
        };
        let sets: Vec<Off> = self.gyros.chunks(self.of_set).map(of_set).collect();
        let largest = sets.iter().map(|off| off.rms).fold(0.0, libm::fmax);
        let variance = sets.iter().map(|off| off.variance).sum::<f64>() / sets.len() as f64;
        // |√a − √b| is at most |a − b|/√a, and at most √|a − b|.
        let of_variance = libm::sqrt(variance).min(variance / rms);
        largest + of_variance + SUM_ERROR * rms
    }

    /// Relative difference of the rms of some errors together, `rms` in closed form, from that of the inputs.
    ///
    /// # Errors
    /// The difference exceeds what the rounding of words explains.
    pub(crate) fn representation(
        &self,
        errors: &[usize],
        rms: f64,
        physical: &PhysicalTheory,
    ) -> Result<Option<f64>, Unrepresentable> {
        let (inputs, most) = (physical.rms(errors), self.representation_bound(errors, rms));
        let off = (rms - inputs).abs();
        if off > most || off.is_nan() {
            let found = format!(
                "the error {:?} is {} rms for the integers that would be sampled and {} for the inputs, in \u{2033}, m/s or m, \
                 which rounding to {} does not explain",
                self.errors[errors[0]],
                shown(rms),
                shown(inputs),
                shown(most)
            );
            let help = "this is a fault of the program: please report the study";
            return Err(Unrepresentable::new("noise", found, help));
        }
        Ok(sampling::representation(Some(rms), Some(inputs), most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use sagnac_theory::allan::terms::Term;

    #[test]
    fn drawn_coefficients_fill_their_distributions_evenly_and_independently() {
        const DRAWS: u32 = 4000;
        let text = r#"
title = "Drawn coefficients"
kind = "navigation"
trials = 4000
[navigation]
solution = "heading"
duration = "10 min"
draws = 64
[noise]
angle_random_walk = "0.05 deg/sqrt(h)"
quantization = "0.5 arcsec"
[[sensitivity]]
key = "noise.angle_random_walk"
uniform = { from = "0.02 deg/sqrt(h)", to = "0.08 deg/sqrt(h)" }
[[sensitivity]]
key = "noise.quantization"
uniform = { from = "0 arcsec", to = "1 arcsec" }
"#;
        let study = Study::parse("drawn.toml", text).unwrap_or_else(|error| panic!("{error:?}"));
        let navigation = study.asked::<Navigation>().unwrap();
        let noises: Vec<Noise> = (0..u64::from(DRAWS))
            .map(|set| drawn(&navigation.points[0], navigation, study.seed, set))
            .collect();
        // 1 deg/sqrt(h) is 60 arcsec/sqrt(s).
        let levels = [(Term::AngleRandomWalk, 0.02 * 60.0, 0.06 * 60.0), (Term::Quantization, 0.0, 1.0)].map(
            |(term, from, width)| {
                noises.iter().map(|noise| (noise.of(term)[0] - from) / width).collect::<Vec<f64>>()
            },
        );
        let n = f64::from(DRAWS);
        for levels in &levels {
            let mut sorted = levels.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            // Kolmogorov: beyond 1.95/√n in one of 1000 cases.
            let apart = sorted.iter().enumerate().map(|(k, level)| (level - (k as f64 + 0.5) / n).abs());
            let apart = apart.fold(0.0, f64::max);
            assert!(apart < 1.95 / n.sqrt(), "{apart}");
            let next: f64 = levels.windows(2).map(|pair| (pair[0] - 0.5) * (pair[1] - 0.5)).sum();
            assert!((12.0 * next / n.sqrt()).abs() < 4.0, "sets are correlated: {next}");
        }
        let product: f64 = levels[0].iter().zip(&levels[1]).map(|(a, b)| (a - 0.5) * (b - 0.5)).sum();
        assert!((12.0 * product / n.sqrt()).abs() < 4.0, "coefficients are correlated: {product}");
    }
}
