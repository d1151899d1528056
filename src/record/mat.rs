//! MATLAB files of version 5 to 7, compressed or not. Those of version 7.3 are HDF5.
//!
//! The parser is our own, because numbers are converted to f64 in one pass and only those of the requested columns are kept.
//! The format is that of "MAT-File Format" (MathWorks, 2024), chapter 1.

use std::io::{self, Cursor, Read, SeekFrom};

use flate2::read::ZlibDecoder;

use crate::record::arrays::{Array, Arrays};
use crate::record::error::RecordError;
use crate::record::format::{Columns, Format, Seekable, Source};
use crate::record::matrix::{Matrix, Number};
use crate::record::names::Name;
use crate::record::recording::Rules;

/// Length of the header: text, offset of other data, version and order of bytes.
const HEADER: usize = 128;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Longest list of dimensions, and longest name, in bytes.
const LONGEST: u32 = 4096;

/// The classes of arrays other than numbers.
const OTHERS: [(u8, &str); 7] = [
    (1, "the cell array"),
    (2, "the struct"),
    (3, "the object"),
    (4, "the text"),
    (5, "the sparse matrix"),
    (16, "the function"),
    (17, "the object"),
];

/// The types of numbers in data elements.
const NUMBERS: [(u32, &str); 10] = [
    (1, "i1"),
    (2, "u1"),
    (3, "i2"),
    (4, "u2"),
    (5, "i4"),
    (6, "u4"),
    (7, "f4"),
    (9, "f8"),
    (12, "i8"),
    (13, "u8"),
];

pub(crate) const FORMAT: Format = Format {
    begins: |head| {
        let ending = head.get(124..HEADER);
        matches!(ending, Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I']))
    },
    open,
};

/// A file of which the headers of all variables have been read.
struct Mat<'a> {
    file: String,
    bytes: Box<dyn Seekable + 'a>,
    big_endian: bool,
    arrays: Arrays,
    /// Start of the element of each array.
    starts: Vec<u64>,
}

/// Why a variable cannot be read.
enum Wrong {
    /// The variable is not a matrix of real numbers.
    Other(String),
    Malformed(&'static str),
    Unreadable(io::Error),
}

impl From<io::Error> for Wrong {
    fn from(error: io::Error) -> Wrong {
        Wrong::Unreadable(error)
    }
}

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let big_endian = source.head[126] == b'M';
    let length = source.length.unwrap_or_default();
    let mut bytes = source.seekable()?;
    let (mut starts, mut about, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    let mut start = HEADER as u64;
    while start < length {
        let failed = |wrong: Wrong| refusal(&file, wrong);
        let size = variable(&mut bytes, start, length, big_endian, false, |_, size, found| Ok((size, found)))
            .map_err(failed)?;
        match size {
            (size, Ok((name, matrix))) => {
                about.push(Array { name, rows: matrix.rows, columns: matrix.columns });
                starts.push(start);
                start += size;
            }
            (size, Err(Wrong::Other(what))) => {
                left_out.push(what);
                start += size;
            }
            (_, Err(wrong)) => return Err(refusal(&file, wrong)),
        }
    }
    let arrays = Arrays::of(&file, &about, &left_out)?;
    Ok(Box::new(Mat { file, bytes, big_endian, arrays, starts }))
}

impl Columns for Mat<'_> {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let Mat { file, bytes, big_endian, arrays, starts } = self;
        arrays.read(wanted, rules, |array, within| {
            let columns = variable(bytes, starts[array], u64::MAX, *big_endian, true, |reader, _, found| {
                let (_, matrix) = found?;
                let columns = matrix.read(reader, within)?;
                match io::copy(reader, &mut io::sink())? {
                    0..8 => Ok(columns),
                    _ => Err(Wrong::Malformed("a variable is longer than its dimensions say")),
                }
            });
            columns.map_err(|wrong| refusal(file, wrong))
        })
    }
}

/// The name and the matrix of a variable, or why it is none.
type Found = Result<(String, Matrix), Wrong>;

/// Reads the variable at `start` up to its numbers, and passes these on with the size of its element. With `to_end` it
/// verifies the checksum of a compressed one after that.
fn variable<T>(
    bytes: &mut dyn Seekable,
    start: u64,
    length: u64,
    big_endian: bool,
    to_end: bool,
    take: impl FnOnce(&mut dyn Read, u64, Found) -> Result<T, Wrong>,
) -> Result<T, Wrong> {
    bytes.seek(SeekFrom::Start(start))?;
    let order = Order { big_endian };
    let (kind, size) = (order.word(bytes)?, order.word(bytes)?);
    let whole = 8 + u64::from(size);
    if start + whole > length {
        return Err(Wrong::Malformed("it ends too early"));
    }
    let element = Read::take(&mut *bytes, size.into());
    match kind {
        COMPRESSED => {
            let mut inner = ZlibDecoder::new(element);
            let (kind, size) = (order.word(&mut inner)?, order.word(&mut inner)?);
            if kind != MATRIX {
                return Err(Wrong::Malformed("a compressed element holds no variable"));
            }
            let taken = order.numbers(&mut inner, size, |reader, found| take(reader, whole, found))?;
            if to_end && io::copy(&mut inner, &mut io::sink())? > 0 {
                return Err(Wrong::Malformed("a compressed element is longer than its variable"));
            }
            Ok(taken)
        }
        MATRIX => {
            let mut inner = element;
            order.numbers(&mut inner, size, |reader, found| take(reader, whole, found))
        }
        _ => Err(Wrong::Malformed("an element is no variable")),
    }
}

