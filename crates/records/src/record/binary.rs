//! Numbers of binary files: raw files by a described layout, the types of numbers, matrices of them in a stream of bytes, and files
//! that hold several named arrays, whose columns are taken for the columns of a log.

use std::io::{self, Read};

use crate::record::column_file::Rules;
use crate::record::format::{Bytes, Columns, Source, check_unpacked};
use crate::record::names::Name;
use crate::record::{RecordError, told};

/// Most columns of a row.
const MAX_COLUMNS: usize = 4096;

/// Bytes read at a time, about.
const BLOCK: usize = 8 << 20;

/// The layout of a raw binary file, whose rows follow each other without anything between: the types of the numbers in a row,
/// their order of bytes, the names of some columns, and the length of a header.
#[derive(Debug, Clone, PartialEq)]
pub struct Binary {
    /// Index of the type of each column among the known ones.
    types: Vec<usize>,
    big_endian: bool,
    /// Column numbers from 1, with their names.
    names: Vec<(usize, String)>,
    skipped: u64,
}

/// Why a layout is not understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{message}\nwrite it as in \"f64 x7, little, time 1, rate 3\": types f32, f64, i8 to i64 and u8 to u64 with the number \
    of such columns, little or big, names of columns with their numbers, and `skip 128` for a header of 128 bytes"
)]
pub struct BinaryError {
    message: String,
}

impl Binary {
    /// Reads a description such as `u32, f32 x6, big, skip 64, time 1, gz 4`. Without `big`, the lowest byte is first.
    ///
    /// # Errors
    /// An item is unknown, or there are no columns.
    ///
    /// # Example
    /// ```
    /// use sagnac_records::record::binary::Binary;
    ///
    /// assert!(Binary::parse("f64 x7, little, rate 3").is_ok());
    /// assert!(Binary::parse("f64 x7, middle").unwrap_err().to_string().contains("`middle`"));
    /// ```
    pub fn parse(text: &str) -> Result<Binary, BinaryError> {
        let wrong = |message: String| BinaryError { message };
        let mut layout = Binary { types: vec![], big_endian: false, names: vec![], skipped: 0 };
        for item in text.split(',') {
            let words: Vec<&str> = item.split_whitespace().collect();
            let unknown =
                || wrong(format!("`{}` has no meaning in the layout of a binary file", item.trim()));
            let kind = |word: &str| NUMBERS.iter().position(|number| number.long_name == word);
            match words[..] {
                ["little"] => layout.big_endian = false,
                ["big"] => layout.big_endian = true,
                ["skip", bytes] => layout.skipped = bytes.parse().map_err(|_| unknown())?,
                [word] => layout.types.push(kind(word).ok_or_else(unknown)?),
                [word, count] if kind(word).is_some() => {
                    let times: Option<usize> = count.strip_prefix('x').and_then(|times| times.parse().ok());
                    let times =
                        times.filter(|times| (1..=MAX_COLUMNS).contains(times)).ok_or_else(unknown)?;
                    layout.types.extend(std::iter::repeat_n(kind(word).unwrap_or_default(), times));
                }
                [.., number] => {
                    let column: usize = number.parse().map_err(|_| unknown())?;
                    layout.names.push((column, words[..words.len() - 1].join(" ")));
                }
                [] => return Err(unknown()),
            }
        }
        let columns = layout.types.len();
        if !(1..=MAX_COLUMNS).contains(&columns) {
            return Err(wrong(format!("the layout has {columns} columns")));
        }
        if let Some((column, name)) = layout.names.iter().find(|(column, _)| !(1..=columns).contains(column))
        {
            return Err(wrong(format!(
                "`{name} {column}` names a column that is not there: the layout has {columns}"
            )));
        }
        Ok(layout)
    }

    fn numbers(&self) -> impl Iterator<Item = &'static Number> + '_ {
        self.types.iter().map(|&kind| &NUMBERS[kind])
    }

    /// Columns that the layout names, other than those of times: they are the requested ones where no others are.
    pub(crate) fn named(&self, is_time: impl Fn(&str) -> bool) -> Vec<usize> {
        let others = self.names.iter().filter(|(_, name)| !is_time(&Name::read(name).bare));
        others.map(|(column, _)| column - 1).collect()
    }

