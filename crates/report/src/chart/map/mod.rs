//! Maps of a quantity over two swept ones, with a cell for each pair of their values.
//!
//! A heat map shows a value by colour, a winner map the series with the least value.

pub(crate) mod colour_bar;
pub(crate) mod contour;
pub(crate) mod draw;
pub(crate) mod limit_line;
pub(crate) mod svg;
pub mod winners;
pub(crate) mod words;

use serde::Serialize;

use crate::chart::figure::{Axis, Grouping, Limit};

/// A map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// Title, in bold.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The quantity that is shown or compared.
    pub z: Axis,
    /// The values of x with a column of cells, ascending, which the axis can show.
    pub columns: Vec<f64>,
    /// The values of y with a row of cells, ascending, which the axis can show.
    pub rows: Vec<f64>,
    /// The cells.
    pub cells: Cells,
    /// Values of the cells: those of a heat map, or those of all competitors of a winner map.
    pub layers: Vec<Layer>,
    /// Limit against which z is judged.
    pub limit: Option<Limit>,
    /// Rows selected from the table for the legend, such as `filler = const`.
    pub chosen: Vec<String>,
}

/// The cells of a map row by row, from the least y: the cell of a column and a row has the index row · columns +
/// column. Cells without a known value stay blank.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cells {
    /// Values by colour, where the scale of z can show them.
    Values(Vec<Option<f64>>),
    /// The entries with the least value.
    Winners {
        /// Competitors, and joint entries for cells with several winners.
        of: Grouping,
        /// Winners.
        won: Vec<Option<Won>>,
        /// Whether the values have uncertainties, so that a lead can be judged.
        banded: bool,
    },
}

/// The values of all cells, in the order of [`Cells`], with their intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layer {
    /// [`Entry::style`](crate::chart::figure::Entry::style) of the competitor; 0 for a heat map.
    pub style: usize,
    /// Name of the competitor; empty for a heat map.
    pub name: String,
    /// Values in the unit of z; `None` where unknown.
    pub values: Vec<Option<Estimate>>,
}

/// A value with the lower and upper end of its 95 % interval.
pub type Estimate = (f64, Option<(f64, f64)>);

/// The winner of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Won {
    /// [`Entry::style`](crate::chart::figure::Entry::style) of the winner.
    pub style: usize,
    /// Its value.
    pub value: f64,
    /// Whether its interval ends below that of the next competitor. Unknown intervals count as having zero width.
    pub certain: bool,
}

impl Map {
    /// The value of each cell: the one shown, or that of the winner.
    fn values(&self) -> Vec<Option<f64>> {
        match &self.cells {
            Cells::Values(values) => values.clone(),
            Cells::Winners { won, .. } => won.iter().map(|won| won.map(|won| won.value)).collect(),
        }
    }

    /// Whether its values are only no and yes, as 0 and 1, and both occur.
    pub fn is_yes_or_no(&self) -> bool {
        let Cells::Values(values) = &self.cells else { return false };
        let known = || values.iter().flatten();
        known().all(|value| [0.0, 1.0].contains(value))
            && known().any(|value| *value == 0.0)
            && known().any(|value| *value == 1.0)
    }

    /// Number of cells with a value.
    pub fn known(&self) -> usize {
        self.values().iter().flatten().count()
    }

    /// Number of cells with a value within the limit; `None` without a limit.
    pub fn within_limit(&self) -> Option<usize> {
        let limit = self.limit.as_ref()?.value;
        Some(self.values().into_iter().flatten().filter(|value| *value <= limit).count())
    }
}

/// A fraction of all cells in percent, which is never rounded to all or none.
pub fn share(part: usize, cells: usize) -> String {
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

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn shares_are_never_rounded_to_all_or_none() {
        let shown: Vec<String> = [(0, 9), (1, 5000), (1, 300), (1, 3), (299, 300), (9, 9), (0, 0)]
            .map(|(part, cells)| share(part, cells))
            .into();
        assert_eq!(
            shown,
            [
                "no cells",
                "< 0.1 % of cells",
                "0.3 % of cells",
                "33 % of cells",
                "> 99.5 % of cells",
                "all cells",
                "no cells"
            ]
        );
    }
}