/// The order of the bytes.
struct Order {
    big_endian: bool,
}

impl Order {
    fn word(&self, reader: &mut dyn Read) -> Result<u32, Wrong> {
        let mut bytes = [0; 4];
        reader.read_exact(&mut bytes)?;
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The type and the size of the next element; one of at most four bytes holds its data in the second half of the tag.
    fn tag(&self, reader: &mut dyn Read) -> Result<(u32, u32, Option<[u8; 4]>), Wrong> {
        let kind = self.word(reader)?;
        if kind >> 16 == 0 {
            return Ok((kind, self.word(reader)?, None));
        }
        let mut data = [0; 4];
        reader.read_exact(&mut data)?;
        match kind >> 16 {
            size @ 1..=4 => Ok((kind & 0xffff, size, Some(data))),
            _ => Err(Wrong::Malformed("a short element has more than four bytes")),
        }
    }

    /// The bytes of the next element, which is of this type.
    fn element(&self, reader: &mut dyn Read, wanted: u32) -> Result<Vec<u8>, Wrong> {
        let (kind, size, short) = self.tag(reader)?;
        if kind != wanted || size > LONGEST {
            return Err(Wrong::Malformed("the header of a variable is damaged"));
        }
        if let Some(data) = short {
            return Ok(data[..size as usize].to_vec());
        }
        let mut bytes = vec![0; size.next_multiple_of(8) as usize];
        reader.read_exact(&mut bytes)?;
        bytes.truncate(size as usize);
        Ok(bytes)
    }

    /// Reads the header of a variable of `size` bytes, and passes on its numbers.
    fn numbers<T>(
        &self,
        reader: &mut dyn Read,
        size: u32,
        take: impl FnOnce(&mut dyn Read, Found) -> Result<T, Wrong>,
    ) -> Result<T, Wrong> {
        let reader = &mut Read::take(reader, size.into());
        let flags = self.element(reader, 6)?;
        let dims = self.element(reader, 5)?;
        let name = String::from_utf8_lossy(&self.element(reader, 1)?).into_owned();
        let word = |bytes: &[u8]| {
            let bytes = bytes.try_into().unwrap_or_default();
            if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
        };
        if flags.len() != 8 || dims.len() % 4 != 0 {
            return Err(Wrong::Malformed("the header of a variable is damaged"));
        }
        let flags = word(&flags[..4]);
        let class = (flags & 0xff) as u8;
        let other = |what: &str| Err(Wrong::Other(format!("{what} `{name}`")));
        if let Some((_, what)) = OTHERS.iter().find(|(other, _)| *other == class) {
            return take(reader, other(what));
        }
        if !(6..=15).contains(&class) {
            return Err(Wrong::Malformed("a variable is of an unknown class"));
        }
        if flags & 0x800 != 0 {
            return take(reader, other("the complex matrix"));
        }
        let dims: Vec<usize> = dims.chunks_exact(4).map(|raw| word(raw) as usize).collect();
        let [first, second] = dims[..] else {
            return take(reader, other("the array of more than two dimensions"));
        };
        // Vectors of MATLAB are rows as often as columns.
        let (rows, columns) = if first == 1 { (second, 1) } else { (first, second) };
        let (kind, bytes, short) = self.tag(reader)?;
        let number =
            NUMBERS.iter().find(|(known, _)| *known == kind).and_then(|(_, name)| Number::called(name));
        let Some(number) = number else {
            return Err(Wrong::Malformed("the numbers of a variable are of an unknown type"));
        };
        let matrix = Matrix { number, big_endian: self.big_endian, by_columns: true, rows, columns };
        if matrix.bytes() != Some(bytes.into()) {
            return Err(Wrong::Malformed("the dimensions of a variable do not fit its numbers"));
        }
        match short {
            Some(data) => take(&mut Cursor::new(&data[..bytes as usize]), Ok((name, matrix))),
            None => take(reader, Ok((name, matrix))),
        }
    }
}

fn refusal(file: &str, wrong: Wrong) -> RecordError {
    let why = match wrong {
        Wrong::Unreadable(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            "it ends too early".to_owned()
        }
        Wrong::Unreadable(error) => error.to_string(),
        Wrong::Malformed(why) => why.to_owned(),
        Wrong::Other(what) => format!("{what} is no matrix of real numbers"),
    };
    let help = "save it again, as in save('log.mat', 'time', 'gyro') with a row for each sample";
    RecordError::new(format!("{file} cannot be taken as a MATLAB file: {why}"), "", help, None)
}
