//! Sentences with answers: the minimum and the winner.

use crate::kinds::allan::columns::COEFFICIENT;
use crate::quantity::list::listed;
use crate::quantity::number::{Side, significant};
use crate::table::{Cell, Column, Role, Table, Unit, worded};
use crate::theory::allan::terms::in_words;
use crate::view::chart::map::{Cells, Map, Won, share};
use crate::view::verdict::places;

/// Most rows that are named beside one from which they do not differ.
const MOST_ALIKE: usize = 4;

/// Distance of the mean place of cells from the middle of an axis, in lengths of that axis, from which on they are mostly on one
/// side.
const OFF_CENTRE: f64 = 0.05;

/// Time from which on it is told in hours or days too, s.
const LONG_S: f64 = 7200.0;

/// Significant digits of all values in a sentence.
const DIGITS: usize = 3;

/// The statement of a table about an estimate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Best {
    /// Beginning of the sentence, such as `The least rms error is`.
    subject: String,
    /// Value and place, such as `2.1 ″ (95 %: 2 to 2.2): quadratic, frequency 4 Hz`.
    pub(crate) value: String,
    /// Index of the best row, or of one of several, if less is better and rows differ.
    pub(crate) row: Option<usize>,
}

impl Best {
    pub(crate) fn sentence(&self) -> String {
        let end = if self.value.ends_with('…') { "" } else { "." };
        format!("{} {}{end}", self.subject, self.value)
    }
}

/// The rows that answer a question about an estimate: where it is least, or its range if less is not better.
///
/// `rows` are the compared rows, `by` the columns that distinguish them. `None` where no row has a value. Rows that
/// agree to the digits shown are counted.
pub(crate) fn best(table: &Table, column: &Column, rows: &[usize], by: &[&Column]) -> Option<Best> {
    let known: Vec<(usize, f64)> =
        rows.iter().filter_map(|&row| Some((row, column.cells[row].number()?))).collect();
    let order = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
    let (least, most) = (known.iter().min_by(order)?, known.iter().max_by(order)?);
    let place = |row: usize| {
        let mut places: Vec<String> = Vec::new();
        for column in by.iter().filter(|column| rows.iter().any(|&at| column.cells[at] != column.cells[row]))
        {
            // The name of a count may have a column of its own.
            places.extend(named(column, &column.cells[row]).filter(|name| !places.contains(name)));
        }
        places.join(", ")
    };
    let shown = |value: f64| measured(column, value);
    let label = worded(&column.label);
    let alike = known.iter().filter(|(_, other)| shown(*other) == shown(least.1)).count();
    let band = column.interval(least.0).map_or(String::new(), |(low, high)| {
        format!(" (95 %: {} to {})", significant(low, DIGITS), significant(high, DIGITS))
    });
    let least_of = |value: String| Best {
        subject: format!("The least {label} is"),
        value: format!("{}{band}{value}", shown(least.1)),
        row: Some(least.0),
    };
    let told = |how: &str, value: String| Best { subject: format!("The {label} {how}"), value, row: None };
    Some(match (known.len(), alike) {
        (1, _) => told("is", format!("{}{band}", shown(least.1))),
        (all, alike) if alike == all => told("is", format!("{} in all {all} rows", shown(least.1))),
        _ if !less_is_better(table, column, rows) => {
            let end = |(row, value): &(usize, f64)| format!("{} ({})", shown(*value), place(*row));
            told("runs from", format!("{} to {}", end(least), end(most)))
        }
        (_, 1) => {
            let is_alike = |(row, _): &&(usize, f64)| *row != least.0 && column.is_alike(least.0, *row);
            let alike: Vec<String> = known.iter().filter(is_alike).map(|(row, _)| place(*row)).collect();
            let alike = match alike.len() {
                0 => String::new(),
                1..=MOST_ALIKE => format!("; the 95 % intervals show no difference to {}", alike.join("; ")),
                others => format!("; the 95 % intervals show no difference to {others} other rows"),
            };
            least_of(format!(": {}{alike}", place(least.0)))
        }
        (_, alike) => least_of(format!(", in {alike} rows: {}, …", place(least.0))),
    })
}

/// Whether less of an estimate is better in all selected rows: its role says so, and none of its values is negative.
pub(crate) fn less_is_better(table: &Table, column: &Column, rows: &[usize]) -> bool {
    let estimate = if column.role == Role::Oracle { table.referred(column) } else { Some(column) };
    let signed = rows.iter().any(|&row| column.value(row) < 0.0);
    estimate.is_some_and(|column| column.role.less_is_better()) && !signed
}

/// The estimate of some rows side by side, distinguished by `by`, such as `rms angle left: 34.7 ″ (none), 20.4 ″
/// (frequency)`. `None` where a row has no value, or there are no rows.
pub(crate) fn side_by_side(column: &Column, rows: &[usize], by: &[&Column]) -> Option<String> {
    let differs = |by: &&Column| rows.iter().any(|&row| by.cells[row] != by.cells[rows[0]]);
    let by: Vec<&Column> = by.iter().copied().filter(differs).collect();
    let of_row = |&row: &usize| {
        let value = measured(column, column.cells[row].number()?);
        let names = names(&by, row);
        Some(if names.is_empty() { value } else { format!("{value} ({names})") })
    };
    let told = rows.iter().map(of_row).collect::<Option<Vec<String>>>().filter(|told| !told.is_empty())?;
    Some(format!("{}: {}", column.label, told.join(", ")))
}

