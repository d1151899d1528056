//! One run of a gyro that switches modes: the error of its angle at the end, at its largest, and at chosen times.
//!
//! Twin of `shaders/switched_run.wgsl`. The smooth drift is tabulated in closed form and so accumulates no rounding;
//! the random parts are summed exactly in 2^−32 LSB. Each switch adds the fill residual: for each tone of the motion a
//! sine of its phase, a constant and a normal part. Source: Z(3), Z(5), Z(18).

mod row;
pub mod shape;
mod trial;

use crate::Form;
use crate::launch::{Launch, Shape as _};
use crate::moments::{MAX_ESTIMATES, Sampler};
use crate::normal::{NORMAL_BITS, normal};
use crate::philox::{Address, Keys, Purpose, schedule};
use crate::power::{EXP2_ONE, LOG_BITS, MAX_MINUS, exp2_minus, log2_word};
use crate::relock_ticks::{self, Given, relock_ticks, relock_wrong};
use crate::shader::constants;
use crate::sine::sine;
use crate::word::{Scalar, Wide, Word};

use crate::switched_run::row::{OfEnd, Row, Same};

pub use crate::switched_run::shape::{END_BITS, ENDS, MAX_TONES, Parameters, Shape};

constants!(END_BITS, DECAY_BITS, DECAY_ONE, MAX_HALVINGS, MAX_STRETCH);

/// Maps trials to moments of the angles.
pub const FORM: Form = Form::Moments;

/// Fractional bits of an exponential.
const DECAY_BITS: u32 = 30;
const DECAY_ONE: u32 = 1 << DECAY_BITS;

/// Number of halvings after which nothing is left of a decay.
const MAX_HALVINGS: u32 = 31;

/// log2 of the largest factor by which a drawn τ is longer or shorter than the nominal one.
const MAX_STRETCH: u32 = 5;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 1;

/// Receives the angles of a run as it proceeds, LSB.
pub trait Recorder<W> {
    /// Receives the angle just before a switch or at the end, and then the angle just after the switch.
    fn record(&mut self, angle: W);
}

/// Discards all angles.
impl<W> Recorder<W> for () {
    // Only here: shaders record no angles.
    #[inline(always)]
    fn record(&mut self, _: W) {}
}

/// The trials of one launch.
#[derive(Clone, Copy)]
struct SwitchedRun<'a> {
    p: Parameters<'a>,
    table: &'a [u32],
    shape: Shape,
    keys: Keys,
}

/// The random state of a run.
struct Run<W: Word> {
    /// Deviations of A, Ω_m0, Ω_nm in standard deviations, 2^−28.
    deviation: [W; 3],
    /// Negative where the run starts in the other mode.
    mode: W,
    /// Phase of each tone at the next switch.
    phase: [W; MAX_TONES],
    /// Sum of all random parts so far, 2^−32 LSB.
    random: W::Wide,
    /// Sum of the effects of relocking so far, LSB.
    relocked: W,
    /// Relative error of f0 in the temperature curve.
    wrong: W,
    warm_up: WarmUp<W>,
}

/// The warm-up of a run whose time constant is drawn. Times are in units of the parameters, ratios in 2^−26,
/// exponentials in 2^−30.
#[derive(Clone, Copy)]
struct WarmUp<W: Word> {
    /// A in 2^−32 LSB per unit of time.
    heated: W,
    /// τ relative to the nominal one, and the nominal one relative to τ.
    ratio: W,
    inverse: W,
    /// τ tanh(MT/2τ), the contribution of the decay over whole pairs of intervals.
    tanh: W,
    /// e^{−t/τ} at the last switch.
    last: W,
}

