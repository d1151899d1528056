//! NumPy arrays in .npy files, versions 1 to 3, and archives of them in .npz files: ZIP archives, each file with a checksum, which
//! is verified.
//!
//! The parser of .npy is our own: the header is one line of text, and the numbers after it are converted to f64 in one pass.
//! The format is that of NEP 1.

use std::io::{self, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use crate::record::RecordError;
use crate::record::binary::{Array, Arrays, MAX_ARRAY_COLUMNS, Matrix, Number};
use crate::record::column_file::Rules;
use crate::record::format::{Bytes, Columns, Format, Seekable, Source};
use crate::record::names::Name;

/// The first bytes of a .npy file.
const MAGIC: &[u8] = b"\x93NUMPY";

/// Length in bytes of the longest header that is read.
pub(crate) const MAX_HEADER: usize = 1 << 16;

pub(crate) const NPY: Format = Format { begins: |head| head.starts_with(MAGIC), open: open_npy };

fn open_npy(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let (matrix, start) = read_npy(&source.file, &source.head, source.length)?;
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
fn read_npy(file: &str, head: &[u8], length: Option<u64>) -> Result<(Matrix, usize), RecordError> {
    let short = || bad_npy(file, "it ends too early");
    if !head.starts_with(MAGIC) {
        return Err(bad_npy(file, "it does not begin as one"));
    }
    let wide = *head.get(6).ok_or_else(short)? > 1;
    let begin = if wide { 12 } else { 10 };
    let size = head.get(8..begin).ok_or_else(short)?;
    let size = size.iter().rev().fold(0, |size, byte| size << 8 | usize::from(*byte));
    if size > MAX_HEADER {
        return Err(bad_npy(file, "its header is longer than 64 KiB"));
    }
    let header = head.get(begin..begin + size).ok_or_else(short)?;
    let matrix = parse(file, &String::from_utf8_lossy(header))?;
    let there = length.map(|length| length.saturating_sub((begin + size) as u64));
    match (matrix.bytes(), there) {
        (Some(promised), Some(there)) if promised != there => Err(bad_npy(
            file,
            &format!("its header promises {promised} bytes of numbers, the file has {there}"),
        )),
        (None, _) => Err(bad_npy(file, "its header promises more numbers than can be")),
        _ if matrix.columns > MAX_ARRAY_COLUMNS => {
            Err(bad_npy(file, &format!("it has {} columns, more than {MAX_ARRAY_COLUMNS}", matrix.columns)))
        }
        _ => Ok((matrix, begin + size)),
    }
}

/// `{'descr': '<f8', 'fortran_order': False, 'shape': (1000, 3), }`, word by word: a damaged one must not pass for another.
fn parse(file: &str, header: &str) -> Result<Matrix, RecordError> {
    let damaged = || bad_npy(file, "its header is damaged");
    let mut words = Words(header);
    words.take("{").ok_or_else(damaged)?;
    let (mut described, mut order, mut shape) = (None, None, None);
    while words.take("}").is_none() {
        let key = words.quoted().ok_or_else(damaged)?;
        words.take(":").ok_or_else(damaged)?;
        match key {
            "descr" if words.0.starts_with('[') => return Err(bad_npy(file, "it has named fields")),
            "descr" => described = Some(words.quoted().ok_or_else(damaged)?),
            "fortran_order" => {
                order = Some(
                    words.take("True").is_some()
                        || words.take("False").map(|()| false).ok_or_else(damaged)?,
                );
            }
            "shape" => shape = Some(words.shape().ok_or_else(damaged)?),
            _ => return Err(damaged()),
        }
        if words.take(",").is_none() && !words.0.starts_with('}') {
            return Err(damaged());
        }
    }
    let (Some(described), Some(by_columns), Some(shape), "") = (described, order, shape, words.0) else {
        return Err(damaged());
    };
    let unsupported = || bad_npy(file, &format!("its numbers are of type '{described}'"));
    let (order, name) = described.split_at_checked(1).ok_or_else(unsupported)?;
    let number = Number::called(name).ok_or_else(unsupported)?;
    let big_endian = match order {
        ">" => true,
        "<" => false,
        "|" if number.size == 1 => false,
        "=" => cfg!(target_endian = "big"),
        _ => return Err(unsupported()),
    };
    let (rows, columns) = match shape[..] {
        [rows] => (rows, 1),
        [rows, columns] => (rows, columns),
        _ => return Err(bad_npy(file, "it has neither one dimension nor two")),
    };
    Ok(Matrix { number, big_endian, by_columns, rows, columns })
}

/// The rest of a header, without blanks at its start.
struct Words<'h>(&'h str);

impl<'h> Words<'h> {
    /// Takes a word, if it is the next one.
    fn take(&mut self, word: &str) -> Option<()> {
        self.0 = self.0.strip_prefix(word)?.trim_start_matches([' ', '\n']);
        Some(())
    }

    fn quoted(&mut self) -> Option<&'h str> {
        let (inner, rest) = self.0.strip_prefix('\'')?.split_once('\'')?;
        self.0 = rest.trim_start_matches(' ');
        Some(inner)
    }

    /// Takes `(1000, 3)` or `(1000,)`.
    fn shape(&mut self) -> Option<Vec<usize>> {
        let (inner, rest) = self.0.strip_prefix('(')?.split_once(')')?;
        self.0 = rest.trim_start_matches(' ');
        let inner = inner.strip_suffix(',').unwrap_or(inner);
        let extent = |part: &str| part.trim_matches(' ').parse().ok();
        if inner.is_empty() { Some(vec![]) } else { inner.split(',').map(extent).collect() }
    }
}

