//! Tables of Parquet files (.parquet), read by the library of the format.
//!
//! Columns with one number or none in each row are read; texts, lists, decimals and dates are not. Times of the calendar are numbers
//! since 1970 in their unit.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, Int96};
use parquet::errors::{ParquetError, Result as Read};
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::record::RecordError;
use crate::record::column_file::Rules;
use crate::record::format::{Columns, Format, MAX_UNPACKED, Origin, Source, check_unpacked};
use crate::record::names::Name;
use sagnac_base::text_file::open as open_file;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(b"PAR1"), open };

/// Rows of a column that are read at a time.
const BLOCK: usize = 1 << 16;

/// Opens the file and finds its columns of numbers.
fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let (file, length) = (source.file.clone(), source.size()?);
    let reader = match &source.origin {
        Origin::Path(path) => {
            let opened = open_file(path).map_err(|error| RecordError::unreadable(&file, &error))?;
            Pages::open(&file, opened, length)?
        }
        Origin::Bytes(bytes) => Pages::open(&file, Bytes::copy_from_slice(bytes), length)?,
        Origin::Unpacked(bytes) => Pages::open(&file, Bytes::from_owner(bytes.clone()), length)?,
    };
    let about = reader.metadata();
    let unpacked = about.row_groups().iter().map(|group| group.total_byte_size().max(0) as u64);
    let rows = usize::try_from(about.file_metadata().num_rows()).unwrap_or(usize::MAX);
    check_unpacked(unpacked.fold(0, u64::saturating_add), Some(length))
        .map_err(|error| refused(&file, &error.to_string()))?;
    let chunks = || about.row_groups().iter().flat_map(|group| group.columns());
    let places = chunks().flat_map(|chunk| {
        [Some(chunk.data_page_offset()), chunk.dictionary_page_offset(), Some(chunk.compressed_size())]
    });
    // On these the library panics.
    if places.flatten().any(|place| place < 0) {
        return Err(refused(&file, "a column has a place before the file"));
    }
    let unknown = chunks().find_map(|chunk| match chunk.compression() {
        Compression::BROTLI(_) => Some("Brotli"),
        Compression::LZO => Some("LZO"),
        _ => None,
    });
    if let Some(packing) = unknown {
        return Err(refused(&file, &format!("it is packed by {packing}")));
    }
    let columns = about.file_metadata().schema_descr().columns().iter().enumerate();
    let (names, columns): (Vec<Name>, Vec<Column>) =
        columns.filter_map(|(place, column)| Column::new(place, column)).unzip();
    if columns.is_empty() {
        let message = format!("{file} has no columns of numbers");
        return Err(RecordError::new(
            message,
            "",
            "give a table of numbers, each in a column of its own",
            None,
        ));
    }
    Ok(Box::new(Parquet { file, reader, names, columns, rows }))
}

/// Does some work of the library. It checks most of what it reads, and panics on the rest.
fn guarded<T>(file: &str, work: impl FnOnce() -> Read<T>) -> Result<T, RecordError> {
    let damaged = || Err(ParquetError::General("it is damaged".to_owned()));
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| damaged()).map_err(|error| {
        // The library says before what kind of error it is.
        let said = error.to_string();
        refused(file, said.split_once(": ").map_or(&said[..], |(_, why)| why))
    })
}

fn refused(file: &str, why: &str) -> RecordError {
    let help = "write the table again, as by `pandas.read_parquet(\"LOG\").to_parquet(\"NEW\")` in Python";
    RecordError::new(format!("{file} cannot be taken as Parquet: {why}"), "", help, None)
}

/// The bytes of a file of some length. The library takes memory for any length that a page claims, which those of recordings do not.
struct Pages<B> {
    bytes: B,
    length: u64,
}

/// Most bytes of the three fields with which the header of a page begins.
const PAGE_HEADER: u64 = 18;

/// Bytes that any page may unpack to.
const ANY_PAGE: u64 = 1 << 24;

impl<B: ChunkReader + 'static> Pages<B> {
    /// Reads the description of the table.
    fn open(file: &str, bytes: B, length: u64) -> Result<Box<dyn FileReader>, RecordError> {
        Ok(Box::new(guarded(file, || SerializedFileReader::new(Pages { bytes, length }))?))
    }
}

impl<B> Length for Pages<B> {
    fn len(&self) -> u64 {
        self.length
    }
}

impl<B: ChunkReader> ChunkReader for Pages<B> {
    type T = B::T;

    /// The bytes from a header on.
    fn get_read(&self, start: u64) -> Read<B::T> {
        let header = self.get_bytes(start, PAGE_HEADER.min(self.length.saturating_sub(start)) as usize)?;
        match lengths(&header) {
            Some([unpacked, stored]) if unpacked > ANY_PAGE.max(MAX_UNPACKED * stored) => {
                Err(ParquetError::General(format!("the {stored} bytes of a page unpack to {unpacked}")))
            }
            _ => self.bytes.get_read(start),
        }
    }

    fn get_bytes(&self, start: u64, length: usize) -> Read<Bytes> {
        match start.checked_add(length as u64).filter(|end| *end <= self.length) {
            Some(_) => self.bytes.get_bytes(start, length),
            None => Err(ParquetError::EOF("it ends too early".to_owned())),
        }
    }
}

