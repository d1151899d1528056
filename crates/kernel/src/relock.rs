//! One trial of a relock: sums over its first ticks of the apparent rotation that remains after compensation.
//!
//! Twin of `shaders/relock.wgsl`.

use std::sync::Arc;

use crate::launch::{self, Launch, Sampled, Trial};
use crate::moments::{self, MAX_ESTIMATES, Moments, Sampler, Trials};
use crate::parameters::parameters;
use crate::philox::{Address, Keys, schedule};
use crate::relock_ticks::{self, Given, relock_ticks, relock_wrong};
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, constants};
use crate::word::{Scalar, Wide, Word};
use crate::{Form, part};

constants!(WEIGHT_BITS);

/// Maps trials to moments of the ticks.
pub const FORM: Form = Form::Moments;

/// Fractional bits of a weight.
pub const WEIGHT_BITS: u32 = 24;

/// Options of a launch, for which its shader is specialized.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// The ticks and their compensation.
    pub ticks: relock_ticks::Shape,
    /// Number of tallied estimates: ticks, and their sum.
    pub estimates: usize,
}

parameters! {
    /// Key of the random words.
    key: |_| 2,
    /// Parameters of the ticks, as they are in `relock_ticks`.
    relock: |shape: Shape| relock_ticks::word_count(shape.ticks),
    /// Weights of the ticks in each estimate, in 2^−24.
    weight: |shape: Shape| shape.estimates * shape.ticks.ticks,
    /// Level at which each estimate's histogram starts.
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

    // The loops mirror those of the shader.
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

impl Sealed for Shape {}

impl launch::Shape for Shape {
    fn part(&self) -> &'static Part {
        &part::relock
    }

    #[inline(always)]
    fn estimates(&self) -> usize {
        self.estimates
    }

    fn steps(&self, _: &[u32]) -> u64 {
        self.ticks.ticks as u64
    }

    fn words(&self) -> usize {
        word_count(*self)
    }

    fn shader(&self) -> Shader {
        let mut shader = Shader {
            parts: vec![&part::philox, &part::normal, &part::power],
            declarations: wgsl_places(*self),
            ..Shader::default()
        };
        self.ticks.include(&mut shader);
        shader.parts.push(&part::relock);
        shader
    }
}

impl From<Shape> for Arc<dyn Sampled> {
    // The table of methods compiles the kernel for every width. It is made here, so that this happens in this package.
    fn from(shape: Shape) -> Self {
        Arc::new(shape)
    }
}

impl Trial for Shape {
    // Only here: the shader has one shape.
    #[inline(always)]
    fn tally<W: Word>(self, launch: &Launch, trials: Trials) -> Vec<Moments> {
        launch.assert_fits(&self);
        let p = Parameters::new(launch.words(), self);
        let given = Given { p: relock_ticks::Parameters::new(p.relock, self.ticks), shape: self.ticks };
        let keys = schedule([Scalar(p.key[0]), Scalar(p.key[1])]).map(|key| key.map(|word| word.0));
        moments::tally::<W>(Relock { p, given, shape: self, keys }, trials)
    }
}
