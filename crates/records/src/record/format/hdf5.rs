//! HDF5 files, and MATLAB files of version 7.3, which are such files with transposed matrices. Read by a library in Rust.
//!
//! Matrices in chunks are read chunk by chunk, and every chunk must be there: the library would fill in zeros for one that is
//! missing.

use std::io::Cursor;

use hdf5_reader::error::{ByteOrder, Error};
use hdf5_reader::group::Group;
use hdf5_reader::storage::BytesStorage;
use hdf5_reader::{Dataset, Datatype, FileStorage, Hdf5File, OpenOptions};

use crate::record::RecordError;
use crate::record::binary::{Array, Arrays, Matrix, Number};
use crate::record::column_file::Rules;
use crate::record::format::{Columns, Origin, Source};
use crate::record::names::Name;

/// Deepest groups that are searched, and most groups and datasets.
const DEEPEST: usize = 16;
const MAX_OBJECTS: usize = 10_000;

/// Largest chunk, in bytes.
const MAX_CHUNK: usize = 1 << 27;

/// Largest ratio of numbers to compressed numbers, that of deflate. More cannot be in the file.
const DENSEST: u64 = 1100;

/// Opens the file and finds all its datasets of numbers in one or two dimensions.
pub(crate) fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let length = source.size()?;
    let options = OpenOptions::default()
        .with_max_read_bytes(length.try_into().unwrap_or(usize::MAX))
        .with_max_chunk_bytes(MAX_CHUNK);
    let opened = match &source.origin {
        Origin::Path(path) => FileStorage::open(path)
            .and_then(|storage| Hdf5File::from_storage_with_options(std::sync::Arc::new(storage), options)),
        Origin::Bytes(bytes) => Hdf5File::from_vec_with_options(bytes.to_vec(), options),
        Origin::Unpacked(bytes) => {
            let storage = BytesStorage::from_owner(bytes.clone());
            Hdf5File::from_storage_with_options(std::sync::Arc::new(storage), options)
        }
    };
    let mut search = Search {
        is_matlab: source.head.starts_with(b"MATLAB 7.3"),
        length,
        seen: 0,
        datasets: vec![],
        about: vec![],
        left_out: vec![],
    };
    opened
        .and_then(|opened| search.group(&opened.root_group()?, "", 0))
        .map_err(|error| bad(&file, &error.to_string()))?;
    let arrays = Arrays::new(&file, &search.about, &search.left_out, Some(length))?;
    Ok(Box::new(Hdf5 { file, arrays, datasets: search.datasets }))
}

/// A file of which the datasets are known.
struct Hdf5 {
    file: String,
    arrays: Arrays,
    datasets: Vec<(Dataset, Matrix)>,
}

impl Columns for Hdf5 {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let Hdf5 { file, arrays, datasets } = self;
        arrays.read(wanted, rules, |array, within| {
            let (dataset, matrix) = &datasets[array];
            let columns = match dataset.chunks() {
                Some(_) => chunked(dataset, matrix, within),
                None => whole(dataset, matrix, within),
            };
            let packing = Packing::new(dataset);
            let unpacked =
                |columns: Vec<Vec<f64>>| columns.into_iter().map(|column| packing.unpacked(column)).collect();
            columns.map(unpacked).map_err(|why| bad(file, &format!("`{}`: {why}", dataset.name())))
        })
    }
}

/// How numbers are packed by the conventions of netCDF: `scale_factor`, `add_offset`, and the numbers that stand for a missing one.
struct Packing {
    scale: f64,
    offset: f64,
    missing: Vec<f64>,
}

impl Packing {
    fn new(dataset: &Dataset) -> Packing {
        let number = |name: &str| dataset.attribute(name).ok()?.read_as_f64().ok();
        Packing {
            scale: number("scale_factor").unwrap_or(1.0),
            offset: number("add_offset").unwrap_or(0.0),
            missing: ["_FillValue", "missing_value"].into_iter().filter_map(number).collect(),
        }
    }

