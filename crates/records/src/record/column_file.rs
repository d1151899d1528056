//! An open file of recorded data: its columns by name or number, their units, and the numbers of the requested columns.

use std::path::PathBuf;

use crate::record::format::{Columns, FORMATS, Origin, Source, open_parts};
use crate::record::layout::Decimal;
use crate::record::log::Field;
use crate::record::log::measure::Data;
use crate::record::log::read::Hints;
use crate::record::loggers::Rivals;
use crate::record::names::{Name, unit_of};
use crate::record::text::{TEXT_WANTED, Text};
use crate::record::time::Calendar;
use crate::record::{RecordError, STEPS_S, excess};
use sagnac_base::diagnostics::{Place, choices};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, parse as parse_quantity};

/// Most columns that a message lists.
pub(crate) const MAX_LISTED: usize = 20;

/// Fewest rows that show how a column goes on.
const MIN_ROWS: usize = 8;

/// Fewest rises of a counter for each time that it begins again.
const MIN_RISES: usize = 4;

/// Advice on text in another encoding.
const UTF_8_WANTED: &str = "save it as UTF-8, which editors and spreadsheets offer as the encoding of text";

/// First bytes of unsupported files that users often give, with their descriptions and what to do.
const OTHERS: [(&[u8], &str, &str); 13] = [
    (b"CDF", "netCDF of an old version", "convert it with `nccopy -k nc4 OLD.nc NEW.nc`"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd", "unpack it with `zstd -d`"),
    (b"BZh", "compressed by bzip2", "unpack it with `bzip2 -d`"),
    (b"\xfd7zXZ\0", "compressed by xz", "unpack it with `xz -d`"),
    (
        b"PAR1",
        "Parquet, which this build of sagnac does not read",
        "programs of releases and builds with `--features parquet` read it; or convert it with \
         `pandas.read_parquet(\"LOG\").to_csv(\"LOG.csv\")` in Python",
    ),
    (
        b"ARROW1",
        "Arrow (Feather)",
        "convert it with `pandas.read_feather(\"LOG\").to_csv(\"LOG.csv\")` in Python",
    ),
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "a workbook of Excel (.xls)",
        "save the sheet of the samples as CSV",
    ),
    (b"\x89PNG", "a picture (PNG)", TEXT_WANTED),
    (b"\xff\xd8\xff", "a picture (JPEG)", TEXT_WANTED),
    (b"%PDF", "a document (PDF)", TEXT_WANTED),
    (b"\xff\xfe", "text in UTF-16", UTF_8_WANTED),
    (b"\xfe\xff", "text in UTF-16", UTF_8_WANTED),
    (b"#ROSBAG", "a ROS bag of an old version", TEXT_WANTED),
];

/// First bytes that tell binary files from text, and the largest part of control signs in text, as a divisor.
const SAMPLE: usize = 4096;
const MAX_CONTROLS: usize = 32;

/// Advice on binary files of no known format.
const BINARY_WANTED: &str = "describe its rows as in `binary = \"f64 x7, little, time 1, rate 3\"`; known formats are text, .npy, \
                             .npz, MATLAB .mat, HDF5, MCAP, ROS bags (.bag and .db3), ULog and DataFlash";

/// What a caller accepts of a file.
#[derive(Clone, Copy)]
pub(crate) struct Rules {
    /// Most rows, and most samples on an even grid.
    pub most: usize,
    /// Advice on missing numbers.
    pub missing: &'static str,
    /// Largest deviation of a step from a whole number of sampling steps, in sampling steps.
    pub jitter: f64,
    /// Whether a longer step is a gap instead of a fault.
    pub has_gaps: bool,
    /// Advice on other steps.
    pub uneven: &'static str,
}

impl Rules {
    /// Refuses `file` if it has too many rows.
    pub(crate) fn limit(&self, file: &str, rows: usize) -> Result<(), RecordError> {
        if rows <= self.most {
            return Ok(());
        }
        let message = format!("{file} has more than {} rows", self.most);
        Err(RecordError::new(message, "", "cut it, or average it to a lower rate", None))
    }
}

/// An open file of which no number has been read yet.
pub(crate) struct ColumnFile<'a> {
    /// Its name in messages.
    pub file: String,
    columns: Box<dyn Columns + 'a>,
}

