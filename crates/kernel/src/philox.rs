//! Random words: Philox4x32-10, a counter-based generator, so that a draw is a function of its address.
//!
//! Twin of `shaders/philox.wgsl`. Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3"
//! (SC 2011), and the known-answer vectors of Random123.

use crate::map::{Block, Map};
use crate::shader::{Constants, Part, Value};
use crate::word::{Factor, Scalar, Word};
use crate::{Form, part};

/// Declares the purposes and their shader constants, such as `FOR_NOISE_BEFORE`.
macro_rules! purposes {
    ($(#[$doc:meta])* pub enum $enum:ident { $($(#[$doc_of:meta])* $name:ident = $value:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $enum { $($(#[$doc_of])* $name = $value),* }

        fn purposes() -> Constants {
            vec![$((wgsl_name(stringify!($name)), Value::Word($value))),*]
        }
    };
}

/// Converts `NoiseBefore` to `FOR_NOISE_BEFORE`.
fn wgsl_name(purpose: &str) -> String {
    let letter = |letter: char| match letter {
        'A'..='Z' => vec!['_', letter],
        _ => vec![letter.to_ascii_uppercase()],
    };
    "FOR".chars().chain(purpose.chars().flat_map(letter)).collect()
}

purposes! {
    /// Purpose of a draw: the last word of its counter. A new purpose shifts no other draw.
    pub enum Purpose {
        /// Noise of the ticks before the gap, counted outward from it: tick 0, −1, −2, …; four to a block.
        NoiseBefore = 0,
        /// Words 0 and 1: noise of the ticks after the gap, counted outward from it: tick n+1, n+2, …; words 2 and 3:
        /// phases of the tones, also of a simulated record. With two of each to a block, the usual trial takes two blocks instead of three.
        NoiseAfterAndPhase = 1,
        /// A block for each tone: word 0 its amplitude, together with word 1 where that is Rayleigh-distributed; word 2
        /// its frequency.
        Tone = 2,
        /// Word 0: the readout at the start of the gap; word 1: noise over the whole gap.
        Readout = 3,
        /// Word 0: the place in a recorded profile.
        Position = 4,
        /// Gaussian motion of the ticks 1, 2, … of the gap; four to a block.
        GaussianGap = 5,
        /// Gaussian motion of the ticks before the gap, counted outward from it; four to a block.
        GaussianBefore = 6,
        /// Gaussian motion of the ticks after the gap, counted outward from it; in a simulated record, the white numbers of
        /// its Gaussian motion, sample by sample. Four to a block.
        GaussianAfter = 7,
        /// Start of a record: word 0 its readout, word 1 the phase of its sine, word 2 its Markov noise before the
        /// first sample.
        RecordStart = 8,
        /// White noise of the rate, sample by sample; four to a block.
        White = 9,
        /// Steps of the rate random walk, sample by sample; four to a block.
        Walk = 10,
        /// Steps of the Markov noise, sample by sample; four to a block.
        Markov = 11,
        /// Quantization noise of the angles 0, 1, …; four to a block.
        Quantization = 12,
        /// A block for each octave of flicker noise: the positions of the grids of its four streams.
        FlickerGrid = 13,
        /// Once for a run: words 0 to 2 the deviations of its A, Ω_m0 and Ω_nm, word 3 its first mode.
        RunDeviation = 20,
        /// Phases of the tones at the first switch of a run; four to a block.
        RunPhase = 21,
        /// A block for each interval of a run: word 0 its random walk, word 1 the normal part of the residual of the
        /// switch that ends it, words 2 and 3 the phases of the first two tones there.
        Interval = 22,
        /// This purpose and the next: phases of the third to sixth and of the last two tones at the switch that ends an
        /// interval, a block each.
        SwitchPhase = 23,
        /// Word 0: the bridge of the random walk within an interval, at a time in it. Two times in the same interval
        /// share the draw, so that only the distribution of each by itself is right.
        Bridge = 25,
        /// Once for a run: word 0 its end.
        RunEnd = 26,
        /// A block for each switch of a record, from number 1 on: word 0 the phase of its fill residual, word 1 its
        /// noise.
        FillResidual = 14,
        /// Relock after a mode switch, eight blocks for each switch. Block 0: the errors of U_λ/2, of the DAC and of
        /// the hysteresis and, for switch 0, the error of f0 in the whole trial. Block 1, word 0: the phase of the
        /// beat. Blocks 2 to 5: noise of the detunings, for both halves of two ticks each.
        Relock = 16,
        /// This purpose and those beyond, below the next: the draws that are a kernel's own. Points of different kinds have
        /// different keys, so kernels share it and need no purpose for each.
        Own = 32,
        /// This purpose and those beyond, one for each octave: its holds. Octaves 1 and 2 have one stream, four holds
        /// to a block; the others have four streams, one hold of each to a block.
        Flicker = 64,
    }
}

/// The address of the draws of a trial: its number in two halves, and the keys of its point.
#[derive(Debug, Clone, Copy)]
pub struct Address<W> {
    /// Lower halves of the trial numbers, one in each lane.
    pub low: W,
    /// Their upper half, common to all lanes.
    pub high: u32,
    /// Round keys of the point.
    pub keys: Keys,
}

impl Address<Scalar> {
    /// The address of a single trial of the point with the key `key`.
    pub fn new(key: [u32; 2], number: u64) -> Address<Scalar> {
        let keys = schedule(key.map(Scalar)).map(|key| key.map(|word| word.0));
        Address { low: Scalar(number as u32), high: (number >> 32) as u32, keys }
    }
}

impl<W: Word> Address<W> {
    /// The four words of a block of a purpose.
    #[inline(always)]
    pub fn draw(&self, purpose: Purpose, block: usize) -> [W; WORDS] {
        self.draw_beyond(purpose, 0, block)
    }

    /// The four words of a block of the purpose `beyond` places after the given one.
    #[inline(always)]
    pub fn draw_beyond(&self, purpose: Purpose, beyond: usize, block: usize) -> [W; WORDS] {
        let counter = [
            self.low.factors(),
            W::Factors::splat(self.high),
            W::Factors::splat(block as u32),
            W::Factors::splat(purpose as u32 + beyond as u32),
        ];
        let mut keys = [[W::Factors::splat(0); 2]; ROUNDS];
        // Not zipped: `zip` is compiled in one unit of the crate and called from the others.
        for (round, keys) in keys.iter_mut().enumerate() {
            *keys = [W::Factors::splat(self.keys[round][0]), W::Factors::splat(self.keys[round][1])];
        }
        let [a, b, c, d] = philox(counter, keys);
        [W::of_factors(a), W::of_factors(b), W::of_factors(c), W::of_factors(d)]
    }
}

/// Words of a block.
pub const WORDS: usize = 4;

const ROUNDS: usize = 10;
const MULTIPLIER: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// The constants that the shader takes from this module.
pub(crate) fn constants() -> Constants {
    let mut all = purposes();
    all.push(("WORDS".to_owned(), WORDS.into()));
    all.push(("ROUNDS".to_owned(), ROUNDS.into()));
    all.push(("MULTIPLIER".to_owned(), MULTIPLIER.into()));
    all.push(("WEYL".to_owned(), WEYL.into()));
    all
}

/// The keys of the ten rounds.
pub type Keys<W = u32> = [[W; 2]; ROUNDS];

/// Maps a counter and a key to random words.
pub const FORM: Form = Form::Map(Map::of::<Words>());

struct Words;

impl Block for Words {
    const PART: &'static Part = &part::philox;
    const INPUTS: usize = 6;
    const OUTPUTS: usize = 4;
    const WGSL: &'static str = "let c = philox(vec4<u32>(x[0], x[1], x[2], x[3]), schedule(vec2<u32>(x[4], x[5]))); \
                                y = array<u32, OUTPUTS>(c.x, c.y, c.z, c.w);";
    // Only here: the shader's version is generated.
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        philox([x[0], x[1], x[2], x[3]], schedule([x[4], x[5]]))
    }
}

