//! The answer of a study in a sentence.

use super::agreement::capitalised;
use crate::chart::{Cells, Map};
use crate::table::{Cell, Column, ColumnError, Table, significant};
use crate::verdict::{Answer as Judged, Outcome};

/// The answer: a sentence, and what stands behind it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Answer {
    /// One sentence.
    pub headline: String,
    /// What is judged of each curve, under a heading for each chart.
    pub verdicts: Vec<(String, Vec<String>)>,
}

/// The rows with the least value of an estimate, as a sentence: `The least rms error is 2.1 ″ (95 %: 2 to 2.2): quadratic, frequency 4 Hz.`
///
/// `filter` chooses rows as [`Table::rows_where`] does, `by` are the columns that tell them apart. None where no row has a value. Rows
/// with the same value to the four digits that are said are counted.
///
/// # Errors
/// A name selects no single column, or the filter leaves no row.
pub fn least(
    table: &Table,
    estimate: &str,
    filter: &[(String, String)],
    by: &[&str],
) -> Result<Option<String>, ColumnError> {
    let column = table.column(estimate)?;
    let by = by.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let rows = table.rows_where(filter)?;
    let known: Vec<(usize, f64)> =
        rows.iter().filter_map(|&row| Some((row, column.cells[row].number()?))).collect();
    let Some(&(row, value)) = known.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    let shown = |value: f64| significant(value, 4);
    let unit = with_unit(column);
    let band = column.band.as_ref().and_then(|band| band[row]);
    let band =
        band.map_or(String::new(), |(low, high)| format!(" (95 %: {} to {})", shown(low), shown(high)));
    let places: Vec<String> = by
        .iter()
        .filter(|column| rows.iter().any(|&other| column.cells[other] != column.cells[row]))
        .filter_map(|column| named(column, &column.cells[row]))
        .collect();
    let alike = known.iter().filter(|(_, other)| shown(*other) == shown(value)).count();
    let sentence = match (known.len(), alike) {
        (1, _) => format!("The {} is {}{unit}{band}", column.label, shown(value)),
        (all, alike) if alike == all => {
            format!("The {} is {}{unit} in all {all} rows", column.label, shown(value))
        }
        (_, 1) => {
            format!("The least {} is {}{unit}{band}: {}", column.label, shown(value), places.join(", "))
        }
        (_, alike) => format!(
            "The least {} is {}{unit}{band}, in {alike} rows: {}, …",
            column.label,
            shown(value),
            places.join(", ")
        ),
    };
    Ok(Some(format!("{sentence}.")))
}

fn with_unit(column: &Column) -> String {
    if column.unit.symbol.is_empty() { String::new() } else { format!(" {}", column.unit.symbol) }
}

/// A value as a sentence has it; none of a blank.
fn named(column: &Column, cell: &Cell) -> Option<String> {
    match cell {
        Cell::Blank => None,
        Cell::Text(text) => Some(text.clone()),
        cell => cell.number().map(|x| column.valued(&significant(x, 4))),
    }
}

/// What a map shows, as a sentence: of a winner map who wins how many cells, of a heat map its least and greatest value.
pub fn of_map(map: &Map) -> Option<String> {
    let within = map.within_limit().zip(map.limit.as_ref()).map(|(within, limit)| {
        let share = percent(within, map.known());
        match &map.cells {
            Cells::Values(_) => format!("{share} of cells are within the {}", limit.label),
            Cells::Winners { .. } => format!("in {share} of cells the least is within the {}", limit.label),
        }
    });
    let found = match &map.cells {
        Cells::Values(values) => {
            let value = |(cell, value): (usize, &Option<f64>)| Some((cell, (*value)?));
            let known = || values.iter().enumerate().filter_map(value);
            let end = |(cell, value): (usize, f64)| {
                let (x, y) = (map.columns[cell % map.columns.len()], map.rows[cell / map.columns.len()]);
                let place = [(&map.x, x), (&map.y, y)].map(|(axis, at)| {
                    let equals = if axis.unit.is_empty() { " =" } else { "" };
                    format!("{}{equals} {} {}", axis.label, significant(at, 4), axis.unit)
                        .trim_end()
                        .to_owned()
                });
                let value = format!("{} {}", significant(value, 4), map.z.unit);
                format!("{} at {}", value.trim_end(), place.join(", "))
            };
            let low = known().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let high = known().max_by(|a, b| a.1.total_cmp(&b.1))?;
            format!("The {} runs from {} to {}", map.z.label, end(low), end(high))
        }
        Cells::Winners { of, won, .. } => {
            let cells = |style: usize| won.iter().flatten().filter(|won| won.style == style).count();
            let mut shares: Vec<(usize, &str)> =
                of.entries.iter().map(|entry| (cells(entry.style), entry.name.as_str())).collect();
            shares.retain(|(cells, _)| *cells > 0);
            shares.sort_by_key(|(cells, _)| std::cmp::Reverse(*cells));
            let known = map.known();
            let share =
                |(cells, name): &(usize, &str)| format!("{name} in {} of cells", percent(*cells, known));
            if shares.is_empty() {
                return None;
            }
            let all: Vec<String> = shares.iter().map(share).collect();
            format!("The least {} has {}", map.z.label, all.join(", "))
        }
    };
    Some(std::iter::once(found).chain(within).collect::<Vec<String>>().join("; ") + ".")
}

/// A part in percent, never rounded to all or none.
fn percent(part: usize, all: usize) -> String {
    match 100.0 * part as f64 / all.max(1) as f64 {
        _ if part == all => "all".to_owned(),
        0.0 => "none".to_owned(),
        p if p < 1.0 => "less than 1 %".to_owned(),
        p if p > 99.0 => "more than 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// Which curve keeps within its limit best, and which worst, as a sentence; none without curves.
///
/// Curves that rise above the limit are judged by how far they stay within it, those that come below it by how early.
pub fn of_verdict(answers: &[Judged], limit: &str) -> Option<String> {
    let falls = |outcome| matches!(outcome, Outcome::WithinFrom | Outcome::WithinBetween);
    let sign = if answers.iter().any(|answer| falls(answer.outcome)) { -1.0 } else { 1.0 };
    // How good: never within the limit is worst, always is best.
    let merit = |answer: &Judged| {
        let at = answer.at.first().map_or(0.0, |at| at.1);
        match answer.outcome {
            Outcome::AboveFrom => (0, 0.0),
            Outcome::WithinUpTo => (2, sign * at),
            _ => (1, sign * at),
        }
    };
    let order = |a: &&Judged, b: &&Judged| {
        let ((a, x), (b, y)) = (merit(a), merit(b));
        a.cmp(&b).then(x.total_cmp(&y))
    };
    let (best, worst) = (answers.iter().max_by(order)?, answers.iter().min_by(order)?);
    let always = answers.iter().filter(|answer| answer.outcome == Outcome::WithinUpTo).count();
    let never = answers.iter().filter(|answer| answer.outcome == Outcome::AboveFrom).count();
    Some(match answers.len() {
        1 => capitalised(&best.sentence(limit)) + ".",
        all if always == all => format!("All {all} curves stay within {limit}."),
        all if never == all => format!("None of the {all} curves is within {limit} at its first point."),
        _ => format!("Best is {}. Worst is {}.", best.sentence(limit), worst.sentence(limit)),
    })
}
