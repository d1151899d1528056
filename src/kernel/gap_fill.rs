//! One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
//!
//! Twin of `shaders/gap_fill.wgsl`. Ticks are counted outward from the gap: `before[0]` is tick 0, `before[1]` tick −1,
//! `after[0]` tick n+1. A filler is a vector of integer weights over a common denominator D (its scale), so that
//! D·δP = Σ w P − D Σ_gap true is an exact integer. One that needs more than 32 bits is rounded down to them by a
//! shift. Source: Z(14)–Z(18).

use super::moments::{self, MAX_ESTIMATES, Moments, Sampler};
use super::normal::normal;
use super::philox::{Address, Purpose};
use super::sine::{QUARTER_TURN, sine};
use super::word::{Wide, Word};
use crate::backend::cpu::{AnyWidth, Width};

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 1;

/// Most ticks on one side of the gap.
pub const MAX_SIDE: usize = 64;

/// Most fillers of one launch; a point with more takes several.
pub const MAX_FILLERS: usize = MAX_ESTIMATES / 2;

/// How many ticks and fillers a launch has: what a shader is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Ticks sampled before the gap: the larger of the next two.
    pub before: usize,
    /// Ticks sampled after the gap.
    pub after: usize,
    /// Ticks before the gap that the residual uses.
    pub residual_before: usize,
    /// Ticks before the gap that the extrapolation uses.
    pub extrapolation_before: usize,
    pub fillers: usize,
    /// Whether weighted sums need 64 bits: fillers with large weights do, the usual polynomials do not.
    pub wide: bool,
}

/// Declares the parameter words once: the fields in order, their lengths for a shape, and their names in the shaders.
macro_rules! parameters {
    ($($(#[$doc:meta])* $field:ident: $length:expr),* $(,)?) => {
        /// The fixed-point image of a point, one field after the other, as the kernel sees it.
        #[derive(Debug, Clone, Copy)]
        pub struct Parameters<'a> { $($(#[$doc])* pub $field: &'a [u32]),* }

        impl<'a> Parameters<'a> {
            /// The fields of `words`, which are as many as `shape` asks for.
            #[inline(always)]
            #[allow(unused_assignments)]
            pub fn of(words: &'a [u32], shape: Shape) -> Parameters<'a> {
                let mut from = 0;
                $(let length = ($length)(shape); let $field = &words[from..from + length]; from += length;)*
                Parameters { $($field),* }
            }

            /// The words of the fields.
            pub fn words(&self) -> Vec<u32> {
                [$(self.$field),*].concat()
            }
        }

        /// The place of each field among the words, as constants of a shader.
        pub fn wgsl_places(shape: Shape) -> String {
            let (mut text, mut from) = (String::new(), 0);
            $(
                text += &format!("const {}: u32 = {from}u;\n", stringify!($field).to_uppercase());
                from += ($length)(shape);
            )*
            text
        }

        /// Number of parameter words of a shape.
        pub fn word_count(shape: Shape) -> usize {
            0 $(+ ($length)(shape))*
        }
    };
}

parameters! {
    /// Key of the random words.
    key: |_| 2,
    /// Phase of the tone at the middle of the gap, 2^32 to the turn, before the random part.
    phase: |_| 1,
    /// Which bits of the random phase are added: all of them or none.
    phase_spread: |_| 1,
    /// Standard deviation of the tick noise, in 2^−4 LSB.
    sigma: |_| 1,
    /// The gap's angle at sine 1 and at cosine 1, in 2^−2 LSB; so for the ticks.
    gap_sin: |_| 1,
    gap_cos: |_| 1,
    before_sin: |shape: Shape| shape.before,
    before_cos: |shape: Shape| shape.before,
    after_sin: |shape: Shape| shape.after,
    after_cos: |shape: Shape| shape.after,
    /// Weights of the residual, filler by filler: ticks before, then after, each outward from the gap.
    residual_weight: |shape: Shape| shape.fillers * (shape.residual_before + shape.after),
    residual_scale: |shape: Shape| shape.fillers,
    /// Weights of the extrapolation, filler by filler, outward from the gap.
    extrapolation_weight: |shape: Shape| shape.fillers * shape.extrapolation_before,
    extrapolation_scale: |shape: Shape| shape.fillers,
    /// How far each wide sum is shifted to the right, rounding: residuals, then extrapolations.
    shift: |shape: Shape| if shape.wide { 2 * shape.fillers } else { 0 },
    /// Where each estimate's histogram starts: residuals, then extrapolations.
    bin_base: |shape: Shape| 2 * shape.fillers,
}

/// Half of a tick's unit: turns the floor of [`tick`] into a rounding.
const HALF: i64 = 1 << 31;

/// The trials of one launch.
#[derive(Clone, Copy)]
pub struct GapFill<'a> {
    p: Parameters<'a>,
    shape: Shape,
}

impl<'a> GapFill<'a> {
    /// The trials that `words` describe.
    #[inline(always)]
    pub fn new(words: &'a [u32], shape: Shape) -> GapFill<'a> {
        GapFill { p: Parameters::of(words, shape), shape }
    }
}

impl Sampler for GapFill<'_> {
    #[inline(always)]
    fn estimates(&self) -> usize {
        2 * self.shape.fillers
    }

    #[inline(always)]
    fn bin_base(&self, estimate: usize) -> u32 {
        self.p.bin_base[estimate]
    }