impl<'a> ColumnFile<'a> {
    /// Opens the file and finds its format, as far as it does not follow from `hints`; messages call it `file`.
    ///
    /// # Errors
    /// The file cannot be read, or its format is not supported.
    pub(crate) fn open(
        file: String,
        origin: Origin<'a>,
        hints: &Hints,
    ) -> Result<ColumnFile<'a>, RecordError> {
        let source = Source::open(file.clone(), origin)?;
        let head = &source.head;
        let columns = match (&hints.binary, FORMATS.iter().find(|format| (format.begins)(head))) {
            (Some(layout), _) => layout.open(source)?,
            (None, Some(format)) => (format.open)(source)?,
            (None, None) => ColumnFile::text(source, hints.decimal)?,
        };
        Ok(ColumnFile { file, columns })
    }

    /// Opens the files of one recording in their order; messages call it `name`.
    ///
    /// # Errors
    /// A file cannot be read, or is of another format than those of ROS 2.
    pub(crate) fn open_parts(name: &str, files: &[PathBuf]) -> Result<ColumnFile<'static>, RecordError> {
        Ok(ColumnFile { file: name.to_owned(), columns: open_parts(name, files)? })
    }

    /// Opens a file of text.
    fn text(source: Source<'a>, decimal: Option<Decimal>) -> Result<Box<dyn Columns + 'a>, RecordError> {
        let (file, head) = (&source.file, &source.head);
        if let Some((_, what, help)) = OTHERS.iter().find(|(start, ..)| head.starts_with(start)) {
            return Err(RecordError::new(format!("{file} is {what}"), "", *help, None));
        }
        // Zeros and many control signs do not occur in text, but among the bytes of numbers.
        let sample = &head[..head.len().min(SAMPLE)];
        let is_control = |byte: &&u8| **byte < 0x20 && !byte.is_ascii_whitespace();
        if sample.contains(&0) || sample.iter().filter(is_control).count() > sample.len() / MAX_CONTROLS {
            return Err(RecordError::new(format!("{file} is binary"), "", BINARY_WANTED, None));
        }
        Ok(Box::new(Text::open(source, decimal)?))
    }

    /// Names of the columns; empty where they have none.
    pub(crate) fn names(&self) -> &[Name] {
        self.columns.names()
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns.count()
    }

    /// The groups of columns, each of one sensor, with the numbers of their rows, if it has such.
    pub(crate) fn groups(&self) -> Vec<(&str, usize)> {
        self.columns.groups()
    }

    /// The field of messages from which a column is, if it is from one.
    pub(crate) fn field(&self, column: usize) -> Option<Field> {
        self.columns.field(column)
    }

    /// A number of a column, NaN where it is not known, or nothing if the column seems to hold other things.
    pub(crate) fn sample(&self, column: usize) -> Option<f64> {
        self.columns.sample(column)
    }

    /// The numbers of a column in the first rows, if these are enough to show how it goes on.
    pub(crate) fn rows(&self, column: usize) -> &[f64] {
        let rows = self.columns.rows(column);
        if rows.len() < MIN_ROWS { &[] } else { rows }
    }

    /// The loggers whose header it may be, if these have other units.
    pub(crate) fn rivals(&self) -> Option<&Rivals> {
        self.columns.rivals()
    }

    /// Whether a column seems to hold one number, or to count rows.
    pub(crate) fn is_steady(&self, column: usize) -> bool {
        let steps = || self.rows(column).windows(2).map(|pair| pair[1] - pair[0]);
        steps()
            .next()
            .is_some_and(|first| [0.0, 1.0, -1.0].contains(&first) && steps().all(|step| step == first))
    }

    /// Whether a column seems to have times or to count: it rises from row to row, but where whole numbers begin again.
    pub(crate) fn rises(&self, column: usize) -> bool {
        let rows = self.rows(column);
        let steps = || rows.windows(2).map(|pair| pair[1] - pair[0]);
        let largest = rows.iter().copied().fold(0.0, f64::max);
        let are_counts = rows.iter().all(|number| *number >= 0.0 && number.fract() == 0.0);
        let rises = steps().filter(|step| *step > 0.0).count();
        let begin_again = || steps().all(|step| step > 0.0 || are_counts && step < -0.5 * largest);
        rises > 0 && MIN_RISES * (rows.len() - 1 - rises) <= rises && begin_again()
    }

    /// What times of the calendar a column holds, if any. Those of a time of day include the date in the column before.
    pub(crate) fn calendar(&self, column: usize) -> Option<Calendar> {
        self.columns.calendar(column)
    }

    /// What was inferred about the file, in a line each.
    pub(crate) fn inferred(&self) -> Vec<String> {
        self.columns.inferred()
    }

    /// What was found while the numbers were read, in a line each.
    pub(crate) fn found(&self) -> Vec<String> {
        self.columns.found()
    }

    /// The sampling step that the file states, s.
    pub(crate) fn step_s(&self) -> Option<f64> {
        self.columns.step_s()
    }

    /// The data that the file states.
    pub(crate) fn data(&self) -> Option<Data> {
        self.columns.data()
    }

    /// All columns as part of a sentence, such as `1 time, 2 gx` or `columns 1 … 4`.
    pub(crate) fn listed(&self) -> String {
        let (names, columns) = (self.names(), self.columns());
        let named = names.iter().zip(1..).map(|(name, number)| format!("{number} {}", name.whole));
        let more = if columns > MAX_LISTED { ", …" } else { "" };
        match columns {
            _ if !names.is_empty() => named.take(MAX_LISTED).collect::<Vec<_>>().join(", ") + more,
            1 => "column 1".to_owned(),
            _ => format!("columns 1 … {columns}"),
        }
    }

    /// The place where a column is shown, or all of them, if the file has lines.
    pub(crate) fn place(&self, column: Option<usize>) -> Option<Place> {
        self.columns.place(column)
    }

    /// An error about a column, or about all of them.
    pub(crate) fn refuse(
        &self,
        column: Option<usize>,
        message: &str,
        label: &str,
        help: &str,
    ) -> RecordError {
        self.error(message, [label, help], self.place(column))
    }

    /// An error about the number of a column in a row, counted from 0, with its place or else the number of the row.
    /// `words` are message, label and help.
    pub(crate) fn refuse_row(&self, row: usize, column: usize, words: [String; 3]) -> RecordError {
        let [message, label, help] = words;
        let place = self.columns.place_of_row(row, column);
        let numbered = if place.is_some() { String::new() } else { format!("row {}: ", row + 1) };
        self.error(&(numbered + &message), [&label, &help], place)
    }

    /// An error with the name of the file, which without a place stands in the message.
    fn error(&self, message: &str, [label, help]: [&str; 2], place: Option<Place>) -> RecordError {
        let named = if place.is_some() { message.to_owned() } else { format!("{}: {message}", self.file) };
        RecordError::new(named, label, help, place)
    }

    /// Finds the column that a user means by `word`: its name with or without unit, in upper or lower case, or its number
    /// from 1. Of several with that name it is the one whose unit is of the dimension `preferred`.
    ///
    /// # Errors
    /// No column matches, or several do; the error lists the columns and the nearest name.
    pub(crate) fn find(&self, word: &str, preferred: Option<Dimension>) -> Result<usize, RecordError> {
        let (word, names, columns) = (word.trim(), self.names(), self.columns());
        let refused =
            |message: String, help: String| Err(self.refuse(None, &message, "these are the columns", &help));
        let called = |is: &dyn Fn(&str) -> bool| -> Vec<usize> {
            (0..names.len()).filter(|&i| is(&names[i].whole) || is(&names[i].bare)).collect()
        };
        let mut found = called(&|name| name == word);
        if found.is_empty() {
            found = called(&|name| name.eq_ignore_ascii_case(word));
        }
        let unit = |i: usize| names[i].unit.as_deref().unwrap_or_default();
        let is_preferred = |i: &usize| preferred.is_some_and(|wanted| unit_of(unit(*i), &[wanted]).is_ok());
        if found.len() > 1 && found.iter().any(is_preferred) {
            found.retain(is_preferred);
        }
        match found[..] {
            [only] => return Ok(only),
            [] => {}
            ref several => {
                let numbers: Vec<String> =
                    several.iter().take(MAX_LISTED).map(|i| (i + 1).to_string()).collect();
                let more = if several.len() > MAX_LISTED { " and others" } else { "" };
                let both = if several.len() == 2 { "both " } else { "" };
                let message = format!("columns {}{more} are {both}called `{word}`", numbers.join(" and "));
                return refused(message, "give the number of the one you mean".to_owned());
            }
        }
        let list = self.listed();
        match word.parse::<usize>() {
            Ok(number) if (1..=columns).contains(&number) => Ok(number - 1),
            Ok(number) => refused(
                format!("there is no column {number}, the file has {columns}"),
                format!("columns are numbered from 1: {list}"),
            ),
            Err(_) if names.is_empty() => refused(
                format!("no column can be called `{word}`: the file has no header"),
                format!("give numbers, counted from 1: {list}"),
            ),
            Err(_) => {
                let bare: Vec<&str> = names.iter().map(|name| name.bare.as_str()).collect();
                let help = format!("{}; numbers from 1 are accepted too", choices(word, &bare));
                refused(format!("no column is called `{word}`"), help)
            }
        }
    }

    /// The size in base units of the unit of a column: the one `given`, or else that of its header. `what` names the
    /// column in messages, and `help` lists the accepted units.
    pub(crate) fn unit_size(
        &self,
        column: usize,
        given: Option<&str>,
        dimension: Dimension,
        what: &str,
        help: &str,
    ) -> Result<f64, RecordError> {
        let of_header = self.names().get(column).and_then(|name| name.unit.as_deref());
        let refused = |message: &str, label: &str| self.refuse(Some(column), message, label, help);
        let unit = given
            .or(of_header)
            .ok_or_else(|| refused(&format!("{what} has no unit"), "its unit is missing"))?;
        // Clocks may count ticks, as in `0.1 ms`.
        let ticks =
            || parse_quantity(unit, &[dimension]).ok().map(|tick| tick.value).filter(|size| *size > 0.0);
        let size = unit_of(unit, &[dimension]).map(|(size, _)| size);
        size.or_else(|error| {
            ticks().ok_or_else(|| refused(&format!("the unit of {what}: {error}"), error.label()))
        })
    }

    /// The numbers of the columns in the requested order, with NaN for missing ones.
    ///
    /// # Errors
    /// The file cannot be read, has too many rows, or contains something other than numbers.
    pub(crate) fn read(&mut self, columns: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let numbers = self.columns.read(columns, rules)?;
        for (numbers, &column) in numbers.iter().zip(columns) {
            let found = numbers.iter().enumerate().find_map(|(row, number)| Some((row, excess(*number)?)));
            if let Some((row, excess)) = found {
                let name = self.title(column);
                let message = format!("{}: {name} is {excess} at row {}", self.file, row + 1);
                return Err(RecordError::new(message, "", "put NaN where a sample is missing", None));
            }
        }
        Ok(numbers)
    }

    /// A column in a sentence: its name, or else its number.
    pub(crate) fn title(&self, column: usize) -> String {
        let name = self.names().get(column);
        name.map_or_else(|| format!("column {}", column + 1), |name| format!("`{}`", name.whole))
    }

    /// Refuses a sampling step, s, that is impossible for a sensor; `time` is the column of the stamps.
    pub(crate) fn check_step(&self, step_s: f64, time: Option<usize>) -> Result<(), RecordError> {
        if STEPS_S.contains(&step_s) {
            return Ok(());
        }
        let message = format!("the samples are {} s apart", significant(step_s, 6));
        let help = "accepted: 1e-9 s to 1e9 s; is the unit of the time right?";
        Err(self.refuse(time, &message, "of this time", help))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(header: &str) -> ColumnFile<'_> {
        ColumnFile::open("g.csv".to_owned(), Origin::Bytes(header.as_bytes()), &Hints::default()).unwrap()
    }

    #[test]
    fn a_column_is_found_by_name_with_or_without_unit_or_by_its_number() {
        let named = recording("time_ms,gx [deg/s],gz (deg/s),Temp,x_y\n");
        for (word, column) in [("time", 0), ("time_ms", 0), ("gx", 1), ("GZ", 2), ("gz (deg/s)", 2), ("4", 3)]
        {
            assert_eq!(named.find(word, None).ok(), Some(column), "{word}");
        }
        assert_eq!(recording("1,2,3\n").find("2", None).ok(), Some(1));
        let doubled = recording("rate_s,rate [deg/s]\n");
        assert_eq!(doubled.find("rate", Some(Dimension::Rate)).ok(), Some(1));
    }

    #[test]
    fn columns_of_times_and_counters_rise_and_others_do_not() {
        let row = |i: i32| {
            let ns = (987_528_132 + 5_000_000 * i64::from(i)) % 1_000_000_000;
            format!(
                "{ns},{},{},{:.2},{}\n",
                0.01 * f64::from(i),
                i % 16,
                f64::from(i * 37 % 11) - 5.0,
                i * 37 % 11
            )
        };
        let text: String = (0..30).map(row).collect();
        let log = recording(&text);
        assert_eq!(
            (0..5).map(|column| log.rises(column)).collect::<Vec<_>>(),
            [true, true, true, false, false]
        );
    }

    #[test]
    fn a_wrong_column_is_told_with_the_nearest_and_all_that_there_are() {
        let named = "time_ms,gx [deg/s],gz (deg/s),Temp,x_y\n";
        for (header, word, pieces) in [
            (named, "gzz", ["no column is called `gzz`", "did you mean `gz`", "Temp"]),
            (named, "9", ["there is no column 9", "the file has 5", "2 gx [deg/s]"]),
            ("1,2,3\n", "0", ["there is no column 0", "from 1", "columns 1 … 3"]),
            ("1,2,3\n", "gz", ["can be called `gz`", "no header", "columns 1 … 3"]),
            ("a,a\n", "a", ["columns 1 and 2", "both called `a`", "g.csv:1:1"]),
        ] {
            let said = recording(header).find(word, None).unwrap_err().render(false, 200);
            for piece in pieces {
                assert!(said.contains(piece), "{piece} is missing in\n{said}");
            }
        }
    }
}