impl<'a> SwitchedRun<'a> {
    #[inline(always)]
    fn new(launch: &'a Launch, shape: Shape) -> SwitchedRun<'a> {
        launch.assert_fits(&shape);
        let p = Parameters::new(launch.words(), shape);
        let keys = schedule([Scalar(p.key[0]), Scalar(p.key[1])]).map(|key| key.map(|word| word.0));
        SwitchedRun { p, table: launch.table(), shape, keys }
    }

    #[inline(always)]
    fn start<W: Word>(&self, address: &Address<W>) -> Run<W> {
        let SwitchedRun { p, shape, .. } = self;
        let zero = W::splat(0);
        let mut run = Run {
            deviation: [zero; 3],
            mode: zero,
            phase: [zero; MAX_TONES],
            random: W::Wide::splat(0),
            relocked: zero,
            wrong: zero,
            warm_up: WarmUp {
                heated: zero,
                ratio: zero,
                inverse: zero,
                tanh: zero,
                last: W::splat(DECAY_ONE),
            },
        };
        if shape.spreads() {
            let words = address.draw(Purpose::RunDeviation, 0);
            run.deviation = [normal(words[0]), normal(words[1]), normal(words[2])];
            run.mode = words[3];
        }
        if shape.warm_up {
            run.warm_up = self.warm_up(run.deviation[0], normal(address.draw(Purpose::RunDeviation, 1)[0]));
        }
        if let Some(relock) = shape.relock {
            run.wrong = relock_wrong(&self.relock(relock), address);
        }
        for block in 0..shape.tones.div_ceil(4) {
            let words = address.draw(Purpose::RunPhase, block);
            for t in 4 * block..shape.tones.min(4 * block + 4) {
                run.phase[t] = words[t % 4] & W::splat(p.run_spread[t]);
            }
        }
        run
    }

    /// The warm-up of a run from the deviations of its A and its ln τ.
    #[inline(always)]
    fn warm_up<W: Word>(&self, magnetic: W, time: W) -> WarmUp<W> {
        let p = &self.p;
        // The factor between a drawn τ and the nominal one is at most 2^5.
        let five = W::splat(MAX_STRETCH << LOG_BITS);
        let log = time.mul_wide(W::splat(p.warm_up_spread[0])).high_word();
        let (ratio, inverse) = (exp2_minus(five - log), exp2_minus(five + log));
        let lost = exp2_minus(self.halvings(inverse, W::splat(p.halvings[0])));
        let one = W::splat(EXP2_ONE);
        // log2 of τ (1 − q)/(1 + q) with q = e^{−MT/τ}; then 2^x is computed as 2^31 · 2^−(31 − x).
        let tanh = log + log2_word(one - lost) - log2_word(one + lost)
            + W::splat((LOG_BITS + p.time_bits[0]) << LOG_BITS);
        WarmUp {
            heated: W::splat(p.heated[0]) + magnetic.mul_wide(W::splat(p.heated[1])).bits_from(NORMAL_BITS),
            ratio,
            inverse,
            tanh: exp2_minus(W::splat(MAX_MINUS) - tanh),
            last: W::splat(DECAY_ONE),
        }
    }

    /// Converts a number of halvings of the nominal τ to halvings of this τ, 2^−26, at most 31.
    #[inline(always)]
    fn halvings<W: Word>(&self, inverse: W, usual: W) -> W {
        let bits = self.p.halving_bits[0];
        let product = inverse.mul_wide(usual);
        let within = (product.high_word() - W::splat(MAX_HALVINGS << (bits - (32 - LOG_BITS)))).sar(31);
        (product.bits_from(bits) & within) + (W::splat(MAX_MINUS) & (within ^ W::splat(!0)))
    }

    /// ∫ s (1 − e^{−t/τ}) dt at a row of the table in interval `k`, and e^{−t/τ} there; the last two words of the row
    /// are those from `at` on.
    #[inline(always)]
    fn heating<W: Word>(&self, warm_up: &WarmUp<W>, k: usize, row: &impl Row<W>, at: usize) -> [W; 2] {
        let bits = self.p.time_bits[0];
        let now = exp2_minus(self.halvings(warm_up.inverse, row.word(at + 1))) >> 1;
        let one = W::splat(DECAY_ONE);
        let even = k.is_multiple_of(2);
        let signed = if even { warm_up.last } else { W::splat(0) - warm_up.last };
        let pairs = warm_up.tanh.mul_wide(one - signed).bits_from(DECAY_BITS);
        let rest = warm_up.ratio.mul_wide(warm_up.last - now).bits_from(DECAY_BITS - bits);
        let decayed = if even { pairs + rest } else { pairs - rest };
        [row.word(at) - decayed, now]
    }

    /// The angle at a row of the table in interval `k`, with the random part `more` added since the last switch.
    #[inline(always)]
    fn angle<W: Word>(&self, run: &Run<W>, k: usize, row: &impl Row<W>, more: W::Wide) -> W {
        let shape = self.shape;
        let mut random = run.random + more + W::Wide::half();
        let mut magnetic = W::Wide::splat(0);
        let mut at = 1 + usize::from(shape.mode);
        if shape.magnetic {
            magnetic = magnetic + run.deviation[0].mul_wide(row.word(at));
            at += 1;
        }
        if shape.initial {
            magnetic = magnetic + run.deviation[1].mul_wide(row.word(at));
            at += 1;
        }
        if shape.non_magnetic {
            random = random + run.deviation[2].mul_wide(row.word(at));
            at += 1;
        }
        if shape.warm_up {
            let [heating, _] = self.heating(&run.warm_up, k, row, at);
            magnetic = magnetic + heating.mul_wide(run.warm_up.heated);
        }
        if shape.mode {
            let whole = magnetic.high_word() + row.word(1);
            return row.word(0) + run.relocked + random.high_word() + whole.with_sign(run.mode);
        }
        row.word(0) + run.relocked + (random + magnetic).high_word()
    }

    /// The residual of the switch after interval `k`, 2^−32 LSB; `words` are those of the interval.
    #[inline(always)]
    fn residual<W: Word>(&self, run: &mut Run<W>, address: &Address<W>, k: usize, words: &[W; 4]) -> W::Wide {
        let SwitchedRun { p, shape, .. } = self;
        let mut residual = W::Wide::splat(long(p.constant));
        if shape.noise {
            residual = residual + normal(words[1]).mul_wide(W::splat(p.noise[0]));
        }
        let mut more = *words;
        for t in 0..shape.tones {
            if t >= 2 && t % 4 == 2 {
                more = address.draw_beyond(Purpose::SwitchPhase, t / 4, k);
            }
            let drawn = more[(t + 2) % 4] & W::splat(p.switch_spread[t]);
            residual = residual + sine(run.phase[t] + drawn).mul_wide(W::splat(p.amplitude[t]));
            run.phase[t] = run.phase[t] + W::splat(p.phase_step[t]);
        }
        residual
    }

    #[inline(always)]
    fn relock(&self, shape: relock_ticks::Shape) -> Given<'a> {
        Given { p: relock_ticks::Parameters::new(self.p.relock, shape), shape }
    }