    /// Opens a file of this layout.
    pub(crate) fn open<'a>(&self, source: Source<'a>) -> Result<Box<dyn Columns + 'a>, RecordError> {
        let row: u64 = self.numbers().map(|number| number.size as u64).sum();
        let bad = |why: String| {
            let help =
                "correct the layout in `binary = \"f64 x7, little\"`: all rows must have the same length";
            Err(RecordError::new(format!("{} does not fit the layout: {why}", source.file), "", help, None))
        };
        let length = source.size()?;
        if length < self.skipped || !(length - self.skipped).is_multiple_of(row) {
            let after = length.saturating_sub(self.skipped);
            return bad(format!("{after} bytes of numbers are no multiple of {row}, the bytes of a row"));
        }
        let rows = usize::try_from((length - self.skipped) / row).unwrap_or(usize::MAX);
        let names = match self.names.is_empty() {
            true => vec![],
            false => (1..=self.types.len())
                .map(|number| {
                    let named = self.names.iter().find(|(column, _)| *column == number);
                    Name::read(&named.map_or_else(|| number.to_string(), |(_, name)| name.clone()))
                })
                .collect(),
        };
        Ok(Box::new(Raw {
            layout: self.clone(),
            file: source.file.clone(),
            names,
            rows,
            bytes: source.from(0),
        }))
    }
}

struct Raw<'a> {
    layout: Binary,
    file: String,
    names: Vec<Name>,
    rows: usize,
    /// The bytes from the start of the file on.
    bytes: Bytes<'a>,
}

impl Columns for Raw<'_> {
    fn names(&self) -> &[Name] {
        &self.names
    }

    fn count(&self) -> usize {
        self.layout.types.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        rules.limit(&self.file, self.rows)?;
        let failed = |error| RecordError::unreadable(&self.file, &error);
        let sizes: Vec<usize> = self.layout.numbers().map(|number| number.size).collect();
        let row: usize = sizes.iter().sum();
        std::io::copy(&mut Read::take(&mut self.bytes, self.layout.skipped), &mut std::io::sink())
            .map_err(failed)?;
        let mut columns: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(self.rows)).collect();
        let (mut left, mut block, mut cells) = (self.rows, Vec::new(), Vec::new());
        while left > 0 {
            let now = left.min((BLOCK / row).max(1));
            block.resize(now * row, 0);
            self.bytes.read_exact(&mut block).map_err(failed)?;
            for (slot, &column) in columns.iter_mut().zip(wanted) {
                let start: usize = sizes[..column].iter().sum();
                let number = &NUMBERS[self.layout.types[column]];
                cells.clear();
                block
                    .chunks_exact(row)
                    .for_each(|row| cells.extend_from_slice(&row[start..start + number.size]));
                number.append(&mut cells, self.layout.big_endian, slot);
            }
            left -= now;
        }
        Ok(columns)
    }
}

/// Bytes read at a time.
const MATRIX_BLOCK: usize = 8 << 20;

/// Most samples for which memory is taken before they are read, because a header may promise any number.
const AT_ONCE: usize = 1 << 24;

/// A type of numbers: its names in NumPy and in a described layout, its size in bytes, and its decoder for many numbers,
/// lowest byte first.
pub(crate) struct Number {
    pub name: &'static str,
    pub long_name: &'static str,
    pub size: usize,
    pub decode: fn(&[u8], &mut Vec<f64>),
}

macro_rules! numbers {
    ($($name:literal $type:ident $number:expr),* $(,)?) => {
        &[$(Number {
            name: $name,
            long_name: stringify!($type),
            size: size_of::<$type>(),
            decode: |bytes, numbers| {
                let number = |raw: &[u8]| $number(<$type>::from_le_bytes(raw.try_into().unwrap_or_default()));
                numbers.extend(bytes.chunks_exact(size_of::<$type>()).map(number));
            },
        }),*]
    };
}

/// The bits of a floating-point number of two bytes.
#[expect(non_camel_case_types, reason = "it is called like the other types of numbers")]
type f16 = u16;

/// The supported types of numbers.
pub(crate) static NUMBERS: &[Number] = numbers!(
    "f2" f16 of_half,
    "f4" f32 f64::from,
    "f8" f64 |x| x,
    "i1" i8 f64::from,
    "i2" i16 f64::from,
    "i4" i32 f64::from,
    "i8" i64 |x| x as f64,
    "u1" u8 f64::from,
    "u2" u16 f64::from,
    "u4" u32 f64::from,
    "u8" u64 |x| x as f64,
);

