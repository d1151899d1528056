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
