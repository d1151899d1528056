//! The part of a text that an error shows.

use std::ops::Range;
use std::sync::Arc;

use miette::{MietteError, MietteSpanContents, NamedSource, SourceCode, SourceSpan, SpanContents};

use crate::quantity::visible::visible;
use crate::source::diagnose::Text;

/// Characters of a line that an error shows on each side of its cell, where it shows only a piece of the line.
const SHOWN: usize = 60;

/// Length in bytes from which on only a piece of a line is shown. Longer lines are unreadable in a report, and miette
/// panics for a caret beyond column 65535.
const LONG: usize = 1000;

/// Text in UTF-8, or else in Latin-1, in which spreadsheets write `°` and `µ`.
pub fn decoded(bytes: &[u8]) -> String {
    let text = std::str::from_utf8(bytes).map(str::to_owned);
    text.unwrap_or_else(|_| bytes.iter().copied().map(char::from).collect())
}

/// A text, or a piece of one of its lines, with the bytes under the caret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    text: Text,
    /// Line number of the start of the text in its file, from 1.
    line: usize,
    /// Bytes of that line before the text.
    before: usize,
    /// The bytes under the caret, within the text.
    pub span: Range<usize>,
}

impl Place {
    /// The piece around the bytes `span` of line number `line`, which reads `text`.
    pub fn new(file: &str, line: usize, text: &[u8], span: Range<usize>) -> Place {
        let span = span.start.min(text.len())..span.end.min(text.len());
        // A piece must not begin within a character, which would then be shown and counted as another.
        let is_midst = |at: &usize| text[*at] & 0xc0 == 0x80;
        let from =
            (span.start.saturating_sub(SHOWN)..span.start).find(|at| !is_midst(at)).unwrap_or(span.start);
        let to = text.len().min(span.end.min(span.start + SHOWN) + SHOWN);
        let is_utf_8 = std::str::from_utf8(text).is_ok();
        let shown =
            |part: &[u8]| if is_utf_8 { String::from_utf8_lossy(part).into_owned() } else { decoded(part) };
        // Converted text may be longer than its bytes, so each part is converted by itself.
        let [head, cell, tail] = [from..span.start, span.start..span.end.min(to), span.end.min(to)..to]
            .map(|part| shown(&text[part]));
        let span = head.len()..head.len() + cell.len();
        Place { text: Arc::new(NamedSource::new(file, head + &cell + &tail)), line, before: from, span }
    }

    /// The bytes `span` of a whole `text`; of a long line only a piece.
    pub fn within(text: &Text, span: Range<usize>) -> Place {
        let whole = text.inner();
        let is_end = |c: char| matches!(c, '\n' | '\r');
        let everything = |span| Place { text: text.clone(), line: 1, before: 0, span };
        let (Some(before), Some(after)) = (whole.get(..span.start), whole.get(span.end..)) else {
            return everything(span);
        };
        let start = before.rfind(is_end).map_or(0, |end| end + 1);
        let end = after.find(is_end).map_or(whole.len(), |length| span.end + length);
        let neighbours = [
            whole[..start].trim_end_matches(is_end).rsplit(is_end).next(),
            whole[end..].trim_start_matches(is_end).split(is_end).next(),
        ];
        if end - start <= LONG && neighbours.iter().flatten().all(|line| line.len() <= LONG) {
            return everything(span);
        }
        // \r\n counts as one line end.
        let ends = before[..start].bytes().zip(before[..start].bytes().skip(1).chain([0]));
        let line = 1 + ends.filter(|&(byte, next)| byte == b'\n' || (byte == b'\r' && next != b'\n')).count();
        Place::new(text.name(), line, &whole.as_bytes()[start..end], span.start - start..span.end - start)
    }
}

impl Place {
    /// The same place in a text whose control characters are visible.
    pub fn visible(&self) -> Place {
        // A carriage return alone ends a line too, and would take a terminal back to its start.
        let whole = &self.text.inner().replace("\r\n", " \n").replace('\r', "\n");
        let [start, end] = [self.span.start, self.span.end].map(|at| match whole.get(..at) {
            Some(before) => visible(before).len(),
            None => at,
        });
        let text = NamedSource::new(visible(self.text.name()), visible(whole).into_owned());
        Place { text: Arc::new(text), span: start..end, ..*self }
    }
}

impl SourceCode for Place {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.inner().read_span(span, before, after)?;
        let (line, column) = (self.line - 1 + inner.line(), self.before + inner.column());
        let (file, span, lines) = (self.text.name().to_owned(), *inner.span(), inner.line_count());
        Ok(Box::new(MietteSpanContents::new_named(file, inner.data(), span, line, column, lines)))
    }
}

#[cfg(test)]
mod tests {
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
