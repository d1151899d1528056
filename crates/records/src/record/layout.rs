//! The layout of a text with columns, determined from its first lines.

use std::ops::Range;

use crate::record::RecordError;
pub use crate::record::cells::Decimal;
use crate::record::cells::{Cells, Delimiter};
use crate::record::log::measure::Data;
use crate::record::log::timing::is_time;
use crate::record::loggers::{self, Known, Rivals};
use crate::record::names::Name;
use crate::record::time::{Calendar, First, median_step};
use sagnac_base::diagnostics::{Place, decoded};
use sagnac_base::quantity::{Dimension, parse as parse_quantity};

/// Lines from which delimiter and decimals are found.
const SAMPLE: usize = 32;

/// The layout of a text.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub file: String,
    pub delimiter: Delimiter,
    pub decimal: Decimal,
    /// Column names; empty without a header.
    pub names: Vec<Name>,
    /// Number of cells in a row.
    pub columns: usize,
    /// The number in each cell of one of the first rows, NaN where there is no row.
    pub numbers: Vec<Option<f64>>,
    /// The numbers of each column in the first rows.
    pub rows: Vec<Vec<f64>>,
    /// The columns with times of the calendar.
    pub calendar: Vec<Option<Calendar>>,
    /// Which number is first in dates with slashes, if the first rows have such dates.
    pub first: Option<First>,
    /// Bytes, and then lines, before the first row, including the header.
    pub start: usize,
    pub lines: usize,
    /// What a header of Stable32 states.
    pub stated: Stated,
    /// What was inferred, in a line each.
    pub inferred: Vec<String>,
    /// The loggers whose header it may be, if these have other units.
    pub rivals: Option<Rivals>,
    /// The line that shows the columns, which is the header or else the first row, with its number from 1.
    shown: Shown,
}

