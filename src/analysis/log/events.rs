//! Gaps and outliers of a log: `events.csv`.

use std::ops::Range;

use crate::analysis::log::tables::{key, text};
use crate::analysis::log::{Analysis, Column};
use crate::table::column::columns_of;
use crate::table::{Cell, ColumnOf, Role, Table, Unit};

/// A row of `events.csv`.
pub(crate) struct Event<'a> {
    column: &'a Column,
    what: &'static str,
    samples: Range<usize>,
    analysis: &'a Analysis,
}

/// The columns of `events.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Event<'a>>> {
    type Of<'a> = ColumnOf<Event<'a>>;
    vec![
        key(|event| text(&event.column.name)),
        Of::new("event", Unit::NONE, "event", |event| text(event.what))
            .is(Role::Key, "`gap` for missing samples, `outlier` for a sample that stands out from its neighbours."),
        Of::new("time", Unit::S, "time", |event| Cell::Number(event.analysis.time(event.samples.start)))
            .is(Role::Coordinate, "Time of the first of the samples from the start of the file, s."),
        Of::new("length", Unit::S, "length", |event| Cell::Number(event.samples.len() as f64 * event.analysis.step_s))
            .is(Role::Estimate, "Duration of the samples, s."),
        Of::new("samples", Unit::NONE, "samples", |event| Cell::Integer(event.samples.len() as i64))
            .is(Role::Count, "Number of samples."),
    ]
}

/// The gaps and outliers of all columns, column by column in the order of time.
pub fn table(analysis: &Analysis) -> Table {
    let of_column = |column| {
        let event = move |what, samples| Event { column, what, samples, analysis };
        let gaps = column.gaps.iter().map(move |gap| event("gap", gap.clone()));
        let outliers =
            column.outliers.samples.iter().map(move |&sample| event("outlier", sample..sample + 1));
        let mut events: Vec<Event> = gaps.chain(outliers).collect();
        events.sort_by_key(|event| event.samples.start);
        events
    };
    let rows: Vec<Event> = analysis.columns.iter().flat_map(of_column).collect();
    Table { columns: columns_of(&columns(), &rows) }
}
