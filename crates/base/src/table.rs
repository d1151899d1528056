//! The table: named columns with units, the sole source of files, charts, reports and JSON.
//!
//! [`windows`] finds where a curve crosses a limit between two rows.

pub mod column;
#[cfg(test)]
mod tests;
pub mod text;

use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::Hash;

use serde::Serialize;

use crate::quantity::number::{joined, significant};
use crate::quantity::{Dimension, Quantity};
pub use crate::quantity::{Unit, Written};
pub use crate::table::column::{About, Cells, ColumnOf, Role, Usual};

/// One quantity over all rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Name without the unit, such as `rms` or `motion.frequency`.
    pub name: String,
    /// Label for the user, such as `rms error` or `vibration frequency`.
    pub label: String,
    /// Unit of all cells.
    pub unit: Unit,
    /// The unit in which its values are written in the study, and in which people read them, if it is another one.
    pub written: Option<Written>,
    /// Role in the table.
    pub role: Role,
    /// The name of the column to which the role refers; empty for none.
    pub of: String,
    /// Meaning of the cells, as a sentence.
    pub meaning: String,
    /// Whether the column is part of a brief summary.
    pub brief: bool,
    /// The purpose for which it is the default.
    pub usual: Option<Usual>,
    /// What the label stands for, as a formula; empty where it needs none.
    pub defined: &'static str,
    /// The names among its cells that look the same in every chart.
    pub styled: &'static [&'static str],
    /// Cells, one for each row.
    pub cells: Cells,
    /// Lower and upper ends of the 95 % interval of each cell, where there is one; empty where no cell has one.
    pub band: Option<Vec<Option<(f64, f64)>>>,
    /// Where `band` holds intervals of single records: the 95 % interval of the mean of all, by which rows are compared.
    pub band_of_mean: Option<Vec<Option<(f64, f64)>>>,
}

/// An interval of a value as one of its magnitude.
fn of_magnitude((low, high): (f64, f64)) -> (f64, f64) {
    match (low < 0.0, high < 0.0) {
        (false, _) => (low, high),
        (true, true) => (-high, -low),
        (true, false) => (0.0, high.max(-low)),
    }
}

impl Column {
    /// The name with its unit, as in the header of a file: `rms_arcsec`.
    pub fn header(&self) -> String {
        if self.unit.suffix.is_empty() {
            self.name.clone()
        } else {
            format!("{}_{}", self.name, self.unit.suffix)
        }
    }

    /// The label with the unit, as in the title of an axis or the heading of a table: `rms error, ″`.
    pub fn title(&self) -> String {
        titled(&self.label, self.unit.symbol)
    }

    /// The column in the unit in which people read it.
    pub fn read(&self) -> Column {
        let Some(written) = self.written else { return self.clone() };
        let read = |cell: &Cell| match cell.number() {
            Some(number) if written.factor != 1.0 => Cell::Number(written.of(number)),
            _ => cell.clone(),
        };
        Column {
            unit: Unit { symbol: written.symbol, ..self.unit },
            written: None,
            cells: self.cells.iter().map(read).collect(),
            ..self.clone()
        }
    }

    /// The value of a cell; NaN where it is not a number.
    pub fn value(&self, row: usize) -> f64 {
        self.cells[row].number().unwrap_or(f64::NAN)
    }

    /// The magnitude of a cell; infinite where it is not a number.
    pub fn magnitude(&self, row: usize) -> f64 {
        self.cells[row].number().map_or(f64::INFINITY, f64::abs)
    }

    /// The 95 % interval of a cell, where there is one.
    pub fn interval(&self, row: usize) -> Option<(f64, f64)> {
        self.band.as_ref()?.get(row).copied().flatten()
    }

    /// The 95 % interval of the magnitude of a cell.
    pub fn interval_of_magnitude(&self, row: usize) -> Option<(f64, f64)> {
        self.interval(row).map(of_magnitude)
    }

