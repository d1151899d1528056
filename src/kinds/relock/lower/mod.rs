//! Lowering of a relock: words of the kernel, and the estimates of each compensation.

pub(crate) mod fixed;

use crate::key::refusal::Refusal;
pub use crate::kinds::relock::lower::fixed::{FixedRelock, MOST_LEFT};

use std::sync::Arc;

use crate::kernel::launch::Launch;
use crate::kernel::moments::{MAX_ESTIMATES, Trials, level};
use crate::kernel::relock::{Parameters, Shape, WEIGHT_BITS};
use crate::kernel::relock_ticks::{self, MAX_TICKS, Method};
use crate::kernel::width::Width;
use crate::key::common::Streams;
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::plan::identity;
use crate::kinds::relock::RelockPoint;
use crate::kinds::relock::inputs::Compensation;
use crate::store::Address;
use crate::tally::id::Id;

/// Number of trials that determine where histograms start.
pub(crate) const PILOT: u64 = 1024;

/// An estimate of the angle that remains in some ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct RelockEstimate {
    /// Compensation applied.
    pub compensation: Compensation,
    /// Tick; absent for all ticks together.
    pub tick: Option<u32>,
    /// Address of its tallies.
    pub address: Address,
    /// Mean and rms in closed form for the words, ″; absent where there is none.
    pub oracle: Option<(f64, f64)>,
    /// Bound of the deviation of a sampled rms from the closed form due to rounding in the kernel, ″.
    pub rounding: f64,
    /// Level at which its histogram starts.
    pub bin_base: u32,
    weights: [u32; MAX_TICKS],
}

/// A point of a relock study, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredRelock {
    /// Id of the point, under which its draws and tallies are found.
    pub id: Id,
    key: [u32; 2],
    /// Its parameters in fixed point.
    pub fixed: FixedRelock,
    ticks: usize,
    /// Estimates by compensation and then by tick, with all ticks together last.
    pub estimates: Vec<RelockEstimate>,
}

impl LoweredRelock {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented; see [`Refusal`].
    pub fn new(point: &RelockPoint, seed: u64, streams: Streams) -> Result<LoweredRelock, Refusal> {
        let inputs = &point.inputs;
        let text = format!("tick_s={:.11e}\n{}", inputs.tick_s, inputs.relock.identity());
        let (id, key) = identity("relock", seed, streams, &text);
        let fixed = FixedRelock::new(&inputs.relock, inputs.tick_s)?;
        let ticks = inputs.relock.ticks as usize;
        let mut lowered = LoweredRelock { id, key, fixed, ticks, estimates: vec![] };
        for compensation in Compensation::ALL {
            let sums = (1..=ticks as u32).map(Some).chain([None]);
            let mut estimates: Vec<RelockEstimate> =
                sums.map(|tick| lowered.estimate(point, compensation, tick)).collect();
            estimates.chunks_mut(MAX_ESTIMATES).for_each(|some| lowered.set_histograms(some));
            lowered.estimates.extend(estimates);
        }
        Ok(lowered)
    }

    fn estimate(&self, point: &RelockPoint, compensation: Compensation, tick: Option<u32>) -> RelockEstimate {
        let relock = &point.inputs.relock;
        let counts = |i: usize| tick.map_or(i < self.ticks, |tick| tick as usize == i + 1);
        let weights: [f64; MAX_TICKS] = core::array::from_fn(|i| if counts(i) { 1.0 } else { 0.0 });
        let (mean, rms) = self.fixed.faked(&weights);
        let rounding = self.fixed.rounding(&weights);
        let exact_detuning = relock.adc_noise == 0.0 && relock.adc_step == 0.0;
        let (oracle, rounding) = match compensation {
            Compensation::None => (Some((mean, rms)), rounding),
            // There is no earlier tick with which the first could be compared.
            Compensation::Frequency if tick == Some(1) => (Some((mean, rms)), rounding),
            Compensation::Detuning if exact_detuning => {
                (Some((0.0, rms * self.fixed.wrong())), self.fixed.rounding_by_detuning(&weights))
            }
            Compensation::Frequency | Compensation::Detuning => (None, 0.0),
        };
        let estimate = match tick {
            Some(tick) => format!("estimate\ncompensation={}\nticks={tick}\n", compensation.name()),
            None => format!("estimate\ncompensation={}\nticks=1..={}\n", compensation.name(), self.ticks),
        };
        let weights = weights.map(|weight| weight as u32 * (1 << WEIGHT_BITS));
        // The digest is filled in when the histogram is known.
        let address = Address { point: self.id, estimate: Id::of(&estimate), digest: self.id };
        RelockEstimate { compensation, tick, address, oracle, rounding, bin_base: 0, weights }
    }

    /// Lets histograms start at a quarter of the rms of the first trials.
    fn set_histograms(&self, estimates: &mut [RelockEstimate]) {
        let trials = Trials { first: 0, count: PILOT, histogram: false };
        let tallies = self.launch(&estimates.iter().collect::<Vec<_>>()).tally(Width::widest(), trials);
        for (estimate, tally) in estimates.iter_mut().zip(&tallies) {
            let rms = libm::sqrt(tally.square as f64 / PILOT as f64);
            let bin_base = level(libm::floor(0.25 * rms) as u32);
            let method = method(estimate.compensation);
            let ticks = relock_ticks::Shape { ticks: MAX_TICKS, method };
            let words = [relock_ticks::VERSION, method as u32, bin_base]
                .into_iter()
                .chain(self.key)
                .chain(words_of(self.fixed.lsb_arcsec))
                .chain(self.fixed.words(ticks))
                .chain(estimate.weights);
            estimate.address.digest = Id::of_words(words);
            estimate.bin_base = bin_base;
        }
    }

    /// The launch that samples some of the estimates, at most [`MAX_ESTIMATES`] and all of one compensation.
    pub fn launch(&self, estimates: &[&RelockEstimate]) -> Launch {
        let method = estimates.first().map_or(Method::None, |estimate| method(estimate.compensation));
        let ticks = relock_ticks::Shape { ticks: self.ticks, method };
        let weights = estimates.iter().map(|estimate| &estimate.weights[..self.ticks]);
        let bin_base: Vec<u32> = estimates.iter().map(|estimate| estimate.bin_base).collect();
        let words = Parameters {
            key: &self.key,
            relock: &self.fixed.words(ticks),
            weight: &weights.collect::<Vec<_>>().concat(),
            bin_base: &bin_base,
        }
        .words();
        let shape = Shape { ticks, estimates: estimates.len() };
        Launch::new(shape, words, Arc::new([])).expect("lowered words are those of the shape")
    }
}

/// The method of the kernel for a compensation.
pub fn method(compensation: Compensation) -> Method {
    match compensation {
        Compensation::None => Method::None,
        Compensation::Frequency => Method::Frequency,
        Compensation::Detuning => Method::Detuning,
    }
}
