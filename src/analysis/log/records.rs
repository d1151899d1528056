//! The records of logs, as `records.csv`.

use std::path::Path;

use crate::analysis::data_sheet::DataSheet;
use crate::analysis::log::report::text;
use crate::analysis::log::{Analysis, Column};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{Deviation, Unit as Curves};
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::outliers::Outliers;
use sagnac_records::spectrum::Density;

/// A record with its fit and its spectrum: a row of `records.csv`.
pub(crate) struct Record<'a> {
    /// The column of the log, or the label of the record.
    pub name: &'a str,
    pub path: &'a Path,
    pub data: Data,
    pub samples: usize,
    pub step_s: f64,
    pub missing: usize,
    pub outliers: &'a Outliers,
    pub unit: Curves,
    pub mean: Option<f64>,
    pub slope: Option<f64>,
    pub noise: Option<&'a DataSheet>,
    pub density: Option<&'a Density>,
}

impl<'a> Record<'a> {
    /// The record of a column of a log.
    pub(crate) fn new(log: &'a Analysis, column: &'a Column, name: &'a str) -> Record<'a> {
        Record {
            name,
            path: &log.path,
            data: log.data,
            samples: log.samples,
            step_s: log.step_s,
            missing: column.missing,
            outliers: &column.outliers,
            unit: column.unit,
            mean: column.mean_rate,
            slope: Some(column.slope),
            noise: column.noise(),
            density: None,
        }
    }
}

fn count(count: impl Into<Option<usize>>) -> Cell {
    count.into().map_or(Cell::Blank, |count| Cell::Integer(count as i64))
}

/// The columns of `records.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Record<'a>>> {
    type Of<'a> = ColumnOf<Record<'a>>;
    vec![
        Of::new("column", Unit::NONE, "column", |row| text(row.name))
            .is(Role::Key, "Column of the log, or the label of the record among several logs."),
        Of::new("file", Unit::NONE, "file", |row| text(&row.path.display().to_string()))
            .is(Role::Note, "The log."),
        Of::new("data", Unit::NONE, "data", |row| text(row.data.name()))
            .is(Role::Note, "What the samples are: `rate`, `increment` or `angle`."),
        Of::new("samples", Unit::NONE, "samples", |row| count(row.samples))
            .is(Role::Count, "Number of samples, including missing ones."),
        Of::new("step", Unit::S, "step", |row| Cell::Number(row.step_s))
            .is(Role::Estimate, "Time from sample to sample, s."),
        Of::new("missing", Unit::NONE, "missing", |row| count(row.missing))
            .is(Role::Count, "Number of samples that are missing in the file or removed."),
        Of::new("outliers", Unit::NONE, "outliers", |row| count(row.outliers.samples.len()))
            .is(Role::Count, "Number of samples that stand out from their neighbours."),
        Of::new("outlier_threshold", Unit::NONE, "outlier threshold", |row| row.outliers.threshold.into())
            .is(Role::Estimate, "Distance from the median of the neighbours beyond which a sample is an outlier, in ″/s or ″, or for accelerometers µg or µg·s."),
        Of::new("mean", Unit::NONE, "mean", |row| row.mean.into())
            .is(Role::Estimate, "Mean rate or acceleration in `unit`."),
        Of::new("removed_slope", Unit::NONE, "removed slope", |row| row.slope.into())
            .is(Role::Estimate, "Slope that was removed, in `unit` per s."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `mean`."),
        Of::new("chi_squared", Unit::NONE, "χ²", |row| row.noise.map(|noise| noise.fit.chi_squared).into())
            .is(Role::Estimate, "χ² of the residuals of the fit."),
        Of::new("degrees_of_freedom", Unit::NONE, "degrees of freedom", |row| count(row.noise.map(|noise| noise.fit.degrees_of_freedom)))
            .is(Role::Count, "Degrees of freedom of `chi_squared`."),
        Of::new("p", Unit::NONE, "p", |row| row.noise.and_then(|noise| noise.fit.p_value()).into())
            .is(Role::Estimate, "Probability of residuals at least as large if the model of the fit holds."),
        Of::new("simulated_records", Unit::NONE, "simulated records", |row| count(row.noise.map(|noise| noise.intervals.records)))
            .is(Role::Count, "Number of simulated records behind the intervals of the coefficients; 0 for intervals in closed form."),
        Of::new("segment", Unit::NONE, "segment", |row| count(row.density.map(|density| density.segment)))
            .is(Role::Count, "Samples of a segment of the power spectral density, which has a Hann window and overlaps half of the next one."),
        Of::new("segments", Unit::NONE, "segments", |row| count(row.density.map(|density| density.segments)))
            .is(Role::Count, "Number of segments that the density averages."),
    ]
}

/// Records with their fits and spectra: `records.csv`.
pub(crate) fn table<'a>(records: impl Iterator<Item = Record<'a>>) -> Table {
    Table { columns: columns_of(&columns(), &records.collect::<Vec<_>>()) }
}
