//! Reading a file into a [`Log`].

use std::fs::File;
use std::io::{Chain, Cursor, Read};
use std::path::Path;

use crate::quantity::number::significant;
use crate::quantity::units::{Dimension, parse_unit};
use crate::record::STEPS_S;

use crate::record::log::channel::{Channel, Log};
use crate::record::log::error::LogError;
use crate::record::log::layout::Layout;
use crate::record::log::measure::expected;
use crate::record::log::measure::{Data, Unit};
use crate::record::log::names::{self, Name, listed};
use crate::record::log::npy::{Array, MAGIC};
use crate::record::log::text::{self, TEXT_WANTED};
#[cfg(doc)]
use crate::record::log::time::JITTER;
use crate::record::log::time::{TimeFault, grid};
use crate::record::log::{MOST_SAMPLES, STEPS_HELP, unreadable};
use crate::source::place::Place;

/// Bytes from which the layout of a text is determined.
const HEAD: u64 = 1 << 20;

/// The columns of a log to read, and their interpretation.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Column names or numbers from 1. If there are none, the file must have only one column besides the time.
    pub columns: Vec<String>,
    /// Spacing of the samples.
    pub timing: Timing,
    /// Quantity of the samples.
    pub data: Data,
    /// Unit; if absent, that in each column's header.
    pub unit: Option<Unit>,
}

/// The times of the samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Timing {
    /// A constant step, s.
    Step(f64),
    /// The times in a column.
    Stamps {
        /// Name of the column, or its number from 1.
        column: String,
        /// Unit of the times, such as `ms`; if absent, that in the header.
        unit: Option<String>,
    },
}

/// First bytes of unsupported files that users often give, with their descriptions.
const OTHERS: [(&[u8], &str); 8] = [
    (b"PK\x03\x04", "a ZIP archive (.npz, .xlsx)"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"\x89HDF", "HDF5 (.h5, .mat)"),
    (b"MATLAB 5.0", "a MATLAB file (.mat)"),
    (b"PAR1", "Parquet"),
    (b"\xff\xfe", "text in UTF-16"),
    (b"\xfe\xff", "text in UTF-16"),
    (b"#ROSBAG", "a ROS bag"),
];

/// [`Timing`] with the column looked up.
#[derive(Clone, Copy)]
enum When {
    Step(f64),
    /// Time stamps; `factor` is the size of their unit in s.
    Stamps {
        column: usize,
        factor: f64,
    },
}

/// The contents of the file, before any sample is read.
enum Contents {
    Text(Layout),
    Npy(Array),
}

type Bytes = Chain<Cursor<Vec<u8>>, File>;

impl Log {
    /// Reads the columns of the log at `path` that `request` selects.
    ///
    /// Text may be CSV, TSV, separated by semicolons or in columns with blanks between, with or without a header, and
    /// with comments after `#`, `%` or `;`; a Stable32 .DAT is one such file. Empty cells and NaN are missing samples,
    /// and so are those skipped by a step of several sampling steps. The sampling step is the median step, and all
    /// steps must be within [`JITTER`] of whole multiples of it.
    ///
    /// # Errors
    /// The first fault found, with its place where the file has lines.
    ///
    /// # Example
    /// ```
    /// # use sagnac::record::log::{Data, Log, Request, Timing};
    /// # let folder = tempfile::tempdir()?;
    /// # let path = &folder.path().join("gyro.csv");
    /// std::fs::write(path, "time [ms],gz [deg/h]\n0,8.1\n10,8.3\n30,8.2\n")?;
    /// let timing = Timing::Stamps { column: "time".to_owned(), unit: None };
    /// let request = Request { columns: vec!["gz".to_owned()], timing, data: Data::Rate, unit: None };
    /// let log = Log::read(path, &request)?;
    /// assert_eq!((log.step_s, log.samples(), log.channels[0].missing()), (0.01, 4, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: &Path, request: &Request) -> Result<Log, LogError> {
        let file = path.display().to_string();
        let mut open = File::open(path).map_err(|error| unreadable(&file, &error))?;
        let about = open.metadata().map_err(|error| unreadable(&file, &error))?;
        let mut head = Vec::new();
        open.by_ref().take(HEAD).read_to_end(&mut head).map_err(|error| unreadable(&file, &error))?;
        if let Some((_, what)) = OTHERS.iter().find(|(start, _)| head.starts_with(start)) {
            return Err(LogError::new(format!("{file} is {what}"), "", TEXT_WANTED, None));
        }
        if head.first() == Some(&0) {
            return Err(LogError::new(format!("{file} is binary"), "", TEXT_WANTED, None));
        }
        let contents =
            if head.starts_with(MAGIC) { None } else { Some(Contents::Text(Layout::of(&head, &file)?)) };
        let mut bytes = Cursor::new(head).chain(open);
        let contents = match contents {
            Some(text) => text,
            None => Contents::Npy(Array::read(&file, &mut bytes, about.is_file().then_some(about.len()))?),
        };
        Reader { path, file, contents }.log(request, bytes)
    }
}

struct Reader<'p> {
    path: &'p Path,
    file: String,
    contents: Contents,
}

