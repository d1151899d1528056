//! Limits on the noise of logs and of the units of a lot, as options.

use sagnac::analysis::requirement::{Limit, LimitError, Limited, applies, check};
use sagnac::record::log::channel::Log;

use crate::failure::Failure;
use crate::reading::Reading;

/// Reads a limit on a log.
pub fn of_log(text: &str) -> Result<Limit, String> {
    Limit::parse(text, &Limited::OF_LOG).map_err(|error| error.to_string())
}

/// Reads limits on the units of a batch.
///
/// # Errors
/// A text is no limit.
pub fn of_units(texts: &[String]) -> Result<Vec<Limit>, Failure> {
    texts.iter().map(|text| Limit::parse(text, Limited::OF_LOT).map_err(failure)).collect()
}

/// Checks that limits agree with each other and with the fit.
///
/// # Errors
/// Two limits are on the same, or a coefficient is not fitted.
pub fn agree(limits: &[Limit], reading: &Reading) -> Result<(), Failure> {
    let fitting = reading.fitting();
    check(limits, fitting.as_ref().map(|fitting| fitting.terms.all())).map_err(failure)
}

/// Checks that a log has a column for each limit.
///
/// # Errors
/// A limit has the unit of no column.
pub fn apply(limits: &[Limit], log: &Log) -> Result<(), Failure> {
    let units: Vec<_> = log.channels.iter().map(|channel| channel.unit.curves).collect();
    applies(limits, &units).map_err(failure)
}

fn failure(error: LimitError) -> Failure {
    Failure::Usage(format!("--limit: {error}"))
}
