//! A piece of one line of a file.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// Characters of a line that an error shows on each side of its cell.
const SHOWN: usize = 60;

/// The piece of a line of a text file that is kept for messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    file: String,
    /// Line number, from 1.
    line: usize,
    /// Bytes of the line before the piece.
    before: usize,
    text: String,
    span: Range<usize>,
}

impl Place {
    /// The piece around the bytes `span` of line number `line`, which reads `text`.
    pub(crate) fn new(file: &str, line: usize, text: &[u8], span: Range<usize>) -> Place {
        let span = span.start.min(text.len())..span.end.min(text.len());
        // A piece must not begin within a character, which would then be shown and counted as another.
        let is_midst = |at: &usize| text[*at] & 0xc0 == 0x80;
        let from =
            (span.start.saturating_sub(SHOWN)..span.start).find(|at| !is_midst(at)).unwrap_or(span.start);
        let to = text.len().min(span.end.min(span.start + SHOWN) + SHOWN);
        // Lossy text may be longer than its bytes, so each part is converted by itself.
        let [head, cell, tail] = [from..span.start, span.start..span.end.min(to), span.end.min(to)..to]
            .map(|part| String::from_utf8_lossy(&text[part]).into_owned());
        let span = head.len()..head.len() + cell.len();
        Place { file: file.to_owned(), line, before: from, text: head + &cell + &tail, span }
    }

    /// The byte range of the cell within the piece.
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
