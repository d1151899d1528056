//! One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
//!
//! Twin of `shaders/gap_fill.wgsl`. Ticks are counted outward from the gap: `before[0]` is tick 0, `before[1]` tick −1,
//! `after[0]` tick n+1. A filler is a vector of integer weights over a common denominator D (its scale), so that
//! D·δP = Σ w P − D Σ_gap true is an exact integer. One that needs more than 32 bits is rounded down to them by a
//! shift. Source: Z(14)–Z(18).

use super::moments::{self, MAX_ESTIMATES, Moments, Sampler};
use super::normal::normal;
use super::philox::{Address, Keys, Purpose, schedule};
use super::sine::{QUARTER_TURN, sine};
use super::word::{Scalar, Wide, Word};
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

impl Shape {
    /// Ticks on the longer side of the gap.
    pub fn sides(self) -> usize {
        self.before.max(self.after)
    }
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
    /// The gap's angle at sine 1 of the phase at its middle, in 2^−2 LSB; at cosine 1 it is 0.
    gap_sin: |_| 1,
    /// The angle of the k-th tick on either side: at sine 1 it is the same on both, at cosine 1 it is this one after the
    /// gap and minus this one before.
    side_sin: |shape: Shape| shape.sides(),
    side_cos: |shape: Shape| shape.sides(),
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

/// Half of an LSB in 2^−32 LSB: turns a floor into a rounding.
const HALF: i64 = 1 << 31;

/// The trials of one launch; `SIDE` is room for the ticks on one side of the gap.
#[derive(Clone, Copy)]
pub struct GapFill<'a, const SIDE: usize> {
    p: Parameters<'a>,
    keys: Keys,
    shape: Shape,
}

impl<'a, const SIDE: usize> GapFill<'a, SIDE> {
    /// The trials that `words` describe.
    #[inline(always)]
    pub fn new(words: &'a [u32], shape: Shape) -> GapFill<'a, SIDE> {
        let p = Parameters::of(words, shape);
        let keys = schedule([Scalar(p.key[0]), Scalar(p.key[1])]).map(|key| key.map(|word| word.0));
        GapFill { p, keys, shape }
    }

    /// The k-th tick on either side of the gap, where the shape has it: what the tone turns through and noise.
    #[inline(always)]
    fn side<W: Word>(&self, ticks: &mut Ticks<W, SIDE>, tone: [W; 2], k: usize, noise: [W; 2]) {
        let GapFill { p, shape, .. } = self;
        if k >= shape.sides() {
            return;
        }
        let even = tone[0].mul_wide(W::splat(p.side_sin[k])) + W::Wide::splat(HALF);
        let odd = tone[1].mul_wide(W::splat(p.side_cos[k]));
        if k < shape.before {
            ticks.before[k] = tick(even - odd, normal(noise[0]), p.sigma[0]);
        }
        if k < shape.after {
            ticks.after[k] = tick(even + odd, normal(noise[1]), p.sigma[0]);
        }
    }
}

/// The ticks on both sides, outward from the gap.
struct Ticks<W, const SIDE: usize> {
    before: [W; SIDE],
    after: [W; SIDE],
}

impl<const SIDE: usize> Sampler for GapFill<'_, SIDE> {
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
        let GapFill { p, shape, .. } = self;
        let address = Address { low, high, keys: self.keys };

        let first = address.draw(Purpose::NoiseAfterAndPhase, 0);
        let phase = W::splat(p.phase[0]) + (first[2] & W::splat(p.phase_spread[0]));
        let tone = [sine(phase), sine(phase + W::splat(QUARTER_TURN))];
        let truth = (tone[0].mul_wide(W::splat(p.gap_sin[0])) + W::Wide::splat(HALF)).high();

        let mut ticks = Ticks { before: [W::splat(0); SIDE], after: [W::splat(0); SIDE] };
        for k in (0..shape.sides()).step_by(4) {
            let draw = |wanted, purpose, block| if wanted { address.draw(purpose, block) } else { first };
            let before = draw(k < shape.before, Purpose::NoiseBefore, k / 4);
            let near = draw(0 < k && k < shape.after, Purpose::NoiseAfterAndPhase, k / 2);
            let far = draw(k + 2 < shape.after, Purpose::NoiseAfterAndPhase, k / 2 + 1);
            // Written out: the compiler leaves loops of such a length rolled, and their words in memory.
            self.side(&mut ticks, tone, k, [before[0], near[0]]);
            self.side(&mut ticks, tone, k + 1, [before[1], near[1]]);
            self.side(&mut ticks, tone, k + 2, [before[2], far[0]]);
            self.side(&mut ticks, tone, k + 3, [before[3], far[1]]);
        }
        let Ticks { before, after } = ticks;

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

/// What the gyro delivers for a tick, in LSB: the angle, in 2^−32 LSB, and `sigma` times the normal number `z`.
#[inline(always)]
fn tick<W: Word>(angle: W::Wide, z: W, sigma: u32) -> W {
    (angle + z.mul_wide(W::splat(sigma))).high()
}

/// The shape that is compiled ahead of time: the default ticks with three fillers.
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
            moments::tally::<W>(GapFill::<4>::new(words, UNROLLED), first, count, histogram)
        } else if shape.sides() <= 16 {
            moments::tally::<W>(GapFill::<16>::new(words, shape), first, count, histogram)
        } else {
            moments::tally::<W>(GapFill::<MAX_SIDE>::new(words, shape), first, count, histogram)
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
