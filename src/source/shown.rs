//! The lines of a text that an error shows.

use std::ops::Range;

use miette::{MietteError, SourceCode, SourceSpan, SpanContents};

use crate::source::diagnose::Text;
use crate::source::place::Place;

/// Length in bytes from which on only a piece of a line is shown. Longer lines are unreadable in a report, and miette
/// panics for a caret beyond column 65535.
const LONG: usize = 1000;

/// The lines around a fault, or a piece of a long line.
#[derive(Debug, Clone)]
pub(crate) enum Shown {
    /// A text with the bytes under the caret.
    Lines(Text, Range<usize>),
    Piece(Box<Place>),
}

impl Shown {
    /// The part of `text` to show for the bytes `span`.
    pub(crate) fn new(text: &Text, span: Range<usize>) -> Shown {
        let whole = text.inner();
        let is_end = |c: char| matches!(c, '\n' | '\r');
        let (Some(before), Some(after)) = (whole.get(..span.start), whole.get(span.end..)) else {
            return Shown::Lines(text.clone(), span);
        };
        let start = before.rfind(is_end).map_or(0, |end| end + 1);
        let end = after.find(is_end).map_or(whole.len(), |length| span.end + length);
        let mut neighbours = [
            whole[..start].trim_end_matches(is_end).rsplit(is_end).next(),
            whole[end..].trim_start_matches(is_end).split(is_end).next(),
        ]
        .into_iter()
        .flatten();
        if end - start <= LONG && neighbours.all(|line| line.len() <= LONG) {
            return Shown::Lines(text.clone(), span);
        }
        // \r\n counts as one line end.
        let ends = before[..start].bytes().zip(before[..start].bytes().skip(1).chain([0]));
        let line = 1 + ends.filter(|&(byte, next)| byte == b'\n' || (byte == b'\r' && next != b'\n')).count();
        let within = span.start - start..span.end - start;
        Shown::Piece(Box::new(Place::new(text.name(), line, &whole.as_bytes()[start..end], within)))
    }

    /// The bytes under the caret, relative to the part shown.
    pub(crate) fn span(&self) -> Range<usize> {
        match self {
            Shown::Lines(_, span) => span.clone(),
            Shown::Piece(place) => place.span(),
        }
    }
}

impl SourceCode for Shown {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        match self {
            Shown::Lines(text, _) => text.read_span(span, before, after),
            Shown::Piece(place) => place.read_span(span, before, after),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use miette::NamedSource;

    use super::*;
    use crate::source::diagnose::Fault;

    #[test]
    fn of_a_long_line_a_piece_is_shown_at_its_true_place() {
        for filling in [10, LONG, 70_000, 1_000_000] {
            let long = "é".repeat(filling);
            for (text, place) in [
                (format!("x = 1\r\ny = {long} bad\nz = 2\n"), format!("a.toml:2:{}", 6 + 2 * filling)),
                (format!("x = 1\n\nbad = {long}\n"), "a.toml:3:1".to_owned()),
                (format!("{long}\n bad\n"), "a.toml:2:2".to_owned()),
                (format!("\rbad\n\n{long}"), "a.toml:2:1".to_owned()),
            ] {
                let at = text.find("bad").unwrap();
                let text: Text = Arc::new(NamedSource::new("a.toml", text));
                let shown =
                    Fault::new(at..at + 3, "bad y", "this one", "mend it").within(&text).render(false, 100);
                for piece in [place.as_str(), "bad", "this one", "mend it"] {
                    assert!(shown.contains(piece), "{piece} is missing in\n{shown}");
                }
                assert!(shown.len() < 4 * LONG, "{} bytes with {filling}", shown.len());
            }
        }
    }
}
