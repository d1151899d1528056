//! The output of a design: its tables and charts, and all results as JSON.

pub(crate) mod json;
pub(crate) mod tables;
pub(crate) mod trade;
pub(crate) mod variants;

pub use crate::analysis::design::report::json::json;
pub(crate) use crate::analysis::design::report::tables::columns;
pub use crate::analysis::design::report::tables::{figure, table};
pub(crate) use crate::analysis::design::report::trade::by_choice;
pub(crate) use crate::analysis::design::report::trade::pareto_columns;
pub use crate::analysis::design::report::trade::{pareto_figure, pareto_table};
pub(crate) use crate::analysis::design::report::variants::by_variant;

pub(crate) use crate::analysis::design::report::variants::named;

use crate::analysis::design::report::variants::{cost_heads, costs};
use crate::analysis::design::{Design, Filler, Found};
use crate::quantity::number::significant;
use crate::view::report::sections::Grid;

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

fn three_digits(value: f64) -> String {
    significant(value, 3)
}

fn four_digits(value: f64) -> String {
    significant(value, 4)
}

/// The best interval of a filler with its uncertainty, in words.
fn range(filler: &Filler) -> String {
    match filler.optimum.interval {
        Some((lo, hi)) => format!("{} to {}", four_digits(lo), four_digits(hi)),
        None if filler.is_at_edge() => "at the end of the range".to_owned(),
        None => "too few candidates near it".to_owned(),
    }
}

/// The fillers to read, each at its best interval and at the best values of swept keys.
pub(crate) fn by_filler(found: &Design) -> Grid {
    let variant = found.variant();
    let (label, angle) = (found.measure.label(), format!("″ after {}", duration(variant.duration_s)));
    let heading =
        ["filler", "best interval, s", "95 % interval, s", "switches", label, &angle, "times the least"];
    let lines = variant.fillers.iter().map(|filler| {
        let best = filler.best();
        let line = [
            called(filler).to_owned(),
            four_digits(best.interval_s),
            range(filler),
            best.switches.to_string(),
            format!("{} °/h", three_digits(best.drift.value)),
            three_digits(variant.angle(best.drift.value)),
            three_digits(found.worse_by(filler).value),
        ];
        line.into_iter().chain(costs(found, filler)).collect::<Vec<_>>()
    });
    Grid::new(heading.map(str::to_owned).into_iter().chain(cost_heads(found)), lines)
}

/// The ends of the interval of a value.
pub(crate) fn ends(found: Found) -> [Option<f64>; 2] {
    found.interval.map_or([None; 2], |(low, high)| [Some(low), Some(high)])
}
