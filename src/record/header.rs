//! The header of a record, which names the columns of time and rate and their units.

use crate::quantity::units::{Dimension, parse_unit};
use crate::record::rows::Row;
use crate::source::diagnose::Fault;

/// Help with an example of a header.
const EXAMPLE: &str =
    "name the two columns with their units, a comma between them, as in\ntime [s], rate [deg/s]";

/// Most columns that a message lists.
const MOST_LISTED: usize = 20;

/// A column that a record requires.
#[derive(Debug)]
struct Wanted {
    name: &'static str,
    dimension: Dimension,
    example: &'static str,
}

const TIME: Wanted = Wanted { name: "time", dimension: Dimension::Time, example: "time [s]" };
const RATE: Wanted = Wanted { name: "rate", dimension: Dimension::Rate, example: "rate [deg/s]" };

/// A column found in the header.
#[derive(Debug)]
pub(crate) struct Column {
    name: &'static str,
    /// Index in a row.
    index: usize,
    /// Size of its unit in ″ and s.
    factor: f64,
}

/// The required columns.
#[derive(Debug)]
pub(crate) struct Columns {
    pub(crate) time: Column,
    pub(crate) rate: Column,
    /// Number of cells in the header, including those that are not read.
    cells: usize,
}

impl Columns {
    /// Finds the columns in a `header`.
    pub(crate) fn read(header: &Row<'_>) -> Result<Columns, Fault> {
        if header.cells.iter().all(|cell| cell.parse::<f64>().is_ok()) {
            let message = "the first row is numbers, the header is missing";
            return Err(Fault::new(header.span.clone(), message, "numbers instead of names", EXAMPLE));
        }
        if header.cells.len() == 1 {
            let message = "the header has only one column";
            return Err(Fault::new(header.span.clone(), message, "no comma", EXAMPLE));
        }
        Ok(Columns { time: find(header, &TIME)?, rate: find(header, &RATE)?, cells: header.cells.len() })
    }

    /// Refuses a `row` with a different number of cells than the header.
    pub(crate) fn check(&self, row: &Row<'_>) -> Result<(), Fault> {
        let (found, expected) = (row.cells.len(), self.cells);
        if found == expected {
            return Ok(());
        }
        let label = if found < expected { "a cell is missing" } else { "a cell too many" };
        let cells = |count: usize| format!("{count} cell{}", if count == 1 { "" } else { "s" });
        let message = format!("this row has {}, the header has {expected}", cells(found));
        let help = "write one cell for each column, a comma between them and the point for decimals; mark a \
                    comment by # at the start of its line";
        Err(Fault::new(row.span.clone(), message, label, help))
    }
}

impl Column {
    /// The value of this column in a `row`, in base units.
    pub(crate) fn value(&self, row: &Row<'_>) -> Result<f64, Fault> {
        let cell = row.cells.get(self.index).unwrap_or_default();
        let fault = |message: String, label: &str| {
            let help = "every row needs a finite number here: put it in, or cut the record and resample what is left";
            Err(Fault::new(row.cell(self.index), message, label, help))
        };
        match cell.parse::<f64>().map(|number| number * self.factor) {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => fault(format!("the {} \"{cell}\" is not a finite number", self.name), "not finite"),
            Err(_) if cell.is_empty() => fault(format!("the {} is missing", self.name), "an empty cell"),
            Err(_) => fault(format!("the {} \"{cell}\" is not a number", self.name), "not a number"),
        }
    }

    /// The place of this column in a `row`.
    pub(crate) fn place(&self, row: &Row<'_>) -> std::ops::Range<usize> {
        row.cell(self.index)
    }
}

/// Finds the single column of a `header` that is `wanted`.
fn find(header: &Row<'_>, wanted: &Wanted) -> Result<Column, Fault> {
    let Wanted { name, dimension, example } = *wanted;
    let mut named = header.cells.iter().enumerate().filter_map(|(i, cell)| Some((i, unit_in(cell, wanted)?)));
    let Some((index, unit)) = named.next() else {
        let listed = header.cells.iter().take(MOST_LISTED);
        let columns: Vec<String> = listed.map(|cell| format!("`{cell}`")).collect();
        let more = if header.cells.len() > MOST_LISTED { ", …" } else { "" };
        let message = format!("no column is called `{name}`; the columns are {}{more}", columns.join(", "));
        return Err(Fault::new(header.span.clone(), message, format!("no `{name}` here"), EXAMPLE));
    };
    if let Some((second, _)) = named.next() {
        let message = format!("two columns are called `{name}`");
        return Err(Fault::new(header.cell(second), message, "the second", "rename or remove one of them"));
    }
    let fault = |message: String, label: &str| {
        let units = dimension.units();
        let help = format!("accepted: {} in {units}, for example `{example}`", dimension.name());
        Fault::new(header.cell(index), message, label, help)
    };
    if unit.is_empty() {
        return Err(fault(format!("the column `{name}` has no unit"), "its unit is missing"));
    }
    let (factor, _) = parse_unit(&unit, &[dimension])
        .map_err(|error| fault(format!("the unit of the column `{name}`: {error}"), error.label()))?;
    Ok(Column { name, index, factor })
}

/// The unit that a header's cell gives for the `wanted` column, empty where it gives none; `None` for another column.
///
/// The forms are `name [unit]`, `name (unit)`, and `name_unit` with `_per_` for the stroke. The last one counts only if
/// it is a unit of the correct dimension, since an underscore may also belong to the name of another column.
fn unit_in(cell: &str, wanted: &Wanted) -> Option<String> {
    let (start, rest) = cell.split_at_checked(wanted.name.len())?;
    if !start.eq_ignore_ascii_case(wanted.name) {
        return None;
    }
    let rest = rest.trim();
    let within = |open, close| rest.strip_prefix(open)?.strip_suffix(close);
    if let Some(unit) = rest.is_empty().then_some("").or(within('[', ']')).or(within('(', ')')) {
        return Some(unit.trim().to_owned());
    }
    let unit = rest.strip_prefix('_')?.replace("_per_", "/");
    parse_unit(&unit, &[wanted.dimension]).is_ok().then_some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_stands_in_brackets_or_after_an_underscore() {
        let table = [
            ("rate [deg/s]", Some("deg/s")),
            ("Rate[ °/h ]", Some("°/h")),
            ("rate (rad/s)", Some("rad/s")),
            ("rate ((deg)/s)", Some("(deg)/s")),
            ("rate_deg_per_s", Some("deg/s")),
            ("rate_arcsec/s", Some("arcsec/s")),
            ("RATE", Some("")),
            ("rate []", Some("")),
            ("rate [furlong]", Some("furlong")),
            ("rate_x", None),
            ("rate_s", None),
            ("rate_x [deg/s]", None),
            ("rates [deg/s]", None),
            ("rate of turn", None),
            ("rate [deg/s", None),
            ("temperature [K]", None),
            ("rat", None),
            ("raté", None),
            ("", None),
        ];
        for (cell, expected) in table {
            assert_eq!(unit_in(cell, &RATE).as_deref(), expected, "{cell}");
        }
    }
}
