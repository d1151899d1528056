//! Keys common to all kinds of study.

use crate::key::holds::{Holds, words};
use crate::key::row::keys;

words! {
    /// Whether the points of a study share their random numbers.
    pub enum Streams {
        /// Every point draws its own random numbers.
        Independent = "independent",
        /// A trial has the same random numbers at every point, which gives smooth curves and paired differences.
        Common = "common",
    }
}

/// Most trials at one point, 2^40.
pub const MAX_TRIALS: u64 = 1 << 40;

keys! {
    /// The keys at the top of every study.
    pub(crate) static KEYS;
    /// Title shown above charts and reports.
    pub TITLE = "title", "", Fixed, Holds::Text, r#"title = "Error of the gap fillers""#, required;
    /// The question that the study answers, in one sentence.
    pub QUESTION = "question", "", Fixed, Holds::Text, r#"question = "Which filler is good enough?""#;
    /// Kind of the study.
    pub KIND = "kind", "", Fixed, Holds::Text, r#"kind = "gap-fill""#, required;
    /// Seed of all random numbers; 1 if absent.
    pub SEED = "seed", "", Fixed, Holds::Whole(0, i64::MAX), "seed = 1";
    /// Monte Carlo trials at each point. If absent, 1 000 000; for kind = "switched-run" 100 000 runs, for kind =
    /// "allan" 1000 records, and for kind = "navigation" 1000 navigators. Kinds in closed form do not use it.
    pub TRIALS = "trials", "", Fixed, Holds::Whole(1, MAX_TRIALS as i64), "trials = 1_000_000";
    /// Requirement of the study, above 0, which its answer must stay within: an error as an angle, "10 arcsec", of a
    /// position as a distance, "1 nmi"; a drift or an Allan deviation as a rate, "0.01 deg/h"; the error of a coefficient as
    /// a percentage, "10 %". Charts of that estimate that have no limit of their own take it, and a chart that the study
    /// leaves to the program shows that estimate.
    pub LIMIT = "limit", "", Fixed, Holds::Any, r#"limit = "10 arcsec""#;
    /// Whether the points share their random numbers.
    pub STREAMS = "streams", "", Fixed, Holds::Word(Streams::WORDS), r#"streams = "independent""#;
}
