//! Angles of synthetic records, of which devices make segments side by side.
//!
//! Twin of `shaders/samples.wgsl`. `noise` makes the angles. A segment is a run of whole chunks, which follows from its place in
//! the record and from the sums that the record has reached at its start ([`Sums`]). All of these but the Markov noise are those
//! of its start plus what a segment that starts with zeros has at its end, to the bit. The angle needs the others, so a device
//! makes the segments of a block up to three times: for the sums of walk and fill residuals, for the angle, and for the angles.

use std::sync::Arc;

use crate::curve::{Chunk, Curve, MAX_LANES, Recorded};
use crate::noise::Noise;
use crate::philox::Address;
use crate::recipe::{CHUNK, Recipe};
use crate::record::SUM_WORDS;
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, Variant, constants};
use crate::width::Width;
use crate::word::{Scalar, ScalarWide};
use crate::{Form, part};

constants!(SUMS_WORDS);

/// Maps segments to their angles, or to the sums at their ends.
pub const FORM: Form = Form::Records;

/// Words of the sums at the start of a segment.
const SUMS_WORDS: usize = 8;

/// The sums of a record before a sample: the angle (2^−32 LSB), the random walk (2^−32 units of the rate), the Markov noise
/// (2^−30 units) and the fill residuals (2^−32 LSB).
pub type Sums = [i64; SUMS_WORDS / 2];

/// The place of the angle in [`Sums`].
pub const ANGLE: usize = 0;
/// The place of the random walk.
pub const WALK: usize = 1;
/// The place of the Markov noise.
pub const MARKOV: usize = 2;
/// The place of the fill residuals.
pub const RESIDUALS: usize = 3;

/// Consecutive segments of a record. As a device numbers them, those of the next record follow, with the same sums at their starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segments {
    recipe: Recipe,
    record: u64,
    /// First chunk of the first segment.
    from: u32,
    /// Chunks of a segment.
    chunks: u32,
    /// Whether the results are the angles of the segments, instead of the sums at their ends.
    has_angles: bool,
    /// Sums at the starts, [`SUMS_WORDS`] words each.
    starts: Vec<u32>,
}

impl Segments {
    /// Segments of `chunks` chunks of the record `record` from the chunk `from` on, with the sums at their starts. The angles are
    /// those before drift is added and whole pulses are read.
    ///
    /// # Panics
    /// There are no segments, or the recipe does not [fit](Recipe::fits).
    pub fn new(
        recipe: &Recipe,
        record: u64,
        from: u32,
        chunks: u32,
        starts: &[Sums],
        has_angles: bool,
    ) -> Segments {
        recipe.assert_fits();
        assert!(chunks > 0 && !starts.is_empty(), "there is no segment");
        let starts = starts.iter().flatten().flat_map(|&sum| halves(sum)).collect();
        Segments { recipe: recipe.unread(), record, from, chunks, has_angles, starts }
    }

    /// The words of each segment in the results of a device: its angles, LSB modulo 2^32, or two for each of the sums at its end.
    pub fn words(&self, values: &[u128]) -> impl Iterator<Item = u32> {
        let words = |&value: &u128| (0..SUM_WORDS).map(move |word| (value >> (32 * word)) as u32);
        values.chunks(self.values()).flat_map(move |of_one| of_one.iter().flat_map(words).take(self.length()))
    }

    /// The sums at the end of each segment in the results of a device for segments without angles.
    pub fn ends(&self, values: &[u128]) -> Vec<Sums> {
        let words: Vec<u32> = self.words(values).collect();
        let (sums, _) = words.as_chunks::<SUMS_WORDS>();
        sums.iter().map(sums_of).collect()
    }

    /// Words of a segment in the results.
    fn length(&self) -> usize {
        if self.has_angles { self.chunks as usize * CHUNK } else { SUMS_WORDS }
    }

