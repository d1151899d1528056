//! The cells of one line of a text, and their values.

use std::ops::Range;

/// The separator between the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Delimiter {
    /// A comma, a semicolon or a tab; blanks around cells are ignored.
    Byte(u8),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Delimiter {
    /// The delimiter of the `first` line and of the one after it, a `row` of numbers: a sign that occurs equally often in both, or
    /// else one in the row. A comma does not count where it stands for the decimal point.
    pub(crate) fn parse(first: &[u8], row: &[u8], decimal: Decimal) -> Delimiter {
        let signs: &[u8] = if decimal == Decimal::Comma { b"\t;" } else { b"\t;," };
        let signs = || signs.iter().copied().filter(|sign| row.trim_ascii().contains(sign));
        let equal = |sign: &u8| Delimiter::Byte(*sign).count(first) == Delimiter::Byte(*sign).count(row);
        match signs().find(equal).or(signs().next()) {
            Some(sign) => Delimiter::Byte(sign),
            None if row.trim_ascii().contains(&b' ') || decimal == Decimal::Comma => Delimiter::Blanks,
            None => Delimiter::Byte(b','),
        }
    }

    /// Number of cells in a line.
    pub(crate) fn count(self, line: &[u8]) -> usize {
        Cells::new(line.trim_ascii(), self).count()
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Delimiter::Byte(b'\t') => "tabs",
            Delimiter::Byte(b';') => "semicolons",
            Delimiter::Byte(_) => "commas",
            Delimiter::Blanks => "blanks",
        }
    }

    /// Whether a line is empty or a comment, which begins with `#` or `%`, or with `;` where that is not the delimiter.
    pub(crate) fn skips(self, line: &[u8]) -> bool {
        match line.trim_ascii_start().first() {
            None | Some(b'#' | b'%') => true,
            Some(b';') => self != Delimiter::Byte(b';'),
            Some(_) => false,
        }
    }
}

/// The cells of a line as byte ranges, without blanks and quotes around them.
pub(crate) struct Cells<'l> {
    line: &'l [u8],
    delimiter: Delimiter,
    /// Start of the next cell; past the end when there is none.
    next: usize,
}

impl<'l> Cells<'l> {
    pub(crate) fn new(line: &'l [u8], delimiter: Delimiter) -> Cells<'l> {
        let next = match delimiter {
            Delimiter::Byte(_) => 0,
            Delimiter::Blanks => skip_blanks(line, 0),
        };
        Cells { line, delimiter, next }
    }
}

impl Iterator for Cells<'_> {
    type Item = Range<usize>;

    #[inline]
    fn next(&mut self) -> Option<Range<usize>> {
        let (line, start) = (self.line, self.next);
        let end = match self.delimiter {
            Delimiter::Byte(byte) if start <= line.len() => end_of(line, start, |b| b == byte),
            Delimiter::Blanks if start < line.len() => end_of(line, start, |b| b.is_ascii_whitespace()),
            _ => return None,
        };
        self.next = if self.delimiter == Delimiter::Blanks { skip_blanks(line, end) } else { end + 1 };
        Some(trimmed(line, start..end))
    }
}

fn skip_blanks(line: &[u8], from: usize) -> usize {
    line[from..].iter().position(|b| !b.is_ascii_whitespace()).map_or(line.len(), |n| from + n)
}

/// The end of the cell at `start`; nothing divides between quotes or within the brackets of a unit.
#[inline]
fn end_of(line: &[u8], start: usize, divides: impl Fn(u8) -> bool) -> usize {
    let (mut quoted, mut depth) = (false, 0_u32);
    for (i, &byte) in line[start..].iter().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b'[' | b'(' => depth += 1,
            b']' | b')' => depth = depth.saturating_sub(1),
            _ if divides(byte) && !quoted && depth == 0 => return start + i,
            _ => {}
        }
    }
    line.len()
}

