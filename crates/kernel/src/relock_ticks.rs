//! The first ticks after one mode switch: the apparent rotation of the closing perimeter loop, less its compensation.
//!
//! Twin of `shaders/relock_ticks.wgsl`. This file is a part of other kernels: `relock` uses it for one switch,
//! `switched_run` for each switch of a run. A switch has draws of its own, addressed by its number. The miss Δλ0 and
//! the measured quantities are words; ratios are differences of logarithms. A mask leaves out a compensation that makes
//! no sense because its y or h has the wrong sign, is 0 or does not decay. Source: Z(2), Z(10)–Z(13).

use crate::normal::normal;
use crate::parameters::parameters;
use crate::part;
use crate::philox::{Address, Purpose};
use crate::power::{EXP2_ONE, LOG_BITS, exp2_fraction, exp2_minus, log2_word};
use crate::shader::{Shader, constants};
use crate::word::{HALF, Wide, Word};

constants!(RELOCK_BLOCKS, WRONG_BITS, MIDDLE);

/// Most ticks for which the loop is followed.
pub const MAX_TICKS: usize = 8;

/// Blocks of random words of a switch: one for the miss, one for the beat, one for each two ticks' detunings; the
/// others are reserved.
pub(crate) const RELOCK_BLOCKS: usize = 8;

/// Fractional bits of the relative error of f0.
const WRONG_BITS: u32 = 30;

/// The middle of the range of a word.
const MIDDLE: u32 = 1 << 31;

/// Raised when results change for the same parameters: part of every digest.
pub const VERSION: u32 = 1;

/// How the ticks are compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Not at all: the apparent rotation remains.
    None,
    /// By the measured frequency of the bias, from the second tick on: Z(11).
    Frequency,
    /// By the measured detuning: Z(11)–Z(13).
    Detuning,
}

/// Options of the ticks in a launch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Number of ticks, at most [`MAX_TICKS`].
    pub ticks: usize,
    /// How they are compensated.
    pub method: Method,
}

impl Shape {
    /// Adds the ticks to the shader of a kernel that has a field `relock` for their parameters.
    pub fn include(self, shader: &mut Shader) {
        shader.parts.push(&part::relock_ticks);
        shader.constants.push(("RELOCK_TICKS", self.ticks));
        shader.flags.push(("RELOCK_BY_FREQUENCY", self.method == Method::Frequency));
        shader.flags.push(("RELOCK_BY_DETUNING", self.method == Method::Detuning));
        // The prefix keeps these names apart from those of the surrounding kernel.
        shader.declarations += &wgsl_places(self).replace("const ", "const RELOCK_");
    }

    /// `count` where this method needs them.
    #[inline(always)]
    fn only(self, method: Method, count: usize) -> usize {
        if self.method == method { count } else { 0 }
    }
}

parameters! {
    /// Nominal Δλ0, in units of the detuning.
    miss: |_| 1,
    /// Standard deviation of the error of U_λ/2, in 2^−4 units.
    half_wave: |_| 1,
    /// Step of the DAC, in units.
    dac_step: |_| 1,
    /// Full width of the hysteresis, in units.
    hysteresis: |_| 1,
    /// Number of bits by which the miss is shifted left before it is squared.
    square_shift: |_| 1,
    /// Angle of each tick, in LSB, at a square of 2^32.
    drift: |shape: Shape| shape.ticks,
    /// Standard deviation of the relative error of f0, in 2^−34.
    temperature: |_| 1,
    /// The sign of the apparent rotation, in its highest bit.
    sign: |_| 1,
    /// Half of f0·T, in units of the beat.
    half_bias: |shape: Shape| shape.only(Method::Frequency, 1),
    /// Deficit of the first half of each tick relative to `half_bias`, at a square of 2^32.
    lost_first: |shape: Shape| shape.only(Method::Frequency, shape.ticks),
    /// Deficit of the second half of each tick relative to `half_bias`, at a square of 2^32.
    lost_second: |shape: Shape| shape.only(Method::Frequency, shape.ticks),
    /// Mask of the bits of a phase that are counted: those of whole periods.
    counted: |shape: Shape| shape.only(Method::Frequency, 1),
    /// Logarithm of a unit of the beat in LSB, 2^−26.
    beat_log: |shape: Shape| shape.only(Method::Frequency, 1),
    /// Mean detuning over the first half of each tick relative to Δλ0, in 2^−31.
    mean_first: |shape: Shape| shape.only(Method::Detuning, shape.ticks),
    /// Mean detuning over the second half of each tick relative to Δλ0, in 2^−31.
    mean_second: |shape: Shape| shape.only(Method::Detuning, shape.ticks),
    /// Standard deviation of the noise of both means, in 2^−4 units.
    adc_sigma: |shape: Shape| shape.only(Method::Detuning, 1),
    /// Half a step of the ADC, in units.
    adc_half: |shape: Shape| shape.only(Method::Detuning, 1),
    /// Mask of the bits that the ADC reports.
    adc_shown: |shape: Shape| shape.only(Method::Detuning, 1),
    /// Half the logarithm of χ f0 T/4 in units and LSB, 2^−26.
    detuning_log: |shape: Shape| shape.only(Method::Detuning, 1),
}

