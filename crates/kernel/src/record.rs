//! What all kernels of records share: the exact sums of a record, one at each place, which carry over from chunk to chunk.
//!
//! Twin of `shaders/record.wgsl`. The terms of a chunk are summed in 64 bits, those of a record in 96.

use crate::curve::MAX_LANES;
use crate::recipe::CHUNK;
use crate::shader::constants;
use crate::word::{Wide, Word};

constants!(CHUNK, SUM_WORDS);

/// Words of a sum.
pub const SUM_WORDS: usize = 3;

/// The sum at one place, kept as the sums of the lower and upper halves of its terms.
#[derive(Clone, Copy)]
pub(crate) struct Sum<W: Word> {
    halves: [W::Wide; 2],
}

impl<W: Word> Sum<W> {
    // Only here: sums are words of a buffer in the shader, which starts with zeros.
    #[inline(always)]
    pub(crate) fn nothing() -> Sum<W> {
        Sum { halves: [W::Wide::splat(0); 2] }
    }

    /// Adds the terms of a chunk, read as unsigned.
    #[inline(always)]
    pub(crate) fn add(&mut self, terms: W::Wide) {
        let [low, high] = terms.halves();
        self.halves = [self.halves[0] + low, self.halves[1] + high];
    }

    // Only here: an invocation has one lane.
    #[inline(always)]
    pub(crate) fn of_lane(&self, lane: usize) -> u128 {
        let (mut low, mut high) = ([0; MAX_LANES], [0; MAX_LANES]);
        self.halves[0].store(&mut low[..W::LANES]);
        self.halves[1].store(&mut high[..W::LANES]);
        u128::from(low[lane]) + (u128::from(high[lane]) << 32)
    }
}
