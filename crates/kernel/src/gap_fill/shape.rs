//! The shape of a launch of the gap-fill kernel, and its parameter words.
//!
//! The table holds the weights of the errors in the gap, followed by the factor of the Gaussian motion or by the
//! profile: its angles since the start in LSB at the boundaries of its ticks. It is often empty.

use crate::launch::{self, MAX_TABLE, Misfit};
use crate::moments::MAX_ESTIMATES;
use crate::parameters::parameters;
use crate::part;
use crate::sealed::Sealed;
use crate::shader::{Part, Shader};

/// Most ticks on one side of the gap.
pub const MAX_SIDE: usize = 64;

/// Most tones of a motion.
pub const MAX_TONES: usize = 8;

/// Ticks of a recorded profile that are kept free on either side of the gap whatever the fillers read, so that another
/// filler moves no trial to another place.
pub const MARGIN: usize = MAX_SIDE;

/// Sizes and options of a launch, for which its shader is specialized.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Ticks sampled before the gap: the larger of the next two.
    pub before: usize,
    /// Ticks sampled after the gap.
    pub after: usize,
    /// Ticks before the gap that the residual uses.
    pub residual_before: usize,
    /// Ticks before the gap that the extrapolation and the error in the gap use.
    pub extrapolation_before: usize,
    /// Fillers; a launch has at most [`MAX_ESTIMATES`] errors of them.
    pub fillers: usize,
    /// Whether each filler has a residual.
    pub residual: bool,
    /// Whether each filler has an error at the end of the gap, before it is closed.
    pub extrapolation: bool,
    /// Whether each filler has an error in the gap, the largest while the gap is open.
    pub in_gap: bool,
    /// Whether weighted sums need 64 bits, as with large weights; the usual polynomials do not.
    pub wide: bool,
    /// Length of the gap where the shape depends on it, else 0; see [`Shape::rows`].
    pub gap_ticks: usize,
    /// Sines of the motion, at most 8.
    pub tones: usize,
    /// Whether amplitudes of tones are drawn.
    pub amplitudes: bool,
    /// Whether frequencies of tones are drawn.
    pub frequencies: bool,
    /// Whether there is stationary Gaussian motion.
    pub gaussian: bool,
    /// Whether the motion is a recorded profile.
    pub profile: bool,
    /// Whether trials take the places of the profile in turn instead of at random.
    pub every: bool,
    /// Whether the motion has a part common to all trials: a constant rate or acceleration, or relock.
    pub constants: bool,
    /// Whether the readout gives whole pulses.
    pub readout: bool,
}

impl Shape {
    /// Ticks on the longer side of the gap.
    #[inline]
    pub fn sides(self) -> usize {
        self.before.max(self.after)
    }

    /// Number of true angles needed: the one over the whole gap and, for errors in the gap, those over its first ticks.
    #[inline]
    pub fn rows(self) -> usize {
        if self.in_gap { self.gap_ticks } else { 1 }
    }

    /// Index in the table where the weights of the errors in the gap end and the data of the motion begin.
    #[inline]
    pub fn motion_table(self) -> usize {
        if self.in_gap { self.fillers * self.gap_ticks * self.extrapolation_before } else { 0 }
    }

    /// Normal numbers of the Gaussian motion: one for each tick of the gap, then one for each tick on either side.
    #[inline]
    pub fn gaussians(self) -> usize {
        self.gap_ticks + 2 * self.sides()
    }

    /// Index in the table of the row of a place on the side, with places counted as in [`Shape::gaussians`].
    #[inline]
    pub fn gaussian_row(self, place: usize) -> usize {
        let n = self.gap_ticks;
        // The rows over the gap come first, then a triangle whose row i has i + 1 words.
        self.motion_table() + self.rows() * n + (place * (place + 1) - n * (n + 1)) / 2
    }
}

impl Sealed for Shape {}

