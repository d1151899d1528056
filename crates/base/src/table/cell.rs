//! The cells of a table.

use serde::Serialize;

use crate::quantity::number::significant;
use crate::quantity::units::{Dimension, Quantity};

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
