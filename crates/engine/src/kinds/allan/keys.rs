//! The keys of `[record]` and `[allan]`, with their settings.

use crate::key::row::{Holds, keys, measure, words};
use crate::key::sweep::Setting;
use crate::kinds::allan::point::Inputs;
use sagnac_base::quantity::units::Dimension;

words! {
    /// The estimated variance.
    pub(crate) enum EstimatorName {
        /// Allan variance of all second differences.
        Overlapping = "overlapping",
        /// Allan variance of adjacent groups.
        NonOverlapping = "non-overlapping",
        /// Overlapping Hadamard variance, which is insensitive to a ramp.
        Hadamard = "hadamard",
    }
}

words! {
    /// The fraction of the overlapping differences that is used.
    pub(crate) enum Overlap {
        /// 64 differences in each averaging time, which increases the scatter by less than 0.2 %.
        Part64 = "m/64",
        /// All differences.
        Full = "full",
    }
}

const SAMPLES: Holds = measure(&[Dimension::Time], 1e-6, 1e6, "1 µs to 1e6 s");
const LENGTHS: Holds = measure(&[Dimension::Time], 1e-6, 1e12, "1 µs to 1e12 s");
const RATES: Holds = measure(&[Dimension::DriftRate], -1e9, 1e9, "-1e9 to 1e9 deg/h");
const TEXTS: Holds = Holds::Either(&[Holds::Any, Holds::List(&Holds::Any)]);

keys! {
    /// The keys of the record.
    pub(crate) static KEYS;
    /// The record of a gyro at rest.
    RECORD = "record", "", Fixed, Holds::Table, "[record]\nsample = \"1 s\"\nlength = \"9 h\"";
    /// Time from one sample to the next: "1 s".
    SAMPLE = "record.sample", "sampling time", Choice, SAMPLES, r#"sample = "1 s""#, required;
    /// Time from the first sample to the last: "9 h". It is rounded to a whole number of samples.
    pub LENGTH = "record.length", "length of the record", Choice, LENGTHS, r#"length = "9 h""#, required;
    /// Constant rate, such as the Earth's on the input axis: "10 deg/h". It affects only a readout in whole pulses.
    pub RATE = "record.rate", "constant rate", Condition, RATES, r#"rate = "10 deg/h""#;
}

keys! {
    /// The keys of the curve and its fit, for every kind of study that has one.
    pub(crate) static CURVE_KEYS;
    /// Estimates made from each record.
    pub ALLAN = "allan", "", Fixed, Holds::Table, "[allan]\ntau = \"octave\"\nfit = [\"Q\", \"N\", \"B\"]";
    /// Averaging times: "octave", "decade10", "decade20", or ["1 s", "10 s"]; octave if absent.
    pub TAU = "allan.tau", "", Fixed, TEXTS, r#"tau = "octave""#;
    /// Estimated variance; "overlapping" if absent.
    pub ESTIMATOR = "allan.estimator", "", Fixed, Holds::Word(EstimatorName::WORDS), r#"estimator = "overlapping""#;
    /// Fraction of the overlapping differences that is used; "m/64" if absent.
    pub OVERLAP = "allan.overlap", "", Fixed, Holds::Word(Overlap::WORDS), r#"overlap = "full""#;
    /// Coefficients fitted to each record: "auto" for those of Q, N, B, K, R that it supports, or some of "Q", "N",
    /// "B", "K", "R", "markov", "sine"; none if absent.
    pub FIT = "allan.fit", "", Fixed, TEXTS, r#"fit = ["Q", "N", "B"]"#;
}

/// The settings of these keys, except the noise.
pub(crate) static SETTINGS: [Setting<Inputs>; 3] = [
    Setting::new(&SAMPLE, |inputs, sample| inputs.sample_s = sample.value),
    Setting::new(&LENGTH, |inputs, length| inputs.length_s = length.value),
    Setting::new(&RATE, |inputs, rate| inputs.rate = rate.value),
];
