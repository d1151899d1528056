//! MATLAB files of version 5 to 7, compressed or not. Those of version 7.3 are HDF5.
//!
//! The parser is our own, because numbers are converted to f64 in one pass and only those of the requested columns are kept.
//! The format is that of "MAT-File Format" (MathWorks, 2024), chapter 1.

use std::io::{self, Cursor, Read, SeekFrom, Take};

use flate2::read::ZlibDecoder;

use crate::record::binary::{Array, Arrays, Matrix, Number};
use crate::record::column_file::Rules;
use crate::record::format::{Columns, Format, Seekable, Source};
use crate::record::names::Name;
use crate::record::{RecordError, malformed, told};

/// Length of the header: text, offset of other data, version and order of bytes.
const HEADER: usize = 128;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Longest list of dimensions, and longest name, in bytes.
const MAX_NAME: u32 = 4096;

/// The flag of complex numbers, and the classes of structs, which may be within each other up to this depth, and of objects such
/// as strings and tables.
const COMPLEX: u32 = 0x800;
const STRUCT: u8 = 2;
const OPAQUE: u8 = 17;
const DEEPEST: usize = 8;

/// The classes of arrays other than numbers.
const OTHERS: [(u8, &str); 7] = [
    (1, "the cell array"),
    (STRUCT, "the struct"),
    (3, "the object"),
    (4, "the text"),
    (5, "the sparse matrix"),
    (16, "the function"),
    (OPAQUE, "the object"),
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
    order: Order,
    arrays: Arrays,
    /// Start of the element of each array, and its number among the variables in that element.
    places: Vec<(u64, usize)>,
}

/// The name of a variable with those of the structs around it, and their number.
#[derive(Default)]
struct Path {
    name: String,
    depth: usize,
}

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let order = Order { big_endian: source.head[126] == b'M' };
    let length = source.size()?;
    let mut bytes = source.seekable()?;
    let (mut places, mut about, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    let mut start = HEADER as u64;
    while start < length {
        let mut number = 0;
        let size = order.element_at(&mut bytes, start, length, false, &mut |_, found| {
            match found {
                Ok((name, matrix)) => {
                    about.push(Array { name: Name::read(&name), rows: matrix.rows, columns: matrix.columns });
                    places.push((start, number));
                }
                Err(what) => left_out.push(what),
            }
            number += 1;
            Ok(())
        });
        start += size.map_err(|error| refusal(&file, &error))?;
    }
    let arrays = Arrays::new(&file, &about, &left_out, Some(length))?;
    Ok(Box::new(Mat { file, bytes, order, arrays, places }))
}

impl Columns for Mat<'_> {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let Mat { file, bytes, order, arrays, places } = self;
        arrays.read(wanted, rules, |array, within| {
            let ((start, wanted), mut number, mut columns) = (places[array], 0, Vec::new());
            let read = order.element_at(bytes, start, u64::MAX, true, &mut |reader, found| {
                if let (true, Ok((_, matrix))) = (number == wanted, found) {
                    columns = matrix.read(reader, within)?;
                }
                number += 1;
                Ok(())
            });
            read.map_err(|error| refusal(file, &error))?;
            Ok(columns)
        })
    }
}

/// The name and the matrix of a variable, or what it is instead.
type Found = Result<(String, Matrix), String>;

/// Takes each variable of an element, with a reader of its numbers.
type Visitor<'v> = &'v mut dyn FnMut(&mut dyn Read, Found) -> io::Result<()>;

/// The order of the bytes.
#[derive(Clone, Copy)]
struct Order {
    big_endian: bool,
}

impl Order {
    /// Passes on the variables in the element at `start`, and returns its size. With `to_end` all of it is read, and a checksum
    /// is compared.
    fn element_at(
        self,
        bytes: &mut dyn Seekable,
        start: u64,
        length: u64,
        to_end: bool,
        visit: Visitor,
    ) -> io::Result<u64> {
        bytes.seek(SeekFrom::Start(start))?;
        let (kind, size) = (self.word(bytes)?, self.word(bytes)?);
        let whole = 8 + u64::from(size);
        if start.saturating_add(whole) > length {
            return malformed("it ends too early");
        }
        let mut element = Read::take(&mut *bytes, size.into());
        match kind {
            COMPRESSED => {
                let mut inner = ZlibDecoder::new(element);
                let (kind, size) = (self.word(&mut inner)?, self.word(&mut inner)?);
                if kind != MATRIX {
                    return malformed("a compressed element holds no variable");
                }
                self.variable(&mut inner, size, Path::default(), to_end, visit)?;
                if to_end && io::copy(&mut inner, &mut io::sink())? > 0 {
                    return malformed("a compressed element is longer than its variable");
                }
            }
            MATRIX => self.variable(&mut element, size, Path::default(), to_end, visit)?,
            _ => return malformed("an element is no variable"),
        }
        Ok(whole)
    }

