//! Recorded logs, read as the program reads them.

use std::borrow::Cow;
use std::path::PathBuf;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sagnac::analysis::log::Treatment;
use sagnac::analysis::temperature::{Effects, Temperature};
use sagnac::record::binary::Binary;
use sagnac::record::layout::Decimal;
use sagnac::record::log::measure::{Data, Unit, UnitCheck};
use sagnac::record::log::read::{Duplicates, Hints, Request, Timing};
use sagnac::record::log::{Channel, Log as Read, Thermometer};
use sagnac::use_cases::LogError;

use super::argument::word;
use super::compute::{compute_on, read_on};
use super::failure::{Failure, in_python};
use super::record::{Reading, side_by_side};

/// A log in memory.
#[pyclass(frozen, module = "sagnac._sagnac")]
pub struct Log {
    pub read: Read,
}

/// Samples: a log, or an array.
#[derive(FromPyObject)]
pub enum Given<'py> {
    Log(Bound<'py, Log>),
    Array(PyReadonlyArray1<'py, f64>),
}

impl Given<'_> {
    /// The samples as a log, of an array called `name`.
    ///
    /// # Errors
    /// The samples of an array are unusable, or an argument is not accepted.
    pub fn log(&self, py: Python, reading: &Reading, name: &str) -> PyResult<Cow<'_, Read>> {
        match self {
            Given::Log(log) => Ok(Cow::Borrowed(&log.get().read)),
            Given::Array(data) => {
                let values = side_by_side(data)?;
                read_on(py, reading.threads, || Ok(Cow::Owned(reading.log(values, name)?)))
            }
        }
    }
}

/// How a log is to be read.
#[derive(FromPyObject)]
pub struct Wanted {
    columns: Vec<String>,
    kind: Option<String>,
    units: Vec<String>,
    step_s: Option<f64>,
    time: Option<String>,
    time_unit: Option<String>,
    duplicates: Option<String>,
    decimal: Option<String>,
    binary: Option<String>,
    temperature: Option<String>,
    temperature_unit: Option<String>,
    skip_s: f64,
    until_s: Option<f64>,
    unit_check: bool,
    threads: usize,
}

/// Whether doubtful units are noted.
pub fn check_of(is_on: bool) -> UnitCheck {
    if is_on { UnitCheck::On } else { UnitCheck::Off }
}

/// What the samples are, by its name.
///
/// # Errors
/// The name is unknown.
pub fn kind_of(name: &str) -> Result<Data, Failure> {
    word("kind", name, &Data::ALL.map(|data| (data.name(), data)))
}

/// The unit of samples, or the size of a pulse.
///
/// # Errors
/// It is none of such samples.
pub fn unit_of(text: &str, data: Data) -> Result<Unit, Failure> {
    Unit::of_header(text, data)
        .map_err(|wrong| Failure::Usage(in_python(&format!("{}\n{}", wrong.message, wrong.help))))
}

impl Wanted {
    fn request(&self) -> Result<Request, Failure> {
        let kind = self.kind.as_deref().map(kind_of).transpose()?;
        let data = kind.unwrap_or(Data::Rate);
        let units = self.units.iter().map(|unit| unit_of(unit, data)).collect::<Result<Vec<_>, _>>()?;
        let usage = |message: &str| Failure::Usage(in_python(message));
        let timing = Timing::new(self.step_s, self.time.clone(), self.time_unit.clone())
            .map_err(|message| usage(&message))?;
        let duplicates =
            [("first", Duplicates::First), ("last", Duplicates::Last), ("keep", Duplicates::Keep)];
        let decimals = [("point", Decimal::Point), ("comma", Decimal::Comma)];
        let hints = Hints {
            duplicates: self
                .duplicates
                .as_ref()
                .map(|text| word("duplicates", text, &duplicates))
                .transpose()?,
            decimal: self.decimal.as_ref().map(|text| word("decimal", text, &decimals)).transpose()?,
            binary: self
                .binary
                .as_ref()
                .map(|text| Binary::parse(text))
                .transpose()
                .map_err(|why| usage(&why.to_string()))?,
        };
        let unit = self.temperature_unit.clone();
        Ok(Request {
            columns: self.columns.clone(),
            timing,
            // A unit that is given is that of a rate unless the kind is given too.
            data: kind.or((!units.is_empty()).then_some(data)),
            units,
            temperature: self.temperature.clone().map(|column| Thermometer { column, unit }),
            hints,
        })
    }