    /// The effect of relocking after the switch that ends interval `k`, LSB: the ticks themselves and their effect on
    /// the filler.
    // The loop mirrors that of the shader.
    #[expect(clippy::needless_range_loop)]
    #[inline(always)]
    fn relocked<W: Word>(
        &self,
        shape: relock_ticks::Shape,
        run: &Run<W>,
        address: &Address<W>,
        k: usize,
    ) -> W {
        let p = &self.p;
        let left = relock_ticks(&self.relock(shape), address, k, run.wrong);
        let bits = p.relock_bits[0];
        let mut sum = W::Wide::splat(1 << (bits - 1));
        for i in 0..shape.ticks {
            sum = sum + left[i].mul_wide(W::splat(p.relock_weight[i]));
        }
        sum.bits_from(bits)
    }

    /// The row of the table with this number.
    // Only here: a shader reads words by their place in the table.
    #[inline(always)]
    fn row(&self, row: usize) -> Same<'a> {
        Same(&self.table[row * self.shape.row()..])
    }

    /// The row of the end that each lane's run draws.
    // Only here: `trial` of the shader computes its place.
    #[inline(always)]
    fn end_row<W: Word>(&self, address: &Address<W>) -> OfEnd<'a, W> {
        let rows = self.p.intervals[0] as usize + self.shape.times;
        let drawn = address.draw(Purpose::RunEnd, 0)[0] >> (32 - END_BITS);
        OfEnd(&self.table[rows * self.shape.row()..], drawn * W::splat(self.shape.end_row() as u32))
    }

    // Only here: `trial` of the shader, which records nothing.
    #[inline(always)]
    fn run<W: Word, R: Recorder<W>>(&self, low: W, high: u32, recorder: &mut R) -> [W; MAX_ESTIMATES] {
        let SwitchedRun { p, shape, .. } = self;
        let address = Address { low, high, keys: self.keys };
        let intervals = p.intervals[0] as usize;
        let mut run = self.start(&address);
        let mut error = [W::splat(0); MAX_ESTIMATES];
        let nothing = W::Wide::splat(0);
        let (mut end, mut end_interval) = (OfEnd(&[], W::splat(0)), W::splat(0));
        if shape.any_end {
            end = self.end_row(&address);
            end_interval = end.word(shape.row());
        }
        for k in 0..intervals {
            let words = address.draw(Purpose::Interval, k);
            let is_last = k + 1 == intervals;
            let step = if shape.walk { normal(words[0]) } else { words[0] };
            for t in 0..shape.times {
                if p.time_interval[t] as usize == k {
                    let mut part = nothing;
                    if shape.walk {
                        let bridge = normal(address.draw(Purpose::Bridge, k)[0]);
                        part = step.mul_wide(W::splat(p.time_walk[t]))
                            + bridge.mul_wide(W::splat(p.time_bridge[t]));
                    }
                    error[shape.first_time() + t] = self.angle(&run, k, &self.row(intervals + t), part);
                }
            }
            // Runs that end before the end of this interval have no angle there.
            let mut counts = W::splat(!0);
            // The ends lie in the last three intervals.
            if shape.any_end && k + 3 >= intervals {
                counts = (W::splat(k as u32) - end_interval).sar(31);
                let mut part = nothing;
                if shape.walk {
                    let bridge = normal(address.draw(Purpose::Bridge, k)[0]);
                    part =
                        step.mul_wide(end.word(shape.row() + 1)) + bridge.mul_wide(end.word(shape.row() + 2));
                }
                let at_end = self.angle(&run, k, &end, part);
                let ended = W::splat(0).add_where_equal(at_end, end_interval, W::splat(k as u32));
                error[0] = error[0] + ended;
                error[1] = error[1].max_signed(ended.with_sign(ended));
            }
            if shape.walk {
                let sigma = p.walk_sigma[usize::from(is_last)];
                run.random = run.random + step.mul_wide(W::splat(sigma));
            }
            let before = self.angle(&run, k, &self.row(k), nothing);
            recorder.record(before);
            if shape.ends {
                if !shape.any_end {
                    error[0] = before;
                }
                error[1] = error[1].max_signed(before.with_sign(before) & counts);
            }
            if !is_last {
                let residual = self.residual(&mut run, &address, k, &words);
                run.random = run.random + residual;
                if let Some(relock) = shape.relock {
                    run.relocked = run.relocked + self.relocked(relock, &run, &address, k);
                }
                let after = self.angle(&run, k, &self.row(k), nothing);
                recorder.record(after);
                if shape.ends {
                    error[1] = error[1].max_signed(after.with_sign(after) & counts);
                }
                if shape.warm_up {
                    run.warm_up.last = self.heating(&run.warm_up, k, &self.row(k), shape.row() - 2)[1];
                }
            }
        }
        error
    }
}

/// A 64-bit number from two words, the lower one first.
#[inline(always)]
fn long(words: &[u32]) -> i64 {
    i64::from(words[1] as i32) << 32 | i64::from(words[0])
}

impl Sampler for SwitchedRun<'_> {
    #[inline(always)]
    fn estimates(&self) -> usize {
        self.shape.estimates()
    }

    #[inline(always)]
    fn bin_base(&self, estimate: usize) -> u32 {
        self.p.bin_base[estimate]
    }

    #[inline(always)]
    fn trial<W: Word>(&self, low: W, high: u32) -> [W; MAX_ESTIMATES] {
        self.run(low, high, &mut ())
    }
}

/// Angles in the order in which they are recorded.
struct Angles(Vec<i32>);

impl Recorder<Scalar> for Angles {
    fn record(&mut self, angle: Scalar) {
        self.0.push(angle.0 as i32);
    }
}

/// The angles of one run just before and just after each switch, and at its end, LSB.
pub fn trajectory(launch: &Launch, shape: Shape, trial: u64) -> Vec<i32> {
    let mut angles = Angles(vec![]);
    SwitchedRun::new(launch, shape).run(Scalar(trial as u32), (trial >> 32) as u32, &mut angles);
    angles.0
}
