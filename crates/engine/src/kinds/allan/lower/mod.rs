//! Lowering of a noise model to records: from Q, N, B, … in ″ and s to the words of a [`Recipe`].
//!
//! ```text
//! Asked ─ model ─▶ Model ─ fixed ─▶ Fixed ─┬─ drift, levels ─▶ Recipe
//!                                         └─ theory ─▶ Theory
//! ```
//!
//! Words, unit of angle and headroom: `docs/dev/numerics.md`, "Synthetic records".

pub mod curve;
pub(crate) mod drift;
pub(crate) mod enough;
pub(crate) mod fixed;
pub(crate) mod model;
pub(crate) mod physical_theory;
pub(crate) mod representation;
pub(crate) mod theory;

use crate::key::row::Refusal;
use crate::kinds::allan::lower::model::too_long;
pub use crate::kinds::allan::lower::theory::Theory;

use crate::kinds::allan::lower::fixed::Fixed;
use crate::kinds::allan::lower::model::{Model, WarmUp};
use crate::kinds::gap_fill::lower::words_of;
use crate::tally::Id;
use sagnac_kernel::allan;
use sagnac_kernel::recipe::{Level, Recipe};
use sagnac_theory::allan::estimator::{Difference, Estimator};
use sagnac_theory::allan::process::Process;
use sagnac_theory::allan::switching::Switching;

/// Samples of the longest record, whose drift takes 4 bytes per sample.
pub const MAX_SAMPLES: u64 = 1 << 26;

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
    ms: Vec<u64>,
    terms: Vec<u64>,
    /// Place of each averaging factor in the sums of the kernel.
    places: Vec<usize>,
}

impl Records {
    /// Lowers a noise model.
    ///
    /// # Errors
    /// The noise model cannot be represented; see [`Refusal`].
    pub fn new(asked: &Asked) -> Result<Records, Refusal> {
        let Asked { samples, estimator, ms, .. } = *asked;
        if !(2..=MAX_SAMPLES).contains(&samples) {
            return Err(too_long(samples));
        }
        let terms: Vec<u64> = ms.iter().map(|&m| estimator.terms(samples, m)).collect();
        if ms.is_empty() {
            let help = "give at least one averaging time";
            return Err(Refusal::new("allan.tau", "no averaging time is given", help));
        }
        if let Some(at) = terms.iter().position(|&terms| terms == 0) {
            let found = format!(
                "an averaging time of {} samples has no difference in a record of {samples}, which needs {} of them",
                ms[at],
                estimator.difference.spans()
            );
            return Err(Refusal::new("allan.tau", found, "leave it out, or take a longer record"));
        }
        let model = Model::new(asked)?;
        let fixed = Fixed::new(&model)?;
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
            drift: drift::angles(&model, &fixed),
            order: match estimator.difference {
                Difference::Second => 2,
                Difference::Third => 3,
            },
            levels,
        };
        let lacking_rate = match fixed.pulse {
            Some(_) => 0.0,
            None => model.unfinished().map(WarmUp::rate).sum::<f64>() / fixed.lsb_arcsec,
        };
        Ok(Records {
            recipe,
            estimator,
            sample_s: asked.process.sample_s,
            fixed,
            curved: model.is_curved(),
            lacking_rate,
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