/// The parameters by name.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Parameter words.
    pub p: Parameters<'a>,
    /// Their shape.
    pub shape: Shape,
}

/// Angles of the ticks of a switch in LSB, of which the first `shape.ticks` count: the apparent rotation less its
/// compensation.
// The loops of this file mirror those of the shader.
#[expect(clippy::needless_range_loop)]
#[inline(always)]
pub fn relock_ticks<W: Word>(given: &Given, address: &Address<W>, switch: usize, wrong: W) -> [W; MAX_TICKS] {
    let Given { p, shape } = given;
    let miss = relock_miss(p, address.draw(Purpose::Relock, switch * RELOCK_BLOCKS));
    let square = relock_square(p, miss);
    let mut left = [W::splat(0); MAX_TICKS];
    for i in 0..shape.ticks {
        left[i] = relock_scaled(square, p.drift[i]);
    }
    match shape.method {
        Method::None => left,
        Method::Frequency => less_by_frequency(given, address, switch, square, wrong, left),
        Method::Detuning => less_by_detuning(given, address, switch, miss, wrong, left),
    }
}

/// The relative error of f0 in the temperature curve, 2^−30; it is the same at all switches of a trial.
#[inline(always)]
pub(crate) fn relock_wrong<W: Word>(given: &Given, address: &Address<W>) -> W {
    let words = address.draw(Purpose::Relock, 0);
    normal(words[3]).mul_wide(W::splat(given.p.temperature[0])).high_word()
}

/// The miss Δλ0 of the switch, in units of the detuning.
#[inline(always)]
fn relock_miss<W: Word>(p: &Parameters, words: [W; 4]) -> W {
    let middle = W::splat(MIDDLE);
    let sum = W::Wide::splat((i64::from(p.miss[0] as i32) << 32) + i64::from(HALF))
        + normal(words[0]).mul_wide(W::splat(p.half_wave[0]))
        + (words[1] ^ middle).mul_wide(W::splat(p.dac_step[0]))
        + (words[2] ^ middle).mul_wide(W::splat(p.hysteresis[0]));
    sum.high_word()
}

/// The square of the shifted miss, below 2^30.
#[inline(always)]
fn relock_square<W: Word>(p: &Parameters, miss: W) -> W {
    let magnitude = miss.with_sign(miss) << p.square_shift[0];
    magnitude.mulhi(magnitude)
}

/// Scales `word`, which belongs to a square of 2^32, to this square.
#[inline(always)]
fn relock_scaled<W: Word>(square: W, word: u32) -> W {
    (square.mul_wide(W::splat(word)) + W::Wide::half()).high_word()
}

