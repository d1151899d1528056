//! What a device needs to make synthetic records of a point and to take their Allan variances.

use std::sync::Arc;

/// Samples that are made at a time.
pub const CHUNK: usize = 64;

/// Octaves of flicker noise, the white one included: what `theory::allan::holds` has variances for.
pub const MAX_OCTAVES: usize = 30;

/// Streams of holds of most octaves.
pub const STREAMS: usize = 4;

/// The first octave with four streams.
pub const FOUR_STREAMS: usize = 3;

/// The first octave whose holds are as long as a chunk.
pub const LONG_HOLDS: usize = 6;

/// Angles at every `stride`-th sample, for the differences over some spans.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Level {
    /// In samples.
    pub stride: u32,
    /// Averaging factors in strides: m = span · stride.
    pub spans: Vec<u32>,
}

impl Level {
    /// Angles that are kept: as far back as the longest difference goes, and the chunk in work; whole chunks.
    pub fn depth(&self, order: u32) -> usize {
        let longest = self.spans.iter().max().copied().unwrap_or(0);
        (order as usize * longest as usize + CHUNK).next_multiple_of(CHUNK)
    }
}

/// Records of one point: parameters in fixed point. Angles are in LSB; the rate, that is the angle of one sample, in units of
/// 2^−32·`rate_scale` LSB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    /// Of the point: the key of Philox.
    pub key: [u32; 2],
    /// Samples N; there are N + 1 angles.
    pub samples: u32,
    /// White noise of the angle's increments, 2^−4 LSB.
    pub white: u32,
    /// One unit of the rate, 2^−32 LSB; at most 2^30.
    pub rate_scale: u32,
    /// Standard deviation of the step of the rate random walk, 2^−4 units of the rate.
    pub walk: u32,
    /// Standard deviations of the holds of octaves 1, 2, … of flicker noise in each stream, 2^−4 units of the rate. Octave 0
    /// is white and part of it.
    pub flicker: Vec<u32>,
    /// Markov noise: what it loses in a sample (2^−30, at most 2^30), standard deviations of its step and at the start (2^−2
    /// units of the rate).
    pub markov: Option<[u32; 3]>,
    /// Sine: phase of a sample (2^−32 turns), amplitude of the angle (2^−2 LSB).
    pub sine: Option<[u32; 2]>,
    /// Standard deviation of quantisation noise, 2^−4 LSB.
    pub quantisation: u32,
    /// log2 of the LSB in a pulse, where whole pulses are read.
    pub pulse: Option<u32>,
    /// Fill residuals of a gyro that switches modes: samples between switches, amplitude of the part with a random phase
    /// (2^−2 LSB), standard deviation of the rest (2^−4 LSB).
    pub switching: Option<[u32; 3]>,
    /// The same angles in all records, LSB: ramp, warm-up and alternating drift; N + 1 of them, or none.
    pub drift: Arc<[u32]>,
    /// Order of the differences: 2, or 3 for Hadamard's.
    pub order: u32,
    /// Which angles are kept, for which differences.
    pub levels: Vec<Level>,
}

impl Recipe {
    /// Octaves of flicker noise, the white one included.
    pub fn octaves(&self) -> usize {
        if self.flicker.is_empty() { 0 } else { self.flicker.len() + 1 }
    }

    /// Curves' places: averaging factors of all levels.
    pub fn places(&self) -> usize {
        self.levels.iter().map(|level| level.spans.len()).sum()
    }

    /// Differences that are averaged at each place, in the order of the levels.
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

    /// Words of angles that a lane keeps.
    pub fn depth(&self) -> usize {
        self.levels.iter().map(|level| level.depth(self.order)).sum()
    }
}
