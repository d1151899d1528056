//! NumPy arrays in .npy files, versions 1 to 3.
//!
//! The parser is our own: the header is one line of text, and the numbers after it are converted to f64 in one pass.
//! The format is that of NEP 1.

use std::io::{self, Read};

use crate::record::log::error::LogError;
use crate::record::log::{MOST_SAMPLES, unreadable};

/// The first bytes of a .npy file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Length in bytes of the longest header that is read.
const LONGEST: usize = 1 << 16;

/// Most columns. An array without rows may claim any number of them, and so may one from a pipe.
const MOST_COLUMNS: usize = 1 << 20;

/// Bytes read at a time.
const BLOCK: usize = 8 << 20;

/// The contents of the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Array {
    file: String,
    element: Element,
    big_endian: bool,
    fortran_order: bool,
    pub rows: usize,
    pub columns: usize,
}

/// The supported types of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Element {
    F4,
    F8,
    I1,
    I2,
    I4,
    I8,
    U1,
    U2,
    U4,
    U8,
}

impl Element {
    const ALL: [(&'static str, Element, usize); 10] = [
        ("f4", Element::F4, 4),
        ("f8", Element::F8, 8),
        ("i1", Element::I1, 1),
        ("i2", Element::I2, 2),
        ("i4", Element::I4, 4),
        ("i8", Element::I8, 8),
        ("u1", Element::U1, 1),
        ("u2", Element::U2, 2),
        ("u4", Element::U4, 4),
        ("u8", Element::U8, 8),
    ];

    fn size(self) -> usize {
        Element::ALL.iter().find(|(_, element, _)| *element == self).map_or(8, |(.., size)| *size)
    }
}

impl Array {
    /// Reads the header. `length` is that of the file, where it is known.
    ///
    /// # Errors
    /// The array is not supported, or is longer than its file.
    pub(crate) fn read(file: &str, reader: &mut impl Read, length: Option<u64>) -> Result<Array, LogError> {
        let mut start = [0; 8];
        reader.read_exact(&mut start).map_err(|e| short(file, &e))?;
        let wide = start[6] > 1;
        let mut size = [0; 4];
        let bytes = if wide { 4 } else { 2 };
        reader.read_exact(&mut size[..bytes]).map_err(|e| short(file, &e))?;
        let size = u32::from_le_bytes(size) as usize;
        if size > LONGEST {
            return Err(bad(file, "its header is longer than 64 KiB"));
        }
        let mut header = vec![0; size];
        reader.read_exact(&mut header).map_err(|e| short(file, &e))?;
        let array = Array::parse(file, &String::from_utf8_lossy(&header))?;
        let promised = (array.rows as u64)
            .checked_mul(array.columns as u64)
            .and_then(|count| count.checked_mul(array.element.size() as u64));
        let there = length.map(|length| length.saturating_sub((8 + bytes + size) as u64));
        match (promised, there) {
            (Some(promised), Some(there)) if promised > there => Err(bad(
                file,
                &format!("its header promises {promised} bytes of numbers, the file has {there}"),
            )),
            (None, _) => Err(bad(file, "its header promises more numbers than can be")),
            _ if array.rows > MOST_SAMPLES => {
                Err(bad(file, &format!("it has {} rows, more than {MOST_SAMPLES}", array.rows)))
            }
            _ if array.columns > MOST_COLUMNS => {
                Err(bad(file, &format!("it has {} columns, more than {MOST_COLUMNS}", array.columns)))
            }
            _ => Ok(array),
        }
    }

