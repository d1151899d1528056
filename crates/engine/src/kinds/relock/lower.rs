//! Lowering of a relock: words of the kernel, and the estimates of each compensation.
//!
//! In the closed form of the inputs, the angle that a miss Δλ0 leaves in some ticks is C·Δλ0². Z(11) over tick i is C_i = 2χ f0 τ_L q^{2i−1} sinh²(T/2τ_L), and
//! over the first m ticks it is ½χ f0 τ_L tanh(T/2τ_L)(1 − q^{2m}), with q = e^{−T/τ_L} and f0 in ″/s. Units, words and the
//! bias lost in half-ticks, of which lowering makes the angles, do not occur.

use std::sync::Arc;

use crate::key::{Streams, Unrepresentable, shown};
use crate::kinds::gap_fill::lower::words_of;
use crate::kinds::plan::identity;
use crate::kinds::relock::{Compensation, FirstHalf, Relock, RelockInputs, RelockPoint};
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{MAX_ESTIMATES, Trials, level};
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock::{Parameters, Shape, WEIGHT_BITS};
use sagnac_kernel::relock_ticks::{
    self, MAX_TICKS, Method, Parameters as TickParameters, Shape as TickShape,
};
use sagnac_kernel::width::Width;
use sagnac_theory::relock;

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
    /// The point cannot be represented; see [`Unrepresentable`].
    pub fn new(point: &RelockPoint, seed: u64, streams: Streams) -> Result<LoweredRelock, Unrepresentable> {
        let inputs = &point.inputs;
        let text = format!("tick_s={:.11e}\n{}", inputs.tick_s, inputs.relock.identity());
        let (id, key) = identity("relock", seed, streams, &text);
        let fixed = FixedRelock::new(&inputs.relock, inputs.tick_s)?;
        let ticks = inputs.relock.ticks as usize;
        let mut lowered = LoweredRelock { id, key, fixed, ticks, estimates: vec![] };
        for compensation in Compensation::ALL {
            let sums = (1..=ticks as u32).map(Some).chain([None]);
            let estimates = sums.map(|tick| lowered.estimate(point, compensation, tick));
            let mut estimates = estimates.collect::<Result<Vec<RelockEstimate>, Unrepresentable>>()?;
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
    ) -> Result<RelockEstimate, Unrepresentable> {
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
        let physical = left(&point.inputs, compensation, tick);
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
        let address = Address { point: self.id, estimate: Id::from_text(&estimate), digest: self.id };
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
    ) -> Result<f64, Unrepresentable> {
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
        Err(Unrepresentable::new(
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

/// Largest detuning, units.
const MAX_DETUNING: f64 = 536_870_912.0;

/// Fewest units of the largest miss.
const MIN_MISS: f64 = 1_048_576.0;

/// Largest apparent rotation of the loop in a tick, LSB.
const MAX_FAKED: f64 = 67_108_864.0;
/// Largest sum of all ticks with their compensation, LSB.
pub(crate) const MAX_LEFT: f64 = 268_435_456.0;

/// Most units of the beat in a tick, and fewest units in a count, whose fraction determines where a count falls.
const MAX_BEAT: f64 = 134_217_728.0;
const MIN_COUNT: f64 = 256.0;

/// Fewest units, of 2^−4 for a standard deviation, of a standard deviation and of a width, which are then rounded by at
/// most 1 %.
const MIN_SIGMA: f64 = 50.0;
const MIN_WIDTH: f64 = 50.0;

/// Relative deviation of the angles of ticks in f64, of which the slowest loop leaves the difference of nearly equal halves.
const F64_DIGITS: f64 = 1e-11;

/// Slowest and fastest loop, in ticks.
const SLOWEST: f64 = 100.0;
const FASTEST: f64 = 0.05;

/// A relock in fixed point, for all of its [`MAX_TICKS`] ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedRelock {
    /// Unit of angle, ″.
    pub lsb_arcsec: f64,
    /// Unit of detunings, in fractions of the wavelength.
    unit: f64,
    miss: u32,
    half_wave: u32,
    dac_step: u32,
    hysteresis: u32,
    square_shift: u32,
    drift: Vec<u32>,
    temperature: u32,
    sign: u32,
    half_bias: u32,
    lost: [Vec<u32>; 2],
    counted: u32,
    beat_log: u32,
    means: [Vec<u32>; 2],
    adc_sigma: u32,
    adc_half: u32,
    adc_shown: u32,
    detuning_log: u32,
}

impl FixedRelock {
    /// # Errors
    /// The relock cannot be represented; see [`Unrepresentable`].
    pub fn new(inputs: &Relock, tick_s: f64) -> Result<FixedRelock, Unrepresentable> {
        let Relock { loop_s, curvature, temperature_error, adc_noise, adc_step, .. } = *inputs;
        check_loop(loop_s, tick_s)?;
        let largest = inputs.largest_miss();
        if largest == 0.0 {
            let message =
                "relock.initial_detuning is 0, and so are its errors: there is nothing to relock".to_owned();
            let help = "give an initial detuning, or one of half_wave_error, dac_step and hysteresis";
            return Err(Unrepresentable { key: "relock.initial_detuning", message, help });
        }
        let part = curvature * largest * largest;
        if part >= 1.0 {
            let found = format!(
                "an initial detuning of up to {} leaves no bias, χ·Δλ² = {}",
                significant(largest, 4),
                significant(part, 4)
            );
            let help = "make the initial detuning, its errors or the curvature smaller: Z(2) holds for small detunings";
            return Err(Unrepresentable::new("relock.curvature", found, help));
        }
        let reach = largest + REACH * adc_noise + adc_step;
        let unit = unit_of_detuning(reach, adc_step)?;
        if largest / unit < MIN_MISS {
            return Err(too_small("relock.initial_detuning", largest, reach));
        }
        let sigma = |key, found: f64| {
            let units = libm::round(16.0 * found / unit);
            word_above(found, units, MIN_SIGMA, || too_small(key, found, reach))
        };
        let width = |key, found: f64, width: f64| {
            let units = libm::round(width / unit);
            word_above(found, units, MIN_WIDTH, || too_small(key, found, reach))
        };
        let square_shift = libm::floor(libm::log2(2_147_483_648.0 / (largest / unit)));
        // Units of the square by which the kernel multiplies, of 2^32 each.
        let square = libm::exp2(2.0 * square_shift - 64.0) / (unit * unit);

        let bias = inputs.bias_frequency_hz * inputs.pulse_weight_arcsec;
        let of_one = relock::Relock { tick_s, loop_s, bias, curvature, miss: 1.0 };
        let ticks = || 1..=MAX_TICKS as u32;
        let at_largest = largest * largest;
        let faked: Vec<f64> = ticks().map(|i| tick_s * of_one.apparent_drift(i)).collect();
        let count = if inputs.count_step > 0.0 { inputs.count_step } else { 1.0 };
        let counts = inputs.bias_frequency_hz * tick_s / count;
        let wrong = REACH * temperature_error;
        // Bounds of all compensations: |y_1| by frequency, and Z(13) at the least ratio of the halves by detuning.
        let [first, second] = of_one.lost(1).map(|lost| 0.5 * lost * at_largest);
        let by_frequency =
            bias * tick_s * (first + second + wrong) + 2.0 * inputs.count_step * inputs.pulse_weight_arcsec;
        let least = unit.max(adc_step) / reach;
        let by_detuning =
            curvature * bias * tick_s * reach * reach * -libm::log(least) * (1.0 + least) * (1.0 + least)
                / 4.0;
        let compensation = by_frequency.max(by_detuning * (1.0 + wrong));
        let sum = faked.iter().sum::<f64>() * at_largest + MAX_TICKS as f64 * compensation;
        let bits = libm::floor(libm::log2((MAX_LEFT / sum).min(MAX_FAKED / (faked[0] * at_largest))));
        let lsb_arcsec = libm::exp2(-bits);

        let pulse = count * inputs.pulse_weight_arcsec;
        let beat_bits = libm::floor(libm::log2((MAX_BEAT / counts).min(pulse / lsb_arcsec)));
        let whole = inputs.count_step > 0.0;
        if whole && counts < 2.0 {
            let found = format!("{} counts in half a tick, less than one", shown(0.5 * counts));
            let help =
                "make relock.bias_frequency or gyro.tick larger, or relock.count_step smaller, 0 for none";
            return Err(Unrepresentable::new("relock.bias_frequency", found, help));
        }
        if beat_bits < libm::log2(MIN_COUNT) {
            let found = format!("{} counts in a tick are too many for 32-bit arithmetic", shown(counts));
            let help = "make gyro.tick smaller, or relock.count_step larger, or 0 for none";
            return Err(Unrepresentable::new("relock.bias_frequency", found, help));
        }
        let beat = libm::exp2(beat_bits);
        let half_bias = libm::round(0.5 * counts * beat);
        let lost = |half: usize| {
            ticks().map(|i| word(counts * beat * 0.5 * of_one.lost(i)[half] / square)).collect()
        };
        let means = |half: usize| {
            let of =
                |i| libm::round(of_one.detuning_means(i)[half] * 2_147_483_648.0).min(f64::from(i32::MAX));
            ticks().map(|i| of(i) as u32).collect()
        };
        let step_units = libm::round(adc_step / unit);
        let per_square = curvature * bias * tick_s * unit * unit / lsb_arcsec;
        // A unit of a logarithm is 2^−26, and each logarithm is floored, for which half a unit is added.
        let log_word = |log: f64, floors: f64| libm::round(log * 67_108_864.0 + floors) as i64 as u32;
        Ok(FixedRelock {
            lsb_arcsec,
            unit,
            miss: libm::round(inputs.miss / unit) as i32 as u32,
            half_wave: sigma("relock.half_wave_error", inputs.half_wave_error)?,
            dac_step: width("relock.dac_step", inputs.dac_step, inputs.dac_step)?,
            hysteresis: width("relock.hysteresis", inputs.hysteresis, 2.0 * inputs.hysteresis)?,
            square_shift: square_shift as u32,
            drift: faked.iter().map(|faked| word(faked / lsb_arcsec / square)).collect(),
            temperature: word(temperature_error * libm::exp2(34.0)),
            sign: if inputs.first_half == FirstHalf::Positive { 1 << 31 } else { 0 },
            half_bias: half_bias as u32,
            lost: [lost(0), lost(1)],
            counted: if whole { !((1 << beat_bits as u32) - 1) } else { u32::MAX },
            beat_log: log_word(libm::log2(pulse / beat / lsb_arcsec), 0.5),
            means: [means(0), means(1)],
            adc_sigma: sigma("relock.adc_noise", adc_noise)?,
            adc_half: step_units as u32 / 2,
            adc_shown: if adc_step > 0.0 { !(step_units as u32 - 1) } else { u32::MAX },
            detuning_log: log_word(
                0.5 * libm::log2(per_square * core::f64::consts::LN_2 / 4.0) - 13.0 - 31.0,
                1.5,
            ),
        })
    }

    /// The parameters of the first ticks.
    pub fn words(&self, shape: TickShape) -> Vec<u32> {
        let only = |method: Method, word: &[u32]| if shape.method == method { word.to_vec() } else { vec![] };
        let frequency = |words: &[u32]| only(Method::Frequency, words);
        let detuning = |words: &[u32]| only(Method::Detuning, words);
        let signed = |words: &[u32]| -> Vec<u32> {
            let sign = |word: &u32| if self.sign > 0 { word.wrapping_neg() } else { *word };
            words[..shape.ticks].iter().map(sign).collect()
        };
        TickParameters {
            miss: &[self.miss],
            half_wave: &[self.half_wave],
            dac_step: &[self.dac_step],
            hysteresis: &[self.hysteresis],
            square_shift: &[self.square_shift],
            drift: &signed(&self.drift),
            temperature: &[self.temperature],
            sign: &[self.sign],
            half_bias: &frequency(&[self.half_bias]),
            lost_first: &frequency(&self.lost[0][..shape.ticks]),
            lost_second: &frequency(&self.lost[1][..shape.ticks]),
            counted: &frequency(&[self.counted]),
            beat_log: &frequency(&[self.beat_log]),
            mean_first: &detuning(&self.means[0][..shape.ticks]),
            mean_second: &detuning(&self.means[1][..shape.ticks]),
            adc_sigma: &detuning(&[self.adc_sigma]),
            adc_half: &detuning(&[self.adc_half]),
            adc_shown: &detuning(&[self.adc_shown]),
            detuning_log: &detuning(&[self.detuning_log]),
        }
        .words()
    }

    /// ⟨Δλ0²⟩ and ⟨Δλ0⁴⟩ from the words, in units.
    fn moments_of_miss(&self) -> [f64; 2] {
        let mean = f64::from(self.miss as i32);
        let sigma = f64::from(self.half_wave) / 16.0;
        let widths = [self.dac_step, self.hysteresis].map(f64::from);
        let [dac, hysteresis] = widths.map(|width| width * width);
        let variance = sigma * sigma + (dac + hysteresis) / 12.0;
        // A uniform distribution of width w has the fourth cumulant −w⁴/120.
        let fourth = -(dac * dac + hysteresis * hysteresis) / 120.0;
        let square = mean * mean;
        [square + variance, square * square + 6.0 * square * variance + 3.0 * variance * variance + fourth]
    }

    /// Mean and rms of the uncompensated sum of the ticks with these weights, ″; exact, as they follow from the words.
    pub fn faked(&self, weights: &[f64]) -> (f64, f64) {
        let sum: f64 = weights.iter().zip(&self.drift).map(|(weight, word)| weight * f64::from(*word)).sum();
        let sign = if self.sign > 0 { -1.0 } else { 1.0 };
        let scale = sign * sum * libm::exp2(2.0 * f64::from(self.square_shift) - 64.0) * self.lsb_arcsec;
        let [second, fourth] = self.moments_of_miss();
        (scale * second, scale.abs() * libm::sqrt(fourth))
    }

    /// Bound of the deviation of mean and rms in [`FixedRelock::faked`] from those of the inputs, ″, where `rms` is that
    /// of the words. Each word is within half its unit of what it stands for; in the norm ⟨x⁴⟩^¼, in which the rms is |C|‖Δλ0‖²,
    /// deviations of the initial detuning add up at most.
    pub(crate) fn representation(&self, weights: &[f64], rms: f64) -> f64 {
        let norm = |word: u32, norm: f64| if word > 0 { norm } else { 0.0 };
        // A normal number has ⟨x⁴⟩ = 3, and one that is uniform over a width of 1 has 1/80.
        let uniform = libm::pow(80.0, -0.25);
        let of_normal = norm(self.half_wave, libm::pow(3.0, 0.25) / 16.0);
        let of_uniform = norm(self.dac_step, uniform) + norm(self.hysteresis, uniform);
        let off = 0.5 * (1.0 + of_normal + of_uniform);
        let size = libm::pow(self.moments_of_miss()[1], 0.25);
        let of_miss = off * (2.0 * size + off);
        // The drift words of the ticks at a square of one unit.
        let square = libm::exp2(2.0 * f64::from(self.square_shift) - 64.0) * self.lsb_arcsec;
        let words: f64 =
            weights.iter().zip(&self.drift).map(|(w, word)| w.abs() * (f64::from(*word) + 0.5)).sum();
        let halves: f64 = weights.iter().map(|w| 0.5 * w.abs()).sum();
        (words * of_miss + halves * (size + off) * (size + off)) * square + F64_DIGITS * rms
    }

    /// Bound of the deviation of [`FixedRelock::wrong`] from the input.
    fn representation_of_wrong(&self) -> f64 {
        0.5 * libm::exp2(-34.0)
    }

    /// Bound of the deviation of such a sum from exact arithmetic, ″: the initial detuning is rounded by half a unit, its square
    /// down, and each tick to the LSB.
    pub fn rounding(&self, weights: &[f64]) -> f64 {
        let of_square = libm::exp2(f64::from(self.square_shift) - 33.0) + libm::exp2(-32.0);
        let each = self.drift.iter().map(|word| 0.5 + f64::from(*word) * of_square);
        let sum: f64 = weights.iter().zip(each).map(|(weight, each)| weight.abs() * each).sum();
        (sum + 0.5) * self.lsb_arcsec
    }

    /// Standard deviation of the relative error of f0, from its word.
    pub fn wrong(&self) -> f64 {
        f64::from(self.temperature) * libm::exp2(-34.0)
    }

    /// Bound of the remainder after compensation by detuning, without noise and steps of the ADC, relative to 0 or to
    /// the effect of a wrong f0, ″. The means are rounded to half a unit, logarithms to 2^−26.
    pub fn rounding_by_detuning(&self, weights: &[f64]) -> f64 {
        let largest = libm::exp2(31.0 - f64::from(self.square_shift));
        let bound = |i: usize| {
            let [plus, minus] =
                [0, 1].map(|half| largest * f64::from(self.means[half][i]) * libm::exp2(-31.0));
            let decay = libm::log(plus / minus);
            let of_means = 1.0 / plus + (0.5 / plus + 0.5 / minus + 3e-8) / decay;
            f64::from(self.drift[i]) * libm::exp2(-2.0) * (of_means + 1e-7) + 2.0
        };
        let sum: f64 = weights.iter().enumerate().map(|(i, weight)| weight.abs() * bound(i)).sum();
        sum * self.lsb_arcsec + self.rounding(weights)
    }
}

fn check_loop(loop_s: f64, tick_s: f64) -> Result<(), Unrepresentable> {
    let (found, tick, ticks) = (shown(loop_s), shown(tick_s), loop_s / tick_s);
    let refuse = |message, help| Err(Unrepresentable { key: "relock.loop_time", message, help });
    if ticks > SLOWEST {
        let message =
            format!("relock.loop_time = {found} s does not settle within the ticks followed, of {tick} s");
        return refuse(message, "accepted: up to 100 ticks; the paper's values are 1 to 6");
    }
    if ticks < FASTEST {
        let message = format!("relock.loop_time = {found} s is over within the first tick, of {tick} s");
        return refuse(message, "accepted: from a 20th of a tick");
    }
    Ok(())
}

/// The refusal of an error that has too few units relative to the initial detuning.
fn too_small(key: &'static str, found: f64, largest: f64) -> Unrepresentable {
    let found =
        format!("{} is lost beside detunings of up to {} in 32-bit arithmetic", shown(found), shown(largest));
    Unrepresentable::new(key, found, "make it larger, or 0; or what is large beside it smaller")
}

/// The unit of detunings up to `largest`: a power of two, or a step of the ADC divided by a power of two.
fn unit_of_detuning(largest: f64, adc_step: f64) -> Result<f64, Unrepresentable> {
    let finest = largest / MAX_DETUNING;
    if adc_step == 0.0 {
        return Ok(libm::exp2(libm::ceil(libm::log2(finest))));
    }
    let bits = libm::floor(libm::log2(adc_step / finest));
    if bits < 1.0 {
        return Err(too_small("relock.adc_step", adc_step, largest));
    }
    Ok(adc_step / libm::exp2(bits))
}

fn word(x: f64) -> u32 {
    libm::round(x) as u32
}

/// The word of `units`, which must be at least `least` unless `found` is 0.
fn word_above(
    found: f64,
    units: f64,
    least: f64,
    error: impl FnOnce() -> Unrepresentable,
) -> Result<u32, Unrepresentable> {
    if found == 0.0 || units >= least { Ok(units as u32) } else { Err(error()) }
}

/// Mean and rms of the angle left in a tick, or in all ticks, ″; `None` where they have no closed form.
fn left(inputs: &RelockInputs, compensation: Compensation, tick: Option<u32>) -> Option<(f64, f64)> {
    let relock = &inputs.relock;
    let scale = angle_of_one(inputs, tick);
    let [second, fourth] = moments_of_miss(relock);
    let (mean, rms) = (scale * second, scale.abs() * libm::sqrt(fourth));
    match (compensation, tick) {
        (Compensation::None, _) | (Compensation::Frequency, Some(1)) => Some((mean, rms)),
        (Compensation::Detuning, _) if relock.adc_noise == 0.0 && relock.adc_step == 0.0 => {
            Some((0.0, rms * relock.temperature_error))
        }
        _ => None,
    }
}

/// C, the angle left of a miss of one wavelength, ″.
fn angle_of_one(inputs: &RelockInputs, tick: Option<u32>) -> f64 {
    let RelockInputs { tick_s, relock } = inputs;
    let ratio = tick_s / relock.loop_s;
    let of_loop = match tick {
        Some(tick) => {
            let half = libm::sinh(0.5 * ratio);
            2.0 * libm::exp(-f64::from(2 * tick - 1) * ratio) * half * half
        }
        None => 0.5 * libm::tanh(0.5 * ratio) * -libm::expm1(-f64::from(2 * relock.ticks) * ratio),
    };
    let sign = if relock.first_half == FirstHalf::Negative { 1.0 } else { -1.0 };
    let bias_arcsec_per_s = relock.pulse_weight_arcsec * relock.bias_frequency_hz;
    sign * relock.curvature * bias_arcsec_per_s * relock.loop_s * of_loop
}

/// ⟨Δλ0²⟩ and ⟨Δλ0⁴⟩.
fn moments_of_miss(relock: &Relock) -> [f64; 2] {
    let square = |x: f64| x * x;
    let normal = square(relock.half_wave_error);
    // An error that is uniform to either side of 0.
    let uniform = |half: f64| [square(half) / 3.0, square(square(half)) / 5.0];
    // An independent error without a mean is added to others.
    let with = |[s, f]: [f64; 2], [second, fourth]: [f64; 2]| [s + second, f + 6.0 * s * second + fourth];
    let errors = [uniform(0.5 * relock.dac_step), uniform(relock.hysteresis)];
    let errors = errors.into_iter().fold([normal, 3.0 * normal * normal], with);
    let miss = square(relock.miss);
    with([miss, miss * miss], errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::relock::{FirstHalf, Relock, RelockInputs, verify};

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

    /// The bias has opposite signs in the halves of a tick.
    #[test]
    fn the_angle_is_the_integral_of_the_bias_that_is_lost() {
        for loop_s in [0.0025, 0.012, 0.2] {
            let mut inputs = verify::relock();
            inputs.relock.loop_s = loop_s;
            let Relock { bias_frequency_hz, pulse_weight_arcsec, curvature, ticks, .. } = inputs.relock;
            let steps = 4000;
            let of = |tick: u32| {
                let at = |k: u32| {
                    let part = (f64::from(k) + 0.5) / f64::from(steps);
                    let detuning = libm::exp(-(f64::from(tick - 1) + part) * inputs.tick_s / loop_s);
                    let sign = if part < 0.5 { 1.0 } else { -1.0 };
                    sign * curvature * detuning * detuning
                };
                let mean = (0..steps).map(at).sum::<f64>() / f64::from(steps);
                bias_frequency_hz * pulse_weight_arcsec * inputs.tick_s * mean
            };
            let mut sum = 0.0;
            for tick in 1..=ticks {
                let (found, expected) = (angle_of_one(&inputs, Some(tick)), of(tick));
                sum += expected;
                assert!(
                    (found / expected - 1.0).abs() < 1e-5,
                    "{loop_s} s, tick {tick}: {found}, {expected}"
                );
            }
            let found = angle_of_one(&inputs, None);
            assert!((found / sum - 1.0).abs() < 1e-5, "{loop_s} s: {found}, not {sum}");
        }
    }
}
