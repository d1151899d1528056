//! Notes attached to results.

use crate::quantity::number::short;
use crate::run::{Plan, Tables};
use crate::store::Store;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::study::Study;
use crate::table::{Cell, Role, Table};

/// The notes on results, each a sentence, except those on charts: missing or degraded work, the notes of the plan, and
/// different numbers of trials.
///
/// `index` is that of the store, `held` the result of [`Plan::held`], `lacking` the number of missing trials, and
/// `degraded` the deviations of a run from the requested execution.
/// asked.
///
/// # Errors
/// A row of the store is damaged, or the disk fails.
pub fn notes(
    study: &Study,
    plan: &Plan,
    (store, index): (&Store, &Index),
    tables: &Tables,
    (held, lacking): (u64, u64),
    degraded: &[String],
) -> Result<Vec<String>, StoreError> {
    let incomplete =
        (lacking > 0).then(|| format!("the run is incomplete: {} trials are missing", short(lacking as f64)));
    let uneven = if study.precision.is_some() { None } else { uneven(&tables.points) };
    let degraded = degraded.iter().cloned();
    Ok(incomplete.into_iter().chain(degraded).chain(plan.notes(store, index, held)?).chain(uneven).collect())
}

/// A note that rows have different numbers of trials.
fn uneven(table: &Table) -> Option<String> {
    let column = table.of_role(Role::Trials)?;
    let trials = || column.cells.iter().filter_map(Cell::number);
    let (least, most) = (trials().reduce(f64::min)?, trials().reduce(f64::max)?);
    (least < most).then(|| format!("rows are from {} to {} trials", short(least), short(most)))
}
