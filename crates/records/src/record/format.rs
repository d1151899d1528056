//! The formats of recorded data, each in a file of this folder.

mod dataflash;
mod db3;
mod groups;
#[cfg(feature = "hdf5")]
mod hdf5;
mod mat;
mod messages;
mod numpy;
mod packed;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "ros")]
mod ros;
mod sqlite;
mod ulog;

use std::io::{self, Chain, Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::record::column_file::Rules;
#[cfg(feature = "hdf5")]
use crate::record::format::hdf5::open as open_hdf5;
use crate::record::format::messages::Messages;
use crate::record::format::packed::Packing;
#[cfg(feature = "ros")]
use crate::record::format::ros::{open_bag, open_mcap, take_mcap};
use crate::record::log::Field;
use crate::record::log::measure::Data;
use crate::record::loggers::Rivals;
use crate::record::names::Name;
use crate::record::time::Calendar;
use crate::record::{RecordError, malformed, told};
use sagnac_base::diagnostics::Place;
use sagnac_base::text_file::open;

/// Bytes from which the format and the layout of a file are determined.
pub(crate) const HEAD: u64 = 1 << 20;

/// A format of files.
pub(crate) struct Format {
    /// Whether files that begin like this have the format.
    pub begins: fn(&[u8]) -> bool,
    /// Opens such a file.
    pub open: for<'a> fn(Source<'a>) -> Result<Box<dyn Columns + 'a>, RecordError>,
}

/// All formats that the first bytes tell; other files are text.
pub(crate) static FORMATS: &[Format] = &[
    numpy::NPY,
    numpy::NPZ,
    // Before MATLAB's earlier format, because its files may begin like those.
    Format { begins: is_hdf5, open: open_hdf5 },
    mat::FORMAT,
    Format { begins: |head| head.starts_with(MCAP), open: open_mcap },
    Format { begins: |head| head.starts_with(b"#ROSBAG V2.0\n"), open: open_bag },
    #[cfg(feature = "parquet")]
    parquet::FORMAT,
    ulog::FORMAT,
    dataflash::FORMAT,
    db3::FORMAT,
];

/// The first bytes of an MCAP file.
const MCAP: &[u8] = b"\x89MCAP0\r\n";

/// Opens the files of one recording of ROS 2 in their order; messages call it `name`.
///
/// # Errors
/// A file is no recording of ROS 2, or cannot be read.
pub(crate) fn open_parts(name: &str, files: &[PathBuf]) -> Result<Box<dyn Columns>, RecordError> {
    let mut messages = Messages::default();
    for path in files {
        let source = Source::open(path.display().to_string(), Origin::Path(path))?;
        match &source.head {
            head if head.starts_with(MCAP) => take_mcap(source, &mut messages)?,
            head if (db3::FORMAT.begins)(head) => db3::take(source, &mut messages)?,
            _ => {
                let message = format!("{} is no recording of ROS 2 (.db3, .mcap)", source.file);
                return Err(RecordError::new(message, "", "give each log by itself", None));
            }
        }
    }
    messages.columns(name)
}

/// Whether the signature is at the start, or after a block of the user's of 512, 1024, … bytes.
fn is_hdf5(head: &[u8]) -> bool {
    let starts =
        std::iter::successors(Some(512), |start| Some(2 * start)).take_while(|start| *start < head.len());
    std::iter::once(0).chain(starts).any(|start| head[start..].starts_with(b"\x89HDF\r\n\x1a\n"))
}

#[cfg(not(feature = "hdf5"))]
fn open_hdf5(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    Err(left_out(&source, "HDF5 (.h5, .mat)", "hdf5"))
}

#[cfg(not(feature = "ros"))]
fn open_mcap(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    Err(left_out(&source, "MCAP", "ros"))
}

#[cfg(not(feature = "ros"))]
fn take_mcap(source: Source<'_>, _: &mut Messages) -> Result<(), RecordError> {
    open_mcap(source).map(drop)
}

#[cfg(not(feature = "ros"))]
fn open_bag(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    Err(left_out(&source, "a ROS bag", "ros"))
}

/// The error for a format of which this build lacks the library.
#[cfg(not(all(feature = "hdf5", feature = "ros")))]
fn left_out(source: &Source, what: &str, feature: &str) -> RecordError {
    let message = format!("{} is {what}, which this build of sagnac does not read", source.file);
    let help = format!("build it with the feature {feature}, or save the samples as CSV or .npy");
    RecordError::new(message, "", help, None)
}

