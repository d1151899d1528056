//! Allan variances of synthetic records: exact sums of the squared differences of their angles.
//!
//! Twin of `shaders/allan.wgsl`. The angle wraps in 32 bits; only its differences have to fit, and lowering proves that
//! they stay below 2^29. Squares are summed in 64 bits within a chunk and in 96 bits within a record.

use crate::noise::{Chunk, Noise};
use crate::philox::{Address, schedule};
use crate::recipe::{CHUNK, Recipe, STREAMS};
use crate::shader::{Part, Shader, Variant, constants};
use crate::width::{AnyWidth, Width};
use crate::word::{Scalar, Wide, Word};
use crate::{Form, part};

constants!(STATE_WORDS, SUM_WORDS, HOLD_WORDS, RING_LANES);

/// Maps records to the sums of their squared differences.
pub const FORM: Form = Form::Records;

/// Words of a record's state, without those of its holds.
const STATE_WORDS: usize = 11;

/// Words of a hold.
const HOLD_WORDS: usize = 3;

/// Words of a sum.
pub const SUM_WORDS: usize = 3;

/// Records of a dispatch whose angles stand side by side: one cache line of a GPU.
pub const RING_LANES: usize = 32;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 2;

/// The newest angles of one level, as many as the longest difference reaches back, in a ring of whole chunks.
struct Ring {
    stride: usize,
    depth: usize,
    words: Vec<u32>,
}

/// The angles of a chunk that a level takes.
#[derive(Clone, Copy)]
struct Newest {
    /// The first, counted in strides.
    first: usize,
    count: usize,
    /// Place of the first in the chunk and in the ring.
    sample: usize,
    at: usize,
}

/// The sum at one place of the curve, kept as the sums of the lower and upper halves of its terms.
#[derive(Clone, Copy)]
struct Sum<W: Word> {
    halves: [W::Wide; 2],
}

struct Records<'a> {
    recipe: &'a Recipe,
    first: u64,
    count: usize,
}

impl AnyWidth for Records<'_> {
    type Output = Vec<u128>;

    // Only here: in the shader, `main` does the work of this function and of `records`.
    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u128> {
        let Records { recipe, first, count } = self;
        let keys = schedule(recipe.key.map(Scalar)).map(|key| key.map(|word| word.0));
        let mut sums = Vec::with_capacity(count * recipe.places());
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // Lanes beyond the last record compute records whose sums are discarded.
            let address = Address { low: W::splat(at as u32) + W::iota(), high: (at >> 32) as u32, keys };
            records::<W>(recipe, address, (count - done).min(W::LANES), &mut sums);
            done += W::LANES;
        }
        sums
    }
}

/// Makes one record per lane and appends the sums of the first `count` of them to `to`.
// Only here: see `run`.
#[inline(always)]
fn records<W: Word>(recipe: &Recipe, address: Address<W>, count: usize, to: &mut Vec<u128>) {
    let mut noise = Noise::begin(recipe, address);
    let mut rings: Vec<Ring> = recipe
        .levels
        .iter()
        .map(|level| {
            let depth = level.depth(recipe.order);
            Ring { stride: level.stride as usize, depth, words: vec![0; depth * W::LANES] }
        })
        .collect();
    let nothing = Sum::<W> { halves: [W::Wide::splat(0); 2] };
    let mut sums = vec![nothing; recipe.places()];
    let mut angles: Chunk = [0; 16 * CHUNK];
    let last = recipe.samples as usize;
    for first in (0..=last).step_by(CHUNK) {
        noise.chunk(recipe, first, &mut angles);
        let count = CHUNK.min(last + 1 - first);
        let mut place = 0;
        for (level, ring) in recipe.levels.iter().zip(&mut rings) {
            let newest = ring.push::<W>(first, count, &angles);
            for &span in &level.spans {
                let square = match recipe.order {
                    2 => ring.squares::<W, 2>(span as usize, newest, &angles),
                    _ => ring.squares::<W, 3>(span as usize, newest, &angles),
                };
                sums[place].add(square);
                place += 1;
            }
        }
    }
    for lane in 0..count {
        to.extend(sums.iter().map(|sum| sum.of_lane(lane)));
    }
}

