//! A ring laser gyro with lock-in and dither: the angle by which its output departs from the input, and the sums of its
//! squared differences.
//!
//! Twin of `shaders/lock_in.wgsl`. The beat phase is that of the lock-in so far, of the input and of the dither, ψ = φ + I + D.
//! Input and dither are exact in each step and not integrated. Only φ is: it grows by c·sin ψ at the middle of each step, which is
//! symmetric splitting, in units so small that c has 26 bits. The sine is odd bit for bit, so rounding makes no false rate
//! (`docs/dev/numerics.md`).
//!
//! A half-cycle of the dither lies between two zero crossings of its angle, with the reversal in the middle. Each has its own
//! amplitude, and the angle stays continuous. At zero crossings from below an angle has what the integral has beyond the sum of steps
//! there.

pub mod recipe;

use crate::Form;
use crate::curve::{Chunk, MAX_LANES, Source};
pub use crate::lock_in::recipe::{LockIn, Readout};
use crate::normal::normal;
use crate::philox::{Address, Purpose, schedule};
use crate::recipe::CHUNK;
use crate::shader::constants;
use crate::sine::{QUARTER_TURN, sine};
use crate::word::{Scalar, Wide, Word};

constants!(ROUND, LOCK_IN_STATE, OTHER_VALUES);

/// Maps gyros to the sums of the squared differences of their angles, and to the sums of the angles of the first and the last
/// third.
pub const FORM: Form = Form::Records;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 2;

/// Steps of a round, within which the lock-in adds less than half a unit of its word.
pub const ROUND: usize = 16;

/// Terms of the sine of a step.
pub const KICKS: usize = 4;

/// Values of a gyro besides its sums.
pub const OTHER_VALUES: usize = 2;

/// Words of a gyro's state.
const LOCK_IN_STATE: usize = 20;

/// sin(πz/2)/z = T₀ − z²(T₁ − z²(T₂ − z²T₃)) for z in [0, 1]; T_k in units of 2^−(31+k). The error is below 2^−19.7.
pub const SHORT_SINE: [u32; KICKS] = [3_373_256_853, 2_774_229_846, 682_899_858, 75_086_095];

/// State carried from chunk to chunk. What all lanes share is in plain words.
pub struct State<W: Word> {
    address: Address<W>,
    /// The lock-in so far, with the noise of the beam.
    angle: W::Wide,
    /// The phase at the start.
    start: W,
    /// Amplitude of the half-cycle, negative in every second one.
    amplitude: W,
    /// Its random walk, 2^−32 units.
    walk: W::Wide,
    /// Phase of the dither at the reversal, 2^−32 turns.
    phase: W,
    /// Sums of the angles of the first and the last third.
    thirds: [W::Wide; 2],
    /// Number of the half-cycle, and its rounds so far.
    number: u32,
    at: u32,
    /// Fraction of a round that the samples have left over.
    left: u32,
    /// The input so far and that of a step, 2^−64 turns.
    input: u64,
    rate: u64,
    /// Phase of the dither at the sample, 2^−64 turns.
    sample_phase: u64,
}

impl<W: Word> State<W> {
    #[inline(always)]
    fn begin(p: &LockIn, address: Address<W>) -> State<W> {
        let nothing = W::Wide::splat(0);
        let mut state = State {
            address,
            angle: nothing,
            start: address.draw_beyond(Purpose::Own, 1, 0)[0],
            amplitude: W::splat(0),
            walk: nothing,
            phase: W::splat(0),
            thirds: [nothing; 2],
            number: 0,
            at: 0,
            left: 0,
            input: 0,
            rate: p.rate,
            sample_phase: 0,
        };
        state.begin_half(p);
        state
    }

    /// Computes the angles of the chunk that starts at sample `first`.
    #[inline(always)]
    fn chunk(&mut self, p: &LockIn, first: usize, angles: &mut Chunk) {
        for i in 0..CHUNK {
            let sample = (first + i) as u32;
            if sample > p.samples {
                return;
            }
            let angle = self.reading(p);
            angle.store(&mut angles[i * W::LANES..]);
            let angle = angle.mul_wide(W::splat(1));
            if sample < p.third {
                self.thirds[0] = self.thirds[0] + angle;
            }
            if sample > p.samples - p.third {
                self.thirds[1] = self.thirds[1] + angle;
            }
            self.advance(p);
        }
    }