/// The lengths of a page, unpacked and as it is stored, which its header has behind its type.
fn lengths(header: &[u8]) -> Option<[u64; 2]> {
    let mut bytes = header.iter();
    // Each field begins with the byte of an integer that follows the one before.
    let mut field = || {
        bytes.next().filter(|byte| **byte == 0x15)?;
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = bytes.next()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        // The last bit is that of the sign.
        Some(number >> 1)
    };
    let [_, unpacked, stored] = [field()?, field()?, field()?];
    Some([unpacked, stored])
}

/// An open file.
struct Parquet {
    file: String,
    reader: Box<dyn FileReader>,
    names: Vec<Name>,
    columns: Vec<Column>,
    rows: usize,
}

impl Columns for Parquet {
    fn names(&self) -> &[Name] {
        &self.names
    }

    fn count(&self) -> usize {
        self.columns.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        rules.limit(&self.file, self.rows)?;
        let mut all = Vec::new();
        for &column in wanted {
            let (column, mut numbers) = (&self.columns[column], Vec::new());
            guarded(&self.file, || {
                (0..self.reader.num_row_groups()).try_for_each(|group| {
                    let reader = self.reader.get_row_group(group)?.get_column_reader(column.place)?;
                    column.append(reader, &mut numbers, self.rows)
                })
            })?;
            if numbers.len() != self.rows {
                let why = format!("a column has {} rows of {}", numbers.len(), self.rows);
                return Err(refused(&self.file, &why));
            }
            all.push(numbers);
        }
        Ok(all)
    }
}

/// A column with numbers.
struct Column {
    /// The place of the column among all columns of the file.
    place: usize,
    is_unsigned: bool,
    /// The level of a row with a number; others have none.
    level: i16,
}

impl Column {
    /// The column with its name, if it has one number or none in each row.
    fn new(place: usize, column: &ColumnDescriptor) -> Option<(Name, Column)> {
        use ConvertedType as Old;
        let unit = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => "ms",
            TimeUnit::MICROS => "us",
            TimeUnit::NANOS => "ns",
        };
        let kind = column.physical_type();
        let (unit, is_unsigned) = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(time)), _) => (Some(unit(&time.unit)), false),
            (Some(LogicalType::Time(time)), _) => (Some(unit(&time.unit)), false),
            (Some(LogicalType::Integer(integer)), _) => (None, !integer.is_signed),
            (Some(_), _) => return None,
            (None, Old::TIMESTAMP_MILLIS | Old::TIME_MILLIS) => (Some("ms"), false),
            (None, Old::TIMESTAMP_MICROS | Old::TIME_MICROS) => (Some("us"), false),
            (None, Old::UINT_8 | Old::UINT_16 | Old::UINT_32 | Old::UINT_64) => (None, true),
            (None, Old::INT_8 | Old::INT_16 | Old::INT_32 | Old::INT_64) => (None, false),
            // Times of early versions.
            (None, Old::NONE) => ((kind == Type::INT96).then_some("ns"), false),
            (None, _) => return None,
        };
        let is_number = matches!(kind, Type::INT32 | Type::INT64 | Type::INT96 | Type::FLOAT | Type::DOUBLE);
        if !is_number || column.max_rep_level() > 0 {
            return None;
        }
        let path = column.path().string();
        let name = Name::read(&path);
        let name = match unit {
            Some(unit) if name.unit.is_none() => Name::read(&format!("{path} [{unit}]")),
            _ => name,
        };
        Some((name, Column { place, is_unsigned, level: column.max_def_level() }))
    }

    /// Adds the numbers of a part of the rows, of which the file has so many.
    fn append(&self, reader: ColumnReader, numbers: &mut Vec<f64>, rows: usize) -> Read<()> {
        use ColumnReader::{
            DoubleColumnReader, FloatColumnReader, Int32ColumnReader, Int64ColumnReader, Int96ColumnReader,
        };
        let to = (numbers, rows);
        match reader {
            Int32ColumnReader(reader) if self.is_unsigned => {
                self.each(reader, |number| f64::from(number as u32), to)
            }
            Int64ColumnReader(reader) if self.is_unsigned => {
                self.each(reader, |number| number as u64 as f64, to)
            }
            Int32ColumnReader(reader) => self.each(reader, f64::from, to),
            Int64ColumnReader(reader) => self.each(reader, |number| number as f64, to),
            Int96ColumnReader(reader) => self.each(reader, |time: Int96| time.to_nanos() as f64, to),
            FloatColumnReader(reader) => self.each(reader, f64::from, to),
            DoubleColumnReader(reader) => self.each(reader, |number| number, to),
            _ => Ok(()),
        }
    }

    fn each<T: DataType>(
        &self,
        mut reader: ColumnReaderImpl<T>,
        number: impl Fn(T::T) -> f64,
        (numbers, rows): (&mut Vec<f64>, usize),
    ) -> Read<()> {
        let (mut levels, mut values) = (Vec::new(), Vec::new());
        loop {
            let (count, ..) = reader.read_records(BLOCK, Some(&mut levels), None, &mut values)?;
            // Of a damaged file, a few bytes may claim any number of rows.
            if count == 0 || numbers.len() > rows {
                return Ok(());
            }
            let mut values = values.drain(..).map(&number);
            match self.level {
                0 => numbers.extend(values),
                level => numbers.extend(levels.drain(..).map(|found| {
                    let value = if found == level { values.next() } else { None };
                    value.unwrap_or(f64::NAN)
                })),
            }
        }
    }
}