impl Ring {
    /// Stores the angles of a chunk at multiples of the stride, and returns which these are.
    #[inline(always)]
    fn push<W: Word>(&mut self, start: usize, count: usize, angles: &Chunk) -> Newest {
        let first = start.div_ceil(self.stride);
        let mut newest =
            Newest { first, count: 0, sample: first * self.stride - start, at: first % self.depth };
        let mut at = newest.at;
        for sample in (newest.sample..count).step_by(self.stride) {
            W::load(&angles[sample * W::LANES..]).store(&mut self.words[at * W::LANES..]);
            at = self.beyond(at, 1);
            newest.count += 1;
        }
        newest
    }

    /// The place `by` places beyond `at` in the ring.
    #[inline(always)]
    fn beyond(&self, at: usize, by: usize) -> usize {
        if at + by >= self.depth { at + by - self.depth } else { at + by }
    }

    /// The place `by` places before `at` in the ring.
    #[inline(always)]
    fn before(&self, at: usize, by: usize) -> usize {
        if at < by { at + self.depth - by } else { at - by }
    }

    /// Sum of the squared differences of order `ORDER` over `span` strides that end at the newest angles.
    #[inline(always)]
    fn squares<W: Word, const ORDER: usize>(&self, span: usize, newest: Newest, angles: &Chunk) -> W::Wide {
        let mut sum = W::Wide::splat(0);
        let start = newest.first.max(ORDER * span);
        if start >= newest.first + newest.count {
            return sum;
        }
        let mut sample = newest.sample + (start - newest.first) * self.stride;
        let mut place = self.beyond(newest.at, start - newest.first);
        let mut at = [0; 3];
        for at in &mut at[..ORDER] {
            place = self.before(place, span);
            *at = place;
        }
        let mut left = newest.first + newest.count - start;
        while left > 0 {
            // The run ends where the first of the places reaches the end of the ring.
            let run = left.min(self.depth - at[0].max(at[1]).max(at[2]));
            for i in 0..run {
                let first = W::load(&angles[sample * W::LANES..]);
                let second = self.angle::<W>(at[0] + i);
                let third = self.angle::<W>(at[1] + i);
                let mut difference = first - second - (second - third);
                if ORDER == 3 {
                    let fourth = self.angle::<W>(at[2] + i);
                    difference = difference - (second - third - (third - fourth));
                }
                sum = sum + difference.mul_wide(difference);
                sample += self.stride;
            }
            for at in &mut at[..ORDER] {
                *at = self.beyond(*at, run);
            }
            left -= run;
        }
        sum
    }

    #[inline(always)]
    fn angle<W: Word>(&self, at: usize) -> W {
        W::load(&self.words[at * W::LANES..])
    }
}

impl<W: Word> Sum<W> {
    #[inline(always)]
    fn add(&mut self, square: W::Wide) {
        let [low, high] = square.halves();
        self.halves = [self.halves[0] + low, self.halves[1] + high];
    }

    // Only here: an invocation has one lane.
    #[inline(always)]
    fn of_lane(&self, lane: usize) -> u128 {
        let (mut low, mut high) = ([0; 16], [0; 16]);
        self.halves[0].store(&mut low);
        self.halves[1].store(&mut high);
        u128::from(low[lane]) + (u128::from(high[lane]) << 32)
    }
}

impl Recipe {
    /// Sums of the squared differences of the records `first .. first + count`, whose numbers share one upper half:
    /// record by record, and within a record by the places of the curve in the order of the levels.
    pub fn sums(&self, width: Width, first: u64, count: usize) -> Vec<u128> {
        self.assert_fits();
        width.run(Records { recipe: self, first, count })
    }

