//! Allan variances of synthetic records of a gyro at rest.
//!
//! Twin of `shaders/allan.wgsl`. `noise` makes the angles, `curve` the sums of their squared differences.

use std::sync::Arc;

use crate::curve::{Chunk, Curve, MAX_LANES, Recorded, Source};
use crate::noise::Noise;
use crate::philox::{Address, Purpose};
use crate::recipe::{CHUNK, Recipe, STREAMS};
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, Variant, constants};
use crate::width::Width;
use crate::word::Word;
use crate::{Form, part};

constants!(STATE_WORDS, HOLD_WORDS);

/// Maps records to the sums of their squared differences.
pub const FORM: Form = Form::Records;

/// Words of a record's state, without those of its holds.
const STATE_WORDS: usize = 11;

/// Words of a hold.
const HOLD_WORDS: usize = 3;

/// Raised when the kernel's results change for the same parameters: part of every digest.
pub const VERSION: u32 = 2;

impl Sealed for Recipe {}

impl Source for Recipe {
    type State<W: Word> = Noise<W>;

    fn key(&self) -> [u32; 2] {
        self.key
    }

    // Only here: the shader calls that of noise.wgsl.
    #[inline(always)]
    fn begin<W: Word>(&self, address: Address<W>) -> Noise<W> {
        Noise::begin(self, address)
    }

    // Only here: the shader calls that of noise.wgsl.
    #[inline(always)]
    fn chunk<W: Word>(&self, noise: &mut Noise<W>, first: usize, angles: &mut Chunk) {
        noise.chunk(self, first, angles);
    }
}

impl Recorded for Recipe {
    fn part(&self) -> &'static Part {
        &part::allan
    }

    fn curve(&self) -> Curve<'_> {
        Curve { samples: self.samples, order: self.order, levels: &self.levels }
    }

    fn table(&self) -> &[u32] {
        &self.drift
    }

    fn sums(&self, width: Width, first: u64, count: usize) -> Vec<u128> {
        self.assert_fits();
        self.sums_of(width, first, count)
    }

    fn shortened(&self, samples: u32) -> Arc<dyn Recorded> {
        Arc::new(Recipe { samples: self.samples.min(samples), ..self.clone() })
    }

    fn shader(&self, variant: Variant) -> (String, bool) {
        let mut shader = Shader {
            constants: self.curve().constants().to_vec(),
            flags: vec![("THIRD_ORDER", self.order == 3), ("TABLE", !self.drift.is_empty())],
            ..Shader::default()
        };
        self.include(&mut shader, &self.curve().declarations());
        shader.parts.push(&part::curve);
        (shader.text(variant), shader.has_normals())
    }

    fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        self.assert_fits();
        let mut words = self.words(first, lanes, chunks);
        self.curve().parameters(&mut words);
        words
    }

    fn state_words(&self) -> usize {
        self.noise_words()
    }

    fn rounds(&self) -> usize {
        self.curve().rounds() + 16 * CHUNK + 8 * self.octaves()
    }
}

impl Recipe {
    /// The angles of the record `number` at its N + 1 samples, LSB modulo 2^32, in their order: those whose differences
    /// [`sums`](Recorded::sums) adds up.
    ///
    /// # Panics
    /// The recipe does not [fit](Recipe::fits).
    pub fn angles(&self, number: u64) -> impl Iterator<Item = u32> + use<> {
        self.assert_fits();
        let recipe = self.clone();
        let mut noise = recipe.begin(Address::new(recipe.key, number));
        let mut chunk: Chunk = [0; MAX_LANES * CHUNK];
        let angles = recipe.samples as usize + 1;
        let chunks = (0..angles).step_by(CHUNK).flat_map(move |first| {
            recipe.chunk(&mut noise, first, &mut chunk);
            let (words, _) = chunk.as_chunks::<CHUNK>();
            words[0]
        });
        chunks.take(angles)
    }

    /// The recipe of the angles before drift is added and whole pulses are read.
    pub fn unread(&self) -> Recipe {
        Recipe { pulse: None, drift: Arc::new([]), ..self.clone() }
    }

    /// The angle in a pulse at which the reading of the record `number` starts; 0 where no whole pulses are read.
    pub fn start(&self, number: u64) -> u32 {
        let start = Address::new(self.key, number).draw(Purpose::RecordStart, 0)[0].0;
        self.pulse.map_or(0, |bits| start & ((1 << bits) - 1))
    }

    /// Adds the noise to a shader: its files, sizes and options, and its parameters, which `fields` follow.
    pub(crate) fn include(&self, shader: &mut Shader, fields: &str) {
        let octaves = self.octaves();
        let words = self.fixed(0, 0, [0, 0]).map(|(name, _)| format!("    {name}: u32,\n")).concat();
        let vectors = self.flicker_vectors();
        let parts = [&part::philox, &part::normal, &part::sine, &part::noise, &part::allan, &part::record];
        shader.parts.extend(parts);
        shader.constants.extend([("OCTAVES", octaves), ("HOLD_ROOM", STREAMS * octaves.max(1))]);
        shader.flags.extend([
            ("FLICKER_HOLDS", octaves > 1),
            ("WALK_STEPS", self.walk > 0),
            ("MARKOV_STEPS", self.markov.is_some()),
            ("SINE_WAVE", self.sine.is_some()),
            ("QUANTIZATION_NOISE", self.quantization > 0),
            ("PULSE", self.pulse.is_some()),
            ("DRIFT", !self.drift.is_empty()),
            ("FILL_RESIDUALS", self.switching.is_some()),
        ]);
        shader.declarations +=
            &format!("struct Parameters {{\n{words}    flicker: array<vec4<u32>, {vectors}>,\n{fields}}}\n");
    }

    /// The parameters of the noise in a dispatch, in whole vectors of four words.
    pub(crate) fn words(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        let mut words: Vec<u32> =
            self.fixed(first, lanes, chunks).into_iter().map(|(_, word)| word).collect();
        words.resize(words.len().next_multiple_of(4), 0);
        let flicker = words.len();
        // Octave 0 has no hold.
        words.push(0);
        words.extend(&self.flicker);
        words.resize(flicker + 4 * self.flicker_vectors(), 0);
        words
    }

    /// Words of the noise's state that a shader keeps between dispatches.
    pub(crate) fn noise_words(&self) -> usize {
        STATE_WORDS + HOLD_WORDS * STREAMS * self.octaves()
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
            ("quantization", self.quantization),
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
}
