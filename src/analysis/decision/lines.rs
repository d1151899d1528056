//! The five lines in which every decision ends.

use serde_json::{Value as Json, json};

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
    /// Each heading with its sentence.
    pub fn headed(&self) -> Vec<(&'static str, String)> {
        HEADINGS.into_iter().zip(self.sentences.iter().cloned()).collect()
    }

    /// The decision as JSON.
    pub fn json(&self) -> Json {
        json!({ "met": self.met, "sentences": self.headed() })
    }
}
