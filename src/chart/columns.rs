//! The columns shown by curves: a single one, or a list.

use crate::chart::Named;
use crate::chart::file::{LAWS, SERIES};
use crate::chart::law::Law;
use crate::key::given::Given;
use crate::key::table::Table;
use crate::source::diagnose::Fault;

/// Most columns shown at once.
const MOST_COLUMNS: usize = 8;

/// Reads the column y, and the further columns where y is a list.
pub(crate) fn read(y: Given) -> Result<(Named, Vec<Named>), Fault> {
    if !y.is_list() {
        return Ok((Named::from(y), vec![]));
    }
    let mut names = y.items().into_iter().map(Named::from);
    let count = names.len();
    if let (Some(first), 2..=MOST_COLUMNS) = (names.next(), count) {
        return Ok((first, names.collect()));
    }
    let label = if count < 2 { "too few for a list" } else { "too many columns" };
    let help = format!(
        "accepted: the name of a column, or a list of names as in [\"bound\", \"mean_drift\"], 2 to {MOST_COLUMNS}"
    );
    Err(y.fault(format!("chart.y lists {count} columns"), label, help))
}

/// Refuses what cannot be combined with several columns y: more than one further column of series, and laws.
pub(crate) fn check_beside(table: &Table, laws: &[Law]) -> Result<(), Fault> {
    if let Some(series) = table.get(&SERIES).filter(|series| series.items().len() > 1) {
        let message = "series names two columns, but y lists several";
        let help = "name one column, for the dash: the columns y have the colours";
        return Err(series.fault(message, "one too many", help));
    }
    match table.get(&LAWS).filter(|_| !laws.is_empty()) {
        Some(written) => {
            let message = "chart.laws conflict with several columns y";
            Err(written.fault(message, "of one column", "leave them out, or name one column y"))
        }
        None => Ok(()),
    }
}
