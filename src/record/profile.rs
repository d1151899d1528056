//! A recorded motion: the columns `time` and `rate` of a file, every one of their numbers finite and the times even.

use crate::quantity::units::{Dimension, round_12};
use crate::record::Record;
use crate::record::error::RecordError;
use crate::record::recording::Recording;
use crate::record::time::{Spacing, grid};

/// How the columns are named.
const NAMES: &str = "name one column `time` and one `rate`, with their units, as in\ntime [s], rate [deg/s]";

/// Steps that are taken as equal: a record of a motion has no gaps.
const EVEN: Spacing = Spacing {
    jitter: 0.01,
    has_gaps: false,
    help: "resample it evenly first: every step has to be within 1 % of the median step",
};

/// Reads a record of at most `most` samples.
pub(crate) fn read(mut file: Recording, most: usize) -> Result<Record, RecordError> {
    if file.names().is_empty() {
        return Err(file.refuse(None, "the header is missing", "numbers and no names", NAMES));
    }
    let (time, time_size) = column(&file, "time", Dimension::Time, "time [s]")?;
    let (rate, rate_size) = column(&file, "rate", Dimension::Rate, "rate [deg/s]")?;
    let columns = file.read(&[time, rate], most)?;
    let times = finite(&file, time, "time", &columns[0], time_size)?;
    let rates = finite(&file, rate, "rate", &columns[1], rate_size)?;
    if rates.len() < 2 {
        let message = format!("a record needs at least 2 samples, this one has {}", rates.len());
        let help = "the step is the time from one sample to the next: add rows";
        return Err(file.refuse(None, &message, "its columns", help));
    }
    let grid = grid(&times, most, &EVEN)
        .map_err(|fault| file.refuse_row(fault.row(), time, fault.words(&columns[0], 1.0, &EVEN)))?;
    let step_s = round_12(grid.step);
    file.check_step(step_s, Some(time))?;
    Ok(Record { step_s, rates })
}

/// The column of this name, and the size of its unit.
fn column(
    file: &Recording,
    name: &str,
    dimension: Dimension,
    example: &str,
) -> Result<(usize, f64), RecordError> {
    let column = file.find(name, Some(dimension)).map_err(|error| error.with_help(NAMES))?;
    let help = format!("accepted: {} in {}, for example `{example}`", dimension.name(), dimension.units());
    Ok((column, file.unit_size(column, None, dimension, &format!("the column `{name}`"), &help)?))
}

/// The numbers of a column in base units.
fn finite(
    file: &Recording,
    column: usize,
    name: &str,
    numbers: &[f64],
    size: f64,
) -> Result<Vec<f64>, RecordError> {
    let values: Vec<f64> = numbers.iter().map(|number| number * size).collect();
    let Some(row) = values.iter().position(|value| !value.is_finite()) else { return Ok(values) };
    let wrong = if numbers[row].is_nan() { "missing" } else { "too large" };
    let help = "every row needs a finite number here: put it in, or cut the record and resample what is left";
    Err(file.refuse_row(row, column, [format!("the {name} is {wrong}"), wrong.to_owned(), help.to_owned()]))
}