/// Four random words for a counter and the keys of its rounds.
#[inline(always)]
pub fn philox<W: Factor>(counter: [W; 4], keys: Keys<W>) -> [W; 4] {
    let mut c = counter;
    // Unrolled by hand: a rolled loop keeps the words out of the wide registers.
    c = philox_round(c, keys[0]);
    c = philox_round(c, keys[1]);
    c = philox_round(c, keys[2]);
    c = philox_round(c, keys[3]);
    c = philox_round(c, keys[4]);
    c = philox_round(c, keys[5]);
    c = philox_round(c, keys[6]);
    c = philox_round(c, keys[7]);
    c = philox_round(c, keys[8]);
    philox_round(c, keys[9])
}

#[inline(always)]
fn philox_round<W: Factor>(c: [W; 4], k: [W; 2]) -> [W; 4] {
    let (high0, low0) = c[0].mulhilo(W::splat(MULTIPLIER[0]));
    let (high1, low1) = c[2].mulhilo(W::splat(MULTIPLIER[1]));
    [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
}

/// The keys of the rounds, computed once for a point: the Weyl sequence from its key.
#[inline(always)]
pub fn schedule<W: Word>(key: [W; 2]) -> Keys<W> {
    let mut keys = [key; ROUNDS];
    for r in 1..ROUNDS {
        let [k0, k1] = keys[r - 1];
        keys[r] = [k0 + W::splat(WEYL[0]), k1 + W::splat(WEYL[1])];
    }
    keys
}

/// The words of one key in counter order, for use with `rand`'s distributions and adaptors.
///
/// The counter is 128 bits, least significant word first, and starts at 0; output word i of block b is word 4b + i of
/// the stream. Period 2^130 words. Not cryptographic.
///
/// ```
/// use rand::{RngExt, SeedableRng};
/// let mut rng = sagnac_kernel::philox::Philox::seed_from_u64(1);
/// let x: f64 = rng.random();
/// assert!((0.0..1.0).contains(&x));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Philox {
    key: [u32; 2],
    /// Index of the next word.
    next: u128,
    block: [u32; 4],
}