/// The columns of an opened file, of which no number has been read yet.
pub(crate) trait Columns {
    /// Names of the columns; empty where they have none.
    fn names(&self) -> &[Name];

    fn count(&self) -> usize;

    /// The numbers of the `wanted` columns in the given order, with NaN for missing ones.
    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError>;

    /// The groups of columns, each of one sensor, with the numbers of their rows, if it has such.
    fn groups(&self) -> Vec<(&str, usize)> {
        vec![]
    }

    /// The field of messages from which a column is, if it is from one.
    fn field(&self, _column: usize) -> Option<Field> {
        None
    }

    /// A number of a column, NaN where it is not known, or nothing if the column seems to hold other things.
    fn sample(&self, _column: usize) -> Option<f64> {
        Some(f64::NAN)
    }

    /// The numbers of a column in the first rows, as far as they are known before all are read.
    fn rows(&self, _column: usize) -> &[f64] {
        &[]
    }

    /// The loggers whose header it may be, if these have other units.
    fn rivals(&self) -> Option<&Rivals> {
        None
    }

    /// What times of the calendar a column holds, if any.
    fn calendar(&self, _column: usize) -> Option<Calendar> {
        None
    }

    /// What was inferred about the file, in a line each.
    fn inferred(&self) -> Vec<String> {
        vec![]
    }

    /// What was found while the numbers were read, in a line each.
    fn found(&self) -> Vec<String> {
        vec![]
    }

    /// The sampling step that the file states, s.
    fn step_s(&self) -> Option<f64> {
        None
    }

    /// The data that the file states.
    fn data(&self) -> Option<Data> {
        None
    }

    /// The place where a column is shown, or all of them, if the file has lines.
    fn place(&self, _column: Option<usize>) -> Option<Place> {
        None
    }

    /// The place of a column in a row, counted from 0, if the file has lines.
    fn place_of_row(&self, _row: usize, _column: usize) -> Option<Place> {
        None
    }
}