/// A line with a cell for each column.
#[derive(Debug, Clone)]
struct Shown {
    number: usize,
    text: Vec<u8>,
    cells: Vec<Range<usize>>,
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
    /// Finds the layout of the text that begins with `head`, with these decimals if they are given.
    ///
    /// # Errors
    /// The log has no rows.
    pub(crate) fn parse(head: &[u8], file: &str, decimal: Option<Decimal>) -> Result<Layout, RecordError> {
        let labview = labview(head);
        let (header_end, stated) =
            stable32(head, file).or_else(|| Some((labview?, Stated::default()))).unwrap_or_default();
        let (mut content, comments) = first_lines(head, header_end);
        let titles = titles(&content, decimal);
        content.drain(..titles);
        let Some(first) = content.first() else {
            let what = if head.is_empty() { "is empty" } else { "has no samples" };
            let help = "write one line for each sample, below a header with the names of the columns";
            return Err(RecordError::new(format!("{file} {what}"), "", help, None));
        };
        let (delimiter, decimal_found) = signs(&content, decimal);
        let mut cells = texts(first.text, delimiter);
        // Rows without a remark end before its column.
        let last = content.last().unwrap_or(first);
        if labview.is_some() && delimiter.count(last.text) + 1 == cells.len() {
            cells.pop();
        }
        // A line below the header may have units, and a cell may be empty.
        let rows = &content[1 + usize::from(content.len() > 2)..];
        let mut shown = vec![vec![]; cells.len()];
        for line in rows.iter().rev() {
            let cells = shown.iter_mut().zip(Cells::new(line.text, delimiter));
            cells.filter(|(shown, _)| shown.is_empty()).for_each(|(shown, cell)| {
                *shown = line.text[cell].to_vec();
            });
        }
        let mut numbers: Vec<Vec<f64>> = vec![vec![]; cells.len()];
        for line in rows {
            for (numbers, cell) in numbers.iter_mut().zip(Cells::new(line.text, delimiter)) {
                numbers.extend(decimal_found.value(&line.text[cell]));
            }
        }
        let date = shown.iter().find_map(|cell| First::parse(cell));
        let of_calendar = |cell: &Vec<u8>| Calendar::parse(cell)?.seconds(cell, date.unwrap_or(First::Month));
        let number = |cell: &Vec<u8>| decimal_found.value(cell).or_else(|| of_calendar(cell));
        let mut layout = Layout {
            file: file.to_owned(),
            delimiter,
            decimal: decimal_found,
            names: vec![],
            columns: cells.len(),
            numbers: shown.iter().map(number).collect(),
            rows: numbers,
            calendar: shown.iter().map(|cell| Calendar::parse(cell)).collect(),
            first: date,
            start: first.start,
            lines: first.number - 1,
            stated,
            inferred: vec![],
            rivals: None,
            shown: Shown {
                number: first.number,
                text: first.text.to_vec(),
                cells: Cells::new(first.text, delimiter).collect(),
            },
        };
        if titles > 0 {
            let lines = if titles == 1 { "1 line".to_owned() } else { format!("{titles} lines") };
            layout.inferred.push(format!("{lines} above the header: not read"));
        }
        if decimal.is_none() && decimal_found == Decimal::Comma {
            let divided = delimiter.name();
            layout.inferred.push(format!("commas are decimals, and cells are divided by {divided}"));
        }
        if is_header(&cells, decimal_found) {
            let units = content.get(1).map(|line| texts(line.text, delimiter)).filter(|units| {
                let is_row = units.iter().any(|cell| Calendar::parse(cell.as_bytes()).is_some());
                units.len() == cells.len() && is_header(units, decimal_found) && content.len() > 2 && !is_row
            });
            let last = if units.is_some() { &content[1] } else { first };
            layout.names = names(&cells);
            units.iter().flatten().zip(&mut layout.names).for_each(|(unit, name)| name.complete(unit));
            layout.lines = last.number;
            layout.start = head.len().min(last.end);
        } else if is_numbered(&cells, &shown) {
            let message = "the first line has the numbers of the columns, as a table of pandas without names, and is no sample";
            layout.inferred.push(message.to_owned());
            layout.lines = first.number;
            layout.start = head.len().min(first.end);
        } else {
            // The header as NumPy's savetxt writes it.
            let is_sign = |byte: &u8| b"#%; \t".contains(byte);
            let words = |text: &&[u8]| {
                let signs = text.iter().take_while(|byte| is_sign(byte)).count();
                let words = texts(&text[signs..], delimiter);
                (words.len() == cells.len() && is_header(&words, decimal_found)).then(|| names(&words))
            };
            // Above the last comment there may be a header too, but other texts as well.
            let last = comments.last().and_then(words);
            let has_time = |names: &Vec<Name>| names.iter().any(|name| is_time(&name.bare));
            let other = || comments.iter().rev().filter_map(words).find(has_time);
            layout.names = last.or_else(other).unwrap_or_default();
        }
        if labview.is_some() {
            let line = layout.lines + 1;
            layout.inferred.push(format!("a measurement of LabVIEW, whose numbers begin in line {line}"));
            for name in layout.names.iter_mut().filter(|name| name.whole == "X_Value") {
                name.complete("s");
            }
        }
        let above = String::from_utf8_lossy(&head[..first.start]);
        let rows = &layout.rows;
        let step = |column: usize| {
            let numbers = rows.get(column).filter(|numbers| numbers.len() > 1)?;
            Some(median_step(numbers)).filter(|step| *step > 0.0)
        };
        match loggers::complete(&mut layout.names, file, &above, &step) {
            Some(Known::One(note)) => layout.inferred.push(note),
            Some(Known::Several(rivals)) => layout.rivals = Some(rivals),
            None => {}
        }
        Ok(layout)
    }

    /// The number that a cell of a column stands for, NaN where it is missing.
    #[inline]
    pub(crate) fn value(&self, column: usize, cell: &[u8]) -> Option<f64> {
        match self.calendar.get(column) {
            Some(Some(calendar)) => calendar.seconds(cell, self.first.unwrap_or(First::Month)),
            _ => self.decimal.value(cell),
        }
    }

    /// The place where a column is shown, or all of them.
    pub(crate) fn place(&self, column: Option<usize>) -> Place {
        let Shown { number, text, cells } = &self.shown;
        // Where blanks divide, units separated by blanks are cells of their own.
        let is_cut = self.delimiter == Delimiter::Blanks && !self.names.is_empty();
        let cell = column.filter(|_| !is_cut).and_then(|at| cells.get(at));
        Place::new(&self.file, *number, text, cell.cloned().unwrap_or(0..text.len()))
    }
}

/// What the header of a file of Stable32 states.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stated {
    /// The sampling step, s.
    pub step_s: Option<f64>,
    /// The number of points, and the line that has it.
    pub points: Option<(usize, Place)>,
    /// Phases are angles, and frequencies rates.
    pub data: Option<Data>,
}

