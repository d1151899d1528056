//! The content of a map: where each option is the best, or the ends of a range of values.

use crate::analysis::answer::Outline;
use crate::analysis::answer::{headline, sampled};
use sagnac_report::answer::reading::{joined, number, range, symbol};
use sagnac_report::answer::{AnswerCell, AnswerTable, Kind, Reading};
use sagnac_report::chart::figure::Axis;
use sagnac_report::chart::map::{Cells, Map};

pub(super) fn of_map(map: &Map) -> Option<Outline> {
    match &map.cells {
        Cells::Winners { of, won, .. } => {
            let names: Vec<(usize, &str)> =
                of.entries.iter().map(|entry| (entry.style, entry.name.as_str())).collect();
            let styles: Vec<Option<usize>> = won.iter().map(|won| won.map(|won| won.style)).collect();
            winners(map, &names, &styles)
        }
        Cells::Values(values) => of_values(map, values),
    }
}

/// For places along x, the values of y at which each option has the least value.
fn winners(map: &Map, names: &[(usize, &str)], won: &[Option<usize>]) -> Option<Outline> {
    let (columns, rows) = (map.columns.len(), map.rows.len());
    let count = |style: usize| won.iter().flatten().filter(|&&other| other == style).count();
    let mut shown: Vec<(usize, &str)> =
        names.iter().copied().filter(|&(style, _)| count(style) > 0).collect();
    // The option that wins less often is told, as the others win everywhere else.
    shown.sort_by_key(|&(style, _)| count(style));
    let places = sampled(columns, 0);
    let stretch = |style: usize, column: usize| {
        let wins: Vec<usize> = (0..rows).filter(|row| won[row * columns + column] == Some(style)).collect();
        let (Some(&first), Some(&last)) = (wins.first(), wins.last()) else {
            return ("never".to_owned(), None);
        };
        let is_whole = wins.len() == last - first + 1;
        let y = |row: usize| map.rows[row];
        let border = |low: usize, high: usize| range(&number(y(low)), &number(y(high)));
        match (first, last == rows - 1) {
            _ if !is_whole => ("in part".to_owned(), None),
            (0, true) => ("always".to_owned(), None),
            (0, false) => (format!("below {}", border(last, last + 1)), None),
            (_, true) => (format!("above {}", border(first - 1, first)), Some(first)),
            _ => (range(&number(y(first)), &number(y(last))), None),
        }
    };
    let line = |&(style, name): &(usize, &str)| {
        let cells = places.iter().map(|&column| AnswerCell::from(stretch(style, column).0));
        std::iter::once(AnswerCell::from(name.to_owned())).chain(cells).collect()
    };
    let table = AnswerTable {
        columns: std::iter::once(format!("least {} by {}", map.z.label, map.y.label))
            .chain(places.iter().map(|&column| valued(&map.x, map.columns[column])))
            .collect(),
        rows: shown.iter().map(line).collect(),
        best: None,
        omitted: 0,
        are_places: true,
    };
    let (style, name) = *shown.first()?;
    // Where it begins to win at the lowest y, of the places in the table.
    let begins = places.iter().filter_map(|&column| Some((column, stretch(style, column).1?)));
    let (headline, value) = match begins.min_by_key(|&(_, row)| row) {
        Some((column, row)) if row > 0 => {
            let y = range(&number(map.rows[row - 1]), &number(map.rows[row]));
            let x = valued(&map.x, map.columns[column]);
            let text = format!("{name} wins above {} {} at {x}", short(&map.y), joined(&y, &map.y.unit));
            let value = Reading {
                quantity: map.y.label.clone(),
                value: map.rows[row],
                unit: map.y.unit.clone(),
                interval: Some([map.rows[row - 1], map.rows[row]]),
            };
            (headline("", &text), Some(value))
        }
        _ => (headline("", &format!("{} has the least {} most often", shown.last()?.1, map.z.label)), None),
    };
    Some(Outline { kind: Kind::Map, headline, value, table, marks: vec![], met: met(map) })
}

/// The cells whose winner is within the limit, and all with a winner.
fn met(map: &Map) -> Option<[usize; 2]> {
    Some([map.within_limit()?, map.known()])
}

/// Values at places along both axes.
fn of_values(map: &Map, values: &[Option<f64>]) -> Option<Outline> {
    let columns = map.columns.len();
    let places = sampled(columns, 0);
    let line = |row: usize| {
        let cells = places.iter().map(|&column| {
            AnswerCell::from(
                values[row * columns + column]
                    .map_or_else(String::new, |value| joined(&number(value), &map.z.unit)),
            )
        });
        std::iter::once(AnswerCell::from(valued(&map.y, map.rows[row]))).chain(cells).collect()
    };
    let known = values.iter().enumerate().filter_map(|(at, value)| Some((at, (*value)?)));
    let (cell, value) = known.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let table = AnswerTable {
        columns: std::iter::once(map.z.label.clone())
            .chain(places.iter().map(|&column| valued(&map.x, map.columns[column])))
            .collect(),
        rows: sampled(map.rows.len(), 0).into_iter().map(line).collect(),
        best: None,
        omitted: 0,
        are_places: true,
    };
    let value = Reading { quantity: map.z.label.clone(), value, unit: map.z.unit.clone(), interval: None };
    let at = [(&map.x, map.columns[cell % columns]), (&map.y, map.rows[cell / columns])]
        .map(|(axis, at)| valued(axis, at));
    let headline = headline("", &format!("{}: at most {} at {}", map.z.label, value.text(), at.join(", ")));
    Some(Outline { kind: Kind::Map, headline, value: Some(value), table, marks: vec![], met: met(map) })
}

/// The part of a label that names it in few words.
fn short(axis: &Axis) -> &str {
    symbol(&axis.label)
}

/// A value of an axis, after its label where it has no unit.
fn valued(axis: &Axis, value: f64) -> String {
    let unit = &axis.unit;
    match unit.is_empty() {
        true => format!("{} = {}", short(axis), number(value)),
        false => joined(&number(value), unit),
    }
}
