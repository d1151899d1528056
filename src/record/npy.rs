//! NumPy arrays in .npy files, versions 1 to 3.
//!
//! The parser is our own: the header is one line of text, and the numbers after it are converted to f64 in one pass.
//! The format is that of NEP 1.

use std::io;

use crate::record::arrays::MOST_COLUMNS;
use crate::record::error::RecordError;
use crate::record::format::{Bytes, Columns, Format, Source};
use crate::record::matrix::{Matrix, NUMBERS};
use crate::record::names::Name;
use crate::record::recording::Rules;

/// The first bytes of a .npy file.
const MAGIC: &[u8] = b"\x93NUMPY";

/// Length in bytes of the longest header that is read.
pub(crate) const LONGEST: usize = 1 << 16;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(MAGIC), open };

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let (matrix, start) = read(&source.file, &source.head, source.length)?;
    Ok(Box::new(Npy { file: source.file.clone(), matrix, numbers: source.from(start) }))
}

/// An array of which the header has been read.
struct Npy<'a> {
    file: String,
    matrix: Matrix,
    numbers: Bytes<'a>,
}

impl Columns for Npy<'_> {
    fn names(&self) -> &[Name] {
        &[]
    }

    fn count(&self) -> usize {
        self.matrix.columns
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        rules.limit(&self.file, self.matrix.rows)?;
        self.matrix.read(&mut self.numbers, wanted).map_err(|error| cut_off(&self.file, &error))
    }
}

/// Reads the header from the `head` of an array, and returns it with the offset of its end. `length` is that of the array
/// in its file, if known.
///
/// # Errors
/// The array is not supported, or is longer than its file.
pub(crate) fn read(file: &str, head: &[u8], length: Option<u64>) -> Result<(Matrix, usize), RecordError> {
    let short = || bad(file, "it ends too early");
    if !head.starts_with(MAGIC) {
        return Err(bad(file, "it does not begin as one"));
    }
    let wide = *head.get(6).ok_or_else(short)? > 1;
    let begin = if wide { 12 } else { 10 };
    let size = head.get(8..begin).ok_or_else(short)?;
    let size = size.iter().rev().fold(0, |size, byte| size << 8 | usize::from(*byte));
    if size > LONGEST {
        return Err(bad(file, "its header is longer than 64 KiB"));
    }
    let header = head.get(begin..begin + size).ok_or_else(short)?;
    let matrix = parse(file, &String::from_utf8_lossy(header))?;
    let there = length.map(|length| length.saturating_sub((begin + size) as u64));
    match (matrix.bytes(), there) {
        (Some(promised), Some(there)) if promised != there => {
            Err(bad(file, &format!("its header promises {promised} bytes of numbers, the file has {there}")))
        }
        (None, _) => Err(bad(file, "its header promises more numbers than can be")),
        _ if matrix.columns > MOST_COLUMNS => {
            Err(bad(file, &format!("it has {} columns, more than {MOST_COLUMNS}", matrix.columns)))
        }
        _ => Ok((matrix, begin + size)),
    }
}

/// `{'descr': '<f8', 'fortran_order': False, 'shape': (1000, 3), }`
fn parse(file: &str, header: &str) -> Result<Matrix, RecordError> {
    let after = |key: &str| {
        let found = header.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
        found.ok_or_else(|| bad(file, &format!("its header has no `{key}`")))
    };
    let quoted = after("descr")?.strip_prefix('\'').and_then(|rest| rest.split_once('\''));
    let Some((described, _)) = quoted else {
        return Err(bad(file, "it has named fields"));
    };
    let (order, name) = described.split_at_checked(1).unwrap_or_default();
    let Some(number) = NUMBERS.iter().find(|number| number.name == name) else {
        return Err(bad(file, &format!("its numbers are of type '{described}'")));
    };
    let big_endian = match order {
        ">" => true,
        "<" | "|" => false,
        _ => cfg!(target_endian = "big"),
    };
    let by_columns = after("fortran_order")?.starts_with("True");
    let inner = after("shape")?.strip_prefix('(').and_then(|rest| rest.split_once(')'));
    let parts =
        inner.map_or("", |(inner, _)| inner).split(',').map(str::trim).filter(|part| !part.is_empty());
    let shape: Option<Vec<usize>> = parts.map(|part| part.parse().ok()).collect();
    let (rows, columns) = match shape.as_deref() {
        Some([rows]) => (*rows, 1),
        Some([rows, columns]) => (*rows, *columns),
        _ => return Err(bad(file, "it has neither one dimension nor two")),
    };
    Ok(Matrix { number, big_endian, by_columns, rows, columns })
}

/// The error for numbers that could not be read.
pub(crate) fn cut_off(file: &str, error: &io::Error) -> RecordError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => bad(file, "it ends too early"),
        _ => RecordError::unreadable(file, error),
    }
}

fn bad(file: &str, why: &str) -> RecordError {
    let help = "save it as np.save(\"log.npy\", a) with a of one dimension, or two with a row for each \
                sample, of floats or integers";
    RecordError::new(format!("{file} cannot be taken as a .npy record: {why}"), "", help, None)
}
