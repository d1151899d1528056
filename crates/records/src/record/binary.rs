//! Raw binary files by a described layout.

use std::io::Read;

use crate::record::error::RecordError;
use crate::record::format::{Bytes, Columns, Source};
use crate::record::matrix::{NUMBERS, Number};
use crate::record::names::Name;
use crate::record::recording::Rules;

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