/// Subtracts the compensation by frequency. The beat counts up in the first half of a tick and down in the second;
/// whole periods of both are counted. y_i T is their number less the assumed f0·T.
#[expect(clippy::needless_range_loop)]
#[inline(always)]
fn less_by_frequency<W: Word>(
    given: &Given,
    address: &Address<W>,
    switch: usize,
    square: W,
    wrong: W,
    mut left: [W; MAX_TICKS],
) -> [W; MAX_TICKS] {
    let Given { p, shape } = given;
    let one = W::splat(EXP2_ONE);
    let (zero, least) = (W::splat(0), W::splat(1));
    let counted = W::splat(p.counted[0]);
    let half = W::splat(p.half_bias[0]);
    let bias = half << 1;
    let assumed = bias + bias.mul_wide(wrong).bits_from(WRONG_BITS);
    let mut phase = address.draw(Purpose::Relock, switch * RELOCK_BLOCKS + 1)[0] & W::splat(!p.counted[0]);
    let (mut first, mut first_log) = (zero, zero);
    for i in 0..shape.ticks {
        let top = phase + half - relock_scaled(square, p.lost_first[i]);
        let end = top - half + relock_scaled(square, p.lost_second[i]);
        let error = ((top & counted) << 1) - (phase & counted) - (end & counted) - assumed;
        phase = end;
        let log = log2_word((zero - error).max_signed(least));
        if i == 0 {
            first = error;
            first_log = log;
        } else {
            // −log2 q: 1/(2(i−1)) of −log2(y_i/y_1).
            let decay = (first_log - log).max_signed(least).mulhi(W::splat(EXP2_ONE / i as u32));
            let q = exp2_minus(decay.max_signed(least));
            let angle = relock_power(
                log + log2_word(one - q) - log2_word(one + q) + W::splat(p.beat_log[0]),
                LOG_BITS,
            );
            let decays = error.sar(31) & (first - error).sar(31);
            left[i] = left[i] - (angle & decays).with_sign(W::splat(p.sign[0]));
        }
    }
    left
}

/// Subtracts the compensation by detuning, from the mean detunings h⁺, h⁻ over the halves of a tick as an ADC reports
/// them.
#[inline(always)]
fn less_by_detuning<W: Word>(
    given: &Given,
    address: &Address<W>,
    switch: usize,
    miss: W,
    wrong: W,
    mut left: [W; MAX_TICKS],
) -> [W; MAX_TICKS] {
    let Given { p, shape } = given;
    let one = W::splat(EXP2_ONE);
    let (zero, least) = (W::splat(0), W::splat(1));
    let mut noise = [zero; 4];
    for i in 0..shape.ticks {
        if i % 2 == 0 {
            noise = address.draw(Purpose::Relock, switch * RELOCK_BLOCKS + 2 + i / 2);
        }
        let plus = relock_shown(p, miss, p.mean_first[i], noise[2 * (i % 2)]);
        let minus = relock_shown(p, miss, p.mean_second[i], noise[2 * (i % 2) + 1]);
        let (first, second) = (plus.with_sign(plus), minus.with_sign(minus));
        let log = log2_word(first.max_signed(least));
        // −log2 r.
        let decay = (log - log2_word(second.max_signed(least))).max_signed(least);
        let half_log =
            log + (log2_word(decay) >> 1) + log2_word(one + exp2_minus(decay)) + W::splat(p.detuning_log[0]);
        let angle = relock_power(half_log, LOG_BITS - 1);
        let angle = angle.mul_wide(W::splat(1 << WRONG_BITS) + wrong).bits_from(WRONG_BITS);
        let decays = (second - first).sar(31) & (zero - second).sar(31);
        let alike = (plus ^ minus).sar(31) ^ W::splat(!0);
        left[i] = left[i] - (angle & decays & alike).with_sign(W::splat(p.sign[0]));
    }
    left
}

/// A mean detuning with noise, rounded to the step of the ADC.
#[inline(always)]
fn relock_shown<W: Word>(p: &Parameters, miss: W, mean: u32, noise: W) -> W {
    let sum = (miss << 1).mul_wide(W::splat(mean))
        + normal(noise).mul_wide(W::splat(p.adc_sigma[0]))
        + W::Wide::half();
    (sum.high_word() + W::splat(p.adc_half[0])) & W::splat(p.adc_shown[0])
}

/// 2 to the power of `log`, which has `bits` fractional bits; 1 where `log` is negative.
#[inline(always)]
fn relock_power<W: Word>(log: W, bits: u32) -> W {
    let log = log.max_signed(W::splat(0)).min_signed(W::splat((32_u64 << bits) as u32 - 1));
    exp2_fraction(log << (32 - bits)).shift_right(W::splat(31) - (log >> bits))
}
