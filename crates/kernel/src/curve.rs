//! Records whose angles come chunk by chunk from a source, and the exact sums of their squared differences.
//!
//! Twin of `shaders/curve.wgsl`. The angle wraps in 32 bits; only its differences have to fit, and lowering proves that
//! they stay below 2^29. Squares are summed in 64 bits within a chunk and in 96 bits within a record.

use core::fmt::Debug;
use std::sync::Arc;

use crate::philox::{Address, schedule};
use crate::recipe::{CHUNK, Level};
use crate::record::Sum;
use crate::sealed::Sealed;
use crate::shader::{Part, Variant, constants};
use crate::width::pair::Pair;
use crate::width::{AnyWidth, Width};
use crate::word::{Scalar, Wide, Word};

constants!(RING_LANES);

/// Records of a dispatch whose angles stand side by side: one cache line of a GPU.
pub const RING_LANES: usize = 32;

/// Most lanes of any word: a pair of the widest.
pub(crate) const MAX_LANES: usize = 32;

/// A chunk of words, one for each lane and sample.
pub(crate) type Chunk = [u32; MAX_LANES * CHUNK];

/// The differences that are taken of the angles of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Curve<'a> {
    /// Number of samples N; there are N + 1 angles.
    pub samples: u32,
    /// Order of the differences: 2, or 3 for the Hadamard variance.
    pub order: u32,
    /// The angles kept, with the differences that use them.
    pub levels: &'a [Level],
}

impl Curve<'_> {
    /// Number of places of the curve: the averaging factors of all levels.
    pub fn places(&self) -> usize {
        self.levels.iter().map(|level| level.spans.len()).sum()
    }

    /// Number of differences averaged at each place, in the order of the levels.
    pub fn terms(&self) -> Vec<u64> {
        let of_level = |level: &Level| {
            let last = u64::from(self.samples / level.stride);
            let order = u64::from(self.order);
            level
                .spans
                .iter()
                .map(move |&span| (last + 1).saturating_sub(order * u64::from(span)))
                .collect::<Vec<_>>()
        };
        self.levels.iter().flat_map(of_level).collect()
    }

    /// Chunks of a record; the last is rarely full.
    pub fn chunks(&self) -> u32 {
        self.samples / CHUNK as u32 + 1
    }

    /// Words of angles kept per lane.
    pub fn depth(&self) -> usize {
        self.levels.iter().map(|level| level.depth(self.order)).sum()
    }

    /// Words of the rings of `lanes` records in the shader, which fill whole rows.
    pub fn ring_words(&self, lanes: usize) -> usize {
        self.depth() * lanes.next_multiple_of(lanes.min(RING_LANES))
    }

    /// Loop rounds of the differences of a chunk in the shader.
    pub(crate) fn rounds(&self) -> usize {
        // A difference goes through the rounds of a chunk in at most five runs: each angle passes the end of the ring once.
        CHUNK * (self.places() + 1) + 6 * self.places()
    }

    /// Declarations of the lists of parameters in the shader.
    pub(crate) fn declarations(&self) -> String {
        let spans = self.places().div_ceil(4);
        format!("    levels: array<vec4<u32>, LEVELS>,\n    spans: array<vec4<u32>, {spans}>,\n")
    }

    /// Constants of the shader.
    pub(crate) fn constants(&self) -> [(&'static str, usize); 3] {
        [("LEVELS", self.levels.len()), ("PLACES", self.places()), ("ORDER", self.order as usize)]
    }

    /// The lists of parameters of the shader, after others that fill whole vectors of four words.
    pub(crate) fn parameters(&self, words: &mut Vec<u32>) {
        let (mut ring, mut place) = (0, 0);
        for level in self.levels {
            let depth = level.depth(self.order) as u32;
            words.extend([level.stride, ring, depth, place]);
            ring += depth;
            place += level.spans.len() as u32;
        }
        words.extend(self.levels.iter().flat_map(|level| &level.spans));
        words.resize(words.len().next_multiple_of(4), 0);
    }
}