    /// The angle of a sample.
    #[inline(always)]
    fn reading(&self, p: &LockIn) -> W {
        let mut angle = self.angle;
        if p.end > 0 {
            angle = angle + self.end(p).mul_wide(W::splat(1));
        }
        let angle = angle.bits_from(p.lsb);
        if p.readout == Readout::Stripped {
            return angle;
        }
        let mut amplitude = self.amplitude;
        if p.readout == Readout::Demodulated {
            amplitude = amplitude - W::splat(p.amplitude).with_sign(W::splat(self.number << 31));
        }
        let turn = W::splat((self.sample_phase >> 32) as u32 & (u32::MAX >> 1));
        let dither = amplitude.mul_wide(sine(self.with_noise(p, turn, sine(turn) << 1))) + W::Wide::half();
        angle + dither.high_word().sar(p.dither_lsb)
    }

    /// What the integral up to a zero crossing has beyond the sum of steps that ends there.
    #[inline(always)]
    fn end(&self, p: &LockIn) -> W {
        let phase = self.angle.bits_from(p.fine) + self.start + W::splat((self.input >> 32) as u32);
        let cosine = sine(phase + W::splat(QUARTER_TURN));
        cosine.mul_wide(W::splat(p.end)).high_word()
    }

    /// A phase within the half-cycle with its noise, which vanishes at both ends; `sin` is its sine, 2^−31.
    #[inline(always)]
    fn with_noise(&self, p: &LockIn, turn: W, sin: W) -> W {
        if p.phase_noise == 0 {
            return turn;
        }
        turn + self.phase.mul_wide(sin).bits_from(31)
    }

    /// Goes on to the next sample.
    #[inline(always)]
    fn advance(&mut self, p: &LockIn) {
        let left = u64::from(self.left) + u64::from(p.interval[0]);
        let mut to_go = p.interval[1] + (left >> 32) as u32;
        self.left = left as u32;
        self.sample_phase = self.sample_phase.wrapping_add(p.sample_phase);
        while to_go > 0 {
            let run = to_go.min(p.half - self.at);
            self.rounds(p, run);
            to_go -= run;
            if self.at == p.half {
                self.number += 1;
                self.at = 0;
                self.rate = self.rate.wrapping_add(p.ramp);
                self.begin_half(p);
            }
        }
    }

    /// Draws what is random in a half-cycle.
    #[inline(always)]
    fn begin_half(&mut self, p: &LockIn) {
        let mut words = [W::splat(0); 4];
        if p.is_random() {
            words = self.address.draw(Purpose::Own, self.number as usize);
        }
        let mut amplitude = W::splat(p.amplitude);
        if p.amplitude_noise[0] > 0 {
            amplitude = amplitude + normal(words[0]).mul_wide(W::splat(p.amplitude_noise[0])).high_word();
        }
        if p.amplitude_noise[1] > 0 {
            self.walk = self.walk + normal(words[1]).mul_wide(W::splat(p.amplitude_noise[1]));
            amplitude = amplitude + self.walk.high_word();
        }
        self.amplitude = amplitude.with_sign(W::splat(self.number << 31));
        if p.phase_noise > 0 {
            self.phase = normal(words[2]).mul_wide(W::splat(p.phase_noise)).high_word();
        }
        if p.beam > 0 {
            let noise = normal(words[3]).mul_wide(W::splat(p.beam)) + W::Wide::half();
            self.angle = self.angle + noise.high_word().mul_wide(W::splat(1));
        }
    }

    /// Makes some rounds of steps of one half-cycle.
    #[inline(always)]
    fn rounds(&mut self, p: &LockIn, count: u32) {
        let steps = p.half as usize * ROUND;
        let mut rate = self.rate;
        if p.motion {
            let start = p.motion_start();
            rate = rate.wrapping_add(u64::from(p.table[start + self.number as usize]) << 32);
        }
        let step = (rate >> 32) as u32;
        let to_middle = (step as i32 >> 1) as u32;
        for round in self.at..self.at + count {
            let first = round as usize * ROUND;
            let mut at = self.angle.bits_from(p.fine) + self.start;
            at = at + W::splat(((self.input >> 32) as u32).wrapping_add(to_middle));
            let mut sum = W::splat(0);
            for k in 0..ROUND {
                let mut phase = at + W::splat((k as u32).wrapping_mul(step));
                if p.amplitude > 0 {
                    phase = phase + self.dither(p, steps, first + k);
                }
                sum = sum + kick(p, phase + sum.sar(p.fine));
            }
            self.angle = self.angle + sum.mul_wide(W::splat(1));
            self.input = self.input.wrapping_add(rate.wrapping_mul(ROUND as u64));
        }
        self.at += count;
    }

