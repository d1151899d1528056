//! Motion of the base in one trial: the angles through which it turns in the gap and in the ticks on either side.
//!
//! Twin of `shaders/motion.wgsl`. The motion is the sum of tones, stationary Gaussian motion, a recorded profile and a
//! part common to all trials; a launch pays only for the parts that its shape has. Angles are in 2^−32 LSB until they
//! are rounded. Ticks are counted outward from the gap.
//!
//! Closures in this file do nothing but load: the compiler may compile a closure apart from its caller, and then
//! without the instructions of its width, which makes it ten times as slow.

use crate::gap_fill::shape::{MARGIN, MAX_TONES, Parameters, Shape};
use crate::normal::normal;
use crate::philox::{Address, Purpose};
use crate::shader::constants;
use crate::sine::{QUARTER_TURN, sine, sine_ratio};
use crate::word::{Wide, Word};

constants!(MARGIN, AMPLITUDE_BITS, HALF_TURN_MASK);

/// Fractional bits of a relative amplitude.
const AMPLITUDE_BITS: u32 = 31;

/// The bits of a phase within half a turn, where sines are positive.
const HALF_TURN_MASK: u32 = u32::MAX >> 1;

/// The parameters of a launch and its table, by name.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) p: Parameters<'a>,
    pub(crate) table: &'a [u32],
    pub(crate) shape: Shape,
}

/// The random part of the motion of one trial; `GAUSSIANS` is the room for normal numbers.
pub(crate) struct Motion<W, const GAUSSIANS: usize> {
    /// Sine and cosine of the phase of each tone at the middle of the gap, in 2^−30, times its amplitude where that is
    /// drawn. A Rayleigh-distributed amplitude has two normal numbers in their own unit instead.
    tone: [[W; 2]; MAX_TONES],
    /// Where frequencies are drawn: the angle of a tick at the peak of the rate in 2^−4 LSB, and turns per half tick.
    peak: [W; MAX_TONES],
    half_turn: [W; MAX_TONES],
    gaussian: [W; GAUSSIANS],
    /// The boundary of the profile's ticks at which the gap starts.
    start: W,
}

impl<W: Word, const GAUSSIANS: usize> Motion<W, GAUSSIANS> {
    /// Draws the motion; `first` is the block of noise and phases that the caller has already drawn.
    #[inline(always)]
    pub fn draw_motion(given: &Given, address: &Address<W>, first: [W; 4]) -> Motion<W, GAUSSIANS> {
        let zero = W::splat(0);
        let mut motion = Motion {
            tone: [[zero; 2]; MAX_TONES],
            peak: [zero; MAX_TONES],
            half_turn: [zero; MAX_TONES],
            gaussian: [zero; GAUSSIANS],
            start: zero,
        };
        let Given { p, shape, .. } = given;
        let mut block = first;
        for t in 0..shape.tones {
            if t > 0 && t % 2 == 0 {
                block = address.draw(Purpose::NoiseAfterAndPhase, t / 2);
            }
            let phase = W::splat(p.phase[t]) + (block[2 + t % 2] & W::splat(p.phase_spread[t]));
            motion.tone[t] = [sine(phase), sine(phase + W::splat(QUARTER_TURN))];
            if shape.amplitudes || shape.frequencies {
                let words = address.draw(Purpose::Tone, t);
                if shape.amplitudes {
                    motion.tone[t] = with_amplitude(motion.tone[t], words, p, t);
                }
                if shape.frequencies {
                    let turn = W::splat(p.frequency_low[t]) + words[2].mulhi(W::splat(p.frequency_width[t]));
                    motion.half_turn[t] = turn * W::splat(p.frequency_scale[t]);
                    motion.peak[t] = peak_of(turn, motion.half_turn[t], p, t);
                }
            }
        }
        if shape.gaussian {
            motion.draw_gaussian(given, address);
        }
        if shape.profile {
            let drawn = address.draw(Purpose::Position, 0)[0];
            let position =
                if shape.every { in_turn(address.low, p) } else { drawn.mulhi(W::splat(p.positions[0])) };
            motion.start = position + W::splat(MARGIN as u32);
        }
        motion
    }

