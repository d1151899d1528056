//! What a chart of a table is asked for, and what comes back beside the figure.

#[cfg(doc)]
use crate::table::Table;
use crate::table::{ColumnError, Unit};
#[cfg(doc)]
use crate::view::chart::figure::Figure;
use crate::view::chart::scale::Scale;

/// Which columns make a chart, and how. Columns are named as [`Table::column`] understands them.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// In bold over the chart.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The column along the horizontal axis.
    pub x: String,
    /// The column along the vertical axis. Its bands are drawn, and as its closed form the column `oracle_<y>`, where the table has it.
    pub y: String,
    /// How the horizontal axis is divided.
    pub x_scale: Scale,
    /// How the vertical axis is divided.
    pub y_scale: Scale,
    /// At most two columns that split the rows into curves: the first by colour, the second by dash and marker.
    pub series: Vec<String>,
    /// The columns by which the rows of the table are told apart, such as swept keys: only one of them may vary along a
    /// curve. Empty: not checked.
    pub apart: Vec<String>,
    /// Only rows with this value in this column are shown: (column, value as files show it).
    pub filter: Vec<(String, String)>,
    /// A horizontal line, in a unit that y must have.
    pub limit: Option<(f64, Unit)>,
    /// Columns with laws to be drawn beside the curves, angles in ″: y must be one. Their labels stand in the legend.
    pub laws: Vec<String>,
    /// What the points are, for the legend: `Monte Carlo`, `measured`. Empty: not said.
    pub points: String,
    /// What the bands are: `95 % band`.
    pub bands: String,
}

/// What the reader of a chart should be told besides.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// Points that the axes cannot show, as [`Figure::left_out`] counts them.
    pub left_out: usize,
    /// Rows of the chart without x or without y.
    pub blank: usize,
    /// Entries that stand for several curves because they coincide: `const = linear`.
    pub merged: Vec<String>,
    /// Single curves that coincide: `const, 1 and linear, 1`.
    pub coincident: Vec<String>,
}

impl Notes {
    /// One sentence, or none if there is nothing to say.
    pub fn sentence(&self) -> Option<String> {
        let counted = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let equal: Vec<&str> = self.merged.iter().chain(&self.coincident).map(String::as_str).collect();
        let parts = [
            counted(
                self.left_out,
                "of the points cannot be shown on these axes (not positive or not finite)",
            ),
            counted(self.blank, "of the rows have no value"),
            (!equal.is_empty()).then(|| format!("curves that coincide: {}", equal.join("; "))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("{}.", parts.join("; ")))
    }
}

/// Why a table makes no such chart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChartError {
    /// A name that selects no single column, or a filter that leaves nothing.
    #[error(transparent)]
    Column(#[from] ColumnError),
    /// More than two columns to tell curves apart.
    #[error("{found} columns are to tell the curves apart; a chart has one for colour and one for dash")]
    TooManySeries {
        /// How many were named.
        found: usize,
    },
    /// A column of text for an axis.
    #[error("`{column}` holds text such as `{example}`; an axis needs numbers")]
    NotNumbers {
        /// Its header.
        column: String,
        /// One of its texts.
        example: String,
    },
    /// A column is two of the curves.
    #[error("`{column}` stands twice among the columns of y")]
    Twice {
        /// As it is named the second time.
        column: String,
    },
    /// Both axes of a map show the same.
    #[error("`{column}` is both x and y; a map needs two different columns")]
    SameAxes {
        /// As y names it.
        column: String,
    },
    /// Rows on one curve that belong on several.
    #[error("one curve{} runs through rows that differ in {column} ({})", of_curve(curve), values.join(", "))]
    MixedCurve {
        /// What tells the curve from the others: `filler = const`; empty for the only one.
        curve: String,
        /// The column besides that along which the curve runs.
        column: String,
        /// Two of its values there.
        values: Vec<String>,
    },
    /// Several rows on one cell of a map.
    #[error("several rows fall on one cell of the map, as at {cell}{}", differing(column.as_deref(), values))]
    SeveralRows {
        /// The values of the axes there: `dt_nu = 0.1, motion.amplitude = 5`.
        cell: String,
        /// The first column in which two of the rows differ.
        column: Option<String>,
        /// Their values there.
        values: Vec<String>,
    },
    /// A limit or a law in one unit beside estimates in another.
    #[error("`{column}` is {}, a {beside} {} cannot be drawn on it", in_unit(unit), in_words(wanted))]
    OtherUnit {
        /// The name of the column of the estimates.
        column: String,
        /// The symbol of its unit; empty for a pure number.
        unit: String,
        /// `limit` or `law`.
        beside: &'static str,
        /// The symbol of its unit; empty for a pure number.
        wanted: &'static str,
    },
}

fn differing(column: Option<&str>, values: &[String]) -> String {
    column.map_or(String::new(), |column| format!(": they differ in {column} ({})", values.join(", ")))
}

fn of_curve(curve: &str) -> String {
    if curve.is_empty() { String::new() } else { format!(", that of {curve},") }
}

fn in_unit(unit: &str) -> String {
    if unit.is_empty() { "a number without unit".to_owned() } else { format!("in {unit}") }
}

fn in_words(unit: &str) -> String {
    if unit.is_empty() { "in percent".to_owned() } else { format!("in {unit}") }
}
