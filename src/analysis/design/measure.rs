//! The quantity that a design minimizes.

use sagnac_engine::key::names;

names! {
    /// The quantity to minimize, as listed by `--by`.
    pub enum Measure {
        /// The drift that 99.73 % of runs do not exceed.
        DriftP9973 = "drift_p99_73",
        /// The rms drift.
        DriftRms = "drift_rms",
        /// The largest angle of a run, divided by the run time, that 99.73 % of runs do not exceed.
        LargestP9973 = "largest_p99_73",
        /// The rms of the largest angle of a run, divided by the run time.
        LargestRms = "largest_rms",
    }
}

impl Measure {
    /// Meaning, as a sentence.
    pub fn meaning(self) -> &'static str {
        Measure::WORDS[self as usize].meaning.trim()
    }

    /// Label for axes and sentences.
    pub fn label(self) -> &'static str {
        match self {
            Measure::DriftP9973 => "99.73 % drift",
            Measure::DriftRms => "rms drift",
            Measure::LargestP9973 => "99.73 % largest angle over the run time",
            Measure::LargestRms => "rms largest angle over the run time",
        }
    }

    /// Whether it refers to the largest angle of a run instead of that at its end.
    pub(crate) fn is_largest(self) -> bool {
        matches!(self, Measure::LargestP9973 | Measure::LargestRms)
    }
}