/// Finds the lines up to `# Header End`, such as `File: PHASE.DAT`, `Date: …`, `Type: Phase`, `Points: 1000` and `Tau: 1.0e+00`, and
/// returns their length in bytes with what they state.
fn stable32(head: &[u8], file: &str) -> Option<(usize, Stated)> {
    let (mut end, mut stated) = (0, Stated::default());
    for (line, number) in head.split_inclusive(|byte| *byte == b'\n').take(MAX_HEADER).zip(1..) {
        end += line.len();
        let text = String::from_utf8_lossy(line);
        let text = text.trim().trim_start_matches('#').trim_start();
        if text.eq_ignore_ascii_case("header end") {
            return Some((end, stated));
        }
        let Some((key, value)) = text.split_once([':', '=']) else { continue };
        let value = value.trim();
        match key.trim().to_ascii_lowercase().as_str() {
            "tau" => {
                let seconds = value.parse().ok();
                let with_unit = || parse_quantity(value, &[Dimension::Time]).ok().map(|tau| tau.value);
                let is_step = |step_s: &f64| *step_s > 0.0 && step_s.is_finite();
                stated.step_s = seconds.or_else(with_unit).filter(is_step);
            }
            "points" | "number of points" => {
                let line = line.trim_ascii_end();
                let place = Place::new(file, number, line, 0..line.len());
                stated.points = value.parse().ok().map(|points| (points, place));
            }
            "type" if value.eq_ignore_ascii_case("phase") => stated.data = Some(Data::Angle),
            "type" if value.eq_ignore_ascii_case("frequency") => stated.data = Some(Data::Rate),
            _ => {}
        }
    }
    None
}

/// Finds the end of the headers of a measurement file of LabVIEW (.lvm), in bytes.
fn labview(head: &[u8]) -> Option<usize> {
    let mut end = 0;
    let lines = head.split_inclusive(|byte| *byte == b'\n').take(MAX_HEADER).map(|line| {
        end += line.len();
        (line, end)
    });
    let ends = lines.filter(|(line, _)| line.starts_with(b"***End_of_Header***")).map(|(_, end)| end);
    ends.last().filter(|_| head.starts_with(b"LabVIEW Measurement"))
}

/// Most lines in the header of a file of Stable32 or LabVIEW.
const MAX_HEADER: usize = 200;

/// The delimiter and the decimals of some lines, of which the first may be a header; the decimals may be given.
fn signs(content: &[Line], decimal: Option<Decimal>) -> (Delimiter, Decimal) {
    let (first, row) = (content[0].text, content.last().unwrap_or(&content[0]).text);
    let found =
        |decimal| (Delimiter::parse(first, content.get(1).unwrap_or(&content[0]).text, decimal), decimal);
    if let Some(decimal) = decimal {
        return found(decimal);
    }
    let (delimiter, _) = found(Decimal::Point);
    let cells = |delimiter| Cells::new(row, delimiter).map(|cell| &row[cell]);
    if delimiter != Delimiter::Byte(b',') {
        let any = |is: &dyn Fn(&[u8]) -> bool| {
            content.iter().any(|line| Cells::new(line.text, delimiter).any(|cell| is(&line.text[cell])))
        };
        let has_points =
            any(&|cell| cell.contains(&b'.') && Decimal::Point.value(cell).is_some_and(f64::is_finite));
        let are_commas = !has_points && any(&Decimal::is_comma);
        return (delimiter, if are_commas { Decimal::Comma } else { Decimal::Point });
    }
    // Commas that divide cells leave `01 1` of `0,01 1,5`; or more cells than names in the header.
    let blanks = Delimiter::Blanks;
    let are_decimals = cells(blanks).all(|cell| Decimal::Comma.value(cell).is_some());
    let is_divided = cells(delimiter).all(|cell| Decimal::Point.value(cell).is_some());
    let names = texts(first, blanks);
    let fits_header = is_header(&names, Decimal::Comma)
        && texts(first, delimiter).len() != delimiter.count(row)
        && names.len() == blanks.count(row);
    match are_decimals && (!is_divided || fits_header) {
        true => (blanks, Decimal::Comma),
        false => (delimiter, Decimal::Point),
    }
}

