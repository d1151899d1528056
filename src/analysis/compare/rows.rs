//! Coefficients of two logs in the units of data sheets.

use crate::analysis::compare::{Comparison, Difference, Length, SIGNIFICANT};
use sagnac_records::allan::Unit;

/// The result for one coefficient of two logs.
#[derive(Debug, Clone)]
pub struct Row {
    /// Name in files.
    pub name: &'static str,
    /// Unit in files.
    pub unit: &'static str,
    /// Unit for the user.
    pub symbol: &'static str,
    /// Result in this unit, except p and the ratio.
    pub found: Difference,
    /// Record length required to distinguish the values.
    pub length: Length,
    /// Whether the fit describes the curve of each log.
    pub described: [bool; 2],
}

/// The verdict on a quantity of two logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The second record has a significantly higher value.
    Higher,
    /// The second record has a significantly lower value.
    Lower,
    /// The records show no significant difference.
    Consistent,
    /// Both values are the same number.
    Equal,
    /// Neither record shows the quantity.
    Neither,
    /// An event of a record explains the quantity as well.
    Explained,
}

impl Verdict {
    /// The verdict in files, where the second log has the label `b`: `after higher`.
    pub fn text(self, b: &str) -> String {
        match self {
            Verdict::Higher => format!("{b} higher"),
            Verdict::Lower => format!("{b} lower"),
            Verdict::Consistent => "consistent".to_owned(),
            Verdict::Equal => "equal".to_owned(),
            Verdict::Neither => "in neither record".to_owned(),
            Verdict::Explained => "not compared".to_owned(),
        }
    }
}

impl Row {
    /// The verdict that follows from p.
    pub fn verdict(&self) -> Verdict {
        match self.found.p {
            None if self.found.values.iter().any(Option::is_some) => Verdict::Explained,
            None => Verdict::Neither,
            Some(p) if p < SIGNIFICANT => match self.found.interval[0] {
                Some(low) if low >= 0.0 => Verdict::Higher,
                _ => Verdict::Lower,
            },
            Some(_) if self.found.difference == Some(0.0) => Verdict::Equal,
            Some(_) => Verdict::Consistent,
        }
    }
}

/// The rows of a comparison, or the reason why there are none.
pub fn rows(comparison: &Comparison, unit: Unit) -> Result<Vec<Row>, String> {
    let differences = comparison.differences.as_ref().map_err(ToString::to_string)?;
    let row = |(found, length)| row(found, length, comparison.described(), unit);
    Ok(differences.iter().zip(comparison.lengths()).map(row).collect())
}

fn row(found: &Difference, length: Length, described: [bool; 2], unit: Unit) -> Row {
    let (factor, unit, symbol) = found.quantity.unit(unit);
    let scaled = |value: Option<f64>| value.map(|value| factor * value);
    let found = Difference {
        values: found.values.map(scaled),
        at_most: found.at_most.map(scaled),
        difference: scaled(found.difference),
        interval: found.interval.map(scaled),
        ..*found
    };
    Row { name: found.quantity.name(), unit, symbol, found, length, described }
}
