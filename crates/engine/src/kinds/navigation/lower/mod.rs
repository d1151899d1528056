//! Lowering of a navigator: the records of its gyros, as those of an Allan curve are lowered, and the whole weights of
//! their increments in each error.
//!
//! ```text
//! Inputs ─┬─ noise ─▶ allan::lower::Records ─▶ Recipe ─┐
//!         └─ task ─▶ theory::navigation: weights or filter ─┴─▶ Navigation, one for each gyro and set of coefficients
//! ```
//!
//! Words, weights and headroom: `docs/dev/numerics.md`, "Errors of a navigator".

pub mod closed;
pub(crate) mod physical_theory;
pub(crate) mod representation;

use std::sync::Arc;

use crate::key::row::{Refusal, Streams, shown};
use crate::key::sensitivity::Uncertain;
use crate::key::sweep;
use crate::kinds::allan::lower::fixed::Fixed;
use crate::kinds::allan::lower::model::DEVIATIONS;
use crate::kinds::allan::lower::{Asked, Records};
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::navigation::Navigation;
use crate::kinds::navigation::lower::representation::Deviation;
use crate::kinds::navigation::point::Point;
use crate::kinds::plan::identity;
use crate::noise::{Noise, SETTINGS as NOISE_SETTINGS};
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::navigation::{self, INCREMENT_BITS, WEIGHT_BITS};
use sagnac_kernel::philox::{philox, schedule};
use sagnac_kernel::recipe::Recipe;
use sagnac_kernel::word::Scalar;
use sagnac_theory::allan::estimator::Estimator;
use sagnac_theory::navigation::{Error, Gyro, Weights};

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
    pub(crate) noise: sagnac_theory::navigation::covariance::Noise,
    /// Bounds of their deviation from those of the inputs.
    pub(crate) deviation: Deviation,
    /// The weights as whole numbers, by errors.
    pub(crate) weights: Vec<Vec<i32>>,
}

impl Lowered {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The noise cannot be represented; see [`Refusal`].
    pub fn new(point: &Point, study: &Navigation, seed: u64, streams: Streams) -> Result<Lowered, Refusal> {
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
    let keys = schedule(Id::of(&format!("coefficients\nkind=navigation\nseed={seed}\n")).key().map(Scalar));
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
    ) -> Result<LoweredGyro, Refusal> {
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
            noise: closed::noise(records.fixed()),
            deviation: Deviation::of(records.fixed()),
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
fn of_navigation(refusal: Refusal) -> Refusal {
    let key = match refusal.key {
        "record.length" | "record.sample" => "navigation.sample",
        key => key,
    };
    Refusal { key, message: refusal.message.replacen(refusal.key, key, 1), ..refusal }
}

fn words_of_id(id: &Id) -> impl Iterator<Item = u32> {
    id.0.chunks_exact(4).map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

// Increments have the room of differences.
const _: () = assert!(LIMIT == 1 << INCREMENT_BITS);

/// The proof that no increment of the angle exceeds 2^[`INCREMENT_BITS`]: 16 standard deviations of its random parts, and
/// all of its sine and of what all records share.
fn check_increments(fixed: &Fixed, recipe: &Recipe) -> Result<(), Refusal> {
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
    Err(Refusal::new("noise", found, "take a shorter navigation.sample"))
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