/// Number of lines above the header, such as the name of a logger: lines of words in fewer cells than the rows have, before one with as
/// many names as the rows have cells. A line with as many cells, of which half have names, may be a header above one of units.
fn titles(content: &[Line], decimal: Option<Decimal>) -> usize {
    let Some(row) = content.last() else { return 0 };
    let named = |line: &Line, delimiter, decimal| {
        let cells = texts(line.text, delimiter);
        let named = cells.iter().filter(|cell| !cell.trim().is_empty()).count();
        is_header(&cells, decimal).then_some((named, cells.len()))
    };
    let is_below_titles = |at: &usize| {
        let (delimiter, decimal) = signs(&content[*at..], decimal);
        let columns = texts(row.text, delimiter).len();
        // The last cell of the rows may be empty, as one for remarks.
        let cells = Cells::new(row.text, delimiter).count();
        let is_title = |line| {
            named(line, delimiter, decimal)
                .is_some_and(|(named, count)| named == 1 || 2 * named < columns || count < columns)
        };
        columns > 1
            && named(&content[*at], delimiter, decimal)
                .is_some_and(|(named, count)| named == count && [columns, cells].contains(&count))
            && content[..*at].iter().all(is_title)
    };
    (0..content.len() - 1).find(is_below_titles).unwrap_or(0)
}

/// The first lines with content from `start` on, and the comments before the first.
fn first_lines(head: &[u8], start: usize) -> (Vec<Line<'_>>, Vec<&[u8]>) {
    let bom: &[u8] = b"\xef\xbb\xbf";
    let mut number = head[..start].iter().filter(|byte| **byte == b'\n').count();
    let mut start = if start == 0 && head.starts_with(bom) { bom.len() } else { start };
    let (mut content, mut comments) = (Vec::new(), Vec::new());
    while start < head.len() && content.len() < SAMPLE {
        let end = head[start..].iter().position(|byte| *byte == b'\n').map_or(head.len(), |n| start + n);
        let text = &head[start..end];
        number += 1;
        if !Delimiter::Byte(b',').skips(text) {
            content.push(Line { number, start, end: end + 1, text: text.trim_ascii_end() });
        } else if content.is_empty() && !text.trim_ascii().is_empty() {
            comments.push(text);
        }
        start = end + 1;
    }
    (content, comments)
}

