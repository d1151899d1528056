//! The columns that curves show: one, or a list.

use crate::chart::Named;
use crate::chart::file::ChartTable;
use crate::chart::law::Law;
use crate::key::file::either::Either;
use crate::key::scalar::Scalar;
use crate::source::diagnose::Fault;

/// Most columns that are shown at once.
const MOST_COLUMNS: usize = 8;

/// The column y, and those beside it where it is a list.
pub(crate) fn read(table: &ChartTable) -> Result<(Named, Vec<Named>), Fault> {
    const ACCEPTED: &str =
        "accepted: the name of a column, or a list of names as in [\"bound\", \"mean_drift\"]";
    let span = table.y.span();
    match table.y.get_ref() {
        Either::One(Scalar::Text(name)) => Ok((Named { name: name.clone(), span }, vec![])),
        Either::One(other) => {
            Err(Fault::new(span, format!("chart.y: {other} names no column"), other.kind(), ACCEPTED))
        }
        Either::Other(names) if (2..=MOST_COLUMNS).contains(&names.len()) => {
            let mut names = names.iter().map(|name| Named::from(name.clone()));
            let y = names.next().unwrap_or(Named::default(""));
            Ok((y, names.collect()))
        }
        Either::Other(names) => {
            let message = format!("chart.y lists {} columns", names.len());
            let label = if names.len() < 2 { "too few for a list" } else { "too many columns" };
            Err(Fault::new(span, message, label, format!("{ACCEPTED}, 2 to {MOST_COLUMNS}")))
        }
    }
}

/// Refuses what has no place beside several columns y: more than one further column of series, and laws.
pub(crate) fn check_beside(table: &ChartTable, laws: &[Law]) -> Result<(), Fault> {
    if let Some(series) = table.series.as_ref().filter(|series| series.get_ref().len() > 1) {
        let message = "series names two columns beside several columns y";
        let help = "name one column, for the dash: the columns y have the colours";
        return Err(Fault::new(series.span(), message, "one too many", help));
    }
    match table.laws.as_ref().filter(|_| !laws.is_empty()) {
        Some(written) => {
            let message = "chart.laws stand beside several columns y";
            let help = "leave them out, or name one column y";
            Err(Fault::new(written.span(), message, "of one column", help))
        }
        None => Ok(()),
    }
}