/// A value of a column with its unit.
pub(crate) fn measured(column: &Column, value: f64) -> String {
    if column.is_relative() {
        return format!("{} %", significant(100.0 * value, DIGITS));
    }
    format!("{} {}", significant(value, DIGITS).replace('-', "−"), column.unit.symbol).trim_end().to_owned()
}

/// A value as in a sentence; `None` for a blank.
fn named(column: &Column, cell: &Cell) -> Option<String> {
    match cell {
        Cell::Blank => None,
        Cell::Text(text) if column.name == COEFFICIENT => Some(in_words(text).unwrap_or(text).to_owned()),
        Cell::Text(text) if text.parse::<f64>().is_ok() => Some(column.valued(text)),
        Cell::Text(text) => Some(text.clone()),
        cell => cell.number().map(|x| match x >= LONG_S && column.unit == Unit::S {
            true => places(&[(column, x)], Side::Nearest),
            false => column.valued(&significant(x, 4)),
        }),
    }
}

/// The values of some columns in each row as [`names`] gives them; those of a column with few values are written once.
pub(crate) fn naming<'t>(columns: &[&'t Column]) -> impl Fn(usize) -> String + use<'t> {
    let texts = |column: &&'t Column| {
        let column = *column;
        column.cells.texts(move |cell| named(column, cell).unwrap_or_default())
    };
    let columns: Vec<_> = columns.iter().map(texts).collect();
    move |row| {
        let names = columns.iter().map(|column| column.at(row)).filter(|name| !name.is_empty());
        names.collect::<Vec<_>>().join(", ")
    }
}

/// The values of some columns in a row, as in a sentence.
pub(crate) fn names(columns: &[&Column], row: usize) -> String {
    columns.iter().filter_map(|column| named(column, &column.cells[row])).collect::<Vec<_>>().join(", ")
}

/// Where the cells of a winner mostly are, as the end of a sentence: at low or high values of each axis along which their
/// mean place differs from the middle.
fn mostly(map: &Map, won: &[Option<Won>], style: usize) -> String {
    let cells = || won.iter().enumerate().filter(|(_, won)| won.is_some_and(|won| won.style == style));
    let (columns, rows) = (map.columns.len(), map.rows.len());
    let axes = [(&map.x, columns, true), (&map.y, rows, false)];
    let sides = axes.into_iter().filter_map(|(axis, count, is_column)| {
        let place =
            |(cell, _): (usize, &Option<Won>)| if is_column { cell % columns } else { cell / columns };
        let mean = cells().map(place).sum::<usize>() as f64 / cells().count() as f64;
        let off = mean / (count.max(2) - 1) as f64 - 0.5;
        (off.abs() > OFF_CENTRE).then(|| format!("{} {}", if off < 0.0 { "low" } else { "high" }, axis.label))
    });
    let sides: Vec<String> = sides.collect();
    if sides.is_empty() { String::new() } else { format!(" (mostly at {})", listed(&sides)) }
}

/// The content of a map as a sentence: the shares of the winners, or the least and greatest value of a heat map.
pub(crate) fn of_map(map: &Map) -> Option<String> {
    let within = map.within_limit().zip(map.limit.as_ref()).map(|(within, limit)| {
        let share = share(within, map.known());
        match &map.cells {
            Cells::Values(_) => format!("{share} are within the {}", limit.label),
            Cells::Winners { .. } => format!("in {share} the least is within the {}", limit.label),
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
                    format!("{}{equals} {} {}", axis.label, significant(at, DIGITS), axis.unit)
                        .trim_end()
                        .to_owned()
                });
                let value = format!("{} {}", significant(value, DIGITS), map.z.unit);
                format!("{} at {}", value.trim_end(), place.join(", "))
            };
            let low = known().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let high = known().max_by(|a, b| a.1.total_cmp(&b.1))?;
            format!("The {} runs from {} to {}", map.z.label, end(low), end(high))
        }
        Cells::Winners { of, won, .. } => {
            let cells = |style: usize| won.iter().flatten().filter(|won| won.style == style).count();
            let shared =
                of.entries.iter().map(|entry| (cells(entry.style), entry.name.as_str(), entry.style));
            let mut shares: Vec<(usize, &str, usize)> = shared.collect();
            shares.retain(|(cells, ..)| *cells > 0);
            shares.sort_by_key(|(cells, ..)| std::cmp::Reverse(*cells));
            let known = map.known();
            let place = |style: usize| match shares.len() {
                1 => String::new(),
                _ => mostly(map, won, style),
            };
            let ((cells, first, style), others) = shares.split_first()?;
            let share = |cells: usize| share(cells, known);
            let others = others
                .iter()
                .map(|(cells, name, style)| format!(", in {} {name}{}", share(*cells), place(*style)));
            let others: String = others.collect();
            format!("In {} {first} has the least {}{}{others}", share(*cells), map.z.label, place(*style))
        }
    };
    Some(std::iter::once(found).chain(within).collect::<Vec<String>>().join("; ") + ".")
}
