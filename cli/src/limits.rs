//! Limits on the noise of logs and of the units of a batch, as options.

use sagnac::analysis::requirement::{Limit, LimitError, Limited, applies, check};
use sagnac::key::docs::note;
use sagnac::record::log::channel::Log;

use crate::failure::Failure;
use crate::reading::Reading;

/// Reads a limit on a log.
pub fn of_log(text: &str) -> Result<Limit, String> {
    Limit::parse(text, &Limited::OF_LOG).map_err(|error| error.to_string())
}

/// The value of a limit on what has these names, as in `residual=8 arcsec`; without a name, as before 0.3, it is on the
/// first.
///
/// # Errors
/// It is on something else.
pub fn on<'t>(text: &'t str, names: &[&str]) -> Result<&'t str, Failure> {
    match text.split_once('=') {
        None => {
            let named = format!("--limit {}={text}", names[0]);
            note!("{}", note(&format!("--limit {text}"), &named));
            Ok(text)
        }
        Some((name, value)) if names.contains(&name.trim()) => Ok(value.trim()),
        Some((name, _)) => {
            let message = format!("--limit: unknown limit `{}`\naccepted: {}", name.trim(), names.join(", "));
            Err(Failure::Usage(message))
        }
    }
}

/// Reads limits on the units of a batch.
///
/// # Errors
/// A text is no limit.
pub fn of_units(texts: &[String]) -> Result<Vec<Limit>, Failure> {
    texts.iter().map(|text| Limit::parse(text, Limited::OF_BATCH).map_err(failure)).collect()
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
