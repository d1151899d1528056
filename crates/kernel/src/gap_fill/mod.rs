//! One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
//!
//! Twin of `shaders/gap_fill.wgsl`. Ticks are counted outward from the gap: the first before it is tick 0, the second
//! tick −1, the first after it tick n+1. A filler is a vector of integer weights over a common denominator D (its
//! scale), so that D·δP = Σ w P − D Σ_gap true is an exact integer. An error that needs more than 32 bits is shifted
//! right until it fits. Source: Z(14)–Z(18).

pub mod shape;

use std::sync::Arc;

use crate::Form;
use crate::launch::{Launch, Sampled, Shape as _, Trial};
use crate::moments::{self, MAX_ESTIMATES, Moments, Sampler, Trials};
use crate::motion::{Given, Motion};
use crate::normal::normal;
use crate::philox::{Address, Keys, Purpose, schedule};
use crate::shader::constants;
use crate::word::{Scalar, Wide, Word};

pub use crate::gap_fill::shape::{MAX_SIDE, Parameters, Shape};

constants!();

/// Maps trials to moments of the errors.
pub const FORM: Form = Form::Moments;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 2;

/// The trials of one launch. `KEPT` is the room for ticks before the gap that the errors in the gap read again,
/// `GAUSSIANS` the room for the normal numbers of Gaussian motion.
#[derive(Clone, Copy)]
struct GapFill<'a, const KEPT: usize, const GAUSSIANS: usize> {
    given: Given<'a>,
    keys: Keys,
}

impl<'a, const KEPT: usize, const GAUSSIANS: usize> GapFill<'a, KEPT, GAUSSIANS> {
    #[inline(always)]
    fn new(launch: &'a Launch, shape: Shape) -> GapFill<'a, KEPT, GAUSSIANS> {
        launch.assert_fits(&shape);
        let p = Parameters::new(launch.words(), shape);
        let keys = schedule([Scalar(p.key[0]), Scalar(p.key[1])]).map(|key| key.map(|word| word.0));
        GapFill { given: Given { p, table: launch.table(), shape }, keys }
    }

    /// Reads motion and noise of the k-th tick on either side of the gap, where the shape has that tick, and adds them
    /// to the sums.
    #[inline(always)]
    fn side<W: Word>(&self, run: &mut Run<W, KEPT>, motion: &Motion<W, GAUSSIANS>, k: usize, noise: [W; 2]) {
        let Given { p, shape, .. } = &self.given;
        if k >= shape.sides() {
            return;
        }
        let [mut before, mut after] = motion.side_motion(&self.given, k);
        let profile = if shape.profile { motion.profile_side(&self.given, k) } else { [W::splat(0); 2] };
        if k < shape.before {
            before = before + normal(noise[0]).mul_wide(W::splat(p.sigma[0]));
            let mut reading = before.high_word() + profile[0];
            if shape.readout {
                let earlier = run.at_start - reading;
                reading = pulses(run.at_start, p) - pulses(earlier, p);
                run.at_start = earlier;
            }
            if KEPT > 0 {
                run.kept[k] = reading;
            }
            for filler in 0..shape.fillers {
                if k < shape.residual_before && shape.residual {
                    let weight = p.residual_weight[filler * (shape.residual_before + shape.after) + k];
                    run.sum[filler].add_tick(reading, weight);
                }
                if k < shape.extrapolation_before && shape.extrapolation {
                    let weight = p.extrapolation_weight[filler * shape.extrapolation_before + k];
                    run.sum[extrapolations(*shape) + filler].add_tick(reading, weight);
                }
            }
        }
        if k < shape.after {
            after = after + normal(noise[1]).mul_wide(W::splat(p.sigma[0]));
            let mut reading = after.high_word() + profile[1];
            if shape.readout {
                let later = run.at_end + reading;
                reading = pulses(later, p) - pulses(run.at_end, p);
                run.at_end = later;
            }
            for filler in 0..shape.fillers {
                let weights = filler * (shape.residual_before + shape.after) + shape.residual_before;
                run.sum[filler].add_tick(reading, p.residual_weight[weights + k]);
            }
        }
    }
}

/// State carried from tick to tick.
struct Run<W: Word, const KEPT: usize> {
    sum: [Sum<W>; MAX_ESTIMATES],
    /// Readings of the ticks before the gap.
    kept: [W; KEPT],
    /// Readout at the outermost boundaries so far, in LSB.
    at_start: W,
    at_end: W,
}

/// Index of the first extrapolation among the estimates.
#[inline(always)]
fn extrapolations(shape: Shape) -> usize {
    if shape.residual { shape.fillers } else { 0 }
}

/// Index of the first error in the gap among the estimates.
#[inline(always)]
fn in_gaps(shape: Shape) -> usize {
    extrapolations(shape) + if shape.extrapolation { shape.fillers } else { 0 }
}

/// The angle represented by the whole pulses up to `angle`.
#[inline(always)]
fn pulses<W: Word>(angle: W, p: &Parameters) -> W {
    angle & W::splat(p.readout_mask[0])
}

impl<const KEPT: usize, const GAUSSIANS: usize> Sampler for GapFill<'_, KEPT, GAUSSIANS> {
    #[inline(always)]
    fn estimates(&self) -> usize {
        self.given.shape.estimates()
    }

    #[inline(always)]
    fn bin_base(&self, estimate: usize) -> u32 {
        self.given.p.bin_base[estimate]
    }

