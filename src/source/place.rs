//! A piece of one line of a file.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// Characters of a line that an error shows on each side of its cell.
const SHOWN: usize = 60;

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
