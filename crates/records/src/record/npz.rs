//! NumPy archives in .npz files: ZIP archives of .npy files, each with a checksum, which is verified.

use std::io::{self, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use crate::record::arrays::{Array, Arrays};
use crate::record::error::RecordError;
use crate::record::format::{Columns, Format, Seekable, Source};
use crate::record::matrix::Matrix;
use crate::record::names::Name;
use crate::record::npy;
use crate::record::recording::Rules;

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(b"PK\x03\x04"), open };

/// An archive of which the headers have been read.
struct Npz<'a> {
    file: String,
    archive: ZipArchive<Box<dyn Seekable + 'a>>,
    arrays: Arrays,
    /// The number of each array in the archive, with the place of its numbers.
    parts: Vec<(usize, Matrix, usize)>,
}

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let file = source.file.clone();
    let stored = source.length;
    let mut archive = ZipArchive::new(source.seekable()?).map_err(|error| bad(&file, &error))?;
    let (mut parts, mut about, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for at in 0..archive.len() {
        let mut entry = archive.by_index(at).map_err(|error| bad(&file, &error))?;
        let name = entry.name().map_err(|error| bad(&file, &error))?.into_owned();
        let Some(stem) = name.strip_suffix(".npy") else {
            left_out.push(name);
            continue;
        };
        let (length, mut head) = (entry.size(), Vec::new());
        let read = entry.by_ref().take(npy::MAX_HEADER as u64 + 12).read_to_end(&mut head);
        read.map_err(|error| npy::cut_off(&file, &error))?;
        match npy::read(&format!("{file}, {name}"), &head, Some(length)) {
            Ok((matrix, start)) => {
                about.push(Array { name: Name::read(stem), rows: matrix.rows, columns: matrix.columns });
                parts.push((at, matrix, start));
            }
            Err(error) => left_out.push(error.to_string()),
        }
    }
    let arrays = Arrays::of(&file, &about, &left_out, stored)?;
    Ok(Box::new(Npz { file, archive, arrays, parts }))
}

impl Columns for Npz<'_> {
    fn names(&self) -> &[Name] {
        &self.arrays.names
    }

    fn count(&self) -> usize {
        self.arrays.names.len()
    }

    fn read(&mut self, wanted: &[usize], rules: &Rules) -> Result<Vec<Vec<f64>>, RecordError> {
        let Npz { file, archive, arrays, parts } = self;
        arrays.read(wanted, rules, |array, within| {
            let (at, matrix, start) = &parts[array];
            let mut entry = archive.by_index(*at).map_err(|error| bad(file, &error))?;
            let read = |entry: &mut dyn Read| {
                io::copy(&mut entry.take(*start as u64), &mut io::sink())?;
                let columns = matrix.read(entry, within)?;
                // The checksum is compared at the end.
                io::copy(entry, &mut io::sink())?;
                Ok(columns)
            };
            read(&mut entry).map_err(|error| npy::cut_off(file, &error))
        })
    }
}

fn bad(file: &str, error: &ZipError) -> RecordError {
    let help = "save it as np.savez(\"log.npz\", time=t, gyro=a); a spreadsheet (.xlsx) must be saved as CSV";
    RecordError::new(format!("{file} cannot be taken as a .npz record: {error}"), "", help, None)
}