    // The loops read like those of the shader.
    #[expect(clippy::needless_range_loop)]
    #[inline(always)]
    fn trial<W: Word>(&self, low: W, high: u32) -> [W; MAX_ESTIMATES] {
        let GapFill { p, shape } = self;
        let address = Address { low, high, key: [p.key[0], p.key[1]] };

        let mut random = address.draw(Purpose::NoiseAfterAndPhase, 0);
        let phase = W::splat(p.phase[0]) + (random[2] & W::splat(p.phase_spread[0]));
        let sin = sine(phase);
        let cos = sine(phase + W::splat(QUARTER_TURN));
        let truth = angle(sin, cos, p.gap_sin[0], p.gap_cos[0]).high();

        let mut after = [W::splat(0); MAX_SIDE];
        for k in 0..shape.after {
            if k > 0 && k % 2 == 0 {
                random = address.draw(Purpose::NoiseAfterAndPhase, k / 2);
            }
            after[k] =
                tick(angle(sin, cos, p.after_sin[k], p.after_cos[k]), normal(random[k % 2]), p.sigma[0]);
        }
        let mut before = [W::splat(0); MAX_SIDE];
        for k in 0..shape.before {
            if k % 4 == 0 {
                random = address.draw(Purpose::NoiseBefore, k / 4);
            }
            before[k] =
                tick(angle(sin, cos, p.before_sin[k], p.before_cos[k]), normal(random[k % 4]), p.sigma[0]);
        }

        let mut error = [W::splat(0); MAX_ESTIMATES];
        for filler in 0..shape.fillers {
            let mut sum = Sum::less(truth, p.residual_scale[filler], shape.wide);
            let weight = &p.residual_weight[filler * (shape.residual_before + shape.after)..];
            for k in 0..shape.residual_before {
                sum.add(before[k], weight[k]);
            }
            for k in 0..shape.after {
                sum.add(after[k], weight[shape.residual_before + k]);
            }
            error[filler] = sum.error(p.shift, filler);
        }
        for filler in 0..shape.fillers {
            let mut sum = Sum::less(truth, p.extrapolation_scale[filler], shape.wide);
            let weight = &p.extrapolation_weight[filler * shape.extrapolation_before..];
            for k in 0..shape.extrapolation_before {
                sum.add(before[k], weight[k]);
            }
            error[shape.fillers + filler] = sum.error(p.shift, shape.fillers + filler);
        }
        error
    }
}

/// A weighted sum of ticks less the scaled truth, in 32 bits where that is enough.
#[derive(Clone, Copy)]
enum Sum<W: Word> {
    Narrow(W),
    Wide(W::Wide),
}

impl<W: Word> Sum<W> {
    #[inline(always)]
    fn less(truth: W, scale: u32, wide: bool) -> Sum<W> {
        let minus = W::splat(scale.wrapping_neg());
        if wide { Sum::Wide(truth.mul_wide(minus)) } else { Sum::Narrow(truth * minus) }
    }

    #[inline(always)]
    fn add(&mut self, tick: W, weight: u32) {
        match self {
            Sum::Narrow(sum) => *sum = *sum + tick * W::splat(weight),
            Sum::Wide(sum) => *sum = *sum + tick.mul_wide(W::splat(weight)),
        }
    }

    #[inline(always)]
    fn error(self, shift: &[u32], estimate: usize) -> W {
        match self {
            Sum::Narrow(sum) => sum,
            Sum::Wide(sum) => {
                let half = (1_i64 << shift[estimate]) >> 1;
                (sum + W::Wide::splat(half)).bits_from(shift[estimate])
            }
        }
    }
}

/// The angle that the tone turns through, in 2^−32 LSB, with half an LSB for rounding.
#[inline(always)]
fn angle<W: Word>(sin: W, cos: W, at_sin: u32, at_cos: u32) -> W::Wide {
    sin.mul_wide(W::splat(at_sin)) + cos.mul_wide(W::splat(at_cos)) + W::Wide::splat(HALF)
}

/// What the gyro delivers for a tick: the angle and `sigma` times the normal number `z`, in LSB.
#[inline(always)]
fn tick<W: Word>(angle: W::Wide, z: W, sigma: u32) -> W {
    (angle + z.mul_wide(W::splat(sigma))).high()
}

/// Shapes whose loops are worth unrolling ahead of time: the default ticks with one to three fillers.
const UNROLLED: Shape = Shape {
    before: 4,
    after: 2,
    residual_before: 2,
    extrapolation_before: 4,
    fillers: MAX_FILLERS,
    wide: false,
};

struct Tally<'a> {
    words: &'a [u32],
    shape: Shape,
    first: u64,
    count: u64,
    histogram: bool,
}

impl AnyWidth for Tally<'_> {
    type Output = Vec<Moments>;

    #[inline(always)]
    fn run<W: Word>(self) -> Vec<Moments> {
        let Tally { words, shape, first, count, histogram } = self;
        // The comparison makes the shape a constant of the branch.
        if shape == UNROLLED {
            moments::tally::<W>(GapFill::new(words, UNROLLED), first, count, histogram)
        } else {
            moments::tally::<W>(GapFill::new(words, shape), first, count, histogram)
        }
    }
}

/// Tallies of the estimates over the trials `first .. first + count`, which have one upper half.
pub fn tally(width: Width, launch: &Launch, first: u64, count: u64, histogram: bool) -> Vec<Moments> {
    width.run(Tally { words: &launch.words, shape: launch.shape, first, count, histogram })
}

/// All that a device needs to sample the estimates of one point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launch {
    pub shape: Shape,
    /// The [`Parameters`], one after the other.
    pub words: Vec<u32>,
}
