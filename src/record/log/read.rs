//! Reading a file into a [`Log`].

use std::path::Path;

use crate::quantity::units::Dimension;
use crate::record::error::RecordError;
use crate::record::log::MOST_SAMPLES;
use crate::record::log::channel::{Channel, Log};
use crate::record::log::measure::{Data, Unit, expected};
use crate::record::recording::{Origin, Recording, Rules};
use crate::record::time::grid;

/// Steps are within 10 % of whole multiples of the sampling step; longer ones are gaps.
const RULES: Rules = Rules {
    most: MOST_SAMPLES,
    missing: "leave the cell empty or write NaN where a sample is missing",
    jitter: 0.1,
    has_gaps: true,
    uneven: "steps within 10 % of whole multiples of the median are taken; resample the log, or give `rate = 100Hz` instead \
           of stamps if the stamps are only rounded or late",
};

/// The columns of a log to read, and their interpretation.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Column names or numbers from 1. If there are none, the file must have only one column besides the time.
    pub columns: Vec<String>,
    /// Spacing of the samples.
    pub timing: Timing,
    /// Quantity of the samples.
    pub data: Data,
    /// Unit; if absent, that in each column's header.
    pub unit: Option<Unit>,
}

/// The times of the samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Timing {
    /// A constant step, s.
    Step(f64),
    /// The times in a column.
    Stamps {
        /// Name of the column, or its number from 1.
        column: String,
        /// Unit of the times, such as `ms`; if absent, that in the header.
        unit: Option<String>,
    },
}

impl Log {
    /// Reads the columns of the log at `path` that `request` selects.
    ///
    /// Text may be CSV, TSV, separated by semicolons or in columns with blanks between, with or without a header, and
    /// with comments after `#`, `%` or `;`; a Stable32 .DAT is one such file. Empty cells and NaN are missing samples,
    /// and so are those skipped by a step of several sampling steps. The sampling step is the median step, and all
    /// steps must be within 10 % of whole multiples of it.
    ///
    /// # Errors
    /// The first fault found, with its place if the file has lines.
    ///
    /// # Example
    /// ```
    /// # use sagnac::record::log::{channel::Log, measure::Data, read::{Request, Timing}};
    /// # let folder = tempfile::tempdir()?;
    /// # let path = &folder.path().join("gyro.csv");
    /// std::fs::write(path, "time [ms],gz [deg/h]\n0,8.1\n10,8.3\n30,8.2\n")?;
    /// let timing = Timing::Stamps { column: "time".to_owned(), unit: None };
    /// let request = Request { columns: vec!["gz".to_owned()], timing, data: Data::Rate, unit: None };
    /// let log = Log::read(path, &request)?;
    /// assert_eq!((log.step_s, log.samples()), (0.01, 4));
    /// assert!(log.channels[0].samples[2].is_nan());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: &Path, request: &Request) -> Result<Log, RecordError> {
        let mut file = Recording::open(path.display().to_string(), Origin::Path(path))?;
        // The sampling step, s; or for time stamps their column and its unit, s.
        let (mut step_s, time) = match &request.timing {
            Timing::Step(step_s) => (*step_s, None),
            Timing::Stamps { column: word, unit } => {
                let column = file.find(word, None)?;
                let what = format!("the time column `{word}`");
                let help = "give its unit as in `time_unit = ms`; accepted: s, ms, us, ns, min, h";
                let unit_s = file.unit_size(column, unit.as_deref(), Dimension::Time, &what, help)?;
                (unit_s, Some(column))
            }
        };
        let wanted = wanted(&file, &request.columns, time)?;
        let channels = wanted.iter().map(|&column| channel(&file, column, request));
        let mut channels = channels.collect::<Result<Vec<_>, _>>()?;
        let all: Vec<usize> = time.into_iter().chain(wanted).collect();
        if (1..all.len()).any(|i| all[..i].contains(&all[i])) {
            let message = "a column is requested twice";
            return Err(file.refuse(None, message, "these are the columns", "name each column once"));
        }
        let mut columns = file.read(&all, &RULES)?;
        if let Some(time) = time {
            let stamps = columns.remove(0);
            let grid = grid(&stamps, step_s, &RULES)
                .map_err(|fault| file.refuse_row(fault.row, time, fault.words))?;
            columns = columns.into_iter().map(|values| grid.spread(values)).collect();
            step_s *= grid.step;
        }
        file.check_step(step_s, time)?;
        channels.iter_mut().zip(columns).for_each(|(channel, samples)| channel.samples = samples);
        Ok(Log { file: file.file, step_s, data: request.data, start_s: 0.0, channels })
    }
}

/// The columns of samples that `words` select, or the only one.
fn wanted(file: &Recording, words: &[String], time: Option<usize>) -> Result<Vec<usize>, RecordError> {
    if !words.is_empty() {
        return words.iter().map(|word| file.find(word, None)).collect();
    }
    let others: Vec<usize> = (0..file.columns()).filter(|column| Some(*column) != time).collect();
    match others[..] {
        [_] => Ok(others),
        [] => {
            let help = "add a column of samples, or give `rate = 100Hz` instead of a time column";
            Err(file.refuse(None, "there is no column besides the time", "the only one", help))
        }
        _ => {
            let message = format!("the file has {} columns: select some of them", file.columns());
            let help = format!("name one or several as in `column = 2,3`: {}", file.listed());
            Err(file.refuse(None, &message, "these are the columns", &help))
        }
    }
}

/// A channel for a column, without its samples.
fn channel(file: &Recording, column: usize, request: &Request) -> Result<Channel, RecordError> {
    let name = file.names().get(column);
    let unit_in_header = name.and_then(|name| name.unit.clone());
    let unit = match (&request.unit, &unit_in_header) {
        (Some(unit), _) => unit.clone(),
        (None, Some(text)) => Unit::parse(text, request.data)
            .map_err(|wrong| file.refuse(Some(column), &wrong.message, "no such unit", &wrong.help))?,
        (None, None) => {
            let what =
                name.map_or_else(|| format!("column {}", column + 1), |name| format!("`{}`", name.whole));
            let message = format!("the unit of {what} is missing");
            return Err(file.refuse(Some(column), &message, "no unit", &expected(request.data)));
        }
    };
    let shown = name.map(|name| name.bare.clone()).filter(|name| !name.is_empty());
    let name = shown.unwrap_or_else(|| (column + 1).to_string());
    Ok(Channel { name, unit, unit_in_header, samples: vec![], place: file.place(Some(column)) })
}