    /// Passes on a variable of `size` bytes, or those in a struct.
    fn variable(
        self,
        reader: &mut dyn Read,
        size: u32,
        path: Path,
        to_end: bool,
        visit: Visitor,
    ) -> io::Result<()> {
        if size == 0 {
            return visit(reader, Err(format!("the empty `{}`", path.name)));
        }
        let reader = &mut Read::take(reader, size.into());
        let flags = self.element(reader, 6)?;
        if flags.len() != 8 {
            return malformed("the header of a variable is damaged");
        }
        let flags = self.number(&flags[..4]);
        let class = (flags & 0xff) as u8;
        // Strings, tables and times are objects without dimensions.
        let dims = if class == OPAQUE { vec![] } else { self.element(reader, 5)? };
        let name = self.element(reader, 1)?;
        let name = if path.depth == 0 { String::from_utf8_lossy(&name).into_owned() } else { path.name };
        if dims.len() % 4 != 0 {
            return malformed("the header of a variable is damaged");
        }
        let dims: Vec<usize> = dims.chunks_exact(4).map(|raw| self.number(raw) as usize).collect();
        match OTHERS.iter().find(|(other, _)| *other == class) {
            Some((STRUCT, _)) if dims == [1, 1] && path.depth < DEEPEST => {
                self.fields(reader, &Path { name, depth: path.depth + 1 }, visit)?;
            }
            Some((_, what)) => visit(reader, Err(format!("{what} `{name}`")))?,
            None if name.is_empty() => visit(reader, Err("the contents of objects".to_owned()))?,
            None if !(6..=15).contains(&class) => {
                return malformed("a variable is of an unknown class");
            }
            None => self.matrix(reader, name, &dims, flags & COMPLEX != 0, visit)?,
        }
        // Its padding follows, or what was not read of it.
        if to_end || path.depth > 0 {
            io::copy(reader, &mut io::sink())?;
            if reader.limit() > 0 {
                return malformed("it ends too early");
            }
        }
        Ok(())
    }

    /// Passes on the fields of a struct.
    fn fields(self, reader: &mut dyn Read, path: &Path, visit: Visitor) -> io::Result<()> {
        let damaged = malformed("the fields of a struct are damaged");
        let length = self.element(reader, 5)?;
        let names = self.element(reader, 1)?;
        let length = if length.len() == 4 { self.number(&length) as usize } else { 0 };
        if length == 0 || names.len() % length != 0 {
            return damaged;
        }
        for name in names.chunks_exact(length) {
            let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
            let name = format!("{}.{}", path.name, String::from_utf8_lossy(name));
            let (kind, size) = (self.word(reader)?, self.word(reader)?);
            if kind != MATRIX {
                return damaged;
            }
            self.variable(reader, size, Path { name, depth: path.depth }, false, visit)?;
        }
        Ok(())
    }

    /// Passes on a matrix of numbers.
    fn matrix(
        self,
        reader: &mut Take<&mut dyn Read>,
        name: String,
        dims: &[usize],
        is_complex: bool,
        visit: Visitor,
    ) -> io::Result<()> {
        if is_complex {
            return visit(reader, Err(format!("the complex matrix `{name}`")));
        }
        let [first, second] = *dims else {
            return visit(reader, Err(format!("`{name}` in more than two dimensions")));
        };
        // Vectors of MATLAB are rows as often as columns.
        let (rows, columns) = if first == 1 { (second, 1) } else { (first, second) };
        let (kind, bytes, short) = self.tag(reader)?;
        let number =
            NUMBERS.iter().find(|(known, _)| *known == kind).and_then(|(_, name)| Number::called(name));
        let Some(number) = number else {
            return malformed("the numbers of a variable are of an unknown type");
        };
        let matrix = Matrix { number, big_endian: self.big_endian, by_columns: true, rows, columns };
        // Up to seven bytes of padding follow.
        let is_whole = short.is_some() || (bytes.into()..u64::from(bytes) + 8).contains(&reader.limit());
        if matrix.bytes() != Some(bytes.into()) || !is_whole {
            return malformed("the dimensions of a variable do not fit its numbers");
        }
        match short {
            Some(data) => visit(&mut Cursor::new(&data[..bytes as usize]), Ok((name, matrix))),
            None => visit(reader, Ok((name, matrix))),
        }
    }

    fn number(self, bytes: &[u8]) -> u32 {
        let bytes = bytes.try_into().unwrap_or_default();
        if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    fn word(self, reader: &mut dyn Read) -> io::Result<u32> {
        let mut bytes = [0; 4];
        reader.read_exact(&mut bytes)?;
        Ok(self.number(&bytes))
    }

    /// The type and the size of the next element; one of at most four bytes holds its data in the second half of the tag.
    fn tag(self, reader: &mut dyn Read) -> io::Result<(u32, u32, Option<[u8; 4]>)> {
        let kind = self.word(reader)?;
        if kind >> 16 == 0 {
            return Ok((kind, self.word(reader)?, None));
        }
        let mut data = [0; 4];
        reader.read_exact(&mut data)?;
        match kind >> 16 {
            size @ 1..=4 => Ok((kind & 0xffff, size, Some(data))),
            _ => malformed("a short element has more than four bytes"),
        }
    }

    /// The bytes of the next element, which is of this type.
    fn element(self, reader: &mut dyn Read, wanted: u32) -> io::Result<Vec<u8>> {
        let (kind, size, short) = self.tag(reader)?;
        if kind != wanted || size > MAX_NAME {
            return malformed("the header of a variable is damaged");
        }
        if let Some(data) = short {
            return Ok(data[..size as usize].to_vec());
        }
        let mut bytes = vec![0; size.next_multiple_of(8) as usize];
        reader.read_exact(&mut bytes)?;
        bytes.truncate(size as usize);
        Ok(bytes)
    }
}

fn refusal(file: &str, error: &io::Error) -> RecordError {
    let help = "save it again, as in save('log.mat', 'time', 'gyro') with a row for each sample";
    let message = format!("{file} cannot be taken as a MATLAB file: {}", told(error));
    RecordError::new(message, "", help, None)
}