    /// The dither's angle in the middle of a step of the half-cycle, as a turn word.
    #[inline(always)]
    fn dither(&self, p: &LockIn, steps: usize, step: usize) -> W {
        let sin = W::splat(p.table[step]);
        if p.phase_noise == 0 {
            return self.amplitude.mul_wide(sin).bits_from(p.amplitude_bits - 1);
        }
        let sin = sine(self.with_noise(p, W::splat(p.table[steps + step]), sin));
        self.amplitude.mul_wide(sin).bits_from(p.amplitude_bits - 2)
    }
}

/// The lock-in of a step at a phase: an odd function of it, bit for bit.
#[inline(always)]
fn kick<W: Word>(p: &LockIn, phase: W) -> W {
    let half = phase << 1;
    let mirror = half.sar(31);
    let z = (half ^ mirror) - mirror;
    let zz = z.mulhi(z);
    let mut sum = W::splat(p.kick[3]);
    sum = W::splat(p.kick[2]) - sum.mulhi(zz);
    sum = W::splat(p.kick[1]) - sum.mulhi(zz);
    sum = W::splat(p.kick[0]) - sum.mulhi(zz);
    sum.mulhi(z).with_sign(phase)
}

impl Source for LockIn {
    type State<W: Word> = State<W>;

    fn key(&self) -> [u32; 2] {
        self.key
    }

    #[inline(always)]
    fn begin<W: Word>(&self, address: Address<W>) -> State<W> {
        State::begin(self, address)
    }

    #[inline(always)]
    fn chunk<W: Word>(&self, state: &mut State<W>, first: usize, angles: &mut Chunk) {
        state.chunk(self, first, angles);
    }

    // Only here: `store_state` of the shader sets these values.
    #[inline(always)]
    fn others<W: Word>(&self, state: &State<W>, lane: usize, to: &mut Vec<u128>) {
        for third in state.thirds {
            let mut lanes = [0; MAX_LANES];
            third.store(&mut lanes[..W::LANES]);
            to.push(lanes[lane].into());
        }
    }
}

/// What one gyro draws and puts out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trace {
    /// Phase at the start, 2^−32 turns.
    pub start: u32,
    /// Angles 0, 1, …, N, LSB.
    pub angles: Vec<i32>,
    /// Amplitudes of the half-cycles, in the units of [`LockIn::amplitude`], negative in every second one.
    pub amplitudes: Vec<i32>,
    /// Phases of the dither at the reversals, 2^−32 turns.
    pub phases: Vec<i32>,
}

impl LockIn {
    /// What one gyro draws and puts out, with which other programs compare it.
    pub fn trace(&self, number: u64) -> Trace {
        self.assert_fits();
        let keys = schedule(self.key.map(Scalar)).map(|key| key.map(|word| word.0));
        let address = Address { low: Scalar(number as u32), high: (number >> 32) as u32, keys };
        let (mut state, mut drawn) = (State::begin(self, address), State::begin(self, address));
        let mut angles = Vec::new();
        for _ in 0..=self.samples {
            angles.push(state.reading(self).0 as i32);
            state.advance(self);
        }
        let (mut amplitudes, mut phases) = (Vec::new(), Vec::new());
        for half in 0..=state.number {
            if half > 0 {
                drawn.number = half;
                drawn.begin_half(self);
            }
            amplitudes.push(drawn.amplitude.0 as i32);
            phases.push(drawn.phase.0 as i32);
        }
        Trace { start: state.start.0, angles, amplitudes, phases }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::through_chebyshev_points;

    /// The polynomial in z² through sin(πz/2)/z.
    fn regenerated() -> [u32; KICKS] {
        let ratio = |zz: f64| libm::sin(libm::sqrt(zz) * core::f64::consts::FRAC_PI_2) / libm::sqrt(zz);
        let polynomial = through_chebyshev_points::<KICKS>(ratio);
        core::array::from_fn(|k| libm::round(libm::fabs(polynomial[k]) * libm::exp2(31.0 + k as f64)) as u32)
    }

    #[test]
    fn the_committed_coefficients_are_those_of_their_formula() {
        assert_eq!(regenerated(), SHORT_SINE);
    }
}