/// The number that stands for the `bits` of a half-precision one.
fn of_half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => libm::ldexp(fraction, -24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => libm::ldexp(1024.0 + fraction, exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

impl Number {
    /// The type that NumPy calls so, such as `f8`; 8 are its bytes.
    pub(crate) fn called(name: &str) -> Option<&'static Number> {
        NUMBERS.iter().find(|number| number.name == name)
    }

    /// Appends the numbers in `bytes`, which are reversed where their highest byte is first.
    pub(crate) fn append(&self, bytes: &mut [u8], big_endian: bool, numbers: &mut Vec<f64>) {
        if big_endian {
            bytes.chunks_exact_mut(self.size).for_each(<[u8]>::reverse);
        }
        (self.decode)(bytes, numbers);
    }
}

/// A matrix with a row for each sample.
#[derive(Clone, Copy)]
pub(crate) struct Matrix {
    pub number: &'static Number,
    pub big_endian: bool,
    /// Whether the numbers of a column are side by side, not those of a row.
    pub by_columns: bool,
    pub rows: usize,
    pub columns: usize,
}

impl Matrix {
    /// Length of the numbers, if it is one that a file can have.
    pub(crate) fn bytes(&self) -> Option<u64> {
        (self.rows as u64).checked_mul(self.columns as u64)?.checked_mul(self.number.size as u64)
    }

    /// The `wanted` columns, in the order given.
    ///
    /// # Errors
    /// The numbers cannot be read, or end early.
    pub(crate) fn read(&self, reader: &mut dyn Read, wanted: &[usize]) -> io::Result<Vec<Vec<f64>>> {
        let mut columns: Vec<Vec<f64>> = vec![vec![]; wanted.len()];
        for column in &mut columns {
            // A header may promise any number.
            column.try_reserve_exact(self.rows.min(AT_ONCE)).map_err(|_| io::ErrorKind::OutOfMemory)?;
        }
        if self.by_columns {
            for column in 0..self.columns {
                let mut slot =
                    wanted.iter().position(|wanted| *wanted == column).map(|slot| &mut columns[slot]);
                self.blocks(reader, self.rows, 1, |numbers| {
                    slot.iter_mut().for_each(|slot| slot.extend(numbers));
                })?;
            }
        } else {
            self.blocks(reader, self.rows, self.columns, |numbers| {
                for (column, &place) in columns.iter_mut().zip(wanted) {
                    column.extend(numbers.iter().skip(place).step_by(self.columns));
                }
            })?;
        }
        Ok(columns)
    }

    /// Reads `count` groups of `width` numbers, and passes them on several whole groups at a time.
    fn blocks(
        &self,
        reader: &mut dyn Read,
        count: usize,
        width: usize,
        mut take: impl FnMut(&[f64]),
    ) -> io::Result<()> {
        let size = self.number.size;
        let at_a_time = (MATRIX_BLOCK / (width * size).max(1)).max(1);
        let (mut bytes, mut numbers, mut left) = (Vec::new(), Vec::new(), count);
        while left > 0 && width > 0 {
            let now = left.min(at_a_time);
            bytes.resize(now * width * size, 0);
            reader.read_exact(&mut bytes)?;
            numbers.clear();
            self.number.append(&mut bytes, self.big_endian, &mut numbers);
            take(&numbers);
            left -= now;
        }
        Ok(())
    }
}

/// Most columns. An array without rows may claim any number of them.
pub(crate) const MAX_ARRAY_COLUMNS: usize = 1 << 20;

/// An array of a file.
pub(crate) struct Array {
    pub name: Name,
    pub rows: usize,
    pub columns: usize,
}

/// The columns of all arrays of a file with at least two rows. Those of a matrix `gyro_dps` are called `gyro_dps.1`, `gyro_dps.2`
/// and so on, and have its unit.
pub(crate) struct Arrays {
    file: String,
    pub names: Vec<Name>,
    /// The array of each column, with the place of the column in it and the number of its rows.
    places: Vec<(usize, usize, usize)>,
    /// Length of the file in bytes, if it is known.
    stored: Option<u64>,
}

impl Arrays {
    /// The columns of `arrays`; `left_out` describes what else the file holds.
    ///
    /// # Errors
    /// There are no columns, or too many.
    pub(crate) fn new(
        file: &str,
        arrays: &[Array],
        left_out: &[String],
        stored: Option<u64>,
    ) -> Result<Arrays, RecordError> {
        let (mut names, mut places) = (Vec::new(), Vec::new());
        for (at, array) in arrays.iter().enumerate().filter(|(_, array)| array.rows > 1) {
            if names.len().saturating_add(array.columns) > MAX_ARRAY_COLUMNS {
                let message = format!("{file} has more than {MAX_ARRAY_COLUMNS} columns");
                let help = "an array needs a row for each sample: transpose it";
                return Err(RecordError::new(message, "", help, None));
            }
            for column in 0..array.columns {
                names.push(match array.columns {
                    1 => array.name.clone(),
                    _ => array.name.numbered(column + 1),
                });
                places.push((at, column, array.rows));
            }
        }
        if names.is_empty() {
            let others =
                if left_out.is_empty() { String::new() } else { format!(", only {}", left_out.join(", ")) };
            let message = format!("{file} has no arrays of real numbers{others}");
            let help = "save the samples as arrays of numbers with a row for each sample; in MATLAB `writetimetable(T, \"log.csv\")` and \
                        `writetable` save tables as text";
            return Err(RecordError::new(message, "", help, None));
        }
        Ok(Arrays { file: file.to_owned(), names, places, stored })
    }

    /// The numbers of the `wanted` columns, of which `read` gives those of one array.
    ///
    /// # Errors
    /// The columns have different lengths, or more rows than accepted, or cannot be read.
    pub(crate) fn read(
        &self,
        wanted: &[usize],
        rules: &Rules,
        mut read: impl FnMut(usize, &[usize]) -> Result<Vec<Vec<f64>>, RecordError>,
    ) -> Result<Vec<Vec<f64>>, RecordError> {
        let rows = |column: usize| self.places[column].2;
        if let Some((&first, &other)) =
            wanted.first().zip(wanted.iter().find(|other| rows(**other) != rows(wanted[0])))
        {
            let message = format!(
                "{}: `{}` has {} rows, `{}` has {}",
                self.file,
                self.names[first].whole,
                rows(first),
                self.names[other].whole,
                rows(other)
            );
            return Err(RecordError::new(
                message,
                "",
                "select columns of the same length with `column = NAME`",
                None,
            ));
        }
        let count = wanted.first().map_or(0, |&column| rows(column));
        rules.limit(&self.file, count)?;
        let bytes = (count as u64).saturating_mul(8 * wanted.len() as u64);
        check_unpacked(bytes, self.stored).map_err(|error| {
            let help = "if it is a recording, save it without compression";
            RecordError::new(format!("{}: {}", self.file, told(&error)), "", help, None)
        })?;
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut arrays: Vec<usize> = wanted.iter().map(|&column| self.places[column].0).collect();
        arrays.sort_unstable();
        arrays.dedup();
        for array in arrays {
            let slots: Vec<usize> =
                (0..wanted.len()).filter(|&slot| self.places[wanted[slot]].0 == array).collect();
            let within: Vec<usize> = slots.iter().map(|&slot| self.places[wanted[slot]].1).collect();
            for (slot, numbers) in slots.into_iter().zip(read(array, &within)?) {
                columns[slot] = numbers;
            }
        }
        Ok(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_have_types_order_header_and_names() {
        let layout = Binary::parse("u32, f32 x6, big, skip 64, time_us 1, gz [dps] 4").unwrap();
        let names: Vec<&str> = layout.numbers().map(|number| number.long_name).collect();
        assert_eq!(names, ["u32", "f32", "f32", "f32", "f32", "f32", "f32"]);
        assert_eq!((layout.big_endian, layout.skipped), (true, 64));
        assert_eq!(layout.named(|name| name == "time"), [3]);
    }

    #[test]
    fn what_is_no_layout_is_named() {
        for (text, piece) in [
            ("", "`` has no meaning"),
            ("little", "has 0 columns"),
            ("f64 x0", "`f64 x0`"),
            ("f64 x99999", "`f64 x99999`"),
            ("f65", "`f65`"),
            ("f64 x2, rate 3", "`rate 3` names a column that is not there: the layout has 2"),
            ("f64, rate", "`rate`"),
            ("f64, skip -1", "`skip -1`"),
        ] {
            let error = Binary::parse(text).unwrap_err().to_string();
            assert!(error.contains(piece) && error.contains("f64 x7"), "{text}: {error}");
        }
    }
}