/// The error for numbers that could not be read.
fn cut_off(file: &str, error: &io::Error) -> RecordError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => bad_npy(file, "it ends too early"),
        // A checksum or the compression of an archive.
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::Other => {
            let message = format!("{file} is damaged: {error}");
            RecordError::new(message, "", "copy it again from where it was recorded", None)
        }
        _ => RecordError::unreadable(file, error),
    }
}

fn bad_npy(file: &str, why: &str) -> RecordError {
    let help = "save it as np.save(\"log.npy\", a) with a of one dimension, or two with a row for each \
                sample, of floats or integers";
    RecordError::new(format!("{file} cannot be taken as a .npy record: {why}"), "", help, None)
}

pub(crate) const NPZ: Format = Format { begins: |head| head.starts_with(b"PK\x03\x04"), open: open_npz };

/// An archive of which the headers have been read.
struct Npz<'a> {
    file: String,
    archive: ZipArchive<Box<dyn Seekable + 'a>>,
    arrays: Arrays,
    /// The number of each array in the archive, with the place of its numbers.
    parts: Vec<(usize, Matrix, usize)>,
}

fn open_npz(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let stored = source.length;
    let mut archive = ZipArchive::new(source.seekable()?).map_err(|error| bad_npz(&file, &error))?;
    let (mut parts, mut about, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for at in 0..archive.len() {
        let mut entry = archive.by_index(at).map_err(|error| bad_npz(&file, &error))?;
        let name = entry.name().map_err(|error| bad_npz(&file, &error))?.into_owned();
        let Some(stem) = name.strip_suffix(".npy") else {
            left_out.push(name);
            continue;
        };
        let (length, mut head) = (entry.size(), Vec::new());
        let read = entry.by_ref().take(MAX_HEADER as u64 + 12).read_to_end(&mut head);
        read.map_err(|error| cut_off(&file, &error))?;
        match read_npy(&format!("{file}, {name}"), &head, Some(length)) {
            Ok((matrix, start)) => {
                about.push(Array { name: Name::read(stem), rows: matrix.rows, columns: matrix.columns });
                parts.push((at, matrix, start));
            }
            Err(error) => left_out.push(error.to_string()),
        }
    }
    let arrays = Arrays::new(&file, &about, &left_out, stored)?;
    Ok(Box::new(Npz { file, archive, arrays, parts }))
}

impl Columns for Npz<'_> {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let Npz { file, archive, arrays, parts } = self;
        arrays.read(wanted, rules, |array, within| {
            let (at, matrix, start) = &parts[array];
            let mut entry = archive.by_index(*at).map_err(|error| bad_npz(file, &error))?;
            let read = |entry: &mut dyn Read| {
                io::copy(&mut entry.take(*start as u64), &mut io::sink())?;
                let columns = matrix.read(entry, within)?;
                // The checksum is compared at the end.
                io::copy(entry, &mut io::sink())?;
                Ok(columns)
            };
            read(&mut entry).map_err(|error| cut_off(file, &error))
        })
    }
}

fn bad_npz(file: &str, error: &ZipError) -> RecordError {
    let help = "save it as np.savez(\"log.npz\", time=t, gyro=a); a spreadsheet (.xlsx) must be saved as CSV";
    RecordError::new(format!("{file} cannot be taken as a .npz record: {error}"), "", help, None)
}