impl Philox {
    /// The stream of `key` from its start.
    pub fn new(key: [u32; 2]) -> Philox {
        Philox { key, next: 0, block: [0; 4] }
    }

    fn word(&mut self) -> u32 {
        let lane = (self.next % 4) as usize;
        if lane == 0 {
            let counter = self.next / 4;
            let words = [0, 32, 64, 96].map(|shift| Scalar((counter >> shift) as u32));
            self.block = philox(words, schedule(self.key.map(Scalar))).map(|word| word.0);
        }
        self.next = self.next.wrapping_add(1);
        self.block[lane]
    }
}

impl rand::rand_core::TryRng for Philox {
    type Error = core::convert::Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
        Ok(self.word())
    }

    fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
        rand::rand_core::utils::next_u64_via_u32(self)
    }

    fn try_fill_bytes(&mut self, to: &mut [u8]) -> Result<(), Self::Error> {
        rand::rand_core::utils::fill_bytes_via_next_word(to, || self.try_next_u32())
    }
}

impl rand::rand_core::SeedableRng for Philox {
    type Seed = [u8; 8];

    fn from_seed(seed: [u8; 8]) -> Philox {
        let [a, b, c, d, e, f, g, h] = seed;
        Philox::new([u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rand_core::{Rng, SeedableRng};

    /// Random123's `kat_vectors` for philox4x32, 10 rounds: counter, key, output.
    const RANDOM123: [([u32; 4], [u32; 2], [u32; 4]); 3] = [
        ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
        ([!0; 4], [!0; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
        (
            [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
            [0xa409_3822, 0x299f_31d0],
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
        ),
    ];

    #[test]
    fn words_are_those_of_random123() {
        for (counter, key, expected) in RANDOM123 {
            assert_eq!(philox(counter.map(Scalar), schedule(key.map(Scalar))).map(|word| word.0), expected);
        }
    }

    #[test]
    fn the_stream_is_the_blocks_in_counter_order() {
        let mut rng = Philox::from_seed([0; 8]);
        let first: Vec<u32> = (0..4).map(|_| rng.next_u32()).collect();
        assert_eq!(first, RANDOM123[0].2);
        let fifth = philox([1, 0, 0, 0].map(Scalar), schedule([Scalar(0); 2]))[0].0;
        assert_eq!(rng.next_u32(), fifth);
    }

    #[test]
    fn value_stability() {
        let mut rng = Philox::seed_from_u64(42);
        assert_eq!(rng.next_u64(), 16_613_817_376_571_387_151);
        let mut bytes = [0; 5];
        rng.fill_bytes(&mut bytes);
        assert_eq!(bytes, [209, 255, 10, 185, 5]);
    }
}