    /// The file of the kernel that makes these records.
    pub fn part(&self) -> &'static Part {
        &part::allan
    }

    /// The shader that makes these records, and whether it draws normal numbers.
    pub fn shader(&self, variant: Variant) -> (String, bool) {
        let octaves = self.octaves();
        let fields = self.fixed(0, 0, [0, 0]).map(|(name, _)| format!("    {name}: u32,\n")).concat();
        let shader = Shader {
            parts: vec![&part::philox, &part::normal, &part::sine, &part::noise, &part::allan],
            constants: vec![
                ("OCTAVES", octaves),
                ("HOLD_ROOM", STREAMS * octaves.max(1)),
                ("LEVELS", self.levels.len()),
                ("PLACES", self.places()),
                ("ORDER", self.order as usize),
            ],
            flags: vec![
                ("FLICKER_HOLDS", octaves > 1),
                ("WALK_STEPS", self.walk > 0),
                ("MARKOV_STEPS", self.markov.is_some()),
                ("SINE_WAVE", self.sine.is_some()),
                ("QUANTISATION_NOISE", self.quantisation > 0),
                ("PULSE", self.pulse.is_some()),
                ("DRIFT", !self.drift.is_empty()),
                ("FILL_RESIDUALS", self.switching.is_some()),
                ("THIRD_ORDER", self.order == 3),
            ],
            declarations: format!(
                "struct Parameters {{\n{fields}    flicker: array<vec4<u32>, {}>,\n    \
                 levels: array<vec4<u32>, LEVELS>,\n    spans: array<vec4<u32>, {}>,\n}}\n",
                self.flicker_vectors(),
                self.places().div_ceil(4)
            ),
        };
        (shader.text(variant), shader.has_normals())
    }

    /// Words of a dispatch that precede the lists of the recipe, by their names in the shader. The dispatch covers the
    /// chunks `chunk_from .. chunk_to` of `lanes` records; the first record has the number high·2^32 + low.
    fn fixed(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> [(&'static str, u32); 21] {
        let [loss, step, start] = self.markov.unwrap_or_default();
        let [sine_step, amplitude] = self.sine.unwrap_or_default();
        let [interval, residual_amplitude, residual_noise] = self.switching.unwrap_or_default();
        [
            ("key_0", self.key[0]),
            ("key_1", self.key[1]),
            ("samples", self.samples),
            ("white", self.white),
            ("rate_scale", self.rate_scale),
            ("walk", self.walk),
            ("markov_loss", loss),
            ("markov_step", step),
            ("markov_start", start),
            ("sine_step", sine_step),
            ("sine_amplitude", amplitude),
            ("quantisation", self.quantisation),
            ("pulse", self.pulse.unwrap_or(0)),
            ("switch_interval", interval),
            ("residual_amplitude", residual_amplitude),
            ("residual_noise", residual_noise),
            ("low", first as u32),
            ("high", (first >> 32) as u32),
            ("lanes", lanes),
            ("chunk_from", chunks[0]),
            ("chunk_to", chunks[1]),
        ]
    }

    /// Vectors of four words for the standard deviations of flicker noise; octave o has index o.
    fn flicker_vectors(&self) -> usize {
        self.octaves().max(1).div_ceil(4)
    }

    /// The parameters of a dispatch of the shader.
    pub fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        self.assert_fits();
        let mut words: Vec<u32> =
            self.fixed(first, lanes, chunks).into_iter().map(|(_, word)| word).collect();
        words.resize(words.len().next_multiple_of(4), 0);
        let flicker = words.len();
        // Octave 0 has no hold.
        words.push(0);
        words.extend(&self.flicker);
        words.resize(flicker + 4 * self.flicker_vectors(), 0);
        let (mut ring, mut place) = (0, 0);
        for level in &self.levels {
            let depth = level.depth(self.order) as u32;
            words.extend([level.stride, ring, depth, place]);
            ring += depth;
            place += level.spans.len() as u32;
        }
        words.extend(self.levels.iter().flat_map(|level| &level.spans));
        words.resize(words.len().next_multiple_of(4), 0);
        words
    }

    /// Words of the rings of `lanes` records in the shader, which fill whole rows.
    pub fn ring_words(&self, lanes: usize) -> usize {
        self.depth() * lanes.next_multiple_of(lanes.min(RING_LANES))
    }

    /// Words of a record's state that the shader keeps between dispatches.
    pub fn state_words(&self) -> usize {
        STATE_WORDS + HOLD_WORDS * STREAMS * self.octaves()
    }

    /// Largest number of loop rounds that a chunk takes in the shader.
    pub fn rounds(&self) -> usize {
        // A difference goes through the rounds of a chunk in at most five runs: each angle passes the end of the ring once.
        CHUNK * (self.places() + 17) + 6 * self.places() + 8 * self.octaves()
    }
}
