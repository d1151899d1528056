//! The best intervals of a drift budget, in words.

use sagnac::quantity::number::significant;
use sagnac::study::Study;
use sagnac::table::{Column, ColumnError, Table};

/// Most budgets that have a line each.
const MOST_LINES: usize = 6;

/// A line for each budget: which interval has the least bound, and which the least rms drift, with what is left there. Of more
/// budgets the table has to do.
///
/// # Errors
/// The table is not that of a drift budget.
pub fn optima(study: &Study, table: &Table) -> Result<String, ColumnError> {
    let others = study.sweeps.iter().filter(|sweep| sweep.key.name != "switching.interval");
    let others = others.map(|sweep| table.column(sweep.key.name)).collect::<Result<Vec<_>, _>>()?;
    let bound = [table.column("optimum")?, table.column("optimum_bound")?];
    let truly = [table.column("optimum_true")?, table.column("optimum_true_rms")?];
    let mut lines: Vec<String> = Vec::new();
    for row in 0..table.rows() {
        let value = |column: &Column| {
            let cell = &column.cells[row];
            cell.number().map_or_else(|| cell.text(), |x| significant(x, 4))
        };
        let at: String = others.iter().map(|column| format!(", {}", column.valued(&value(column)))).collect();
        let best = |what: &str, [interval, least]: [&Column; 2]| {
            let known = interval.cells[row].number().is_some() && least.cells[row].number().is_some();
            known.then(|| format!("{what} at {} s, {} ″/s", value(interval), value(least)))
        };
        let found = [best("least bound", bound), best("least rms drift left by switching", truly)];
        let found: Vec<String> = found.into_iter().flatten().collect();
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