    /// `{'descr': '<f8', 'fortran_order': False, 'shape': (1000, 3), }`
    fn parse(file: &str, header: &str) -> Result<Array, LogError> {
        let after = |key: &str| {
            let found = header.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
            found.ok_or_else(|| bad(file, &format!("its header has no `{key}`")))
        };
        let quoted = after("descr")?.strip_prefix('\'').and_then(|rest| rest.split_once('\''));
        let Some((described, _)) = quoted else {
            return Err(bad(file, "it has named fields"));
        };
        let (order, name) = described.split_at_checked(1).unwrap_or_default();
        let Some(&(_, element, size)) = Element::ALL.iter().find(|(known, ..)| *known == name) else {
            return Err(bad(file, &format!("its numbers are of type '{described}'")));
        };
        let big_endian = match order {
            ">" => size > 1,
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
        Ok(Array { file: file.to_owned(), element, big_endian, fortran_order, rows, columns })
    }

    /// The `wanted` columns, in the order given.
    ///
    /// # Errors
    /// The file cannot be read, ends early, or contains an infinite number.
    pub(crate) fn columns(&self, mut reader: impl Read, wanted: &[usize]) -> Result<Vec<Vec<f64>>, LogError> {
        let mut columns: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(self.rows)).collect();
        // Stretches of numbers that belong to one row, or in Fortran order to one column.
        let (stretches, length) =
            if self.fortran_order { (self.columns, self.rows) } else { (self.rows, self.columns) };
        let slot = |column: usize| wanted.iter().position(|wanted| *wanted == column);
        if self.fortran_order || self.columns == 1 {
            let (stretches, length) = if self.columns == 1 { (1, self.rows) } else { (stretches, length) };
            for column in 0..stretches {
                match slot(column) {
                    Some(slot) => {
                        self.blocks(&mut reader, length, 1, |numbers| columns[slot].extend(numbers))?
                    }
                    None => {
                        let bytes = (length * self.element.size()) as u64;
                        io::copy(&mut reader.by_ref().take(bytes), &mut io::sink())
                            .map_err(|e| short(&self.file, &e))?;
                    }
                }
            }
        } else {
            self.blocks(&mut reader, stretches, length, |numbers| {
                for (column, &place) in columns.iter_mut().zip(wanted) {
                    column.extend(numbers.iter().skip(place).step_by(length));
                }
            })?;
        }
        for (column, place) in columns.iter().zip(wanted) {
            if let Some(row) = column.iter().position(|number| number.is_infinite()) {
                let message = format!("{}: column {} is infinite at row {}", self.file, place + 1, row + 1);
                return Err(LogError::new(message, "", "put NaN where a sample is missing", None));
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
    ) -> Result<(), LogError> {
        let group = width * self.element.size();
        let at_a_time = (BLOCK / group.max(1)).max(1);
        let (mut bytes, mut numbers, mut left) = (Vec::new(), Vec::new(), count);
        while left > 0 && width > 0 {
            let now = left.min(at_a_time);
            bytes.resize(now * group, 0);
            reader.read_exact(&mut bytes).map_err(|e| short(&self.file, &e))?;
            self.decode(&bytes, &mut numbers);
            take(&numbers);
            left -= now;
        }
        Ok(())
    }

    fn decode(&self, bytes: &[u8], numbers: &mut Vec<f64>) {
        numbers.clear();
        macro_rules! decode {
            ($type:ty) => {{
                let of = |chunk: &[u8]| {
                    let mut raw = [0; size_of::<$type>()];
                    raw.copy_from_slice(chunk);
                    let number = if self.big_endian {
                        <$type>::from_be_bytes(raw)
                    } else {
                        <$type>::from_le_bytes(raw)
                    };
                    number as f64
                };
                numbers.extend(bytes.chunks_exact(size_of::<$type>()).map(of));
            }};
        }
        match self.element {
            Element::F4 => decode!(f32),
            Element::F8 => decode!(f64),
            Element::I1 => decode!(i8),
            Element::I2 => decode!(i16),
            Element::I4 => decode!(i32),
            Element::I8 => decode!(i64),
            Element::U1 => decode!(u8),
            Element::U2 => decode!(u16),
            Element::U4 => decode!(u32),
            Element::U8 => decode!(u64),
        }
    }
}

fn bad(file: &str, why: &str) -> LogError {
    let help = "save it as np.save(\"log.npy\", a) with a of one dimension, or two with a row for each \
                sample, of floats or integers";
    LogError::new(format!("{file} cannot be taken as a .npy record: {why}"), "", help, None)
}

fn short(file: &str, error: &io::Error) -> LogError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => bad(file, "it ends too early"),
        _ => unreadable(file, error),
    }
}