    /// Makes a segment, and gives its angles, or the sums at its end.
    fn segment(&self, number: u64) -> Vec<u32> {
        let (starts, _) = self.starts.as_chunks::<SUMS_WORDS>();
        let place = (number % starts.len() as u64) as usize;
        let record = self.record + number / starts.len() as u64;
        let base = self.from as usize + place * self.chunks as usize;
        let address = Address::new(self.recipe.key, record);
        let mut noise = Noise::<Scalar>::begin_at(&self.recipe, address, base * CHUNK);
        for (sum, start) in noise.sums().into_iter().zip(sums_of(&starts[place])) {
            *sum = ScalarWide(start);
        }
        let mut angles: Chunk = [0; MAX_LANES * CHUNK];
        let mut words = vec![];
        for c in 0..self.chunks as usize {
            noise.chunk(&self.recipe, (base + c) * CHUNK, &mut angles);
            if self.has_angles {
                words.extend(&angles[..CHUNK]);
            }
        }
        if !self.has_angles {
            words.extend(noise.sums().into_iter().flat_map(|sum| halves(sum.0)));
        }
        words
    }
}

fn halves(sum: i64) -> [u32; 2] {
    [sum as u32, (sum >> 32) as u32]
}

fn sums_of(words: &[u32; SUMS_WORDS]) -> Sums {
    core::array::from_fn(|at| (u64::from(words[2 * at]) | u64::from(words[2 * at + 1]) << 32) as i64)
}

impl Sealed for Segments {}

impl Recorded for Segments {
    fn part(&self) -> &'static Part {
        &part::samples
    }

    fn curve(&self) -> Curve<'_> {
        Curve { samples: self.chunks * CHUNK as u32 - 1, order: 2, levels: &[] }
    }

    fn values(&self) -> usize {
        self.length().div_ceil(SUM_WORDS)
    }

    fn table(&self) -> &[u32] {
        &self.starts
    }

    /// Each segment is made in one lane of any width, because the lanes of a word would have to be at the same sample.
    fn sums(&self, _width: Width, first: u64, count: usize) -> Vec<u128> {
        let value = |words: &[u32]| words.iter().rev().fold(0, |value, &word| value << 32 | u128::from(word));
        let numbers = first..first + count as u64;
        numbers
            .flat_map(|number| self.segment(number).chunks(SUM_WORDS).map(value).collect::<Vec<_>>())
            .collect()
    }

    fn shortened(&self, samples: u32) -> Arc<dyn Recorded> {
        let chunks = self.chunks.min(samples / CHUNK as u32).max(1);
        Arc::new(Segments { chunks, ..self.clone() })
    }

    fn shader(&self, variant: Variant) -> (String, bool) {
        let flags = vec![("TABLE", true), ("ANGLES", self.has_angles)];
        let mut shader = Shader { flags, ..Shader::default() };
        self.recipe.include(&mut shader, "    segments: vec4<u32>,\n");
        shader.parts.push(&part::samples);
        (shader.text(variant), shader.has_normals())
    }

    fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        let count = (self.starts.len() / SUMS_WORDS) as u64;
        let mut words = self.recipe.words(self.record + first / count, lanes, chunks);
        words.extend([(first % count) as u32, count as u32, self.from, self.chunks]);
        words
    }

    fn state_words(&self) -> usize {
        self.recipe.noise_words()
    }

    fn rounds(&self) -> usize {
        18 * CHUNK + 8 * self.recipe.octaves()
    }
}

/// The Markov noise of a record at the starts of its segments. A step depends on how the one before was rounded, so that no device
/// can make them side by side.
pub struct Markov {
    recipe: Recipe,
    noise: Noise<Scalar>,
    chunk: usize,
}

impl Markov {
    /// The Markov noise of the record `number`; `None` where it has none.
    pub fn new(recipe: &Recipe, number: u64) -> Option<Markov> {
        recipe.markov?;
        let (flicker, sine, switching) = (vec![], None, None);
        let recipe =
            Recipe { white: 0, walk: 0, flicker, sine, quantization: 0, switching, ..recipe.unread() };
        let noise = Noise::begin(&recipe, Address::new(recipe.key, number));
        Some(Markov { recipe, noise, chunk: 0 })
    }

    /// The Markov noise now, and goes on by `chunks` chunks.
    pub fn next(&mut self, chunks: u32) -> i64 {
        let state = self.noise.sums()[MARKOV].0;
        let mut angles: Chunk = [0; MAX_LANES * CHUNK];
        for _ in 0..chunks {
            self.noise.chunk(&self.recipe, self.chunk * CHUNK, &mut angles);
            self.chunk += 1;
        }
        state
    }
}
