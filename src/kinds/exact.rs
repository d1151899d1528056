//! Studies whose every value is a closed form: points become a table at once.

use crate::key::setting::Swept;
use crate::kinds::drift_budget::DriftBudget;
use crate::kinds::suspension::SuspensionStudy;
use crate::run::swept_columns;
use crate::study::Study;
use crate::table::{Cell, Column, Table};

/// The table of a study of the drift budget, a row for each point.
pub(crate) fn of_budget(study: &Study, budget: &DriftBudget) -> Table {
    let rows =
        budget.points.iter().map(|point| (&point.swept[..], crate::kinds::drift_budget::table::row(point)));
    table(study, crate::kinds::drift_budget::table::columns(), rows)
}

/// The table of a study of a suspension, a row for each point.
pub(crate) fn of_suspension(study: &Study, suspension: &SuspensionStudy) -> Table {
    let rows =
        suspension.points.iter().map(|point| (&point.swept[..], crate::kinds::suspension::table::row(point)));
    table(study, crate::kinds::suspension::table::columns(), rows)
}

type Row<'p> = (&'p [(&'static str, Swept)], Vec<Cell>);

fn table<'p>(study: &Study, columns: Vec<Column>, rows: impl Iterator<Item = Row<'p>>) -> Table {
    let mut all = swept_columns(study);
    all.extend(columns);
    for (swept, cells) in rows {
        let cells = swept.iter().map(|(_, value)| value.cell()).chain(cells);
        all.iter_mut().zip(cells).for_each(|(column, cell)| column.cells.push(cell));
    }
    Table { columns: all }
}
