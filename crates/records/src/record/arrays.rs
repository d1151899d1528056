//! Files that hold several named arrays, whose columns are taken for the columns of a log.

use crate::record::error::{RecordError, told};
use crate::record::format::check_unpacked;
use crate::record::names::Name;
use crate::record::recording::Rules;

/// Most columns. An array without rows may claim any number of them.
pub(crate) const MAX_COLUMNS: usize = 1 << 20;

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
    pub(crate) fn of(
        file: &str,
        arrays: &[Array],
        left_out: &[String],
        stored: Option<u64>,
    ) -> Result<Arrays, RecordError> {
        let (mut names, mut places) = (Vec::new(), Vec::new());
        for (at, array) in arrays.iter().enumerate().filter(|(_, array)| array.rows > 1) {
            if names.len().saturating_add(array.columns) > MAX_COLUMNS {
                let message = format!("{file} has more than {MAX_COLUMNS} columns");
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
            let help =
                "save the samples as arrays of numbers with a row for each sample, not in cells or tables";
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
