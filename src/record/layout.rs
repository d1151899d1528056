//! The layout of a text with columns, determined from its first lines.

use crate::record::cells::{Cells, Delimiter, value};
use crate::record::error::RecordError;
use crate::record::names::Name;
use crate::source::place::Place;

/// The layout of a text.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub file: String,
    pub delimiter: Delimiter,
    /// Column names; empty without a header.
    pub names: Vec<Name>,
    /// Number of cells in a row.
    pub columns: usize,
    /// Bytes, and then lines, before the first row, including the header.
    pub start: usize,
    pub lines: usize,
    /// The line that shows the columns, which is the header or else the first row, with its number from 1.
    shown: (usize, Vec<u8>),
}

/// A line that is neither empty nor a comment.
struct Line<'h> {
    number: usize,
    start: usize,
    /// Offset of the next line, in bytes.
    end: usize,
    text: &'h [u8],
}

impl Layout {
    /// Finds the layout of the text that begins with `head`.
    ///
    /// # Errors
    /// The log has no rows.
    pub(crate) fn of(head: &[u8], file: &str) -> Result<Layout, RecordError> {
        let (content, comment) = first_lines(head);
        let Some(first) = content.first() else {
            let what = if head.is_empty() { "is empty" } else { "has no samples" };
            let help = "write one line for each sample, below a header with the names of the columns";
            return Err(RecordError::new(format!("{file} {what}"), "", help, None));
        };
        let delimiter = Delimiter::of(first.text, content.last().unwrap_or(first).text);
        let cells = texts(first.text, delimiter);
        let mut layout = Layout {
            file: file.to_owned(),
            delimiter,
            names: vec![],
            columns: cells.len(),
            start: first.start,
            lines: first.number - 1,
            shown: (first.number, first.text.to_vec()),
        };
        if is_header(&cells) {
            layout.names = names(&cells);
            layout.lines = first.number;
            layout.start = head.len().min(first.end);
        } else {
            // The header as NumPy's savetxt writes it.
            let is_sign = |byte: &u8| b"#%; \t".contains(byte);
            let text = comment.map(|text| &text[text.iter().take_while(|byte| is_sign(byte)).count()..]);
            let words = text.map(|text| texts(text, delimiter)).unwrap_or_default();
            layout.names =
                if words.len() == cells.len() && is_header(&words) { names(&words) } else { vec![] };
        }
        Ok(layout)
    }

    /// The place where a column is shown, or all of them.
    pub(crate) fn place(&self, column: Option<usize>) -> Place {
        let (number, text) = &self.shown;
        // Where blanks divide, units separated by blanks are cells of their own.
        let is_cut = self.delimiter == Delimiter::Blanks && !self.names.is_empty();
        let cell = column.filter(|_| !is_cut).and_then(|at| Cells::new(text, self.delimiter).nth(at));
        Place::new(&self.file, *number, text, cell.unwrap_or(0..text.len()))
    }
}

/// The first two lines with content, and the comment before the first.
fn first_lines(head: &[u8]) -> (Vec<Line<'_>>, Option<&[u8]>) {
    let bom: &[u8] = b"\xef\xbb\xbf";
    let mut start = if head.starts_with(bom) { bom.len() } else { 0 };
    let (mut content, mut comment, mut number) = (Vec::new(), None, 0);
    while start < head.len() && content.len() < 2 {
        let end = head[start..].iter().position(|byte| *byte == b'\n').map_or(head.len(), |n| start + n);
        let text = &head[start..end];
        number += 1;
        if !Delimiter::Byte(b',').skips(text) {
            content.push(Line { number, start, end: end + 1, text: text.trim_ascii_end() });
        } else if content.is_empty() && !text.trim_ascii().is_empty() {
            comment = Some(text);
        }
        start = end + 1;
    }
    (content, comment)
}

fn texts(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for cell in Cells::new(line, delimiter) {
        let text = String::from_utf8_lossy(&line[cell]).into_owned();
        match texts.last_mut() {
            // `time [s]` is one name even where blanks divide.
            Some(name) if delimiter == Delimiter::Blanks && text.starts_with(['[', '(']) => {
                *name += &format!(" {text}")
            }
            _ => texts.push(text),
        }
    }
    // Many loggers end each line with a delimiter.
    if texts.len() > 1 && texts.last().is_some_and(String::is_empty) {
        texts.pop();
    }
    texts
}

/// Whether the cells are words without a number among them.
fn is_header(cells: &[String]) -> bool {
    let mut values = cells.iter().map(|cell| value(cell.as_bytes()));
    values.clone().any(|value| value.is_none()) && !values.any(|value| value.is_some_and(f64::is_finite))
}

fn names(cells: &[String]) -> Vec<Name> {
    cells.iter().map(|cell| Name::read(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        Layout::of(text.as_bytes(), "g.csv").unwrap()
    }

    fn bare(layout: &Layout) -> Vec<&str> {
        layout.names.iter().map(|name| name.bare.as_str()).collect()
    }

    #[test]
    fn headers_comments_and_delimiters_are_found() {
        let table: [(&str, &[&str], usize, usize); 9] = [
            ("time [s],gz [deg/s]\n0,1\n", &["time", "gz"], 2, 1),
            ("0,1\n", &[], 2, 0),
            ("# made by a logger\n\n1;2;3;\n", &[], 3, 2),
            ("# t gz\n0.0 1.0\n0.1 2.0\n", &["t", "gz"], 2, 1),
            ("# PHASE.DAT\n#\n0.000e0\n8.5e-2\n", &[], 1, 2),
            ("% a comment\nt [s]   rate (deg / h)\n0 1\n1 2\n", &["t", "rate"], 2, 2),
            ("\u{feff}t\tgx\n0\t1\n", &["t", "gx"], 2, 1),
            ("t;gx;\n0;1;\n", &["t", "gx"], 2, 1),
            ("gyro z\n1\n2\n", &["gyro z"], 1, 1),
        ];
        for (text, names, columns, lines) in table {
            let found = layout(text);
            assert_eq!(
                (bare(&found), found.columns, found.lines),
                (names.to_vec(), columns, lines),
                "{text}"
            );
            let row = std::str::from_utf8(&text.as_bytes()[found.start..]).unwrap();
            assert!(row.starts_with(|c: char| c.is_ascii_digit()), "{text}: rows begin at {row}");
        }
    }

    #[test]
    fn a_file_without_samples_says_so() {
        for (text, piece) in [("", "is empty"), ("# only\n\n", "has no samples")] {
            let error = Layout::of(text.as_bytes(), "g.csv").unwrap_err();
            assert!(error.to_string().contains(piece), "{error}");
        }
        assert_eq!(layout("a,b\n").columns, 2);
    }
}