    /// Whether the intervals of the magnitudes of two rows, those of means where there are such, have values in common.
    pub fn is_alike(&self, one: usize, other: usize) -> bool {
        let of_mean = |row: usize| self.band_of_mean.as_ref()?.get(row).copied().flatten();
        let interval = |row: usize| of_mean(row).or_else(|| self.interval(row)).map(of_magnitude);
        let intervals = interval(one).zip(interval(other));
        intervals.is_some_and(|((low, high), (least, most))| low <= most && least <= high)
    }

    /// Whether the column holds errors relative to what is estimated, which people read in percent.
    pub fn is_relative(&self) -> bool {
        self.role == Role::Error && self.unit == Unit::NONE
    }

    /// A value of the column as in a sentence: `vibration frequency 20 Hz`, `lost ticks n = 3`.
    pub fn valued(&self, value: &str) -> String {
        let unread = (value, self.unit.symbol);
        let (value, symbol) = match self.written.zip(value.parse::<f64>().ok()) {
            Some((written, number)) => (&*significant(written.of(number), 12), written.symbol),
            None => unread,
        };
        let value = match value.strip_prefix('-') {
            Some(size) => format!("−{size}"),
            None => value.to_owned(),
        };
        match symbol {
            "" => format!("{} = {value}", self.label),
            symbol => format!("{} {}", self.label, joined(&value, symbol)),
        }
    }
}

/// A label as in a sentence: `drift (bound, Z(7))` for `drift: bound, Z(7)`.
pub fn worded(label: &str) -> String {
    match label.split_once(": ") {
        Some((whole, part)) => format!("{whole} ({part})"),
        None => label.to_owned(),
    }
}

/// A label with its unit; a pure number has an empty one.
pub fn titled(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.to_owned() } else { format!("{label}, {unit}") }
}

/// Why a name or filter given by the user selects no single column, or no row.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ColumnError {
    /// No column has the name.
    #[error("no column is called `{name}`; the columns are {}", known.join(", "))]
    Unknown {
        /// Requested name.
        name: String,
        /// Available columns.
        known: Vec<String>,
    },
    /// Several columns match the name.
    #[error("`{name}` may mean {}; write the whole name", candidates.join(" or "))]
    Ambiguous {
        /// Requested name.
        name: String,
        /// Matching columns.
        candidates: Vec<String>,
    },
    /// No row has the value.
    #[error("no row has {column} = `{value}`; its values are {}", known.join(", "))]
    NoRow {
        /// Requested column.
        column: String,
        /// Requested value.
        value: String,
        /// Values in the column.
        known: Vec<String>,
    },
}

/// Columns of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// The columns, which have equally many cells.
    pub columns: Vec<Column>,
}

