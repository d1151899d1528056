//! Allan variances of synthetic records: exact sums of the squared differences of their angles.
//!
//! Twin of `shaders/allan.wgsl`. The angle wraps in 32 bits: only its differences have to fit, below 2^29, which lowering
//! proves. Squares are added up in 64 bits for a chunk and in 96 for a record.

use crate::noise::{Chunk, Noise};
use crate::philox::{Address, schedule};
use crate::recipe::{CHUNK, Recipe};
use crate::width::{AnyWidth, Width};
use crate::word::{Scalar, Wide, Word};

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 2;

/// Angles of one level: the newest ones, as many as the longest difference reaches back, in a ring of whole chunks.
struct Ring {
    depth: usize,
    words: Vec<u32>,
}

/// The sums of one place of the curve, as the sums of lower and upper halves.
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

    #[inline(always)]
    fn run<W: Word>(self) -> Vec<u128> {
        let Records { recipe, first, count } = self;
        let keys = schedule(recipe.key.map(Scalar)).map(|key| key.map(|word| word.0));
        let mut sums = Vec::with_capacity(count * recipe.places());
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // Lanes beyond the last record make one that is not asked for.
            let address = Address { low: W::splat(at as u32) + W::iota(), high: (at >> 32) as u32, keys };
            records::<W>(recipe, address, (count - done).min(W::LANES), &mut sums);
            done += W::LANES;
        }
        sums
    }
}

/// As many records as there are lanes, the sums of the first `count` of them.
#[inline(always)]
fn records<W: Word>(recipe: &Recipe, address: Address<W>, count: usize, to: &mut Vec<u128>) {
    let mut noise = Noise::begin(recipe, address);
    let mut rings: Vec<Ring> = recipe
        .levels
        .iter()
        .map(|level| level.depth(recipe.order))
        .map(|depth| Ring { depth, words: vec![0; depth * W::LANES] })
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
            let range = ring.push::<W>(level.stride as usize, first, count, &angles);
            for &span in &level.spans {
                let square = match recipe.order {
                    2 => ring.squares::<W, 2>(span as usize, range),
                    _ => ring.squares::<W, 3>(span as usize, range),
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
    /// Takes the angles of a chunk at the multiples of `stride`; the first of them, counted in strides, and how many.
    #[inline(always)]
    fn push<W: Word>(&mut self, stride: usize, first: usize, count: usize, angles: &Chunk) -> [usize; 2] {
        let from = first.div_ceil(stride);
        let mut taken = 0;
        while (from + taken) * stride < first + count {
            let angle = W::load(&angles[((from + taken) * stride - first) * W::LANES..]);
            angle.store(&mut self.words[(from + taken) % self.depth * W::LANES..]);
            taken += 1;
        }
        [from, taken]
    }

    /// The sum of the squared differences of order `ORDER` over `span` strides that end at the angles of `range`.
    #[inline(always)]
    fn squares<W: Word, const ORDER: usize>(&self, span: usize, range: [usize; 2]) -> W::Wide {
        let mut sum = W::Wide::splat(0);
        let [from, count] = range;
        let start = from.max(ORDER * span);
        if start >= from + count {
            return sum;
        }
        let mut at = [0; 4];
        for (k, at) in at.iter_mut().enumerate() {
            *at = start.saturating_sub(k * span) % self.depth;
        }
        let mut left = from + count - start;
        while left > 0 {
            // To where the first of them comes to the end of the ring.
            let run = left.min(self.depth - at[0].max(at[1]).max(at[2]).max(at[3]));
            for i in 0..run {
                let first = self.angle::<W>(at[0] + i);
                let second = self.angle::<W>(at[1] + i);
                let third = self.angle::<W>(at[2] + i);
                let mut difference = first - second - (second - third);
                if ORDER == 3 {
                    let fourth = self.angle::<W>(at[3] + i);
                    difference = difference - (second - third - (third - fourth));
                }
                sum = sum + difference.mul_wide(difference);
            }
            for at in &mut at {
                *at = if *at + run == self.depth { 0 } else { *at + run };
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

    #[inline(always)]
    fn of_lane(&self, lane: usize) -> u128 {
        let (mut low, mut high) = ([0; 16], [0; 16]);
        self.halves[0].store(&mut low);
        self.halves[1].store(&mut high);
        u128::from(low[lane]) + (u128::from(high[lane]) << 32)
    }
}

/// Sums of the squared differences of the records `first .. first + count`, which have one upper half: record by record, in
/// each the places of the curve in the order of the levels.
pub fn sums(width: Width, recipe: &Recipe, first: u64, count: usize) -> Vec<u128> {
    width.run(Records { recipe, first, count })
}
