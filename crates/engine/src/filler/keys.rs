//! The keys of `[switching]` for the gap at a switch and its fillers.

use crate::filler::closed;
use crate::filler::ticks::FARTHEST;
use crate::key::holds::{Holds, words};
use crate::key::row::keys;
use crate::motion::keys::FREQUENCIES;

words! {
    /// An error of a filler.
    pub enum Error {
        /// Permanent error of the angle, after the gap is closed and corrected.
        Residual = "residual",
        /// Error of the angle at the end of the gap, before it is corrected.
        Extrapolation = "extrapolation",
        /// Largest error of the angle while the gap is open.
        InGap = "in-gap",
    }
}

/// Longest gap, ticks.
pub(crate) const MAX_GAP: i64 = FARTHEST;

const LIST: Holds = Holds::List(&Holds::Any);

keys! {
    /// The keys of the gap and its fillers.
    pub(crate) static KEYS;
    /// The mode switch, and the fillers of the lost ticks.
    pub SWITCHING = "switching", "", Fixed, Holds::Table, "[switching]\ngap_ticks = 3\nfillers = [\"const\", \"quadratic\"]";
    /// Number n of lost ticks; they are numbered 1 … n.
    pub GAP_TICKS = "switching.gap_ticks", "lost ticks n", Condition, Holds::Whole(1, MAX_GAP), "gap_ticks = 3";
    /// Ticks to which the residual is fitted; -1, 0, n+1, n+2 if absent. A tick is a number or "n+1"; "-7..0" is a
    /// range of ticks.
    pub FIT_TICKS = "switching.fit_ticks", "", Fixed, LIST, r#"fit_ticks = [-1, 0, "n+1", "n+2"]"#;
    /// Ticks to which the extrapolation is fitted, none after 0; -3, -2, -1, 0 if absent.
    pub EXTRAPOLATION_TICKS = "switching.extrapolation_ticks", "", Fixed, LIST, "extrapolation_ticks = [-3, -2, -1, 0]";
    /// Fillers to compare, each once: a polynomial "const", "linear" or "quadratic", fitted to switching.fit_ticks, or
    /// a table with its own kind, name and ticks, such as a minimum-variance filler.
    pub FILLERS = "switching.fillers", "", Fixed, Holds::List(&Holds::Either(&[Holds::Any, Holds::Word(closed::NAMES), Holds::Table])), r#"fillers = ["const", "quadratic", { kind = "minimum-variance", name = "mv8+2", fit_ticks = ["-7..0", "n+1", "n+2"] }]"#;
    /// Method by which the filler weights its ticks.
    pub FILLER_KIND = "switching.fillers.kind", "", Fixed, Holds::Word(closed::KINDS), r#"kind = "minimum-variance""#, required;
    /// Name in tables and charts; the kind if absent.
    pub FILLER_NAME = "switching.fillers.name", "", Fixed, Holds::Text, r#"name = "mv8+2""#;
    /// Ticks to which the residual is fitted; switching.fit_ticks if absent.
    pub FILLER_FIT_TICKS = "switching.fillers.fit_ticks", "", Fixed, LIST, r#"fit_ticks = ["-7..0", "n+1", "n+2"]"#;
    /// Ticks to which the extrapolation is fitted. If absent, they are the fit ticks up to 0 for a minimum-variance
    /// filler with its own fit_ticks, else switching.extrapolation_ticks.
    pub FILLER_EXTRAPOLATION_TICKS = "switching.fillers.extrapolation_ticks", "", Fixed, LIST, r#"extrapolation_ticks = ["-7..0"]"#;
    /// Vibration band for which a minimum-variance filler is designed, ["18 Hz", "22 Hz"]; the study's own motion if
    /// absent.
    pub FILLER_BAND = "switching.fillers.band", "", Fixed, Holds::Pair(&FREQUENCIES), r#"band = ["18 Hz", "22 Hz"]"#;
    /// Weights of the residual in the order of its ticks; their sum is n. They are numbers, or fractions such as "5/2".
    pub FILLER_WEIGHTS = "switching.fillers.weights", "", Fixed, LIST, r#"weights = [-1, "5/2", "5/2", -1]"#;
    /// Weights of the extrapolation. If absent, the filler does not extrapolate.
    pub FILLER_EXTRAPOLATION_WEIGHTS = "switching.fillers.extrapolation_weights", "", Fixed, LIST, r#"extrapolation_weights = ["3/4", "3/4", "3/4", "3/4"]"#;
}

keys! {
    /// The keys that apply only where single switches are studied.
    pub(crate) static OF_ONE_SWITCH;
    /// Errors to sample, each once; ["residual", "extrapolation"] if absent.
    pub ERRORS = "switching.errors", "", Fixed, Holds::List(&Holds::Word(Error::WORDS)), r#"errors = ["residual", "extrapolation", "in-gap"]"#;
}