impl Table {
    /// The table with each column in the unit in which people read it.
    pub fn read(&self) -> Cow<'_, Table> {
        match self.columns.iter().any(|column| column.written.is_some()) {
            true => Cow::Owned(Table { columns: self.columns.iter().map(Column::read).collect() }),
            false => Cow::Borrowed(self),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// Finds the column that a user means by `name`: its header or its name, each with or without the parts before any
    /// of its dots.
    ///
    /// # Errors
    /// No column matches, or several do.
    pub fn column(&self, name: &str) -> Result<&Column, ColumnError> {
        find(&self.columns, name)
    }

    /// The rows in which every named column shows its value. A pair is a column and a value as files show it.
    ///
    /// # Errors
    /// A name selects no single column, or a value none of the rows left by the pairs before it.
    pub fn rows_where<N: AsRef<str>, V: AsRef<str>>(
        &self,
        filter: &[(N, V)],
    ) -> Result<Vec<usize>, ColumnError> {
        let mut rows: Vec<usize> = (0..self.rows()).collect();
        for (name, value) in filter {
            let (column, value) = (self.column(name.as_ref())?, value.as_ref());
            let mut known: Vec<&Cell> = rows.iter().map(|&row| &column.cells[row]).collect();
            rows.retain(|&row| column.cells[row].shows(value));
            if rows.is_empty() && !known.is_empty() {
                known.sort_by(|a, b| match (a.number(), b.number()) {
                    (Some(a), Some(b)) => a.total_cmp(&b),
                    _ => a.text().cmp(&b.text()),
                });
                known.dedup();
                return Err(ColumnError::NoRow {
                    column: name.as_ref().to_owned(),
                    value: value.to_owned(),
                    known: known.into_iter().map(Cell::text).collect(),
                });
            }
        }
        Ok(rows)
    }

    /// The description of such a filter in sentences and legends, such as `filler = const`.
    ///
    /// # Errors
    /// A name selects no single column.
    pub fn chosen<N: AsRef<str>, V: AsRef<str>>(
        &self,
        filter: &[(N, V)],
    ) -> Result<Vec<String>, ColumnError> {
        filter.iter().map(|(name, value)| Ok(self.column(name.as_ref())?.valued(value.as_ref()))).collect()
    }

    /// The first column with this role.
    pub fn of_role(&self, role: Role) -> Option<&Column> {
        self.columns.iter().find(|column| column.role == role)
    }

    /// The default column for this purpose; the estimate is also the answer where no other column is.
    pub fn usual(&self, usual: Usual) -> Option<&Column> {
        let of = |usual| self.columns.iter().find(|column| column.usual == Some(usual));
        of(usual).or_else(|| (usual == Usual::Answer).then(|| of(Usual::Estimate))?)
    }

    /// The column that distinguishes rows by the values that this key of the study lists, such as fillers.
    pub fn listed_by(&self, key: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.role == Role::Key && column.of == key)
    }

    /// The column with this role for another column, such as its closed form or standard error.
    pub fn beside(&self, column: &Column, role: Role) -> Option<&Column> {
        self.columns.iter().find(|other| other.role == role && other.of == column.name)
    }

    /// The column to which the role of another one refers.
    pub fn referred(&self, column: &Column) -> Option<&Column> {
        self.columns.iter().find(|other| other.name == column.of)
    }
}

/// Rows by a key that each has, in the order of their first rows.
pub fn grouped<K: Clone + Eq + Hash>(
    rows: impl IntoIterator<Item = usize>,
    key: impl Fn(usize) -> K,
) -> Vec<(K, Vec<usize>)> {
    let (mut groups, mut places): (Vec<(K, Vec<usize>)>, _) = (vec![], HashMap::new());
    for row in rows {
        let key = key(row);
        let place = *places.entry(key.clone()).or_insert(groups.len());
        if place == groups.len() {
            groups.push((key, vec![]));
        }
        groups[place].1.push(row);
    }
    groups
}

/// Finds a column as [`Table::column`] does, among columns that need not form a table.
pub fn find<'c>(columns: &'c [Column], name: &str) -> Result<&'c Column, ColumnError> {
    let exact = |column: &&Column| column.header() == name || column.name == name;
    if let Some(column) = columns.iter().find(exact) {
        return Ok(column);
    }
    let is_end_of = |whole: &str| whole.strip_suffix(name).is_some_and(|before| before.ends_with('.'));
    let bare = |column: &&Column| is_end_of(&column.name) || is_end_of(&column.header());
    let found: Vec<&Column> = columns.iter().filter(bare).collect();
    match found[..] {
        [column] => Ok(column),
        [] => Err(ColumnError::Unknown {
            name: name.to_owned(),
            known: columns.iter().map(Column::header).collect(),
        }),
        _ => Err(ColumnError::Ambiguous {
            name: name.to_owned(),
            candidates: found.iter().map(|column| column.header()).collect(),
        }),
    }
}

/// One cell. An unknown value is [`Cell::Blank`], never 0; in JSON it is null.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum Cell {
    /// An unknown value, or one without meaning in this row.
    Blank,
    /// A name.
    Text(String),
    /// A count.
    Integer(i64),
    /// A value in the unit of its column.
    Number(f64),
}

