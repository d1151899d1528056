//! Output of a batch of units for people.

use sagnac::analysis::compare::words::probability;
use sagnac::analysis::log;
use sagnac::analysis::log::notes::heading;
use sagnac::analysis::lot::pool::Pooled;
use sagnac::analysis::lot::{Coefficient, Found, Lot};
use sagnac::quantity::number::significant;
use sagnac::table::titled;

use crate::terminal::headed_by;

/// The logs, the coefficients of all units and those of the batch.
pub fn report(lot: &Lot) -> String {
    let left_out = |log: &log::Analysis| format!("{}{}\n", heading(log), log.treatment.left_out());
    let logs: String = lot.logs.iter().map(left_out).collect();
    let shown: Vec<&Coefficient> = lot
        .coefficients
        .iter()
        .filter(|one| one.found.iter().flatten().any(|found| found.estimate().is_some()))
        .collect();
    format!("{logs}\n{}\n{}", units(lot, &shown), of_lot(&shown))
}

/// The coefficients of all units, a line for each unit.
fn units(lot: &Lot, shown: &[&Coefficient]) -> String {
    let titles = shown.iter().map(|one| titled(&one.title(), one.symbol));
    let heading: Vec<String> = std::iter::once("unit".to_owned()).chain(titles).collect();
    let line = |(unit, label): (usize, &String)| {
        let cells = shown.iter().map(|one| one.found[unit].as_ref().map_or_else(String::new, cell));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    format!(
        "coefficients of each unit with 95 % intervals; * outlier, < upper bound of a unit that does not show the coefficient\n{}",
        headed_by(heading, lot.labels.iter().enumerate().map(line))
    )
}

/// A value such as `0.3012 (0.297 … 0.305)`, an odd one with a star, or a bound.
fn cell(found: &Found) -> String {
    let mark = if found.odd.is_some() { "*" } else { "" };
    match (found.row.value, found.row.interval) {
        (Some(value), Some(ends)) => format!("{mark}{} ({})", significant(value, 4), range(ends, 3)),
        (Some(value), None) => format!("{mark}{}", significant(value, 4)),
        (None, Some([_, most])) => format!("< {}", significant(most, 3)),
        (None, None) => found.row.verdict.to_owned(),
    }
}

/// The values of the batch, a line for each coefficient.
fn of_lot(shown: &[&Coefficient]) -> String {
    let heading = [
        "",
        "units",
        "median",
        "95 % interval",
        "",
        "spread, %",
        "95 % interval",
        "next unit, 95 %",
        "equal units",
    ];
    let line = |(one, name, pooled): (&&Coefficient, String, Pooled)| {
        vec![
            name,
            format!("{} of {}", pooled.units, one.found.len()),
            significant(pooled.value, 4),
            range(pooled.interval, 4),
            one.symbol.to_owned(),
            significant(100.0 * pooled.spread, 3),
            range(pooled.spread_interval.map(|end| 100.0 * end), 3),
            range(pooled.next, 4),
            probability(pooled.p_equal),
        ]
    };
    let lines = shown.iter().flat_map(|one| {
        let all = one.pooled.map(|pooled| (one, one.title(), pooled));
        let without =
            one.without_odd.map(|pooled| (one, format!("{} without outliers", one.title()), pooled));
        all.into_iter().chain(without)
    });
    format!("the batch\n{}", headed_by(heading.map(str::to_owned).to_vec(), lines.map(line)))
}

fn range(ends: [f64; 2], digits: usize) -> String {
    let [low, high] = ends.map(|end| if end.is_finite() { significant(end, digits) } else { "∞".to_owned() });
    format!("{low} … {high}")
}