#[inline]
fn trimmed(line: &[u8], cell: Range<usize>) -> Range<usize> {
    let outer = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'"';
    let bytes = &line[cell.clone()];
    let lead = bytes.iter().take_while(|b| outer(b)).count();
    let trail = bytes[lead..].iter().rev().take_while(|b| outer(b)).count();
    cell.start + lead..cell.end - trail
}

/// The sign before the decimals of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    /// 1.5
    Point,
    /// 1,5
    Comma,
}

/// Longest number with a decimal comma.
const MAX_DIGITS: usize = 64;

impl Decimal {
    /// Reads a cell as a number with these decimals; an empty cell, `NaN`, `NA` and `null` are missing values, NaN. Other text,
    /// and a number with other decimals, is `None`.
    #[inline]
    pub(crate) fn value(self, cell: &[u8]) -> Option<f64> {
        let mut copy = [0; MAX_DIGITS];
        let cell = match self {
            Decimal::Point => cell,
            Decimal::Comma if cell.contains(&b'.') => return None,
            Decimal::Comma => {
                let copy = copy.get_mut(..cell.len())?;
                copy.copy_from_slice(cell);
                copy.iter_mut().filter(|byte| **byte == b',').for_each(|byte| *byte = b'.');
                copy
            }
        };
        let text = std::str::from_utf8(cell).ok()?;
        let missing = || ["", "NA", "N/A", "null", "-"].contains(&text).then_some(f64::NAN);
        text.parse().ok().or_else(missing)
    }

    /// Whether a cell is a number with a decimal comma.
    pub(crate) fn is_comma(cell: &[u8]) -> bool {
        cell.contains(&b',') && Decimal::Comma.value(cell).is_some_and(f64::is_finite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str) -> Vec<&str> {
        Cells::new(line.as_bytes(), Delimiter::parse(line.as_bytes(), line.as_bytes(), Decimal::Point))
            .map(|cell| &line[cell])
            .collect()
    }

    #[test]
    fn lines_are_divided_by_what_stands_in_them() {
        let table: [(&str, &[&str]); 9] = [
            ("1,2,3", &["1", "2", "3"]),
            ("1, 2 ,\"3\"", &["1", "2", "3"]),
            ("1;2;", &["1", "2", ""]),
            ("1\t\t3", &["1", "", "3"]),
            ("  1   2 3  ", &["1", "2", "3"]),
            ("42", &["42"]),
            ("\"a, b\",c", &["a, b", "c"]),
            ("time [s]  rate (deg / s)", &["time", "[s]", "rate", "(deg / s)"]),
            (",", &["", ""]),
        ];
        for (line, expected) in table {
            assert_eq!(cells(line), expected, "{line}");
        }
    }

    #[test]
    fn numbers_gaps_and_what_is_neither_are_told_apart() {
        assert_eq!(Decimal::Point.value(b"-1.5e-3"), Some(-1.5e-3));
        for missing in ["", "NaN", "nan", "NA", "null"] {
            assert!(Decimal::Point.value(missing.as_bytes()).unwrap().is_nan(), "{missing}");
        }
        for infinite in ["inf", "-Infinity", "1e999"] {
            assert!(Decimal::Point.value(infinite.as_bytes()).unwrap().is_infinite(), "{infinite}");
        }
        for text in ["1,5", "12:00", "0x10", "\u{b0}", "1 2"] {
            assert_eq!(Decimal::Point.value(text.as_bytes()), None, "{text}");
        }
        assert_eq!(Decimal::Comma.value(b"-1,5e-3"), Some(-1.5e-3));
        for text in ["1.5", "1.234,5", "1,234,5", &"1".repeat(100)] {
            assert_eq!(Decimal::Comma.value(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn comments_begin_with_a_sign_that_is_no_delimiter() {
        let comma = Delimiter::Byte(b',');
        for line in ["# a", "  % b", "; c", "", "   "] {
            assert!(comma.skips(line.as_bytes()), "{line}");
        }
        assert!(!comma.skips(b"1") && !Delimiter::Byte(b';').skips(b";1"));
    }
}
