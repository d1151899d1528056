//! What comes back beside a picture, and why there is none.

use crate::table::ColumnError;
#[cfg(doc)]
use crate::view::chart::figure::Figure;

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

/// What the reader of a map should be told besides.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MapNotes {
    /// Rows without x or y, or with one that its axis cannot show.
    pub off_axes: usize,
    /// Cells without a row of the table, or without one for each series that competes.
    pub no_row: usize,
    /// Cells with rows, but without a value, or without that of each series that competes.
    pub blank: usize,
    /// Cells with a value that the colours cannot show: not positive on a logarithmic scale.
    pub left_out: usize,
    /// Series that have the same values throughout: `const = linear`.
    pub merged: Vec<String>,
    /// Where there is a limit: cells within it, and cells with a value.
    pub within_limit: Option<(usize, usize)>,
}

impl MapNotes {
    /// One sentence, or none if there is nothing to say.
    pub fn sentence(&self) -> Option<String> {
        let counted = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let parts = [
            self.within_limit
                .map(|(within, known)| format!("{within} of the {known} cells are within the limit")),
            counted(self.off_axes, "of the rows have no place on these axes"),
            counted(self.no_row, "of the cells have no point: x and y do not vary independently"),
            counted(self.blank, "of the cells have no value"),
            counted(self.left_out, "of the cells have a value that a logarithmic scale cannot show"),
            (!self.merged.is_empty()).then(|| format!("the same in every cell: {}", self.merged.join("; "))),
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