fn texts(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for cell in Cells::new(line, delimiter) {
        let text = decoded(&line[cell]);
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
fn is_header(cells: &[String], decimal: Decimal) -> bool {
    let mut values = cells.iter().map(|cell| decimal.value(cell.as_bytes()));
    values.clone().any(|value| value.is_none()) && !values.any(|value| value.is_some_and(f64::is_finite))
}

/// Whether cells are the numbers of the columns from 0 on, which may have an index without a name before them, above rows that are
/// no whole numbers.
fn is_numbered(cells: &[String], below: &[Vec<u8>]) -> bool {
    let index = usize::from(cells.first().is_some_and(String::is_empty));
    let (numbered, below) = (&cells[index..], &below[index.min(below.len())..]);
    let is_whole = |cell: &Vec<u8>| cell.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-');
    numbered.len() > 1 - index
        && numbered.iter().enumerate().all(|(at, cell)| *cell == at.to_string())
        && !below.iter().any(is_whole)
}

fn names(cells: &[String]) -> Vec<Name> {
    cells.iter().map(|cell| Name::read(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        Layout::parse(text.as_bytes(), "g.csv", None).unwrap()
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
    fn decimal_commas_and_lines_of_units_are_found() {
        use Decimal::{Comma, Point};
        let table: [(&str, &[&str], usize, Decimal); 9] = [
            ("t;gx\n0,01;1,5\n", &["t", "gx"], 2, Comma),
            ("0,01\t1,5\n", &[], 2, Comma),
            ("t gx\n0,01 1,5\n", &["t", "gx"], 2, Comma),
            ("0,01 -1,5\n0,02 1\n", &[], 2, Comma),
            ("gz [deg/s]\n1,5\n", &["gz"], 1, Comma),
            ("1,5\n2,5\n", &[], 2, Point),
            ("t,gx\n0.01,1.5\n", &["t", "gx"], 2, Point),
            ("t;note\n1;a,b\n", &["t", "note"], 2, Point),
            ("t;gx\n1;2\n2;2,5\n", &["t", "gx"], 2, Comma),
        ];
        for (text, names, columns, decimal) in table {
            let found = layout(text);
            assert_eq!(
                (bare(&found), found.columns, found.decimal),
                (names.to_vec(), columns, decimal),
                "{text}"
            );
        }
        let units = layout("time;gx\n[s];[dps]\n0;1\n");
        let found: Vec<Option<&str>> = units.names.iter().map(|name| name.unit.as_deref()).collect();
        assert_eq!((found, units.lines), (vec![Some("s"), Some("dps")], 2));
    }

    #[test]
    fn titles_above_the_header_are_not_read() {
        for title in ["Logger XY v1.2", "Logger XY v1.2;;", "Logger;;\nserial 17a;;", "Logger;serial 17a"] {
            let found =
                layout(&format!("{title}\nt [s];gz [dps];temp [degC]\n0,01;1,5;20,1\n0,02;1,6;20,1\n"));
            assert_eq!(bare(&found), ["t", "gz", "temp"], "{title}");
            assert_eq!(found.lines, title.lines().count() + 1);
            assert!(
                found.inferred.iter().any(|note| note.ends_with("above the header: not read")),
                "{title}"
            );
        }
        assert_eq!(bare(&layout("t;gz\ns;deg/s\n1;2\n2;3\n")), ["t", "gz"], "units are no names");
        assert_eq!(bare(&layout(",time,gz\n-,s,deg/s\n0,1,2\n1,2,3\n")), ["", "time", "gz"]);
        assert_eq!(bare(&layout("gz\n1\n2\n")), ["gz"]);
    }

    #[test]
    fn a_header_of_stable32_is_skipped_and_its_sampling_step_taken() {
        let text = "File: PHASE.DAT\nDate: 10/03/2008 12:00:00\nType: Phase\nTau: 1.00e-01\n# Header End\n1.5e-9\n2.5e-9\n";
        let found = layout(text);
        assert_eq!(
            (found.stated.step_s, found.lines, found.columns, found.names.len()),
            (Some(0.1), 5, 1, 0)
        );
        assert!(text[found.start..].starts_with("1.5e-9"));
    }

    #[test]
    fn a_header_of_names_may_stand_above_other_comments() {
        let rows = "0.0 1.0\n0.1 2.0\n";
        for (comments, names) in [
            ("# t gx\n# units: s deg/s and more\n", &["t", "gx"][..]),
            ("# t gx\n# my log\n", &["my", "log"]),
            ("# my log\n# of three words\n", &[]),
        ] {
            assert_eq!(bare(&layout(&format!("{comments}{rows}"))), names, "{comments}");
        }
    }

    #[test]
    fn the_numbers_of_a_measurement_of_labview_begin_below_its_headers() {
        let header = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\nChannels\t1\nDelta_X\t0,01\n***End_of_Header***\nX_Value\tgz (deg/s)\tComment\n";
        let found = layout(&format!("{header}0,00\t1,5\n0,01\t1,6\n0,02\t1,7\n"));
        assert_eq!((bare(&found), found.columns, found.lines), (vec!["X_Value", "gz"], 2, 9));
        assert_eq!((found.names[0].unit.as_deref(), found.decimal), (Some("s"), Decimal::Comma));
    }

    #[test]
    fn an_empty_cell_in_the_last_line_looked_at_hides_no_clock() {
        let rows: String =
            (0..40).map(|i| if i == 30 { ",1\n".to_owned() } else { format!("10:00:{i:02},1\n") }).collect();
        let found = layout(&format!("time,gz\n{rows}"));
        assert_eq!(found.calendar, [Some(Calendar::Time), None]);
        assert!(found.numbers[0].is_some_and(f64::is_finite), "{:?}", found.numbers);
        assert!(
            layout("t;gz;x\ns;dps;\n1;2;\n2;3;\n").numbers[2].is_some_and(f64::is_nan),
            "no cell of x has a number"
        );
    }

    #[test]
    fn a_file_without_samples_says_so() {
        for (text, piece) in [("", "is empty"), ("# only\n\n", "has no samples")] {
            let error = Layout::parse(text.as_bytes(), "g.csv", None).unwrap_err();
            assert!(error.to_string().contains(piece), "{error}");
        }
        assert_eq!(layout("a,b\n").columns, 2);
    }
}