impl Cell {
    /// The cell as a number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Integer(i) => Some(*i as f64),
            Cell::Number(x) => Some(*x),
            Cell::Blank | Cell::Text(_) => None,
        }
    }

    /// The cell as files show it: 9 significant digits for numbers, nothing for a blank.
    pub fn text(&self) -> String {
        match self {
            Cell::Blank => String::new(),
            Cell::Text(text) => text.clone(),
            Cell::Integer(i) => i.to_string(),
            Cell::Number(x) => significant(*x, 9),
        }
    }

    /// The cell with `digits` significant digits, for people.
    pub fn rounded(&self, digits: usize) -> String {
        self.number().map_or_else(|| self.text(), |x| significant(x, digits))
    }

    /// Whether files show the cell as `value`, or `value` is the same number written differently, such as `0.10` for
    /// 0.1.
    pub fn shows(&self, value: &str) -> bool {
        self.text() == value || self.number().is_some_and(|number| value.parse() == Ok(number))
    }
}

impl From<Option<f64>> for Cell {
    /// A missing or non-finite value becomes a blank.
    fn from(value: Option<f64>) -> Cell {
        value.filter(|x| x.is_finite()).map_or(Cell::Blank, Cell::Number)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Cell {
        Some(value).into()
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Cell {
        Cell::Integer(count as i64)
    }
}

impl From<Quantity> for Cell {
    fn from(quantity: Quantity) -> Cell {
        match quantity.dimension {
            Dimension::Count => Cell::Integer(quantity.value as i64),
            _ => Cell::Number(quantity.shown()),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.to_owned())
    }
}

/// A stretch of a curve within a limit; an end is absent where the curve ends within it.
pub type Window = [Option<f64>; 2];

/// The stretches of a curve through `rows`, in the order of `x`, within which the magnitude of a value is at most `limit`.
/// Their ends lie between rows, or at rows where a count leads from one to the next.
pub fn windows(
    table: &Table,
    x: &Column,
    rows: &[usize],
    limit: f64,
    value: impl Fn(usize) -> f64,
) -> Vec<Window> {
    let is_above = |row: usize| value(row).abs() > limit;
    let stretches: Vec<&[usize]> = rows.chunk_by(|&a, &b| is_above(a) == is_above(b)).collect();
    let crossing = |before: usize, after: usize, inner: usize| match counts_between(table, before, after) {
        true => x.value(inner),
        false => {
            let part = crossing_fraction(value(before), value(after), limit);
            between(x.value(before), x.value(after), part)
        }
    };
    let window = |at: usize| {
        let rows = stretches[at];
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let before =
            at.checked_sub(1).map(|at| crossing(stretches[at][stretches[at].len() - 1], first, first));
        let after = stretches.get(at + 1).map(|next| crossing(last, next[0], last));
        [before, after]
    };
    (0..stretches.len()).filter(|&at| !is_above(stretches[at][0])).map(window).collect()
}

/// Whether a count leads from one row to the other, so that nothing lies between them.
fn counts_between(table: &Table, a: usize, b: usize) -> bool {
    table.columns.iter().filter(|column| !matches!(column.role, Role::Trials | Role::Count)).any(|column| {
        let (a, b) = (&column.cells[a], &column.cells[b]);
        matches!((a, b), (Cell::Integer(_), Cell::Integer(_))) && a != b
    })
}

/// The fraction of the way from a to b at which the limit lies, one of the two being beyond it; on a logarithmic scale
/// where possible.
pub fn crossing_fraction(a: f64, b: f64, limit: f64) -> f64 {
    let beyond = if a.abs() > b.abs() { a } else { b };
    let limit = limit * beyond.signum();
    match a == b {
        true => 0.0,
        false if a * b > 0.0 => libm::log(limit / a) / libm::log(b / a),
        false => (limit - a) / (b - a),
    }
}

/// The number that fraction of the way from a to b, on a logarithmic scale where possible.
pub fn between(a: f64, b: f64, part: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a * libm::pow(b / a, part) } else { a + (b - a) * part }
}
