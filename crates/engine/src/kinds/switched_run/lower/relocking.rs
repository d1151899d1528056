//! The relock after each switch of a run: its ticks as delivered, and their effect on the filler.

use std::sync::Arc;

use crate::key::row::Refusal;
use crate::kinds::relock::inputs::{Compensation, Relock};
use crate::kinds::relock::lower::fixed::{FixedRelock, MAX_LEFT};
use crate::kinds::relock::lower::{PILOT, method};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::relock::Relocking;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Trials;
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock::{self, WEIGHT_BITS};
use sagnac_kernel::relock_ticks::{self, Shape};
use sagnac_kernel::width::Width;

/// The relock of a point, for any filler.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FixedRelocking {
    fixed: FixedRelock,
    /// The same relock with the correct f0.
    right: FixedRelock,
    pub(crate) shape: Shape,
}

impl FixedRelocking {
    pub(crate) fn of(point: &RunPoint) -> Result<Option<FixedRelocking>, Refusal> {
        let (Some(Relocking { relock, compensation }), Some(fill)) = (&point.relock, &point.fill) else {
            return Ok(None);
        };
        let fixed = FixedRelock::new(relock, fill.inputs.tick_s)?;
        let right = Relock { temperature_error: 0.0, ..relock.clone() };
        let right = FixedRelock::new(&right, fill.inputs.tick_s)?;
        let shape = Shape { ticks: relock.ticks as usize, method: method(*compensation) };
        Ok(Some(FixedRelocking { fixed, right, shape }))
    }

    /// Combines the relock with a filler whose weights on the ticks after the gap are `after`.
    pub(crate) fn with(&self, after: &[f64]) -> Coupled {
        let gain = |i: usize| 1.0 + after.get(i).copied().unwrap_or(0.0);
        let gains: Vec<f64> = (0..self.shape.ticks).map(gain).collect();
        let lsb = self.fixed.lsb_arcsec;
        let (faked_mean, faked_rms) = self.fixed.faked(&gains);
        let exact = self.shape.method == method(Compensation::None);
        let [mean, rms, alike] = if exact { [faked_mean, faked_rms, 0.0] } else { self.pilot(&gains) };
        let largest = gains.iter().fold(1.0, |most: f64, gain| most.max(gain.abs()));
        Coupled {
            words: self.fixed.words(self.shape),
            shape: self.shape,
            lsb_arcsec: lsb,
            rounding: self.fixed.rounding(&gains),
            gains,
            exact,
            mean,
            deviation: libm::sqrt((rms * rms - mean * mean - alike * alike).max(0.0)),
            alike,
            // A compensation that fails leaves about as much as no compensation.
            most_rms: rms.max(faked_rms),
            most: MAX_LEFT * lsb * largest,
        }
    }

    /// Mean and rms over the first trials of the relock kernel, and the standard deviation of the part caused by a
    /// wrong f0, which is the same at all switches of a run, ″.
    fn pilot(&self, gains: &[f64]) -> [f64; 3] {
        let [wrong, right] = [&self.fixed, &self.right].map(|fixed| self.launch(fixed, gains));
        let one = |launch: &Launch, fixed: &FixedRelock, first: u64| {
            let tallies = launch.tally(Width::PORTABLE, Trials { first, count: 1, histogram: false });
            tallies.first().map_or(0.0, |tally| tally.sum as f64) * fixed.lsb_arcsec
        };
        let (mut sum, mut squares, mut apart) = (0.0, 0.0, 0.0);
        for trial in 0..PILOT {
            let left = one(&wrong, &self.fixed, trial);
            let by_f0 = left - one(&right, &self.right, trial);
            sum += left;
            squares += left * left;
            apart += by_f0 * by_f0;
        }
        let n = PILOT as f64;
        [sum / n, libm::sqrt(squares / n), libm::sqrt(apart / n)]
    }

    fn launch(&self, fixed: &FixedRelock, gains: &[f64]) -> Launch {
        let weight: Vec<u32> = gains.iter().map(|gain| fixed_point(*gain, WEIGHT_BITS)).collect();
        let words = relock::Parameters {
            key: &[0, 0],
            relock: &fixed.words(self.shape),
            weight: &weight,
            bin_base: &[0],
        }
        .words();
        let shape = relock::Shape { ticks: self.shape, estimates: 1 };
        Launch::new(shape, words, Arc::new([])).expect("lowered words are those of the shape")
    }
}

fn fixed_point(x: f64, bits: u32) -> u32 {
    libm::round(x * libm::exp2(f64::from(bits))) as i32 as u32
}

/// A relock with a filler, ″.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coupled {
    pub(crate) words: Vec<u32>,
    pub(crate) shape: Shape,
    lsb_arcsec: f64,
    /// Effect of each tick, by itself and through the filler.
    gains: Vec<f64>,
    /// Whether mean and deviation of a switch are in closed form.
    pub(crate) exact: bool,
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
    /// Standard deviation of the part that is the same at all switches of a run.
    pub(crate) alike: f64,
    /// Bound of the deviation of the sum of a switch from exact arithmetic.
    pub(crate) rounding: f64,
    most_rms: f64,
    most: f64,
}

impl Coupled {
    /// Bound of the effect of `switches` switches, with `room` standard deviations.
    pub(crate) fn most(&self, switches: f64, room: f64) -> f64 {
        let alike = REACH * switches * self.alike;
        switches * self.mean.abs() + room * libm::sqrt(switches) * self.most_rms + alike + self.most
    }

    /// Weights of the ticks in LSB of a run, and their number of fractional bits.
    pub(crate) fn weights(&self, lsb_arcsec: f64) -> (Vec<u32>, u32) {
        let in_run = |gain: &f64| gain * self.lsb_arcsec / lsb_arcsec;
        let largest = self.gains.iter().map(in_run).fold(0.0, |most: f64, x| most.max(x.abs()));
        let bits = if largest > 0.0 { libm::floor(30.0 - libm::log2(largest)).clamp(1.0, 31.0) } else { 1.0 };
        let words = self.gains.iter().map(|gain| fixed_point(in_run(gain), bits as u32)).collect();
        (words, bits as u32)
    }

    /// The words that determine it in a run.
    pub(crate) fn identity(&self, lsb_arcsec: f64) -> Vec<u32> {
        let (weights, bits) = self.weights(lsb_arcsec);
        let shape = [relock_ticks::VERSION, self.shape.method as u32, self.shape.ticks as u32, bits];
        shape.into_iter().chain(self.words.clone()).chain(weights).collect()
    }
}
