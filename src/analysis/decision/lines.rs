//! The five lines in which every decision ends.

use serde_json::{Value as Json, json};

use crate::analysis::decision::Sheet;

/// The heading of each line.
const HEADINGS: [&str; 5] = ["Requirement", "Best option", "Margin", "What limits", "Next lever"];

/// The decision to which an analysis leads, in a sentence for each heading: whether the requirement is met, the best
/// option, its margin, what limits it, and what to change next. A line that has no answer says why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lines {
    /// Whether the requirement is met; `None` without one.
    pub met: Option<bool>,
    /// The sentences.
    pub sentences: [String; 5],
}

impl Lines {
    /// The lines of a study that judges nothing, as a description without a limit.
    fn unjudged() -> Lines {
        let sentences = [
            "None is given, and no estimate of the study is an error, of which less is better.",
            "None is better without a requirement, which a limit would state.",
            "Without a limit there is none.",
            "The parts of this estimate are not separated.",
            "None is searched where no estimate is an error.",
        ];
        Lines { met: None, sentences: sentences.map(str::to_owned) }
    }

    /// The headings and sentences of a study with complete results, whose sheet is absent where it judges nothing.
    pub fn of_study(sheet: Option<&Sheet>) -> Vec<(&'static str, String)> {
        sheet.map_or_else(|| Lines::unjudged().headed(), Sheet::lines)
    }

    /// Each heading with its sentence.
    pub fn headed(&self) -> Vec<(&'static str, String)> {
        HEADINGS.into_iter().zip(self.sentences.iter().cloned()).collect()
    }

    /// The decision as JSON.
    pub fn json(&self) -> Json {
        json!({ "met": self.met, "sentences": self.headed() })
    }
}
