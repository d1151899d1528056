//! The description from which a device makes gyros with lock-in, and their shader.

use std::sync::Arc;

use crate::curve::{Curve, Recorded, Source};
use crate::lock_in::{KICKS, LOCK_IN_STATE, OTHER_VALUES, ROUND};
use crate::part;
use crate::recipe::{CHUNK, Level};
use crate::sealed::Sealed;
use crate::shader::{Part, Shader, Variant};
use crate::width::Width;

/// The angle that a gyro puts out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Readout {
    /// Without the dither.
    Stripped,
    /// With the dither.
    Dithered,
    /// With the dither, less its nominal angle.
    Demodulated,
}

/// Gyros of one point, with parameters in fixed point. Angles are in turns of the beat phase, which are pulses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LockIn {
    /// Philox key of the point.
    pub key: [u32; 2],
    /// Number of samples N; there are N + 1 angles.
    pub samples: u32,
    /// Rounds of [`ROUND`] steps from one sample to the next: 2^−32 of them, and whole ones, of which there is at least one.
    pub interval: [u32; 2],
    /// Rounds of a half-cycle.
    pub half: u32,
    /// The lock-in of a step, whose polynomial has these terms, in units of 2^−(32 + `fine`) turns.
    pub kick: [u32; KICKS],
    /// Bits of the lock-in beyond 2^−32 turns; below 32.
    pub fine: u32,
    /// What the integral has beyond the sum of steps at a sample, where the cosine of the phase is 1, in quarters of a unit of the
    /// lock-in and below 2^31; 0 where samples are not at zero crossings of the dither from below.
    pub end: u32,
    /// Input of a step at the start, 2^−64 turns.
    pub rate: u64,
    /// Change of the input of a step from half-cycle to half-cycle, 2^−64 turns.
    pub ramp: u64,
    /// Amplitude of the dither's angle in units of 2^−`amplitude_bits` turns, below 2^31; 0 without dither.
    pub amplitude: u32,
    /// Bits of the amplitude; from 2 to 32.
    pub amplitude_bits: u32,
    /// Standard deviations for each half-cycle of its amplitude, and of the step of the amplitude's random walk, 2^−4 units.
    pub amplitude_noise: [u32; 2],
    /// Standard deviation of the dither's phase at a reversal, 2^−36 turns.
    pub phase_noise: u32,
    /// Standard deviation for each half-cycle of the white phase noise of the beam, 2^−4 units of the lock-in.
    pub beam: u32,
    /// log2 of the units of the lock-in in an LSB of the angle; below 32.
    pub lsb: u32,
    /// The angle that is put out, and for angles with the dither log2 of the units of 2^−(`amplitude_bits` − 2) turns in an LSB,
    /// below 32.
    pub readout: Readout,
    /// See `readout`.
    pub dither_lsb: u32,
    /// Phase of the dither from one sample to the next, 2^−64 turns.
    pub sample_phase: u64,
    /// Samples of the first and of the last third, whose angles are summed.
    pub third: u32,
    /// For each step of a half-cycle the sine at its middle, in units of 2^−31, below 2^31; the phase there, if it has noise; and
    /// for each half-cycle of the record the input of a step besides the rate, 2^−32 turns, if there is one.
    pub table: Arc<[u32]>,
    /// Whether the table has the input.
    pub motion: bool,
    /// Order of the differences: 2, or 3 for the Hadamard variance.
    pub order: u32,
    /// The angles kept, with the differences that use them.
    pub levels: Vec<Level>,
}

impl Sealed for LockIn {}

impl LockIn {
    /// Ends the program where a gyro would read beyond the table, or turn in a loop without end.
    pub(crate) fn assert_fits(&self) {
        let halves = self.half_cycles() as usize;
        let table = self.motion_start() + if self.motion { halves } else { 0 };
        let sound = self.interval[1] > 0
            && self.half > 0
            && self.fine < 32
            && self.end < 1 << 31
            && self.lsb < 32
            && self.dither_lsb < 32
            && (2..=32).contains(&self.amplitude_bits)
            && self.third <= self.samples
            && (2..=3).contains(&self.order)
            && !self.levels.is_empty()
            && self
                .levels
                .iter()
                .all(|level| level.stride > 0 && !level.spans.is_empty() && !level.spans.contains(&0));
        assert!(sound, "the words of a gyro with lock-in do not fit: {self:?}");
        assert!(table <= self.table.len(), "a gyro reads {table} words of a table of {}", self.table.len());
    }

    /// Half-cycles of a record, with the one that begins after its last step and those of a chunk that is not full.
    pub fn half_cycles(&self) -> u64 {
        let interval = u64::from(self.interval[1]) + 1;
        (u64::from(self.samples) + 2) * interval / u64::from(self.half) + 2
    }

    /// The place of the input in the table.
    pub(crate) fn motion_start(&self) -> usize {
        let steps = self.half as usize * ROUND;
        match (self.amplitude, self.phase_noise) {
            (0, _) => 0,
            (_, 0) => steps,
            _ => 2 * steps,
        }
    }

