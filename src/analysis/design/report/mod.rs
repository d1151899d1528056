//! The output of a design: its tables and charts.

pub(crate) mod tables;
pub(crate) mod trade;
pub(crate) mod variants;

pub(crate) use crate::analysis::design::report::tables::columns;
pub use crate::analysis::design::report::tables::{figure, table};
pub(crate) use crate::analysis::design::report::trade::{filler_columns, pareto_columns};
pub use crate::analysis::design::report::trade::{filler_table, pareto_figure, pareto_table};

pub(crate) use crate::analysis::design::report::variants::named;

use crate::analysis::design::{Filler, Found};
use sagnac_base::quantity::number::significant;

/// Name of the filler in tables.
pub fn called(filler: &Filler) -> &str {
    filler.name.as_deref().unwrap_or("as given")
}

/// A time in the largest unit of which it has at least one.
pub fn duration(time_s: f64) -> String {
    let (unit, size) = match time_s {
        ..60.0 => ("s", 1.0),
        ..3600.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    };
    format!("{} {unit}", four_digits(time_s / size))
}

fn four_digits(value: f64) -> String {
    significant(value, 4)
}

/// The ends of the interval of a value.
pub(crate) fn ends(found: Found) -> [Option<f64>; 2] {
    found.interval.map_or([None; 2], |(low, high)| [Some(low), Some(high)])
}