    // The loops mirror those of the shader.
    #[expect(clippy::needless_range_loop)]
    #[inline(always)]
    fn trial<W: Word>(&self, low: W, high: u32) -> [W; MAX_ESTIMATES] {
        let Given { p, table, shape } = &self.given;
        let address = Address { low, high, keys: self.keys };

        let first = address.draw(Purpose::NoiseAfterAndPhase, 0);
        let motion = Motion::<W, GAUSSIANS>::draw_motion(&self.given, &address, first);
        let truth = motion.gap(&self.given, shape.rows() - 1);

        let nothing = Sum::less(W::splat(0), 0, shape.wide);
        let zero = W::splat(0);
        let mut run = Run { sum: [nothing; MAX_ESTIMATES], kept: [zero; KEPT], at_start: zero, at_end: zero };
        for filler in 0..shape.fillers {
            if shape.residual {
                run.sum[filler] = Sum::less(truth, p.residual_scale[filler], shape.wide);
            }
            if shape.extrapolation {
                let scale = p.extrapolation_scale[filler];
                run.sum[extrapolations(*shape) + filler] = Sum::less(truth, scale, shape.wide);
            }
        }
        if shape.readout {
            let words = address.draw(Purpose::Readout, 0);
            let noise = normal(words[1]).mul_wide(W::splat(p.gap_sigma[0])) + W::Wide::half();
            run.at_start = words[0] - pulses(words[0], p);
            run.at_end = run.at_start + truth + noise.high_word();
        }
        for k in (0..shape.sides()).step_by(4) {
            let draw = |wanted, purpose, block| if wanted { address.draw(purpose, block) } else { first };
            let before = draw(k < shape.before, Purpose::NoiseBefore, k / 4);
            let near = draw(0 < k && k < shape.after, Purpose::NoiseAfterAndPhase, k / 2);
            let far = draw(k + 2 < shape.after, Purpose::NoiseAfterAndPhase, k / 2 + 1);
            // Unrolled by hand: the compiler keeps loops of this length rolled and their words in memory.
            self.side(&mut run, &motion, k, [before[0], near[0]]);
            self.side(&mut run, &motion, k + 1, [before[1], near[1]]);
            self.side(&mut run, &motion, k + 2, [before[2], far[0]]);
            self.side(&mut run, &motion, k + 3, [before[3], far[1]]);
        }

        let mut error = [zero; MAX_ESTIMATES];
        for e in 0..in_gaps(*shape) {
            error[e] = run.sum[e].error_of(p.shift, e);
        }
        if KEPT > 0 && shape.in_gap {
            for filler in 0..shape.fillers {
                let e = in_gaps(*shape) + filler;
                for row in 0..shape.gap_ticks {
                    let truth = motion.gap(&self.given, row);
                    let mut sum = Sum::less(truth, p.in_gap_scale[filler], shape.wide);
                    let weight = &table[(filler * shape.gap_ticks + row) * shape.extrapolation_before..];
                    for k in 0..shape.extrapolation_before {
                        sum.add_tick(run.kept[k], weight[k]);
                    }
                    let found = sum.error_of(p.shift, e);
                    error[e] = error[e].max_signed(found.with_sign(found));
                }
            }
        }
        error
    }
}

/// A weighted sum of ticks less the scaled truth, kept in 32 bits where that is enough.
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
    fn add_tick(&mut self, tick: W, weight: u32) {
        match self {
            Sum::Narrow(sum) => *sum = *sum + tick * W::splat(weight),
            Sum::Wide(sum) => *sum = *sum + tick.mul_wide(W::splat(weight)),
        }
    }

    #[inline(always)]
    fn error_of(self, shift: &[u32], estimate: usize) -> W {
        match self {
            Sum::Narrow(sum) => sum,
            Sum::Wide(sum) => {
                let half = (1_i64 << shift[estimate]) >> 1;
                (sum + W::Wide::splat(half)).bits_from(shift[estimate])
            }
        }
    }
}

/// The default ticks with three fillers and one tone, the shape of most points.
pub(crate) const POLYNOMIALS: Shape = Shape {
    before: 4,
    after: 2,
    residual_before: 2,
    extrapolation_before: 4,
    fillers: 3,
    residual: true,
    extrapolation: true,
    in_gap: false,
    wide: false,
    gap_ticks: 0,
    tones: 1,
    amplitudes: false,
    frequencies: false,
    gaussian: false,
    profile: false,
    every: false,
    constants: false,
    readout: false,
};

/// One filler with ten ticks, eight of them before the gap.
const TEN_TICKS: Shape =
    Shape { before: 8, residual_before: 8, extrapolation_before: 8, fillers: 1, wide: true, ..POLYNOMIALS };

/// The default ticks with three fillers in a recorded profile.
const PROFILE: Shape = Shape { tones: 0, profile: true, ..POLYNOMIALS };

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
        let shape = self;
        // Each of the first comparisons makes the shape a constant of its branch.
        if shape == POLYNOMIALS {
            moments::tally::<W>(GapFill::<0, 0>::new(launch, POLYNOMIALS), trials)
        } else if W::LANES > 1 && shape == TEN_TICKS {
            moments::tally::<W>(GapFill::<0, 0>::new(launch, TEN_TICKS), trials)
        } else if W::LANES > 1 && shape == PROFILE {
            moments::tally::<W>(GapFill::<0, 0>::new(launch, PROFILE), trials)
        } else if !shape.in_gap && !shape.gaussian {
            moments::tally::<W>(GapFill::<0, 0>::new(launch, shape), trials)
        } else {
            moments::tally::<W>(GapFill::<MAX_SIDE, MAX_GAUSSIANS>::new(launch, shape), trials)
        }
    }
}

/// Most normal numbers of Gaussian motion: a gap and two sides of [`MAX_SIDE`] ticks.
pub(crate) const MAX_GAUSSIANS: usize = 3 * MAX_SIDE;
