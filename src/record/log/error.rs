//! Why a log was refused, with the line at fault.

use std::fmt;
use std::ops::Range;

use miette::{
    Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents,
};

use crate::source::diagnose::render;
use crate::source::setting::spelled;

/// Characters of a line that an error shows on each side of its cell.
const SHOWN: usize = 60;

/// Why a log was refused: what was found and where, what is accepted, how to put it right.
///
/// A [`miette::Diagnostic`]; [`LogError::render`] gives the text for a terminal.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct LogError {
    message: String,
    label: String,
    help: String,
    /// Absent where the fault has no line.
    place: Option<Box<Place>>,
}

/// A piece of one line of a text file: all that is kept of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    file: String,
    /// From 1.
    line: usize,
    /// Bytes of the line before the piece that is kept.
    before: usize,
    text: String,
    span: Range<usize>,
}

impl Place {
    /// The bytes `span` of the `line`, counted from 1, that reads `text`.
    pub(crate) fn new(file: &str, line: usize, text: &[u8], span: Range<usize>) -> Place {
        let span = span.start.min(text.len())..span.end.min(text.len());
        // Not from the midst of a character, which would be shown, and counted, as another.
        let is_midst = |at: &usize| text[*at] & 0xc0 == 0x80;
        let from =
            (span.start.saturating_sub(SHOWN)..span.start).find(|at| !is_midst(at)).unwrap_or(span.start);
        let to = text.len().min(span.end.min(span.start + SHOWN) + SHOWN);
        // Lossy text may be longer: each part is made of its own bytes.
        let [head, cell, tail] = [from..span.start, span.start..span.end.min(to), span.end.min(to)..to]
            .map(|part| String::from_utf8_lossy(&text[part]).into_owned());
        let span = head.len()..head.len() + cell.len();
        Place { file: file.to_owned(), line, before: from, text: head + &cell + &tail, span }
    }

    /// The bytes of the piece that it is about.
    pub(crate) fn span(&self) -> Range<usize> {
        self.span.clone()
    }
}

impl SourceCode for Place {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, before, after)?;
        let (line, column) = (self.line - 1 + inner.line(), self.before + inner.column());
        let (file, span, lines) = (self.file.clone(), *inner.span(), inner.line_count());
        Ok(Box::new(MietteSpanContents::new_named(file, inner.data(), span, line, column, lines)))
    }
}

impl LogError {
    /// `message`: the whole finding; `label`: what stands at `place`; `help`: what to do.
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

    /// The same error with its settings as a front end spells them, see [`spelled`].
    pub fn spelled(mut self, spell: &dyn Fn(&str, &str) -> Option<String>) -> LogError {
        for text in [&mut self.message, &mut self.label, &mut self.help] {
            *text = spelled(text, spell);
        }
        self
    }

    /// The report for people: file, line, caret and help, `width` columns wide; escape codes only if `color`.
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
