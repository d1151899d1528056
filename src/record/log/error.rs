//! Errors of logs, with the line at fault.

use std::fmt;

use miette::{Diagnostic, LabeledSpan, SourceCode};

use crate::source::diagnose::render;
use crate::source::place::Place;
use crate::source::setting::spelled;

/// Why a log was refused: the finding with its place, the accepted values and a remedy.
///
/// A [`miette::Diagnostic`]; [`LogError::render`] gives the text for a terminal.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct LogError {
    message: String,
    label: String,
    help: String,
    /// Place; absent where the fault has no line.
    place: Option<Box<Place>>,
}

impl LogError {
    /// An error with the complete finding as `message`, a `label` for the text at `place`, and advice as `help`.
    pub(crate) fn new(
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
        place: impl Into<Option<Place>>,
    ) -> LogError {
        LogError {
            message: message.into(),
            label: label.into(),
            help: help.into(),
            place: place.into().map(Box::new),
        }
    }

    /// The same error with its settings in the spelling of a front end; see [`spelled`].
    pub fn spelled(mut self, spell: &dyn Fn(&str, &str) -> Option<String>) -> LogError {
        for text in [&mut self.message, &mut self.label, &mut self.help] {
            *text = spelled(text, spell);
        }
        self
    }

    /// The report for the user, with file, line, caret and help, `width` columns wide; it has escape codes only if
    /// `color`.
    pub fn render(&self, color: bool, width: usize) -> String {
        render(self, color, width).unwrap_or_else(|| format!("{self}\nhelp: {}\n", self.help))
    }
}

impl Diagnostic for LogError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(&self.help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_deref().map(|place| place as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.place.as_ref()?.span();
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(Some(self.label.clone()), span))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_the_true_line_and_column_even_of_a_line_that_is_cut() {
        let line = format!("{}oops,{}", "1,".repeat(5000), "2,".repeat(5000));
        let place = Place::new("g.csv", 1_000_001, line.as_bytes(), 10_000..10_004);
        let shown = LogError::new("bad cell", "not a number", "mend it", place).render(false, 100);
        for piece in ["g.csv:1000001:10001", "oops", "not a number", "mend it"] {
            assert!(shown.contains(piece), "{piece} is missing in\n{shown}");
        }
        assert!(shown.len() < 1500, "{shown}");
    }

    #[test]
    fn a_line_that_is_no_utf_8_is_shown_all_the_same() {
        let place = Place::new("g.csv", 1, b"rate [\xb0/s],x", 6..8);
        let shown = LogError::new("bad unit", "here", "write deg/s", place).render(false, 100);
        assert!(shown.contains("g.csv:1:7"), "{shown}");
        let beyond = Place::new("g.csv", 1, b"1,2", 40..50);
        assert!(LogError::new("short", "here", "", beyond).render(false, 80).contains("g.csv:1:"));
    }
}