impl launch::Shape for Shape {
    fn part(&self) -> &'static Part {
        &part::gap_fill
    }

    /// All residuals, then all extrapolations, then all errors in the gap.
    #[inline(always)]
    fn estimates(&self) -> usize {
        let errors = usize::from(self.residual) + usize::from(self.extrapolation) + usize::from(self.in_gap);
        self.fillers * errors
    }

    fn has_table(&self) -> bool {
        self.in_gap || self.gaussian || self.profile
    }

    fn table_words(&self, words: &[u32]) -> Result<usize, Misfit> {
        let most = [
            ("before", self.before, MAX_SIDE),
            ("after", self.after, MAX_SIDE),
            ("residual_before", self.residual_before, self.before),
            ("extrapolation_before", self.extrapolation_before, self.before),
            ("gap_ticks", self.gap_ticks, MAX_SIDE),
            ("tones", self.tones, MAX_TONES),
            ("fillers", self.fillers, MAX_ESTIMATES),
        ];
        if let Some((name, ..)) = most.iter().find(|(_, size, most)| size > most) {
            return Err(Misfit::Field(name));
        }
        let start = self.motion_table();
        if self.gaussian {
            return Ok(self.gaussian_row(self.gaussians()));
        }
        if !self.profile {
            return Ok(start);
        }
        let p = Parameters::new(words, *self);
        let (positions, length) = (p.positions[0], p.gap_length[0]);
        if positions == 0 || positions as usize > MAX_TABLE {
            return Err(Misfit::Field("positions"));
        }
        if length as usize > MAX_TABLE {
            return Err(Misfit::Field("gap_length"));
        }
        // With this inverse the quotient in `in_turn` is too small by one at most.
        if self.every && p.positions_inverse[0] != u32::MAX / positions {
            return Err(Misfit::Field("positions_inverse"));
        }
        // The last boundary that is read: that after the farthest tick, or the end of the gap. The first is at least 0,
        // because no side has more ticks than the margin.
        let beyond = (length as usize + self.sides()).max(self.gap_ticks);
        Ok(start + (positions as usize - 1) + MARGIN + beyond + 1)
    }

    fn words(&self) -> usize {
        word_count(*self)
    }

    fn shader(&self) -> Shader {
        let (residuals, extrapolations) =
            (only(self.residual, self.fillers), only(self.extrapolation, self.fillers));
        Shader {
            parts: vec![&part::philox, &part::normal, &part::sine, &part::motion, &part::gap_fill],
            constants: vec![
                ("BEFORE", self.before),
                ("AFTER", self.after),
                ("SIDES", self.sides()),
                ("RESIDUAL_BEFORE", self.residual_before),
                ("EXTRAPOLATION_BEFORE", self.extrapolation_before),
                ("FILLERS", self.fillers),
                ("EXTRAPOLATIONS", residuals),
                ("IN_GAPS", residuals + extrapolations),
                ("KEPT", if self.in_gap { self.before } else { 1 }),
                ("TONES", self.tones),
                // An array must have at least one element.
                ("TONE_ROOM", self.tones.max(1)),
                ("ROWS", self.rows()),
                ("GAP_TICKS", self.gap_ticks),
                ("GAUSSIANS", self.gaussians()),
                ("GAUSSIAN_SIDES", self.gaussian_row(self.gap_ticks)),
                ("MOTION_TABLE", self.motion_table()),
            ],
            flags: vec![
                ("WIDE", self.wide),
                ("RESIDUAL", self.residual),
                ("EXTRAPOLATION", self.extrapolation),
                ("IN_GAP", self.in_gap),
                ("AMPLITUDES", self.amplitudes),
                ("FREQUENCIES", self.frequencies),
                ("DRAWN", self.amplitudes || self.frequencies),
                ("GAUSSIAN", self.gaussian),
                ("PROFILE", self.profile),
                ("EVERY", self.every),
                ("CONSTANTS", self.constants),
                ("READOUT", self.readout),
            ],
            declarations: wgsl_places(*self),
        }
    }
}

/// `count` where `wanted`, else 0.
#[inline(always)]
fn only(wanted: bool, count: usize) -> usize {
    if wanted { count } else { 0 }
}