    /// Whether half-cycles draw random words.
    pub(crate) fn is_random(&self) -> bool {
        self.amplitude_noise != [0; 2] || self.phase_noise > 0 || self.beam > 0
    }

    /// Words of a dispatch that precede the levels, by their names in the shader.
    fn fixed(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> [(&'static str, u32); 34] {
        let halves = |x: u64| [x as u32, (x >> 32) as u32];
        let ([rate_low, rate_high], [ramp_low, ramp_high]) = (halves(self.rate), halves(self.ramp));
        let [phase_low, phase_high] = halves(self.sample_phase);
        [
            ("key_0", self.key[0]),
            ("key_1", self.key[1]),
            ("samples", self.samples),
            ("interval_fraction", self.interval[0]),
            ("interval", self.interval[1]),
            ("half_rounds", self.half),
            ("kick_0", self.kick[0]),
            ("kick_1", self.kick[1]),
            ("kick_2", self.kick[2]),
            ("kick_3", self.kick[3]),
            ("fine", self.fine),
            ("end", self.end),
            ("rate_low", rate_low),
            ("rate_high", rate_high),
            ("ramp_low", ramp_low),
            ("ramp_high", ramp_high),
            ("amplitude", self.amplitude),
            ("amplitude_bits", self.amplitude_bits),
            ("amplitude_noise", self.amplitude_noise[0]),
            ("amplitude_walk", self.amplitude_noise[1]),
            ("phase_noise", self.phase_noise),
            ("beam", self.beam),
            ("lsb", self.lsb),
            ("dither_lsb", self.dither_lsb),
            ("sample_phase_low", phase_low),
            ("sample_phase_high", phase_high),
            ("third", self.third),
            ("motion_start", self.motion_start() as u32),
            ("low", first as u32),
            ("high", (first >> 32) as u32),
            ("lanes", lanes),
            ("chunk_from", chunks[0]),
            ("chunk_to", chunks[1]),
            ("steps", self.half * ROUND as u32),
        ]
    }
}

impl Recorded for LockIn {
    fn part(&self) -> &'static Part {
        &part::lock_in
    }

    fn curve(&self) -> Curve<'_> {
        Curve { samples: self.samples, order: self.order, levels: &self.levels }
    }

    fn values(&self) -> usize {
        self.curve().places() + OTHER_VALUES
    }

    fn steps(&self) -> u64 {
        let [fraction, whole] = self.interval.map(u128::from);
        let rounds = u128::from(self.samples) * ((whole << 32) + fraction);
        ((rounds * ROUND as u128) >> 32) as u64
    }

    fn table(&self) -> &[u32] {
        &self.table
    }

    fn sums(&self, width: Width, first: u64, count: usize) -> Vec<u128> {
        self.assert_fits();
        self.sums_in_pairs(width, first, count)
    }

    fn lanes(&self, width: Width) -> usize {
        2 * width.lanes()
    }

    fn shortened(&self, samples: u32) -> Arc<dyn Recorded> {
        let samples = self.samples.min(samples);
        Arc::new(LockIn { samples, third: self.third.min(samples), ..self.clone() })
    }

    fn shader(&self, variant: Variant) -> (String, bool) {
        let fields = self.fixed(0, 0, [0, 0]).map(|(name, _)| format!("    {name}: u32,\n")).concat();
        let mut parts = vec![&part::philox, &part::sine, &part::lock_in, &part::record, &part::curve];
        // The table of normal numbers is bound only where the shader reads it.
        if self.is_random() {
            parts.push(&part::normal);
        }
        let shader = Shader {
            parts,
            constants: self.curve().constants().to_vec(),
            flags: vec![
                ("TABLE", !self.table.is_empty()),
                ("DITHER", self.amplitude > 0),
                ("RANDOM", self.is_random()),
                ("AMPLITUDE_NOISE", self.amplitude_noise[0] > 0),
                ("AMPLITUDE_WALK", self.amplitude_noise[1] > 0),
                ("PHASE_NOISE", self.phase_noise > 0),
                ("BEAM", self.beam > 0),
                ("MOTION", self.motion),
                ("ENDS", self.end > 0),
                ("DITHERED", self.readout != Readout::Stripped),
                ("DEMODULATED", self.readout == Readout::Demodulated),
                ("THIRD_ORDER", self.order == 3),
            ],
            declarations: format!("struct Parameters {{\n{fields}{}}}\n", self.curve().declarations()),
        };
        (shader.text(variant), shader.has_normals())
    }

    fn parameters(&self, first: u64, lanes: u32, chunks: [u32; 2]) -> Vec<u32> {
        self.assert_fits();
        let mut words: Vec<u32> =
            self.fixed(first, lanes, chunks).into_iter().map(|(_, word)| word).collect();
        words.resize(words.len().next_multiple_of(4), 0);
        self.curve().parameters(&mut words);
        words
    }

    fn state_words(&self) -> usize {
        LOCK_IN_STATE
    }

    fn rounds(&self) -> usize {
        let interval = self.interval[1] as usize + 1;
        self.curve().rounds() + CHUNK * (interval + interval.div_ceil(self.half as usize) + 2)
    }
}
