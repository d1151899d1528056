//! The best intervals of a drift budget, in words.

use sagnac::drift::schedule::INTERVAL;
use sagnac::study::Study;
use sagnac::table::{Column, ColumnError, Role, Table};

/// Most budgets with their own line.
const MOST_LINES: usize = 6;

/// A line for each budget with the interval of its least errors and their values; empty if there are too many budgets.
///
/// # Errors
/// The table lacks a swept key.
pub fn optima(study: &Study, table: &Table) -> Result<String, ColumnError> {
    let others = study.sweeps.iter().filter(|sweep| sweep.key.name != INTERVAL.name);
    let others = others.map(|sweep| table.column(sweep.key.name)).collect::<Result<Vec<_>, _>>()?;
    let least = table.columns.iter().filter(|column| column.role == Role::Least);
    let least: Vec<_> = least.filter_map(|column| Some((column, table.referred(column)?))).collect();
    let mut lines: Vec<String> = Vec::new();
    for row in 0..table.rows() {
        let value = |column: &Column| column.cells[row].rounded(4);
        let at: String = others.iter().map(|column| format!(", {}", column.valued(&value(column)))).collect();
        let best = |(least, interval): &(&Column, &Column)| {
            let known = interval.cells[row].number().is_some() && least.cells[row].number().is_some();
            let what = least.label.split_once(": ").map_or(least.label.as_str(), |(_, what)| what);
            let (interval, unit) = (value(interval), least.unit.symbol);
            known.then(|| format!("{what} at {interval} s, {} {unit}", value(least)))
        };
        let found: Vec<String> = least.iter().filter_map(best).collect();
        let line = format!("best interval{at}: {}\n", found.join("; "));
        if !found.is_empty() && !lines.contains(&line) {
            lines.push(line);
        }
        if lines.len() > MOST_LINES {
            return Ok(String::new());
        }
    }
    Ok(lines.concat())
}