parameters! {
    /// Key of the random words.
    key: |_| 2,
    /// Phase of each tone at the middle of the gap without the random part, in 2^−32 turns.
    phase: |shape: Shape| shape.tones,
    /// Mask of the bits of the random phase that are added: all of them or none.
    phase_spread: |shape: Shape| shape.tones,
    /// Standard deviation of the tick noise, in 2^−4 LSB.
    sigma: |_| 1,
    /// The angle of each tone over the gap, row by row, at sine 1 of the phase at its middle, in 2^−2 LSB.
    gap_sin: |shape: Shape| only(!shape.frequencies, shape.rows() * shape.tones),
    /// The angle of each tone over the gap at cosine 1, laid out as `gap_sin`; over the whole gap it is 0.
    gap_cos: |shape: Shape| only(!shape.frequencies && shape.in_gap, shape.rows() * shape.tones),
    /// The angle of the k-th tick on either side at sine 1, tone by tone; it is the same on both sides.
    side_sin: |shape: Shape| only(!shape.frequencies, shape.sides() * shape.tones),
    /// The angle of the k-th tick after the gap at cosine 1; before the gap it has the opposite sign.
    side_cos: |shape: Shape| only(!shape.frequencies, shape.sides() * shape.tones),
    /// Least amplitude of each tone as a fraction of its largest, in 2^−31.
    amplitude_low: |shape: Shape| only(shape.amplitudes, shape.tones),
    /// Width of the range of that fraction, in 2^−31.
    amplitude_width: |shape: Shape| only(shape.amplitudes, shape.tones),
    /// All bits set where the amplitude is Rayleigh-distributed, else none.
    rayleigh: |shape: Shape| only(shape.amplitudes, shape.tones),
    /// Largest angle of a tick at frequency 0, times 2/π, in 2^−5 LSB; twice that where the amplitude is an angle.
    peak: |shape: Shape| only(shape.frequencies, shape.tones),
    /// Least frequency of each tone over its scale in turns per half tick, in 2^−32.
    frequency_low: |shape: Shape| only(shape.frequencies, shape.tones),
    /// Width of the range of that ratio, in 2^−32.
    frequency_width: |shape: Shape| only(shape.frequencies, shape.tones),
    /// The scale of the frequency, a power of two: the ratio stays within a quarter of a turn, or half a turn where the amplitude
    /// is that of the angle.
    frequency_scale: |shape: Shape| only(shape.frequencies, shape.tones),
    /// All bits set where the amplitude is that of the angle, else none.
    of_angle: |shape: Shape| only(shape.frequencies, shape.tones),
    /// Length of the gap n, in ticks.
    gap_length: |_| 1,
    /// The part of the angle over the gap that is common to all trials, row by row, in 2^−32 LSB, two words each.
    gap_constant: |shape: Shape| only(shape.constants, 2 * shape.rows()),
    /// The part of the angle of each tick before the gap that is common to all trials, outward, as in `gap_constant`.
    before_constant: |shape: Shape| only(shape.constants, 2 * shape.before),
    /// The part of the angle of each tick after the gap that is common to all trials, outward, as in `gap_constant`.
    after_constant: |shape: Shape| only(shape.constants, 2 * shape.after),
    /// Number of places that the gap can have in the profile.
    positions: |shape: Shape| only(shape.profile, 1),
    /// 2^32 divided by that number.
    positions_inverse: |shape: Shape| only(shape.profile, 1),
    /// Mask of the bits of an angle that make up whole pulses.
    readout_mask: |shape: Shape| only(shape.readout, 1),
    /// Standard deviation of the noise over the whole gap, in 2^−4 LSB.
    gap_sigma: |shape: Shape| only(shape.readout, 1),
    /// Weights of the residual, filler by filler: ticks before, then after, each outward from the gap.
    residual_weight: |shape: Shape| only(shape.residual, shape.fillers * (shape.residual_before + shape.after)),
    /// Denominator D of each filler, by which the angle over the gap is multiplied.
    residual_scale: |shape: Shape| only(shape.residual, shape.fillers),
    /// Weights of the extrapolation, filler by filler, outward from the gap.
    extrapolation_weight: |shape: Shape| only(shape.extrapolation, shape.fillers * shape.extrapolation_before),
    /// Denominator D of each filler's extrapolation.
    extrapolation_scale: |shape: Shape| only(shape.extrapolation, shape.fillers),
    /// Denominator D of each filler's errors in the gap. Their weights are in the table: filler by filler, row by row,
    /// outward.
    in_gap_scale: |shape: Shape| only(shape.in_gap, shape.fillers),
    /// Number of bits by which each wide sum is shifted right, with rounding, in the order of the estimates.
    shift: |shape: Shape| only(shape.wide, launch::Shape::estimates(&shape)),
    /// Level at which each estimate's histogram starts.
    bin_base: |shape: Shape| launch::Shape::estimates(&shape),
}
