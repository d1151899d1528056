//! Sentences with answers: the minimum and the winner.

use crate::quantity::number::significant;
use crate::table::{Cell, Column, ColumnError, Role, Table};
use crate::view::chart::map::{Cells, Map, share};

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
/// agree to the four digits shown are counted.
///
/// # Errors
/// A name selects no single column.
pub(crate) fn best(
    table: &Table,
    estimate: &str,
    rows: &[usize],
    by: &[&str],
) -> Result<Option<Best>, ColumnError> {
    let column = table.column(estimate)?;
    let by = by.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
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
            // The name of a count may have a column of its own.
            places.extend(named(column, &column.cells[row]).filter(|name| !places.contains(name)));
        }
        places.join(", ")
    };
    let shown = |value: f64| measured(column, value);
    let label = &column.label;
    let alike = known.iter().filter(|(_, other)| shown(*other) == shown(least.1)).count();
    let band = column.band.as_ref().and_then(|band| band[least.0]);
    let band = band.map_or(String::new(), |(low, high)| {
        format!(" (95 %: {} to {})", significant(low, 4), significant(high, 4))
    });
    let least_of = |value: String| Best {
        subject: format!("The least {label} is"),
        value: format!("{}{band}{value}", shown(least.1)),
        row: Some(least.0),
    };
    let told = |how: &str, value: String| Best { subject: format!("The {label} {how}"), value, row: None };
    Ok(Some(match (known.len(), alike) {
        (1, _) => told("is", format!("{}{band}", shown(least.1))),
        (all, alike) if alike == all => told("is", format!("{} in all {all} rows", shown(least.1))),
        _ if !less_is_better(table, estimate, rows)? => {
            let end = |(row, value): &(usize, f64)| format!("{} ({})", shown(*value), place(*row));
            told("runs from", format!("{} to {}", end(least), end(most)))
        }
        (_, 1) => least_of(format!(": {}", place(least.0))),
        (_, alike) => least_of(format!(", in {alike} rows: {}, …", place(least.0))),
    }))
}

/// Whether less of an estimate is better in all selected rows: its role says so, and none of its values is negative.
///
/// # Errors
/// The same as for [`best`].
pub(crate) fn less_is_better(table: &Table, estimate: &str, rows: &[usize]) -> Result<bool, ColumnError> {
    let column = table.column(estimate)?;
    let estimate = if column.role == Role::Oracle { table.referred(column) } else { Some(column) };
    let signed = rows.iter().filter_map(|&row| column.cells[row].number()).any(|value| value < 0.0);
    Ok(estimate.is_some_and(|column| column.role.less_is_better()) && !signed)
}

/// The estimate of some rows side by side, distinguished by `by`, such as `rms angle left: 34.7 ″ (none), 20.4 ″
/// (frequency)`. `None` where a row has no value, or there are no rows.
///
/// # Errors
/// A name selects no single column.
pub(crate) fn side_by_side(
    table: &Table,
    estimate: &str,
    rows: &[usize],
    by: &[&str],
) -> Result<Option<String>, ColumnError> {
    let column = table.column(estimate)?;
    let by = by.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let differs = |by: &&&Column| rows.iter().any(|&row| by.cells[row] != by.cells[rows[0]]);
    let of_row = |&row: &usize| {
        let value = measured(column, column.cells[row].number()?);
        let names: Vec<String> =
            by.iter().filter(differs).filter_map(|by| named(by, &by.cells[row])).collect();
        Some(if names.is_empty() { value } else { format!("{value} ({})", names.join(", ")) })
    };
    let told = rows.iter().map(of_row).collect::<Option<Vec<String>>>();
    Ok(told.filter(|told| !told.is_empty()).map(|told| format!("{}: {}", column.label, told.join(", "))))
}

/// A value of a column with its unit.
pub(crate) fn measured(column: &Column, value: f64) -> String {
    format!("{} {}", significant(value, 4).replace('-', "−"), column.unit.symbol).trim_end().to_owned()
}

/// A value as in a sentence; `None` for a blank.
pub(crate) fn named(column: &Column, cell: &Cell) -> Option<String> {
    match cell {
        Cell::Blank => None,
        Cell::Text(text) if text.parse::<f64>().is_ok() => Some(column.valued(text)),
        Cell::Text(text) => Some(text.clone()),
        cell => cell.number().map(|x| column.valued(&significant(x, 4))),
    }
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
            let share = |cells: usize| share(cells, known);
            let others = others.iter().map(|(cells, name)| format!(", in {} {name}", share(*cells)));
            let others: String = others.collect();
            format!("In {} {first} has the least {}{others}", share(*cells), map.z.label)
        }
    };
    Some(std::iter::once(found).chain(within).collect::<Vec<String>>().join("; ") + ".")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::table::Unit;

    fn column(name: &str, unit: Unit, cells: Vec<Cell>) -> Column {
        Column { name: name.to_owned(), label: name.to_owned(), unit, cells, ..Column::default() }
    }

    /// Curves over the frequencies 1, 2, 4 Hz, with the values of an estimate.
    pub(crate) fn table(estimate: &str, curves: &[(&str, [f64; 3])]) -> Table {
        let role = if estimate == "rms" { Role::Error } else { Role::Estimate };
        let names = curves.iter().flat_map(|(name, _)| vec![Cell::Text((*name).to_owned()); 3]).collect();
        let xs = curves.iter().flat_map(|_| [1.0, 2.0, 4.0].map(Cell::Number)).collect();
        let values = curves.iter().flat_map(|(_, values)| values.map(|x| Cell::from(Some(x)))).collect();
        Table {
            columns: vec![
                column("filler", Unit::NONE, names),
                column("frequency", Unit::HZ, xs),
                Column { role, ..column(estimate, Unit::ARCSEC, values) },
            ],
        }
    }

    #[test]
    fn what_is_least_is_told_of_errors_and_of_others_where_they_run() {
        let curves = [("a", [3.0, 2.0, 5.0]), ("b", [4.0, 4.0, 4.0])];
        let told = |estimate: &str| {
            best(&table(estimate, &curves), estimate, &[0, 1, 2, 3, 4, 5], &["filler", "frequency"])
                .unwrap()
                .unwrap()
                .sentence()
        };
        assert_eq!(told("rms"), "The least rms is 2 ″: a, frequency 2 Hz.");
        let range = "The coverage95 runs from 2 ″ (a, frequency 2 Hz) to 5 ″ (a, frequency 4 Hz).";
        assert_eq!(told("coverage95"), range);
        let signed = table("rms", &[("a", [-3.0, 2.0, 5.0])]);
        assert!(
            best(&signed, "rms", &[0, 1, 2], &["frequency"])
                .unwrap()
                .unwrap()
                .sentence()
                .contains("from −3 ″")
        );
    }
}