impl Reader<'_> {
    fn names(&self) -> Option<&[Name]> {
        match &self.contents {
            Contents::Text(layout) => layout.names.as_deref(),
            Contents::Npy(_) => None,
        }
    }

    fn columns(&self) -> usize {
        match &self.contents {
            Contents::Text(layout) => layout.columns,
            Contents::Npy(array) => array.columns,
        }
    }

    /// The place where a column is shown, or all of them.
    fn place(&self, column: Option<usize>) -> Option<Place> {
        match &self.contents {
            Contents::Text(layout) => {
                Some(column.map_or_else(|| layout.line(), |column| layout.place(column)))
            }
            Contents::Npy(_) => None,
        }
    }

    fn log(self, request: &Request, bytes: Bytes) -> Result<Log, LogError> {
        let when = match &request.timing {
            Timing::Step(step_s) => When::Step(*step_s),
            Timing::Stamps { column, unit } => self.stamps(column, unit.as_deref())?,
        };
        let time = match when {
            When::Step(_) => None,
            When::Stamps { column, .. } => Some(column),
        };
        let wanted = self.wanted(&request.columns, time)?;
        let mut channels =
            wanted.iter().map(|&column| self.channel(column, request)).collect::<Result<Vec<_>, _>>()?;
        let all: Vec<usize> = time.into_iter().chain(wanted).collect();
        if (1..all.len()).any(|i| all[..i].contains(&all[i])) {
            let message = "a column is requested twice";
            return Err(LogError::new(
                message,
                "these are the columns",
                "name each column once",
                self.place(None),
            ));
        }
        let mut columns = match &self.contents {
            Contents::Text(layout) => text::read(layout, bytes, &all)?,
            Contents::Npy(array) => array.columns(bytes, &all)?,
        };
        let step_s = match when {
            When::Step(step_s) => step_s,
            When::Stamps { column, factor } => {
                let stamps = columns.remove(0);
                let grid = grid(&stamps, MOST_SAMPLES)
                    .map_err(|fault| self.refuse(column, factor, &stamps, fault))?;
                columns = columns.into_iter().map(|values| grid.spread(values)).collect();
                grid.step * factor
            }
        };
        if !STEPS_S.contains(&step_s) {
            let message = format!("the samples are {} s apart", significant(step_s, 6));
            return Err(LogError::new(message, "of this time", STEPS_HELP, self.place(time)));
        }
        channels.iter_mut().zip(columns).for_each(|(channel, samples)| channel.samples = samples);
        Ok(Log { file: self.file, step_s, data: request.data, start_s: 0.0, channels })
    }

    /// The column of the time, with the size of its unit.
    fn stamps(&self, word: &str, unit: Option<&str>) -> Result<When, LogError> {
        let column = self.find(word)?;
        let of_header = self.names().and_then(|names| names[column].unit.as_deref());
        let help = "give its unit as in `time_unit = ms`; accepted: s, ms, us, ns, min, h";
        let Some(text) = unit.or(of_header) else {
            let message = format!("the time column `{word}` has no unit");
            return Err(LogError::new(message, "its unit is missing", help, self.place(Some(column))));
        };
        match parse_unit(text, &[Dimension::Time]) {
            Ok((factor, _)) => Ok(When::Stamps { column, factor }),
            Err(error) => {
                let message = format!("the unit of the time column `{word}`: {error}");
                Err(LogError::new(message, "no time", help, self.place(Some(column))))
            }
        }
    }

    fn find(&self, word: &str) -> Result<usize, LogError> {
        names::find(word, self.names(), self.columns())
            .map_err(|none| LogError::new(none.message, "these are the columns", none.help, self.place(None)))
    }

    /// The columns of samples.
    fn wanted(&self, words: &[String], time: Option<usize>) -> Result<Vec<usize>, LogError> {
        if !words.is_empty() {
            return words.iter().map(|word| self.find(word)).collect();
        }
        let others: Vec<usize> = (0..self.columns()).filter(|column| Some(*column) != time).collect();
        match others[..] {
            [only] => Ok(vec![only]),
            [] => {
                let help = "add a column of samples, or give `rate = 100Hz` instead of a time column";
                Err(LogError::new(
                    "there is no column besides the time",
                    "the only one",
                    help,
                    self.place(None),
                ))
            }
            _ => {
                let message = format!("the file has {} columns: select some of them", self.columns());
                let list = listed(self.names(), self.columns());
                let help = format!("name one or several as in `column = 2,3`: {list}");
                Err(LogError::new(message, "these are the columns", help, self.place(None)))
            }
        }
    }

    /// A channel for a column, without its samples.
    fn channel(&self, column: usize, request: &Request) -> Result<Channel, LogError> {
        let name = self.names().map(|names| &names[column]);
        let in_header = name.and_then(|name| name.unit.clone());
        let place = self.place(Some(column));
        let unit = match (&request.unit, &in_header) {
            (Some(unit), _) => unit.clone(),
            (None, Some(text)) => Unit::parse(text, request.data)
                .map_err(|wrong| LogError::new(wrong.message, "no such unit", wrong.help, place.clone()))?,
            (None, None) => {
                let message = match name {
                    Some(name) => format!("the unit of `{}` is missing", name.whole),
                    None => format!("the unit of column {} is missing", column + 1),
                };
                return Err(LogError::new(message, "no unit", expected(request.data), place));
            }
        };
        let shown = name.map_or_else(|| (column + 1).to_string(), |name| name.bare.clone());
        let name = if shown.is_empty() { (column + 1).to_string() } else { shown };
        Ok(Channel { name, unit, unit_in_header: in_header, samples: vec![], place })
    }

    fn refuse(&self, column: usize, factor: f64, stamps: &[f64], fault: TimeFault) -> LogError {
        let row = fault.row();
        let place = match &self.contents {
            Contents::Text(layout) => text::place_of_row(layout, self.path, row, column),
            Contents::Npy(_) => None,
        };
        let row = if place.is_some() { String::new() } else { format!("row {}: ", row + 1) };
        let [message, label, help] = fault.words(stamps, factor);
        LogError::new(row + &message, label, help, place)
    }
}