/// The bytes that are there of the next `length` ones.
pub(crate) fn part(reader: &mut dyn Read, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    Read::take(reader, length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The source of the bytes of a file.
#[derive(Debug, Clone)]
pub(crate) enum Origin<'a> {
    Path(&'a Path),
    /// The bytes of a file that was read before.
    Bytes(&'a [u8]),
    /// The bytes in a compressed file.
    Unpacked(Unpacked),
}

/// Bytes that were unpacked and are held once.
#[derive(Debug, Clone)]
pub(crate) struct Unpacked(Arc<Vec<u8>>);

impl AsRef<[u8]> for Unpacked {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl<'a> Origin<'a> {
    /// The bytes from the first on, with their number, which is unknown for a pipe.
    pub(crate) fn open(&self) -> io::Result<(Box<dyn Read + 'a>, Option<u64>)> {
        match self {
            Origin::Path(path) => {
                let file = open(path)?;
                let about = file.metadata()?;
                Ok((Box::new(file), about.is_file().then_some(about.len())))
            }
            Origin::Bytes(bytes) => Ok((Box::new(*bytes), Some(bytes.len() as u64))),
            Origin::Unpacked(bytes) => Ok((Box::new(Cursor::new(bytes.clone())), Some(bytes.0.len() as u64))),
        }
    }
}

/// Bytes that any file may unpack to, and most for each byte of a longer one: noise packs to a fifth at best, and a few columns
/// that do not change to much less.
const ANY_UNPACKED: u64 = 1 << 26;
const MAX_UNPACKED: u64 = 100;

/// Refuses that a file of `stored` bytes, if that is known, unpacks to more than recordings do.
///
/// # Errors
/// The `bytes` are too many for it.
pub(crate) fn check_unpacked(bytes: u64, stored: Option<u64>) -> io::Result<()> {
    match stored.filter(|stored| bytes > ANY_UNPACKED.max(MAX_UNPACKED.saturating_mul(*stored))) {
        None => Ok(()),
        Some(stored) => {
            malformed(&format!("its {stored} bytes unpack to more than {MAX_UNPACKED} times as many"))
        }
    }
}

/// Bytes that can be read in any order.
pub(crate) trait Seekable: Read + Seek {}

impl<T: Read + Seek> Seekable for T {}

/// The bytes of a file, of which the first have been read.
pub(crate) struct Source<'a> {
    /// Its name in messages.
    pub file: String,
    pub origin: Origin<'a>,
    pub head: Vec<u8>,
    /// Length in bytes; unknown for a pipe.
    pub length: Option<u64>,
    rest: Box<dyn Read + 'a>,
}

/// The bytes of a file from some place on.
pub(crate) type Bytes<'a> = Chain<Cursor<Vec<u8>>, Box<dyn Read + 'a>>;

impl<'a> Source<'a> {
    /// Opens a file; one that is compressed as a whole is unpacked into memory.
    ///
    /// # Errors
    /// The file cannot be read or unpacked.
    pub(crate) fn open(file: String, origin: Origin<'a>) -> Result<Source<'a>, RecordError> {
        let source = Source::packed(file, origin)?;
        let Some(packing) = Packing::new(&source.head) else { return Ok(source) };
        let (file, stored) = (source.file.clone(), source.length);
        let bytes = packing.unpack(Box::new(source.from(0)), stored).map_err(|error| {
            let message = format!("{file} cannot be unpacked from {}: {}", packing.name, told(&error));
            let help = format!("unpack it first, by `{} -d`, or copy it again", packing.name);
            RecordError::new(message, "", help, None)
        })?;
        Source::packed(file, Origin::Unpacked(Unpacked(Arc::new(bytes))))
    }

    /// Opens a file as it is stored.
    fn packed(file: String, origin: Origin<'a>) -> Result<Source<'a>, RecordError> {
        let failed = |error| RecordError::unreadable(&file, &error);
        let (mut rest, length) = origin.open().map_err(failed)?;
        let mut head = Vec::new();
        rest.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
        Ok(Source { file, origin, head, length, rest })
    }

    /// Whether the head is the whole file.
    pub(crate) fn is_whole(&self) -> bool {
        let length = self.head.len() as u64;
        length < HEAD || self.length == Some(length)
    }

    /// The bytes from `start` on, which is in the head.
    pub(crate) fn from(self, start: usize) -> Bytes<'a> {
        let mut head = Cursor::new(self.head);
        head.set_position(start as u64);
        head.chain(self.rest)
    }

    /// Its length in bytes.
    ///
    /// # Errors
    /// It is a pipe.
    pub(crate) fn size(&self) -> Result<u64, RecordError> {
        self.length.ok_or_else(|| {
            let message = format!("{} is not a regular file", self.file);
            RecordError::new(message, "", "save it as a file first; text and .npy can be piped", None)
        })
    }

    /// The bytes in any order.
    ///
    /// # Errors
    /// The file cannot be read, or is a pipe.
    pub(crate) fn seekable(&self) -> Result<Box<dyn Seekable + 'a>, RecordError> {
        self.size()?;
        match &self.origin {
            Origin::Path(path) => {
                let file = open(path).map_err(|error| RecordError::unreadable(&self.file, &error))?;
                Ok(Box::new(file))
            }
            Origin::Bytes(bytes) => Ok(Box::new(Cursor::new(*bytes))),
            Origin::Unpacked(bytes) => Ok(Box::new(Cursor::new(bytes.clone()))),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::record::log::read::{Request, Timing};
    use crate::record::log::{Channel, Log};

    /// Reads one column of a file, or all if the name is empty.
    fn read(bytes: &[u8], column: &str) -> Result<Log, RecordError> {
        let columns = if column.is_empty() { vec![] } else { vec![column.to_owned()] };
        Log::read_bytes("log", bytes, &Request { columns, ..Request::default() })
    }

    /// A column of a file that can be read.
    pub(crate) fn channel(bytes: &[u8], column: &str) -> Channel {
        let log = read(bytes, column).unwrap_or_else(|error| panic!("{}", error.render(false, 120)));
        log.channels[0].clone()
    }

    /// Whether the reader of a file says this, where all rows are one series.
    pub(crate) fn note(bytes: &[u8], piece: &str) -> bool {
        let request = Request { timing: Timing::Step(0.01), ..Request::default() };
        let log = Log::read_bytes("log", bytes, &request);
        let log = log.unwrap_or_else(|error| panic!("{}", error.render(false, 120)));
        log.notes.iter().any(|note| note.contains(piece))
    }

    /// The error for a column of a file, with its advice.
    pub(crate) fn refusal(bytes: &[u8], column: &str) -> String {
        let said = read(bytes, column).unwrap_err().render(false, 400);
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn every_format_has_a_file_among_the_test_data() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/formats");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let heads: Vec<Vec<u8>> = files.map(|path| std::fs::read(path).unwrap_or_default()).collect();
        for (place, format) in FORMATS.iter().enumerate() {
            assert!(heads.iter().any(|head| (format.begins)(head)), "no file of format {place}");
        }
    }
}