    fn treatment(&self) -> Treatment {
        Treatment {
            skip_s: self.skip_s,
            until_s: self.until_s,
            unit_check: check_of(self.unit_check),
            ..Treatment::AS_RECORDED
        }
    }
}

/// Reads the log in a file.
#[pyfunction]
pub fn read_log(py: Python, path: PathBuf, wanted: Wanted) -> PyResult<Log> {
    compute_on(py, wanted.threads, || {
        let read = wanted.treatment().read(&path, &wanted.request()?)?;
        Ok(Log { read })
    })
}

impl Log {
    fn channel(&self, column: usize) -> PyResult<&Channel> {
        Ok(self.read.channels.get(column).ok_or_else(|| no_column(column))?)
    }
}

fn no_column(column: usize) -> Failure {
    Failure::Usage(format!("the log has no column at place {column}"))
}

#[pymethods]
impl Log {
    #[getter]
    fn kind(&self) -> &'static str {
        self.read.data.name()
    }

    #[getter]
    fn step_s(&self) -> f64 {
        self.read.step_s
    }

    #[getter]
    fn start_s(&self) -> f64 {
        self.read.start_s
    }

    #[getter]
    fn samples(&self) -> usize {
        self.read.samples()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.read.notes.iter().map(|note| in_python(note)).collect()
    }

    /// Name and unit of each column.
    #[getter]
    fn columns(&self) -> Vec<(&str, &str)> {
        let channels = self.read.channels.iter();
        channels.map(|channel| (channel.name.as_str(), channel.unit.text.as_str())).collect()
    }

    #[getter]
    fn is_compensated(&self) -> bool {
        self.read.is_compensated
    }

    /// The temperature with the name of its column.
    fn temperature<'py>(&self, py: Python<'py>) -> Option<(&str, Bound<'py, PyArray1<f64>>)> {
        let (name, celsius) = self.read.temperature.as_ref()?;
        Some((name, PyArray1::from_slice(py, celsius)))
    }

    fn values<'py>(&self, py: Python<'py>, column: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_slice(py, &self.channel(column)?.samples))
    }

    /// Start and end of each stretch of missing samples.
    fn gaps(&self, column: usize) -> PyResult<Vec<(usize, usize)>> {
        let samples = self.channel(column)?.view(self.read.data, self.read.step_s);
        Ok(samples.gaps().into_iter().map(|gap| (gap.start, gap.end)).collect())
    }

    /// The log with one column alone.
    fn only(&self, column: usize) -> PyResult<Log> {
        let read = self.read.only(column).ok_or_else(|| no_column(column))?;
        Ok(Log { read })
    }

    /// The log without its dependence on temperature.
    fn compensated(&self, py: Python, effects: &str, reading: Reading) -> PyResult<Log> {
        compute_on(py, reading.threads, || {
            let mut read = self.read.clone();
            let found = Temperature::noted(&mut read, &reading.treatment(), &effects_of(effects)?);
            Ok(Log { read: found.ok_or(LogError::NoTemperature)?.compensated(&read) })
        })
    }
}

/// The terms of a dependence on temperature.
///
/// # Errors
/// One of them is unknown.
pub fn effects_of(names: &str) -> Result<Effects, Failure> {
    Effects::parse(names).map_err(|why| Failure::Usage(format!("temperature_terms: {why}")))
}
