//! The description from which a device makes synthetic records of a point and computes their Allan variances.

use std::sync::Arc;

use crate::curve::Recorded;
use crate::launch::{MAX_TABLE, Misfit};

/// Samples made at a time.
pub const CHUNK: usize = 64;

/// Octaves of flicker noise including the white one, for which `theory::allan::holds` has variances.
pub const MAX_OCTAVES: usize = 30;

/// Streams of holds of most octaves.
pub const STREAMS: usize = 4;

/// The first octave with four streams.
pub const FOUR_STREAMS: usize = 3;

/// The first octave whose holds are as long as a chunk.
pub(crate) const LONG_HOLDS: usize = 6;

/// Angles at every `stride`-th sample, kept for the differences over some spans.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Level {
    /// Distance of the angles in samples.
    pub stride: u32,
    /// Averaging factors in strides: m = span · stride.
    pub spans: Vec<u32>,
}

impl Level {
    /// Number of angles kept: as far back as the longest difference reaches, plus the chunk in work, in whole chunks.
    pub fn depth(&self, order: u32) -> usize {
        let longest = self.spans.iter().max().copied().unwrap_or(0);
        (order as usize * longest as usize + CHUNK).next_multiple_of(CHUNK)
    }
}

/// Records of one point, with parameters in fixed point. Angles are in LSB; the rate, which is the angle of one sample,
/// is in units of 2^−32·`rate_scale` LSB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    /// Philox key of the point.
    pub key: [u32; 2],
    /// Number of samples N; there are N + 1 angles.
    pub samples: u32,
    /// White noise of the angle's increments, 2^−4 LSB.
    pub white: u32,
    /// One unit of the rate, 2^−32 LSB; at most 2^30.
    pub rate_scale: u32,
    /// Standard deviation of the step of the rate random walk, 2^−4 units of the rate.
    pub walk: u32,
    /// Standard deviations of the holds of octaves 1, 2, … of flicker noise in each stream, 2^−4 units of the rate.
    /// Octave 0 is white and part of `white`.
    pub flicker: Vec<u32>,
    /// Markov noise: its loss per sample (2^−30, at most 2^30), and the standard deviations of its step and of its
    /// start (2^−2 units of the rate).
    pub markov: Option<[u32; 3]>,
    /// Sine: phase per sample (2^−32 turns) and amplitude of the angle (2^−2 LSB).
    pub sine: Option<[u32; 2]>,
    /// Standard deviation of quantization noise, 2^−4 LSB.
    pub quantization: u32,
    /// log2 of the LSB per pulse, where whole pulses are read.
    pub pulse: Option<u32>,
    /// Fill residuals of a gyro that switches modes: samples between switches, amplitude of the part with a random
    /// phase (2^−2 LSB) and standard deviation of the rest (2^−4 LSB).
    pub switching: Option<[u32; 3]>,
    /// Angles common to all records, LSB, from ramp, warm-up and alternating drift; at least N + 1 of them, or
    /// none.
    pub drift: Arc<[u32]>,
    /// Order of the differences: 2, or 3 for the Hadamard variance.
    pub order: u32,
    /// The angles kept, with the differences that use them.
    pub levels: Vec<Level>,
}

impl Recipe {
    /// Checks that no record reads beyond its drift, its holds or the angles kept, whatever its random words.
    ///
    /// # Errors
    /// Names the field that would lead beyond them.
    pub fn fits(&self) -> Result<(), Misfit> {
        self.noise_fits()?;
        let spans = 1..=(MAX_TABLE / 4) as u32;
        first_unsound(&[
            ("order", (2..=3).contains(&self.order)),
            ("stride", self.levels.iter().all(|level| level.stride > 0)),
            ("levels", !self.levels.is_empty() && self.levels.iter().all(|level| !level.spans.is_empty())),
            ("spans", self.levels.iter().flat_map(|level| &level.spans).all(|span| spans.contains(span))),
        ])
    }

    /// Checks that no record reads beyond its drift or its holds, whatever its random words.
    ///
    /// # Errors
    /// Names the field that would lead beyond them.
    pub(crate) fn noise_fits(&self) -> Result<(), Misfit> {
        let angles = self.samples as usize + 1;
        if !self.drift.is_empty() && self.drift.len() < angles {
            return Err(Misfit::Table { expected: angles, found: self.drift.len() });
        }
        first_unsound(&[
            ("samples", angles <= MAX_TABLE),
            ("flicker", self.flicker.len() < MAX_OCTAVES),
            ("switching", self.switching.is_none_or(|[interval, ..]| interval > 0)),
            ("pulse", self.pulse.is_none_or(|bits| bits < 32)),
        ])
    }

    /// Ends the program where a record would read beyond what there is.
    pub(crate) fn assert_fits(&self) {
        if let Err(misfit) = self.fits() {
            panic!("the recipe of a record does not fit: {misfit}");
        }
    }

    /// Number of octaves of flicker noise, including the white one.
    pub fn octaves(&self) -> usize {
        if self.flicker.is_empty() { 0 } else { self.flicker.len() + 1 }
    }

    /// Number of places of the curve: the averaging factors of all levels.
    pub fn places(&self) -> usize {
        self.curve().places()
    }

    /// Number of differences averaged at each place, in the order of the levels.
    pub fn terms(&self) -> Vec<u64> {
        self.curve().terms()
    }

    /// Words of angles kept per lane.
    pub fn depth(&self) -> usize {
        self.curve().depth()
    }
}

/// Names the first of some fields that is unsound.
fn first_unsound(fields: &[(&'static str, bool)]) -> Result<(), Misfit> {
    fields.iter().find(|(_, sound)| !sound).map_or(Ok(()), |(name, _)| Err(Misfit::Field(name)))
}
