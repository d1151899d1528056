//! Lowering of a gyro with lock-in: from thresholds and rates to the words of the kernel, and the proof that they fit.

pub(crate) mod fixed;
pub(crate) mod lowered_theory;
pub(crate) mod steps;
pub(crate) mod theory;

use std::sync::Arc;

use crate::key::row::{Refusal, Streams};
use crate::kinds::allan::lower::levels;
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::lock_in::Point;
use crate::kinds::lock_in::lower::fixed::Fixed;
use crate::kinds::lock_in::lower::lowered_theory::LoweredTheory;
use crate::kinds::lock_in::lower::steps::Steps;
use crate::kinds::plan::identity;
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::lock_in::{LockIn, OTHER_VALUES, VERSION};
use sagnac_theory::allan::estimator::{Difference, Estimator};

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
    /// The point cannot be represented; see [`Refusal`].
    pub fn new(point: &Point, estimator: Estimator, seed: u64, streams: Streams) -> Result<Gyros, Refusal> {
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
        let physical = theory::angle_random_walk(point);
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
            estimate: Id::of(&format!("estimate\n{estimator:?}\nms={:?}\n", times.ms)),
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
