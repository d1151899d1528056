//! One trial of a relock: sums of its first ticks, of the faked rotation that a compensation leaves.
//!
//! Twin of `shaders/relock.wgsl`.

use crate::launch::Launch;
use crate::moments::{self, MAX_ESTIMATES, Moments, Sampler, Trials};
use crate::parameters::parameters;
use crate::philox::{Address, Keys, schedule};
use crate::relock_ticks::{self, Given, relock_ticks, relock_wrong};
use crate::width::AnyWidth;
use crate::word::{Scalar, Wide, Word};

/// Bits of a weight behind the point.
pub const WEIGHT_BITS: u32 = 24;

/// What a launch has: what a shader is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// The ticks and what is taken off them.
    pub ticks: relock_ticks::Shape,
    /// How many of the ticks, and their sum, are tallied.
    pub estimates: usize,
}

parameters! {
    /// Key of the random words.
    key: |_| 2,
    /// Parameters of the ticks, as they are in `relock_ticks`.
    relock: |shape: Shape| relock_ticks::word_count(shape.ticks),
    /// Weights of the ticks in each estimate, in 2^−24.
    weight: |shape: Shape| shape.estimates * shape.ticks.ticks,
    /// Where each estimate's histogram starts.
    bin_base: |shape: Shape| shape.estimates,
}

/// The trials of one launch.
#[derive(Clone, Copy)]
struct Relock<'a> {
    p: Parameters<'a>,
    given: Given<'a>,
    shape: Shape,
    keys: Keys,
}

impl Sampler for Relock<'_> {
    #[inline(always)]
    fn estimates(&self) -> usize {
        self.shape.estimates
    }

    #[inline(always)]
    fn bin_base(&self, estimate: usize) -> u32 {
        self.p.bin_base[estimate]
    }

    // The loops read like those of the shader.
    #[expect(clippy::needless_range_loop)]
    #[inline(always)]
    fn trial<W: Word>(&self, low: W, high: u32) -> [W; MAX_ESTIMATES] {
        let address = Address { low, high, keys: self.keys };
        let ticks = relock_ticks(&self.given, &address, 0, relock_wrong(&self.given, &address));
        let mut error = [W::splat(0); MAX_ESTIMATES];
        for e in 0..self.shape.estimates {
            let mut sum = W::Wide::splat(1 << (WEIGHT_BITS - 1));
            for i in 0..self.shape.ticks.ticks {
                sum = sum + ticks[i].mul_wide(W::splat(self.p.weight[e * self.shape.ticks.ticks + i]));
            }
            error[e] = sum.bits_from(WEIGHT_BITS);
        }
        error
    }
}

/// The tallies of some trials of a launch.
pub struct Tally<'a> {
    /// The parameters in fixed point.
    pub launch: &'a Launch,
    /// What the parameters are of.
    pub shape: Shape,
    /// Which trials.
    pub trials: Trials,
}

impl AnyWidth for Tally<'_> {
    type Output = Vec<Moments>;

    #[inline(always)]
    fn run<W: Word>(self) -> Vec<Moments> {
        let Tally { launch, shape, trials } = self;
        let p = Parameters::of(&launch.words, shape);
        let given = Given { p: relock_ticks::Parameters::of(p.relock, shape.ticks), shape: shape.ticks };
        let keys = schedule([Scalar(p.key[0]), Scalar(p.key[1])]).map(|key| key.map(|word| word.0));
        moments::tally::<W>(Relock { p, given, shape, keys }, trials)
    }
}