    fn unpacked(&self, column: Vec<f64>) -> Vec<f64> {
        if self.missing.is_empty() && self.scale == 1.0 && self.offset == 0.0 {
            return column;
        }
        let number = |x: f64| if self.missing.contains(&x) { f64::NAN } else { x * self.scale + self.offset };
        column.into_iter().map(number).collect()
    }
}

/// Whether a description of a type is that of whole bytes or of a floating-point number of IEEE 754, as the library takes all.
fn is_usual(dataset: &Dataset) -> bool {
    let Ok(raw) = dataset.raw_datatype() else { return false };
    let Some((head, properties)) = raw.split_at_checked(8) else { return false };
    let [class, flags, sign, _, size, ..] = *head else { return false };
    let bits = u16::from(size) * 8;
    let place = [0, 0, bits.to_le_bytes()[0], bits.to_le_bytes()[1]];
    match class & 15 {
        0 => properties.starts_with(&place),
        // Exponent, mantissa with an implied bit, bias and sign.
        1 => {
            let shape: [u8; 8] = match size {
                2 => [10, 5, 0, 10, 15, 0, 0, 0],
                4 => [23, 8, 0, 23, 127, 0, 0, 0],
                8 => [52, 11, 0, 52, 255, 3, 0, 0],
                _ => return false,
            };
            let is_implied = flags >> 4 & 3 == 2 && flags & 0x40 == 0;
            is_implied
                && u16::from(sign) == bits - 1
                && properties.starts_with(&[&place[..], &shape].concat())
        }
        _ => false,
    }
}

/// The columns of a dataset that is stored in one piece.
fn whole(dataset: &Dataset, matrix: &Matrix, wanted: &[usize]) -> Result<Vec<Vec<f64>>, String> {
    let bytes = dataset.read_raw_bytes().map_err(|error| error.to_string())?;
    matrix.read(&mut Cursor::new(bytes), wanted).map_err(|error| error.to_string())
}

/// The columns of a dataset that is stored in chunks.
fn chunked(dataset: &Dataset, matrix: &Matrix, wanted: &[usize]) -> Result<Vec<Vec<f64>>, String> {
    let told = |error: Error| error.to_string();
    let mut columns = vec![vec![f64::NAN; matrix.rows]; wanted.len()];
    // The extent of a dataset in one dimension as that of a matrix with one column.
    let extent = |shape: &[u64]| [shape[0] as usize, shape.get(1).map_or(1, |second| *second as usize)];
    let [outer, inner] = extent(dataset.shape());
    let (mut places, mut numbers, mut covered) = (std::collections::HashSet::new(), Vec::new(), 0);
    for chunk in dataset.iter_chunks().map_err(told)? {
        let chunk = chunk.map_err(told)?;
        let [height, width] = extent(chunk.shape());
        let first: Vec<usize> = chunk.offsets().iter().map(|offset| *offset as usize).collect();
        let (top, left) = (first[0], first.get(1).copied().unwrap_or(0));
        let is_empty = height == 0 || width == 0;
        if is_empty
            || !places.insert((top, left))
            || top >= outer
            || left >= inner
            || top % height > 0
            || left % width > 0
        {
            return Err("its index of chunks is damaged".to_owned());
        }
        numbers.clear();
        matrix.number.append(&mut chunk.bytes().to_vec(), matrix.big_endian, &mut numbers);
        if numbers.len() != height * width {
            return Err("a chunk has another size than the others".to_owned());
        }
        let (height, right) = (height.min(outer - top), width.min(inner - left));
        covered += height * right;
        for (slot, &column) in columns.iter_mut().zip(wanted) {
            if matrix.by_columns && (top..top + height).contains(&column) {
                let line = &numbers[(column - top) * width..];
                slot[left..left + right].copy_from_slice(&line[..right]);
            } else if !matrix.by_columns && (left..left + right).contains(&column) {
                let of_column = numbers.iter().skip(column - left).step_by(width).take(height);
                slot[top..top + height].iter_mut().zip(of_column).for_each(|(to, from)| *to = *from);
            }
        }
    }
    if covered != outer * inner {
        return Err("chunks are missing".to_owned());
    }
    Ok(columns)
}

