//! The shape of a launch of the switched-run kernel, its parameter words and its table.

use crate::launch::{self, MAX_STEPS, Misfit};
use crate::parameters::parameters;
use crate::sealed::Sealed;
use crate::shader::{Part, Shader};
use crate::{part, relock_ticks};

/// Most tones of the motion at a switch.
pub const MAX_TONES: usize = crate::gap_fill::shape::MAX_TONES;

/// Most intervals of a run of exactly the run time, each with a switch after it except the last.
pub const MAX_INTERVALS: usize = MAX_STEPS as usize;

/// log2 of [`ENDS`].
pub const END_BITS: u32 = 6;

/// Number of equally likely ends of a run whose end is drawn.
pub const ENDS: usize = 1 << END_BITS;

/// Sizes and options of a launch, for which its shader is specialized.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Whether the angle at the end and the largest one are estimated; they are the first two estimates.
    pub ends: bool,
    /// Number of further times at which the angle is estimated.
    pub times: usize,
    /// Whether there is an angle random walk.
    pub walk: bool,
    /// Whether residuals of switches have a normal part.
    pub noise: bool,
    /// Tones of which each switch leaves a sine, at most 8.
    pub tones: usize,
    /// Whether A differs from run to run.
    pub magnetic: bool,
    /// Whether Ω_m0 differs from run to run.
    pub initial: bool,
    /// Whether Ω_nm differs from run to run.
    pub non_magnetic: bool,
    /// Whether the first mode is drawn.
    pub mode: bool,
    /// Whether the warm-up time differs from run to run; A is then not part of the table, and its spread is a
    /// parameter.
    pub warm_up: bool,
    /// Whether the perimeter loop relocks after each switch.
    pub relock: Option<relock_ticks::Shape>,
    /// Whether the end of the run is one of [`ENDS`] at random; else the run ends with its last interval.
    pub any_end: bool,
}

impl Shape {
    /// Index of the first estimate at a time.
    #[inline]
    pub fn first_time(self) -> usize {
        if self.ends { 2 } else { 0 }
    }

    /// Whether anything except phases is drawn once for a run.
    #[inline]
    pub fn spreads(self) -> bool {
        self.magnetic || self.initial || self.non_magnetic || self.mode || self.warm_up
    }

    /// Whether normal numbers are drawn.
    fn has_normals(self) -> bool {
        self.walk || self.noise || self.spreads() || self.relock.is_some()
    }

    /// Whether powers and logarithms are computed.
    fn has_powers(self) -> bool {
        self.warm_up || self.relock.is_some()
    }

    /// Words of a row of the table.
    #[inline]
    pub fn row(self) -> usize {
        let words = [self.mode, self.magnetic, self.initial, self.non_magnetic, self.warm_up, self.warm_up];
        1 + words.into_iter().filter(|has| *has).count()
    }

    /// Words of an end in the table: those of a row, the interval, and the two parts of the random walk.
    #[inline]
    pub fn end_row(self) -> usize {
        self.row() + 1 + only(self.walk, 2)
    }
}

impl Sealed for Shape {}

impl launch::Shape for Shape {
    fn part(&self) -> &'static Part {
        &part::switched_run
    }

    /// At the end, the largest, at each of the times.
    #[inline(always)]
    fn estimates(&self) -> usize {
        self.first_time() + self.times
    }

    fn has_table(&self) -> bool {
        true
    }

    fn table_words(&self, words: &[u32]) -> Result<usize, Misfit> {
        let intervals = Parameters::new(words, *self).intervals[0];
        if u64::from(intervals) > MAX_STEPS {
            return Err(Misfit::Field("intervals"));
        }
        if self.tones > MAX_TONES {
            return Err(Misfit::Field("tones"));
        }
        let rows = (intervals as usize + self.times) * self.row();
        Ok(rows + only(self.any_end, ENDS * self.end_row()))
    }

    fn steps(&self, words: &[u32]) -> u64 {
        let relock = self.relock.map_or(0, |relock| relock.ticks as u64);
        u64::from(Parameters::new(words, *self).intervals[0]) * (1 + relock)
    }

    fn words(&self) -> usize {
        word_count(*self)
    }

    fn shader(&self) -> Shader {
        let mut shader = Shader {
            parts: vec![&part::philox, &part::sine],
            constants: vec![
                ("TONES", self.tones),
                // An array must have at least one element.
                ("TONE_ROOM", self.tones.max(1)),
                ("PHASE_BLOCKS", self.tones.div_ceil(4)),
                ("TIMES", self.times),
                ("FIRST_TIME", self.first_time()),
                ("ROW", self.row()),
                ("END_ROW", self.end_row()),
            ],
            flags: vec![
                ("ENDS", self.ends),
                ("WALK", self.walk),
                ("NOISE", self.noise),
                ("SPREAD", self.spreads()),
                ("MAGNETIC", self.magnetic),
                ("INITIAL", self.initial),
                ("NON_MAGNETIC", self.non_magnetic),
                ("MODE", self.mode),
                ("WARM_UP", self.warm_up),
                ("RELOCKING", self.relock.is_some()),
                ("ANY_END", self.any_end),
            ],
            declarations: wgsl_places(*self),
        };
        if self.has_normals() {
            shader.parts.push(&part::normal);
        }
        if self.has_powers() {
            shader.parts.push(&part::power);
        }
        if let Some(ticks) = self.relock {
            ticks.include(&mut shader);
        }
        shader.parts.push(&part::switched_run);
        shader
    }
}

