//! Numbers of binary files: their types, and matrices of them in a stream of bytes.

use std::io::{self, Read};

/// Bytes read at a time.
const BLOCK: usize = 8 << 20;

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
    ($($name:literal $type:ident),*) => {
        &[$(Number {
            name: $name,
            long_name: stringify!($type),
            size: size_of::<$type>(),
            decode: |bytes, numbers| {
                let number = |raw: &[u8]| <$type>::from_le_bytes(raw.try_into().unwrap_or_default()) as f64;
                numbers.extend(bytes.chunks_exact(size_of::<$type>()).map(number));
            },
        }),*]
    };
}

/// The supported types of numbers.
pub(crate) static NUMBERS: &[Number] = numbers!(
    "f4" f32, "f8" f64, "i1" i8, "i2" i16, "i4" i32, "i8" i64, "u1" u8, "u2" u16, "u4" u32, "u8" u64
);

impl Number {
    /// The type with this name, such as `f8` or `f64`.
    pub(crate) fn called(name: &str) -> Option<&'static Number> {
        NUMBERS.iter().find(|number| number.name == name || number.long_name == name)
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
        let room = self.rows.min(AT_ONCE);
        let mut columns: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(room)).collect();
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
        let at_a_time = (BLOCK / (width * size).max(1)).max(1);
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