/// Records that a device can make. Only kernels of this package have them: shaders run without checks of their indices.
pub trait Recorded: Debug + Send + Sync + Sealed {
    /// The kernel's own file.
    fn part(&self) -> &'static Part;
    /// The differences that are taken.
    fn curve(&self) -> Curve<'_>;
    /// Integers of a record: the sums at all places, and others.
    fn values(&self) -> usize {
        self.curve().places()
    }
    /// Steps of a record, of which its speed is made: its samples, or those between them.
    fn steps(&self) -> u64 {
        self.curve().samples.into()
    }
    /// Words common to all records; often empty.
    fn table(&self) -> &[u32];
    /// The values of the records `first .. first + count`, whose numbers share one upper half: record by record, and within a
    /// record first the sums of the squared differences by the places of the curve in the order of the levels.
    fn sums(&self, width: Width, first: u64, count: usize) -> Vec<u128>;
    /// Number of records that are quickest side by side.
    fn lanes(&self, width: Width) -> usize {
        width.lanes()
    }
    /// The same records with at most so many samples.
    fn shortened(&self, samples: u32) -> Arc<dyn Recorded>;
    /// The shader that makes these records, and whether it draws normal numbers.
    fn shader(&self, variant: Variant) -> (String, bool);
    /// The parameters of a dispatch of the shader, which covers the chunks `chunks[0] .. chunks[1]` of `lanes` records.
    fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32>;
    /// Words of a record's state that the shader keeps between dispatches.
    fn state_words(&self) -> usize;
    /// Largest number of loop rounds that a chunk takes in the shader.
    fn rounds(&self) -> usize;
}

/// What makes the angles of records.
pub(crate) trait Source: Recorded {
    /// State carried from chunk to chunk.
    type State<W: Word>;
    /// Philox key of the point.
    fn key(&self) -> [u32; 2];
    /// The state at the start of the records.
    fn begin<W: Word>(&self, address: Address<W>) -> Self::State<W>;
    /// Computes the angles of the chunk that starts at sample `first`.
    fn chunk<W: Word>(&self, state: &mut Self::State<W>, first: usize, angles: &mut Chunk);
    /// Appends the values of a lane besides its sums, at the end of the record.
    // Only here: the shader of a kernel that has others keeps them where it makes them.
    #[inline(always)]
    fn others<W: Word>(&self, _state: &Self::State<W>, _lane: usize, _to: &mut Vec<u128>) {}

    /// See [`Recorded::sums`]. A lone record is made in one lane, which is quicker than one of several.
    fn sums_of(&self, width: Width, first: u64, count: usize) -> Vec<u128>
    where
        Self: Sized,
    {
        let width = if count == 1 { Width::PORTABLE } else { width };
        width.run(Records { source: self, first, count })
    }

    /// Computes the sums of [`sums_of`](Source::sums_of) with twice as many records side by side, which is quicker where each step waits
    /// for the one before.
    fn sums_in_pairs(&self, width: Width, first: u64, count: usize) -> Vec<u128>
    where
        Self: Sized,
    {
        if count <= width.lanes() {
            return self.sums_of(width, first, count);
        }
        width.run(InPairs(Records { source: self, first, count }))
    }
}

struct InPairs<'a, S>(Records<'a, S>);

impl<S: Source> AnyWidth for InPairs<'_, S> {
    type Output = Vec<u128>;

    // Only here: an invocation has one lane.
    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u128> {
        self.0.run::<Pair<W>>()
    }
}

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

struct Records<'a, S> {
    source: &'a S,
    first: u64,
    count: usize,
}

impl<S: Source> AnyWidth for Records<'_, S> {
    type Output = Vec<u128>;

    // Only here: in the shader, `main` does the work of this function and of `records`.
    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u128> {
        let Records { source, first, count } = self;
        let keys = schedule(source.key().map(Scalar)).map(|key| key.map(|word| word.0));
        let mut sums = Vec::with_capacity(count * source.values());
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // Lanes beyond the last record compute records whose sums are discarded.
            let address = Address { low: W::splat(at as u32) + W::iota(), high: (at >> 32) as u32, keys };
            records::<W, S>(source, address, (count - done).min(W::LANES), &mut sums);
            done += W::LANES;
        }
        sums
    }
}

/// Makes one record per lane and appends the sums of the first `count` of them to `to`.
// Only here: see `run`.
#[inline(always)]
fn records<W: Word, S: Source>(source: &S, address: Address<W>, count: usize, to: &mut Vec<u128>) {
    let curve = source.curve();
    let mut state = source.begin(address);
    let mut rings: Vec<Ring> = curve
        .levels
        .iter()
        .map(|level| {
            let depth = level.depth(curve.order);
            Ring { stride: level.stride as usize, depth, words: vec![0; depth * W::LANES] }
        })
        .collect();
    let mut sums = vec![Sum::<W>::nothing(); curve.places()];
    let mut angles: Chunk = [0; MAX_LANES * CHUNK];
    let last = curve.samples as usize;
    for first in (0..=last).step_by(CHUNK) {
        source.chunk(&mut state, first, &mut angles);
        let count = CHUNK.min(last + 1 - first);
        let mut place = 0;
        for (level, ring) in curve.levels.iter().zip(&mut rings) {
            let newest = ring.push::<W>(first, count, &angles);
            for &span in &level.spans {
                let square = match curve.order {
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
        source.others(&state, lane, to);
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