/// A search through all groups.
struct Search {
    is_matlab: bool,
    /// Length of the file, in bytes.
    length: u64,
    seen: usize,
    datasets: Vec<(Dataset, Matrix)>,
    about: Vec<Array>,
    left_out: Vec<String>,
}

impl Search {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Error> {
        let (groups, datasets) = group.members()?;
        self.seen += groups.len() + datasets.len();
        if depth > DEEPEST || self.seen > MAX_OBJECTS {
            return Err(Error::InvalidData("it has too many groups".to_owned()));
        }
        for dataset in datasets {
            let name = format!("{path}{}", dataset.name());
            match self.matrix(&dataset) {
                Ok(matrix) => {
                    let mut name = Name::read(&name);
                    if let Some(unit) = text(&dataset, "units") {
                        // Times may be written as `seconds since 2026-01-01`.
                        name.complete(unit.split(" since ").next().unwrap_or_default());
                    }
                    self.about.push(Array { name, rows: matrix.rows, columns: matrix.columns });
                    self.datasets.push((dataset, matrix));
                }
                Err(why) => self.left_out.push(format!("`{name}`, which {why}")),
            }
        }
        // MATLAB keeps the contents of cells in `#refs#`.
        for inner in groups.iter().filter(|inner| !inner.name().starts_with('#')) {
            self.group(inner, &format!("{path}{}/", inner.name()), depth + 1)?;
        }
        Ok(())
    }

    /// The matrix of a dataset, or why it is none.
    fn matrix(&self, dataset: &Dataset) -> Result<Matrix, &'static str> {
        let (name, order) = match *dataset.dtype() {
            Datatype::FloatingPoint { size, byte_order } => (format!("f{size}"), byte_order),
            Datatype::FixedPoint { size, signed: true, byte_order } => (format!("i{size}"), byte_order),
            Datatype::FixedPoint { size, signed: false, byte_order } => (format!("u{size}"), byte_order),
            _ => return Err("holds no real numbers"),
        };
        let number = Number::called(&name).ok_or("holds numbers of an unknown size")?;
        if !is_usual(dataset) {
            return Err("holds numbers of an unusual layout of bits");
        }
        if text(dataset, "MATLAB_class").is_some_and(|class| class == "char") {
            return Err("is a text");
        }
        let shape: Vec<usize> = dataset.shape().iter().map(|extent| *extent as usize).collect();
        let (rows, columns, by_columns) = match shape[..] {
            [rows] | [rows, 1] => (rows, 1, false),
            [1, rows] => (rows, 1, true),
            [first, second] if self.is_matlab => (second, first, true),
            [first, second] => (first, second, false),
            _ => return Err("has neither one dimension nor two"),
        };
        let big_endian = order == ByteOrder::BigEndian;
        let matrix = Matrix { number, big_endian, by_columns, rows, columns };
        match matrix.bytes() {
            Some(bytes) if bytes / DENSEST <= self.length => Ok(matrix),
            _ => Err("is larger than its file can hold"),
        }
    }
}

/// An attribute of a dataset, if it is a text.
fn text(dataset: &Dataset, attribute: &str) -> Option<String> {
    dataset.attribute(attribute).ok()?.read_string().ok()
}

fn bad(file: &str, why: &str) -> RecordError {
    let help = "save it again with a row for each sample, as in f[\"gyro\"] = a of h5py or save('log.mat', 'gyro', '-v7.3')";
    RecordError::new(format!("{file} cannot be taken as HDF5: {why}"), "", help, None)
}
