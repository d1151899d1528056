//! Sentences that answer: where something is least, who wins, who stays within a limit.

use super::agreement::capitalised;
use crate::chart::{Cells, Map};
use crate::table::{Cell, Column, ColumnError, Table, significant};
use crate::verdict::{Answer as Judged, Outcome};

/// The rows that answer about an estimate, as a sentence: where it is least, `The least rms error is 2.1 ″ (95 %: 2 to 2.2): quadratic,
/// frequency 4 Hz.`, or of one that is not the better the less it is, from where to where it runs.
///
/// `filter` chooses rows as [`Table::rows_where`] does, `by` are the columns that tell them apart. None where no row has a value. Rows
/// with the same value to the four digits that are said are counted.
///
/// # Errors
/// A name selects no single column, or the filter leaves no row.
pub(super) fn best(
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
    let order = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
    let Some((least, most)) = known.iter().min_by(order).zip(known.iter().max_by(order)) else {
        return Ok(None);
    };
    let place = |row: usize| {
        let mut places: Vec<String> = Vec::new();
        for column in by.iter().filter(|column| rows.iter().any(|&at| column.cells[at] != column.cells[row]))
        {
            // A count may have a column for its name too.
            let said = |name: &String| places.iter().any(|place| place.ends_with(&format!("= {name}")));
            places.extend(named(column, &column.cells[row]).filter(|name| !said(name)));
        }
        places.join(", ")
    };
    let shown = |value: f64| format!("{}{}", significant(value, 4), with_unit(column));
    let label = &column.label;
    let alike = known.iter().filter(|(_, other)| shown(*other) == shown(least.1)).count();
    let band = column.band.as_ref().and_then(|band| band[least.0]);
    let band = band.map_or(String::new(), |(low, high)| {
        format!(" (95 %: {} to {})", significant(low, 4), significant(high, 4))
    });
    Ok(Some(match (known.len(), alike) {
        (1, _) => format!("The {label} is {}{band}.", shown(least.1)),
        (all, alike) if alike == all => format!("The {label} is {} in all {all} rows.", shown(least.1)),
        _ if !less_is_better(table, estimate, filter)? => format!(
            "The {label} runs from {} ({}) to {} ({}).",
            shown(least.1),
            place(least.0),
            shown(most.1),
            place(most.0)
        ),
        (_, 1) => format!("The least {label} is {}{band}: {}.", shown(least.1), place(least.0)),
        (_, alike) => {
            format!("The least {label} is {}{band}, in {alike} rows: {}, …", shown(least.1), place(least.0))
        }
    }))
}

/// Whether an estimate is the better the less it is: errors and drifts are, but not intervals that are best, responses and what has both
/// signs.
///
/// # Errors
/// Those of [`best`].
pub(super) fn less_is_better(
    table: &Table,
    estimate: &str,
    filter: &[(String, String)],
) -> Result<bool, ColumnError> {
    let column = table.column(estimate)?;
    let is_other =
        ["optimum", "response", "normalised", "phase"].iter().any(|name| column.name.starts_with(name));
    let is_bound = ["optimum_bound", "optimum_true_rms"].contains(&column.name.as_str());
    let rows = table.rows_where(filter)?;
    let signed = rows.iter().filter_map(|&row| column.cells[row].number()).any(|value| value < 0.0);
    Ok((!is_other || is_bound) && !signed)
}

/// Where each curve is least, a sentence each, in the order of the table: `600 s: 0.153 °/h at switching interval 37.5 s`.
///
/// `filter` chooses rows as [`Table::rows_where`] does, `series` are the columns that tell curves apart. A curve that is least at one of
/// its ends is said to be.
///
/// # Errors
/// A name selects no single column, or the filter leaves no row.
pub(super) fn least_of_each(
    table: &Table,
    (x, y): (&str, &str),
    filter: &[(String, String)],
    series: &[&str],
) -> Result<Vec<String>, ColumnError> {
    let (x, y) = (table.column(x)?, table.column(y)?);
    let series = series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for row in table.rows_where(filter)? {
        let Some(place) = x.cells[row].number().zip(y.cells[row].number()) else { continue };
        let names: Vec<String> =
            series.iter().filter_map(|column| named(column, &column.cells[row])).collect();
        let name = names.join(", ");
        match curves.iter_mut().find(|(known, _)| *known == name) {
            Some((_, places)) => places.push(place),
            None => curves.push((name, vec![place])),
        }
    }
    let sentence = |(name, mut places): (String, Vec<(f64, f64)>)| {
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = [places.first()?.0, places.last()?.0];
        let least = places.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let name = if name.is_empty() { String::new() } else { format!("{name}: ") };
        let value = format!("{}{}", significant(least.1, 4), with_unit(y));
        if places.len() > 1 && places.iter().all(|place| place.1 == least.1) {
            return Some(format!("{name}{value} everywhere"));
        }
        let at_end = if ends.contains(&least.0) { ", the end of its range" } else { "" };
        Some(format!("{name}{value} at {}{at_end}", x.valued(&significant(least.0, 4))))
    };
    Ok(curves.into_iter().filter_map(sentence).collect())
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
pub(super) fn of_map(map: &Map) -> Option<String> {
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
            let ((cells, first), others) = shares.split_first()?;
            let share = |cells: usize| percent(cells, known);
            let others = others.iter().map(|(cells, name)| format!(", {name} in {}", share(*cells)));
            let others: String = others.collect();
            format!(
                "{} has the least {} in {} of cells{others}",
                capitalised(first),
                map.z.label,
                share(*cells)
            )
        }
    };
    Some(std::iter::once(found).chain(within).collect::<Vec<String>>().join("; ") + ".")
}

/// A part in percent, never rounded to all or none.
fn percent(part: usize, all: usize) -> String {
    match 100.0 * part as f64 / all.max(1) as f64 {
        _ if part == all => "100 %".to_owned(),
        0.0 => "0 %".to_owned(),
        p if p < 1.0 => "less than 1 %".to_owned(),
        p if p > 99.0 => "more than 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// Which curve keeps within its limit best, and which worst, as a sentence; none without curves.
///
/// Curves that rise above the limit are judged by how far they stay within it, those that come below it by how early.
pub(super) fn of_verdict(answers: &[Judged], limit: &str) -> Option<String> {
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
    let stays = |answer: &Judged| match answer.outcome {
        Outcome::AboveFrom => format!("{}, nowhere", answer.name()),
        Outcome::WithinUpTo => format!("{}, throughout", answer.name()),
        Outcome::Passes | Outcome::LastWithin => format!("{}, up to {}", answer.name(), answer.place()),
        Outcome::WithinFrom | Outcome::WithinBetween => {
            format!("{}, from {} on", answer.name(), answer.place())
        }
    };
    let (first, last) = if sign > 0.0 { ("Farthest", "least far") } else { ("Soonest", "latest") };
    Some(match answers.len() {
        1 => capitalised(&best.sentence(limit)) + ".",
        all if always == all => format!("All {all} curves stay within {limit}."),
        all if never == all => format!("None of the {all} curves is within {limit}."),
        _ => format!("{first} within {limit}: {}; {last}: {}.", stays(best), stays(worst)),
    })
}
