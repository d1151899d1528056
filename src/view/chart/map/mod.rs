//! Maps: what stands over two swept quantities, a cell for each pair of their values.
//!
//! A heat map shows a value by colour, a winner map the series whose value is the least.

pub mod colour_bar;
pub mod colour_scale;
pub mod contour;
pub mod draw;
pub mod from_table;
pub mod grid;
pub mod limit_line;
pub mod svg;
#[cfg(test)]
mod tests;
pub mod winners;

use serde::Serialize;

use crate::view::chart::figure::{Axis, Grouping, Limit};

/// A map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// What it answers, in bold.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is shown, or judged.
    pub z: Axis,
    /// The values of x that have a column of cells, ascending; the axis can show them.
    pub columns: Vec<f64>,
    /// The values of y that have a row of cells, ascending; the axis can show them.
    pub rows: Vec<f64>,
    /// The cells.
    pub cells: Cells,
    /// What they are made of: of a heat map its values, of a winner map those of everyone who competes.
    pub layers: Vec<Layer>,
    /// What z is judged by.
    pub limit: Option<Limit>,
    /// How the rows of the table were chosen, for the legend: `filler = const`.
    pub chosen: Vec<String>,
}

/// The cells of a map row by row, from the least y: that of a column and a row is at row · columns + column. Cells of
/// which nothing is known stay blank.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cells {
    /// Values that the scale of z can show, by colour.
    Values(Vec<Option<f64>>),
    /// Which entry has the least value.
    Winners {
        /// Who competes, and, for cells with several winners, these together.
        of: Grouping,
        /// The winners.
        won: Vec<Option<Won>>,
        /// Whether the values have uncertainties, so that a lead can be judged.
        banded: bool,
    },
}

/// The values of all cells, in the order of [`Cells`], with their uncertainties.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layer {
    /// [`Entry::style`](crate::view::chart::figure::Entry::style) of who competes; 0 of a heat map.
    pub style: usize,
    /// Who that is; empty of a heat map.
    pub name: String,
    /// In the unit of z. None of which nothing is known.
    pub values: Vec<Option<Estimate>>,
}

/// A value, and the lower and upper ends of its uncertainty (95 %).
pub type Estimate = (f64, Option<(f64, f64)>);

/// The winner of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Won {
    /// [`Entry::style`](crate::view::chart::figure::Entry::style) of the winner.
    pub style: usize,
    /// Its value.
    pub value: f64,
    /// Whether its uncertainty ends below that of the next. Where no uncertainty is known it is as if there were none.
    pub certain: bool,
}

impl Map {
    /// The value of each cell: that shown, or that of the winner.
    fn values(&self) -> Vec<Option<f64>> {
        match &self.cells {
            Cells::Values(values) => values.clone(),
            Cells::Winners { won, .. } => won.iter().map(|won| won.map(|won| won.value)).collect(),
        }
    }

    /// Number of cells with a value.
    pub fn known(&self) -> usize {
        self.values().iter().flatten().count()
    }

    /// Number of cells with a value within the limit; none if there is no limit.
    pub fn within_limit(&self) -> Option<usize> {
        let limit = self.limit.as_ref()?.value;
        Some(self.values().into_iter().flatten().filter(|value| *value <= limit).count())
    }
}

/// A part of all cells in percent, never rounded to all or none.
pub(crate) fn share(part: usize, cells: usize) -> String {
    let percent = 100.0 * part as f64 / cells.max(1) as f64;
    let shown = match percent {
        0.0 => return "no cells".to_owned(),
        _ if part == cells => return "all cells".to_owned(),
        p if p < 0.1 => "< 0.1".to_owned(),
        p if p < 9.95 => format!("{p:.1}"),
        p if p > 99.5 => "> 99.5".to_owned(),
        p => format!("{p:.0}"),
    };
    format!("{shown} % of cells")
}
