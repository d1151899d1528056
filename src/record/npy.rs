//! NumPy arrays in .npy files, versions 1 to 3.
//!
//! The parser is our own: the header is one line of text, and the numbers after it are converted to f64 in one pass.
//! The format is that of NEP 1.

use std::io::{self, Read};

use crate::record::error::RecordError;

/// The first bytes of a .npy file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Length in bytes of the longest header that is read.
const LONGEST: usize = 1 << 16;

/// Most columns. An array without rows may claim any number of them, and so may one from a pipe.
const MOST_COLUMNS: usize = 1 << 20;

/// Bytes read at a time.
const BLOCK: usize = 8 << 20;

/// The contents of the header.
pub(crate) struct Array {
    file: String,
    number: &'static Number,
    big_endian: bool,
    fortran_order: bool,
    pub rows: usize,
    pub columns: usize,
}

/// A type of numbers: its name, its size in bytes, and its decoder for many numbers, lowest byte first.
struct Number {
    name: &'static str,
    size: usize,
    decode: fn(&[u8], &mut Vec<f64>),
}

macro_rules! numbers {
    ($($name:literal $type:ty),*) => {
        &[$(Number {
            name: $name,
            size: size_of::<$type>(),
            decode: |bytes, numbers| {
                let number = |raw: &[u8]| <$type>::from_le_bytes(raw.try_into().unwrap_or_default()) as f64;
                numbers.extend(bytes.chunks_exact(size_of::<$type>()).map(number));
            },
        }),*]
    };
}

/// The supported types of numbers.
static NUMBERS: &[Number] = numbers!(
    "f4" f32, "f8" f64, "i1" i8, "i2" i16, "i4" i32, "i8" i64, "u1" u8, "u2" u16, "u4" u32, "u8" u64
);

impl Array {
    /// Reads the header from the `head` of the file, and returns it with the offset of its end. `length` is that of the
    /// file, if known.
    ///
    /// # Errors
    /// The array is not supported, or is longer than its file.
    pub(crate) fn read(file: &str, head: &[u8], length: Option<u64>) -> Result<(Array, usize), RecordError> {
        let short = || bad(file, "it ends too early");
        let wide = *head.get(6).ok_or_else(short)? > 1;
        let begin = if wide { 12 } else { 10 };
        let size = head.get(8..begin).ok_or_else(short)?;
        let size = size.iter().rev().fold(0, |size, byte| size << 8 | usize::from(*byte));
        if size > LONGEST {
            return Err(bad(file, "its header is longer than 64 KiB"));
        }
        let header = head.get(begin..begin + size).ok_or_else(short)?;
        let array = Array::parse(file, &String::from_utf8_lossy(header))?;
        let promised = (array.rows as u64)
            .checked_mul(array.columns as u64)
            .and_then(|count| count.checked_mul(array.number.size as u64));
        let there = length.map(|length| length.saturating_sub((begin + size) as u64));
        match (promised, there) {
            (Some(promised), Some(there)) if promised > there => Err(bad(
                file,
                &format!("its header promises {promised} bytes of numbers, the file has {there}"),
            )),
            (None, _) => Err(bad(file, "its header promises more numbers than can be")),
            _ if array.columns > MOST_COLUMNS => {
                Err(bad(file, &format!("it has {} columns, more than {MOST_COLUMNS}", array.columns)))
            }
            _ => Ok((array, begin + size)),
        }
    }

    /// `{'descr': '<f8', 'fortran_order': False, 'shape': (1000, 3), }`
    fn parse(file: &str, header: &str) -> Result<Array, RecordError> {
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
        let fortran_order = after("fortran_order")?.starts_with("True");
        let inner = after("shape")?.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let parts =
            inner.map_or("", |(inner, _)| inner).split(',').map(str::trim).filter(|part| !part.is_empty());
        let shape: Option<Vec<usize>> = parts.map(|part| part.parse().ok()).collect();
        let (rows, columns) = match shape.as_deref() {
            Some([rows]) => (*rows, 1),
            Some([rows, columns]) => (*rows, *columns),
            _ => return Err(bad(file, "it has neither one dimension nor two")),
        };
        Ok(Array { file: file.to_owned(), number, big_endian, fortran_order, rows, columns })
    }

    /// The `wanted` columns, in the order given.
    ///
    /// # Errors
    /// The array has more than `most` rows, or the file cannot be read, ends early, or contains an infinite number.
    pub(crate) fn columns(
        &self,
        mut reader: impl Read,
        wanted: &[usize],
        most: usize,
    ) -> Result<Vec<Vec<f64>>, RecordError> {
        if self.rows > most {
            return Err(bad(&self.file, &format!("it has {} rows, more than {most}", self.rows)));
        }
        let mut columns: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(self.rows)).collect();
        if self.fortran_order {
            for column in 0..self.columns {
                let mut slot =
                    wanted.iter().position(|wanted| *wanted == column).map(|slot| &mut columns[slot]);
                self.blocks(&mut reader, self.rows, 1, |numbers| {
                    slot.iter_mut().for_each(|slot| slot.extend(numbers));
                })?;
            }
        } else {
            self.blocks(&mut reader, self.rows, self.columns, |numbers| {
                for (column, &place) in columns.iter_mut().zip(wanted) {
                    column.extend(numbers.iter().skip(place).step_by(self.columns));
                }
            })?;
        }
        for (column, place) in columns.iter().zip(wanted) {
            if let Some(row) = column.iter().position(|number| number.is_infinite()) {
                let message = format!("{}: column {} is infinite at row {}", self.file, place + 1, row + 1);
                return Err(RecordError::new(message, "", "put NaN where a sample is missing", None));
            }
        }
        Ok(columns)
    }

    /// Reads `count` groups of `width` numbers, and passes them on several whole groups at a time.
    fn blocks(
        &self,
        reader: &mut impl Read,
        count: usize,
        width: usize,
        mut take: impl FnMut(&[f64]),
    ) -> Result<(), RecordError> {
        let Number { size, decode, .. } = *self.number;
        let at_a_time = (BLOCK / (width * size).max(1)).max(1);
        let (mut bytes, mut numbers, mut left) = (Vec::new(), Vec::new(), count);
        while left > 0 && width > 0 {
            let now = left.min(at_a_time);
            bytes.resize(now * width * size, 0);
            reader.read_exact(&mut bytes).map_err(|error| match error.kind() {
                io::ErrorKind::UnexpectedEof => bad(&self.file, "it ends too early"),
                _ => RecordError::unreadable(&self.file, &error),
            })?;
            if self.big_endian {
                bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
            }
            numbers.clear();
            decode(&bytes, &mut numbers);
            take(&numbers);
            left -= now;
        }
        Ok(())
    }
}

fn bad(file: &str, why: &str) -> RecordError {
    let help = "save it as np.save(\"log.npy\", a) with a of one dimension, or two with a row for each \
                sample, of floats or integers";
    RecordError::new(format!("{file} cannot be taken as a .npy record: {why}"), "", help, None)
}
