//! The layout of a text log, determined from its first lines.

use crate::record::log::cells::{Cells, Delimiter, Value, value};
use crate::record::log::error::LogError;
use crate::record::log::names::Name;
use crate::source::place::Place;

/// The layout of a text log.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub file: String,
    pub delimiter: Delimiter,
    /// Column names; absent without a header.
    pub names: Option<Vec<Name>>,
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
    text: &'h [u8],
}

impl Layout {
    /// The layout of the log that begins with `head`.
    ///
    /// # Errors
    /// The log has no rows.
    pub(crate) fn of(head: &[u8], file: &str) -> Result<Layout, LogError> {
        let (content, comment) = first_lines(head);
        let Some(first) = content.first() else {
            let help =
                "give a log: one line for each sample, a header with the names of its columns if you like";
            let message =
                if head.is_empty() { format!("{file} is empty") } else { format!("{file} has no samples") };
            return Err(LogError::new(message, "", help, None));
        };
        let delimiter = Delimiter::of(content.last().unwrap_or(first).text);
        let cells = texts(first.text, delimiter);
        let mut layout = Layout {
            file: file.to_owned(),
            delimiter,
            names: None,
            columns: cells.len(),
            start: first.start,
            lines: first.number - 1,
            shown: (first.number, first.text.to_vec()),
        };
        if is_header(&cells) {
            layout.names = Some(names(&cells));
            layout.columns = layout.names.as_ref().map_or(0, Vec::len);
            layout.lines = first.number;
            layout.start = head.len().min(first.start + first.text.len() + 1);
        } else {
            // The header as NumPy's savetxt writes it.
            let is_sign = |byte: &u8| b"#%; \t".contains(byte);
            let text = comment.map(|text| &text[text.iter().take_while(|byte| is_sign(byte)).count()..]);
            let words = text.map(|text| texts(text, delimiter)).filter(|words| is_header(words));
            layout.names = words.map(|words| names(&words)).filter(|names| names.len() == cells.len());
        }
        Ok(layout)
    }

    /// The place where a column is shown.
    pub(crate) fn place(&self, column: usize) -> Place {
        let (number, text) = &self.shown;
        let cell = Cells::new(text, self.delimiter).nth(column);
        // Where blanks divide, units separated by blanks are cells of their own.
        let whole = self.delimiter == Delimiter::Blanks && self.names.is_some();
        let span = cell.filter(|_| !whole).unwrap_or(0..text.len());
        Place::new(&self.file, *number, text, span)
    }

    /// The line that shows the columns.
    pub(crate) fn line(&self) -> Place {
        let (number, text) = &self.shown;
        Place::new(&self.file, *number, text, 0..text.len())
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
            content.push(Line { number, start, text: text.trim_ascii_end() });
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
    let values = || cells.iter().map(|cell| value(cell.as_bytes()));
    values().any(|value| value == Value::Text)
        && values().all(|value| !matches!(value, Value::Number(number) if !number.is_nan()))
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
        layout.names.iter().flatten().map(|name| name.bare.as_str()).collect()
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