    /// The true angle over the ticks of the gap up to and including that of `row`, in LSB.
    #[inline(always)]
    pub fn gap(&self, given: &Given, row: usize) -> W {
        let Given { p, table, shape } = given;
        let mut angle = W::Wide::half();
        for t in 0..shape.tones {
            let [sin, cos] = if shape.frequencies {
                self.gap_factors(given, row, t)
            } else {
                let cos = if shape.in_gap { p.gap_cos[row * shape.tones + t] } else { 0 };
                [W::splat(p.gap_sin[row * shape.tones + t]), W::splat(cos)]
            };
            angle = angle + self.tone[t][0].mul_wide(sin);
            if shape.in_gap {
                angle = angle + self.tone[t][1].mul_wide(cos);
            }
        }
        if shape.constants {
            angle = angle + constant::<W>(p.gap_constant, row);
        }
        if shape.gaussian {
            let factor = &table[shape.motion_table() + row * shape.gap_ticks..][..shape.gap_ticks];
            let numbers = &self.gaussian[..factor.len()];
            // By index: adapters of iterators are compiled in one unit of the crate and called from the others.
            for k in 0..factor.len() {
                angle = angle + numbers[k].mul_wide(W::splat(factor[k]));
            }
        }
        let angle = angle.high_word();
        if !shape.profile {
            return angle;
        }
        let length = if shape.in_gap { W::splat(row as u32 + 1) } else { W::splat(p.gap_length[0]) };
        angle + given.profile(self.start + length) - given.profile(self.start)
    }

    /// The angles of the k-th tick before and after the gap without the profile, in 2^−32 LSB and with half an LSB
    /// added.
    #[inline(always)]
    pub fn side_motion(&self, given: &Given, k: usize) -> [W::Wide; 2] {
        let Given { p, shape, .. } = given;
        let (mut even, mut odd) = (W::Wide::half(), W::Wide::splat(0));
        for t in 0..shape.tones {
            let [sin, cos] = if shape.frequencies {
                self.side_factors(given, k, t)
            } else {
                let place = k * shape.tones + t;
                [W::splat(p.side_sin[place]), W::splat(p.side_cos[place])]
            };
            even = even + self.tone[t][0].mul_wide(sin);
            odd = odd + self.tone[t][1].mul_wide(cos);
        }
        let (mut before, mut after) = (even - odd, even + odd);
        if shape.constants && k < shape.before {
            before = before + constant::<W>(p.before_constant, k);
        }
        if shape.constants && k < shape.after {
            after = after + constant::<W>(p.after_constant, k);
        }
        if shape.gaussian && k < shape.before {
            before = before + self.gaussian_side(given, shape.gap_ticks + 2 * k + 1);
        }
        if shape.gaussian && k < shape.after {
            after = after + self.gaussian_side(given, shape.gap_ticks + 2 * k);
        }
        [before, after]
    }

    /// The angles of the k-th tick before and after the gap in the profile, in LSB.
    #[inline(always)]
    pub fn profile_side(&self, given: &Given, k: usize) -> [W; 2] {
        let (n, k) = (given.p.gap_length[0], k as u32);
        let end = self.start + W::splat(n + k);
        let start = self.start - W::splat(k);
        let one = W::splat(1);
        [given.profile(start) - given.profile(start - one), given.profile(end + one) - given.profile(end)]
    }

    /// The angle of tone `t`, whose frequency is drawn, over the gap up to `row`, as factors of the sine and cosine at
    /// the middle.
    #[inline(always)]
    fn gap_factors(&self, given: &Given, row: usize, t: usize) -> [W; 2] {
        let n = given.p.gap_length[0];
        let (mut sin, mut cos) = (W::splat(0), W::splat(0));
        for i in 0..if given.shape.in_gap { row as u32 + 1 } else { n } {
            let [tick_sin, tick_cos] = self.factors(t, (2 * i + 1).wrapping_sub(n));
            sin = sin + tick_sin;
            cos = cos + tick_cos;
        }
        [sin, cos]
    }

    /// The angle of tone `t` in the k-th tick after the gap, as the factors that [`Motion::gap_factors`] returns.
    #[inline(always)]
    fn side_factors(&self, given: &Given, k: usize, t: usize) -> [W; 2] {
        self.factors(t, given.p.gap_length[0] + 1 + 2 * k as u32)
    }

    /// The angle of tone `t` in a tick whose middle lies `half_ticks` half ticks after that of the gap, as such
    /// factors.
    #[inline(always)]
    fn factors(&self, t: usize, half_ticks: u32) -> [W; 2] {
        let turn = self.half_turn[t] * W::splat(half_ticks);
        let sin = self.peak[t].mul_wide(sine(turn + W::splat(QUARTER_TURN))) + W::Wide::half();
        let cos = self.peak[t].mul_wide(sine(turn)) + W::Wide::half();
        [sin.high_word(), cos.high_word()]
    }

