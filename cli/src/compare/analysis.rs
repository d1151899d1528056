//! Two logs, from their files to what they say of each other.

use std::path::{Path, PathBuf};

use sagnac::allan::angles::Angles;
use sagnac::allan::unit::Unit;
use sagnac::analysis::compare::{Comparison, compare};
use sagnac::record::log::measure::Data;
use sagnac::record::log::outliers::Outliers;
use sagnac::record::log::read::Request;

use crate::allan::analysis::Treatment;
use crate::compare::options::Options;
use crate::compare::rows::{Row, rows};
use crate::failure::Failure;

/// Everything that is said of two logs.
pub struct Analysis {
    pub sides: [Side; 2],
    pub unit: Unit,
    /// Whether both are one record, so that nothing can differ.
    pub is_one_record: bool,
    pub comparison: Comparison,
    /// Coefficients in the units of data sheets, or why there are none.
    pub rows: Result<Vec<Row>, String>,
}

/// A log.
pub struct Side {
    pub path: PathBuf,
    pub column: String,
    /// What it is called beside the other one.
    pub label: String,
    pub data: Data,
    pub samples: usize,
    pub step_s: f64,
    pub missing: usize,
    pub outliers: Outliers,
    /// What the header says of the unit, where that is something else.
    pub overruled: Option<String>,
    unit: Unit,
    treatment: Treatment,
    angles: Angles,
}

impl Side {
    pub fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    fn of(path: &Path, request: &Request, options: &Options) -> Result<Side, Failure> {
        let log = options.reading.log(path, request)?;
        let channel = &log.channels[0];
        let (angles, outliers) = options.reading.angles(channel, log.data, log.step_s);
        Ok(Side {
            path: path.to_owned(),
            column: channel.name.clone(),
            label: String::new(),
            data: log.data,
            samples: log.samples(),
            step_s: log.step_s,
            missing: channel.missing(),
            outliers,
            overruled: channel.unit_in_header.clone().filter(|text| *text != channel.unit.text),
            unit: if channel.unit.is_angular { Unit::Angular } else { Unit::Plain },
            treatment: Treatment::of(&log, &options.reading),
            angles,
        })
    }
}

impl Analysis {
    /// Reads and compares the logs.
    ///
    /// # Errors
    /// A log that is refused, and logs that have nothing in common to compare.
    pub fn of(options: &Options) -> Result<Analysis, Failure> {
        let request = options.reading.request()?;
        let columns = options.reading.columns();
        if columns.len() > 2 {
            let message = "--column names more than two columns\ngive one of each log, as in --column gx,gy";
            return Err(Failure::Usage(message.to_owned()));
        }
        let side = |path: &Path, column: Option<&String>| {
            let request = Request { columns: column.cloned().into_iter().collect(), ..request.clone() };
            Side::of(path, &request, options)
        };
        let mut a = side(&options.a, columns.first())?;
        let mut b = side(&options.b, columns.last())?;
        if a.unit != b.unit {
            let (plain, angular) = if a.unit == Unit::Plain { (&a, &b) } else { (&b, &a) };
            return Err(Failure::Record(format!(
                "{} has plain numbers, {} has angular rates: they cannot be compared\n\
                 give the unit of both with --unit",
                plain.path.display(),
                angular.path.display()
            )));
        }
        [a.label, b.label] = labels(&a, &b);
        let terms = options.reading.terms();
        let comparison = compare(&a.angles, &b.angles, terms.as_ref())
            .map_err(|error| Failure::Record(error.to_string()))?;
        let rows = rows(&comparison, a.unit);
        Ok(Analysis { unit: a.unit, is_one_record: is_one_record(&a, &b), comparison, rows, sides: [a, b] })
    }

    /// What was done to both records.
    pub fn treatment(&self) -> &Treatment {
        &self.sides[0].treatment
    }

    /// The record that is shorter, s.
    pub fn shorter_s(&self) -> f64 {
        self.sides[0].length_s().min(self.sides[1].length_s())
    }
}

/// As short as tells them apart: the names of the files, with their columns, with their folders.
fn labels(a: &Side, b: &Side) -> [String; 2] {
    let stem = |side: &Side| side.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let with_column = |side: &Side| format!("{} {}", stem(side), side.column);
    let whole = |side: &Side| side.path.display().to_string();
    let names: [&dyn Fn(&Side) -> String; 3] = [&stem, &with_column, &whole];
    let both = names.iter().map(|name| [name(a), name(b)]).find(|[a, b]| a != b);
    both.unwrap_or_else(|| ["A", "B"].map(str::to_owned))
}

fn is_one_record(a: &Side, b: &Side) -> bool {
    let file = |side: &Side| side.path.canonicalize().ok();
    a.angles == b.angles || (a.column == b.column && file(a).is_some_and(|path| Some(path) == file(b)))
}