/// `count` where `wanted`, else 0.
#[inline(always)]
fn only(wanted: bool, count: usize) -> usize {
    if wanted { count } else { 0 }
}

// The table has a row for the end of each interval, then one for each time, then one for each end that may be drawn. A row
// holds the angle of the drift so far, LSB, with its magnetic part apart where the first mode is drawn; then the effects of one standard deviation of A, of
// Ω_m0 and of Ω_nm, 2^−4 LSB; and, where the warm-up time is drawn, the signed time ∫ s dt and the number of halvings
// of e^{−t/τ} at the nominal τ. The row of an end continues with the interval that contains it and, where there is a
// random walk, with the standard deviations of its two parts there, as `time_walk` and `time_bridge`.
parameters! {
    /// Key of the random words.
    key: |_| 2,
    /// Number of intervals of the run, or of the longest one; there is a switch after each but the last.
    intervals: |_| 1,
    /// Standard deviation of the random walk over an interval and over the last one, 2^−4 LSB.
    walk_sigma: |shape: Shape| only(shape.walk, 2),
    /// Standard deviation of the normal part of a residual, 2^−4 LSB.
    noise: |shape: Shape| only(shape.noise, 1),
    /// Standard deviation of log2 τ, 2^−30.
    warm_up_spread: |shape: Shape| only(shape.warm_up, 1),
    /// Fractional bits of a number of halvings.
    halving_bits: |shape: Shape| only(shape.warm_up, 1),
    /// Number of halvings in an interval.
    halvings: |shape: Shape| only(shape.warm_up, 1),
    /// Number of fractional bits that a time has beyond those of a ratio.
    time_bits: |shape: Shape| only(shape.warm_up, 1),
    /// A and its standard deviation, 2^−32 LSB per unit of time.
    heated: |shape: Shape| only(shape.warm_up, 2),
    /// Parameters of the ticks that relock, as in `relock_ticks`.
    relock: |shape: Shape| shape.relock.map_or(0, relock_ticks::word_count),
    /// Weight of each of those ticks, by itself and through the filler, in LSB per LSB.
    relock_weight: |shape: Shape| shape.relock.map_or(0, |relock| relock.ticks),
    /// Fractional bits of those weights.
    relock_bits: |shape: Shape| only(shape.relock.is_some(), 1),
    /// The part common to all residuals, 2^−32 LSB, two words.
    constant: |_| 2,
    /// Residual of a tone at sine 1, 2^−2 LSB.
    amplitude: |shape: Shape| shape.tones,
    /// Phase advance from switch to switch, in 2^−32 turns.
    phase_step: |shape: Shape| shape.tones,
    /// All bits set where the phase is drawn for each switch, else none.
    switch_spread: |shape: Shape| shape.tones,
    /// All bits set where the phase is drawn once for the whole run, else none.
    run_spread: |shape: Shape| shape.tones,
    /// The interval that contains each time.
    time_interval: |shape: Shape| shape.times,
    /// Standard deviation of the part of the interval's random walk at the time that is proportional to the whole, 2^−4
    /// LSB.
    time_walk: |shape: Shape| only(shape.walk, shape.times),
    /// Standard deviation of the rest, 2^−4 LSB.
    time_bridge: |shape: Shape| only(shape.walk, shape.times),
    /// Level at which each estimate's histogram starts.
    bin_base: |shape: Shape| launch::Shape::estimates(&shape),
}
