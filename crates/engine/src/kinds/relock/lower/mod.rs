//! Lowering of a relock: words of the kernel, and the estimates of each compensation.

pub(crate) mod fixed;
pub(crate) mod physical_theory;

use crate::key::row::{Refusal, shown};
pub use crate::kinds::relock::lower::fixed::{FixedRelock, MAX_LEFT};

use std::sync::Arc;

use crate::key::row::Streams;
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::plan::identity;
use crate::kinds::relock::RelockPoint;
use crate::kinds::relock::inputs::Compensation;
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{MAX_ESTIMATES, Trials, level};
use sagnac_kernel::relock::{Parameters, Shape, WEIGHT_BITS};
use sagnac_kernel::relock_ticks::{self, MAX_TICKS, Method};
use sagnac_kernel::width::Width;

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
    pub theory: Option<(f64, f64)>,
    /// Relative difference of that rms from the one of the physical inputs; absent where there is none.
    pub representation: Option<f64>,
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
            let estimates = sums.map(|tick| lowered.estimate(point, compensation, tick));
            let mut estimates = estimates.collect::<Result<Vec<RelockEstimate>, Refusal>>()?;
            estimates.chunks_mut(MAX_ESTIMATES).for_each(|some| lowered.set_histograms(some));
            lowered.estimates.extend(estimates);
        }
        Ok(lowered)
    }

    /// # Errors
    /// The closed form of the words differs from that of the inputs by more than the rounding of words explains.
    fn estimate(
        &self,
        point: &RelockPoint,
        compensation: Compensation,
        tick: Option<u32>,
    ) -> Result<RelockEstimate, Refusal> {
        let relock = &point.inputs.relock;
        let counts = |i: usize| tick.map_or(i < self.ticks, |tick| tick as usize == i + 1);
        let weights: [f64; MAX_TICKS] = core::array::from_fn(|i| if counts(i) { 1.0 } else { 0.0 });
        let (mean, rms) = self.fixed.faked(&weights);
        let rounding = self.fixed.rounding(&weights);
        let exact_detuning = relock.adc_noise == 0.0 && relock.adc_step == 0.0;
        let (theory, rounding) = match compensation {
            Compensation::None => (Some((mean, rms)), rounding),
            // There is no earlier tick with which the first could be compared.
            Compensation::Frequency if tick == Some(1) => (Some((mean, rms)), rounding),
            Compensation::Detuning if exact_detuning => {
                (Some((0.0, rms * self.fixed.wrong())), self.fixed.rounding_by_detuning(&weights))
            }
            Compensation::Frequency | Compensation::Detuning => (None, 0.0),
        };
        let physical = physical_theory::left(&point.inputs, compensation, tick);
        let both = theory.zip(physical);
        let most = both.map(|(words, inputs)| self.check(compensation, tick, [words, inputs], &weights));
        let most = most.transpose()?.unwrap_or(0.0);
        let [of_words, of_inputs] = [theory, physical].map(|moments| moments.map(|(_, rms)| rms));
        let representation = sampling::representation(of_words, of_inputs, most);
        let estimate = match tick {
            Some(tick) => format!("estimate\ncompensation={}\nticks={tick}\n", compensation.name()),
            None => format!("estimate\ncompensation={}\nticks=1..={}\n", compensation.name(), self.ticks),
        };
        let weights = weights.map(|weight| weight as u32 * (1 << WEIGHT_BITS));
        // The digest is filled in when the histogram is known.
        let address = Address { point: self.id, estimate: Id::of(&estimate), digest: self.id };
        Ok(RelockEstimate {
            compensation,
            tick,
            address,
            theory,
            representation,
            rounding,
            bin_base: 0,
            weights,
        })
    }

    /// Checks mean and rms of the words, and returns the bound, ″, of their deviation from those of the inputs.
    ///
    /// # Errors
    /// They differ by more than the rounding of words explains.
    fn check(
        &self,
        compensation: Compensation,
        tick: Option<u32>,
        [words, inputs]: [(f64, f64); 2],
        weights: &[f64],
    ) -> Result<f64, Refusal> {
        let (_, whole) = self.fixed.faked(weights);
        let of_angle = self.fixed.representation(weights, whole);
        let most = match compensation {
            Compensation::Detuning => {
                let of_wrong = self.fixed.representation_of_wrong();
                (whole + of_angle) * of_wrong + (self.fixed.wrong() + of_wrong) * of_angle
            }
            Compensation::None | Compensation::Frequency => of_angle,
        };
        let apart = (words.0 - inputs.0).abs().max((words.1 - inputs.1).abs());
        // A difference that is not a number is refused.
        if apart <= most {
            return Ok(most);
        }
        let tick = tick.map_or("all ticks".to_owned(), |tick| format!("tick {tick}"));
        let found = format!(
            "the angle of {tick} with compensation = \"{}\" has a mean of {}″ and an rms of {}″ for the integers that \
             would be sampled, and {} and {}″ for the inputs, which rounding to {}″ does not explain",
            compensation.name(),
            shown(words.0),
            shown(words.1),
            shown(inputs.0),
            shown(inputs.1),
            shown(most)
        );
        Err(Refusal::new(
            "relock.initial_detuning",
            found,
            "this is a fault of the program: please report the study",
        ))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::relock::inputs::{FirstHalf, Relock};
    use crate::kinds::relock::{RelockInputs, verify};

    /// The words are those of one point and the inputs those of another.
    #[test]
    fn words_that_do_not_stand_for_an_input_are_refused_by_name() {
        let exact = Relock { adc_noise: 0.0, adc_step: 0.0, ..verify::relock().relock };
        let point = |relock: Relock, tick_s: f64| RelockPoint {
            swept: vec![],
            inputs: RelockInputs { tick_s, relock },
        };
        let own = point(exact.clone(), 0.005);
        let lowered = LoweredRelock::new(&own, 1, Streams::Independent).unwrap();
        let first = |point: &RelockPoint, of| lowered.estimate(point, of, Some(1)).map(|_| ());
        for compensation in Compensation::ALL {
            assert_eq!(first(&own, compensation), Ok(()));
        }
        type Change = fn(&mut Relock);
        let changes: [(&str, Change); 9] = [
            ("miss", |relock| relock.miss *= 1.0001),
            ("error of U_λ/2", |relock| relock.half_wave_error *= 1.01),
            ("step of the DAC", |relock| relock.dac_step *= 1.1),
            ("hysteresis", |relock| relock.hysteresis *= 1.01),
            ("time constant", |relock| relock.loop_s *= 1.0001),
            ("f0", |relock| relock.bias_frequency_hz *= 1.0001),
            ("pulse weight", |relock| relock.pulse_weight_arcsec *= 1.0001),
            ("curvature", |relock| relock.curvature *= 1.0001),
            ("first half", |relock| relock.first_half = FirstHalf::Positive),
        ];
        for (name, change) in changes {
            let mut relock = exact.clone();
            change(&mut relock);
            let refused = first(&point(relock, 0.005), Compensation::None);
            assert_eq!(refused.map_err(|refusal| refusal.key), Err("relock.initial_detuning"), "{name}");
        }
        let other_tick = first(&point(exact.clone(), 0.005_001), Compensation::Frequency);
        assert!(other_tick.is_err(), "another tick");
        let relock = Relock { temperature_error: 1.000_01 * exact.temperature_error, ..exact.clone() };
        let refused = first(&point(relock, 0.005), Compensation::Detuning).unwrap_err();
        assert!(refused.message.contains("compensation = \"detuning\""), "{refused}");
        // All ticks together are followed for as long as the inputs say.
        let longer = point(Relock { ticks: 5, ..exact }, 0.005);
        assert!(lowered.estimate(&longer, Compensation::None, None).is_err());
    }
}
