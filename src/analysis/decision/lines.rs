//! The five lines in which every decision ends.

use serde_json::{Value as Json, json};

use crate::analysis::decision::Sheet;

/// The heading of each line.
const HEADINGS: [&str; 5] = ["Requirement", "Best option", "Margin", "What limits", "Next lever"];

/// The single sentence of a study without an estimate of which less is better.
const UNJUDGED: &str = "None is given: the study describes, and its charts judge no error. There is no best option, and neither \
                        margin nor lever, until a limit says what is wanted.";

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
    /// The headings and sentences of a study with complete results. A study that describes and judges nothing has no sheet, and
    /// says so in a single line.
    pub fn of_study(sheet: Option<&Sheet>) -> Vec<(&'static str, String)> {
        let unjudged = || vec![(HEADINGS[0], UNJUDGED.to_owned())];
        sheet.map_or_else(unjudged, Sheet::lines)
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