    /// Draws the normal numbers of the Gaussian motion: those of the gap, then outward, alternately after and before
    /// it.
    #[inline(always)]
    fn draw_gaussian(&mut self, given: &Given, address: &Address<W>) {
        let Given { shape, .. } = given;
        for i in 0..shape.gap_ticks {
            let words = address.draw(Purpose::GaussianGap, i / 4);
            self.gaussian[i] = normal(words[i % 4]);
        }
        for k in (0..shape.sides()).step_by(4) {
            let after = address.draw(Purpose::GaussianAfter, k / 4);
            let before = address.draw(Purpose::GaussianBefore, k / 4);
            for i in 0..4.min(shape.sides() - k) {
                self.gaussian[shape.gap_ticks + 2 * (k + i)] = normal(after[i]);
                self.gaussian[shape.gap_ticks + 2 * (k + i) + 1] = normal(before[i]);
            }
        }
    }

    /// The Gaussian motion of a tick on the side: its row of the factor times the normal numbers up to its own.
    #[inline(always)]
    fn gaussian_side(&self, given: &Given, place: usize) -> W::Wide {
        let factor = &given.table[given.shape.gaussian_row(place)..][..=place];
        let numbers = &self.gaussian[..factor.len()];
        let mut angle = W::Wide::splat(0);
        // By index: adapters of iterators are compiled in one unit of the crate and called from the others.
        for k in 0..factor.len() {
            angle = angle + numbers[k].mul_wide(W::splat(factor[k]));
        }
        angle
    }
}

impl Given<'_> {
    /// The angle of the profile since its start, at a boundary of its ticks.
    #[inline(always)]
    fn profile<W: Word>(&self, boundary: W) -> W {
        let profile = &self.table[self.shape.motion_table()..];
        // SAFETY: `Shape::table_words` counts the last boundary that any position leads to, no side has more ticks than the
        // margin before the first, and `GapFill::new`, which alone makes a `Given`, refuses shorter tables.
        unsafe { W::gather(profile, boundary) }
    }
}

/// A tone with its own amplitude: a fraction of the largest one, or Rayleigh-distributed.
#[inline(always)]
fn with_amplitude<W: Word>(tone: [W; 2], words: [W; 4], p: &Parameters, t: usize) -> [W; 2] {
    let part = W::splat(p.amplitude_low[t]) + words[0].mulhi(W::splat(p.amplitude_width[t]));
    let rayleigh = W::splat(p.rayleigh[t]);
    [amplitude(tone[0], words[0], part, rayleigh), amplitude(tone[1], words[1], part, rayleigh)]
}

/// A fraction `part` of `tone`, or the normal number of `word` where all bits of `rayleigh` are set.
#[inline(always)]
fn amplitude<W: Word>(tone: W, word: W, part: W, rayleigh: W) -> W {
    let scaled = (tone.mul_wide(part) + W::Wide::splat(1 << (AMPLITUDE_BITS - 1))).bits_from(AMPLITUDE_BITS);
    scaled ^ ((scaled ^ normal(word)) & rayleigh)
}

/// The angle of a tick at the peak of the rate, in 2^−4 LSB, for a frequency of `turn` times its scale, which is
/// `half_turn` without whole turns.
#[inline(always)]
fn peak_of<W: Word>(turn: W, half_turn: W, p: &Parameters, t: usize) -> W {
    let mut of_rate = sine_ratio(turn << 1);
    // sinc 2x = sinc x · cos πx, from the frequency over its scale up.
    let (mut half, mut doublings) = (turn, p.frequency_scale[t] >> 1);
    while doublings > 0 {
        let cos = sine((half + W::splat(QUARTER_TURN)) & W::splat(HALF_TURN_MASK));
        of_rate = of_rate.mulhi(cos << 1) << 1;
        (half, doublings) = (half << 1, doublings >> 1);
    }
    let of_angle = sine(half_turn & W::splat(HALF_TURN_MASK)) << 1;
    let ratio = of_rate ^ ((of_rate ^ of_angle) & W::splat(p.of_angle[t]));
    W::splat(p.peak[t]).mulhi(ratio).with_sign(half_turn)
}

/// The trial number modulo the number of positions.
#[inline(always)]
fn in_turn<W: Word>(trial: W, p: &Parameters) -> W {
    let positions = W::splat(p.positions[0]);
    let rest = trial - trial.mulhi(W::splat(p.positions_inverse[0])) * positions;
    // The quotient may be too small by one.
    let less = rest - positions;
    less + (less.sar(31) & positions)
}

/// A constant in 2^−32 LSB from its two words.
#[inline(always)]
fn constant<W: Word>(words: &[u32], k: usize) -> W::Wide {
    W::Wide::splat((u64::from(words[2 * k + 1]) << 32 | u64::from(words[2 * k])) as i64)
}
