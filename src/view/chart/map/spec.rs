//! What a map of a table is asked for, and what comes back beside it.

#[cfg(doc)]
use crate::table::Table;

use crate::table::Unit;
use crate::view::chart::scale::Scale;

/// Which columns make a map, and how. Columns are named as [`Table::column`] understands them.
#[derive(Debug, Clone, PartialEq)]
pub struct MapSpec {
    /// In bold over the map.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The column along the horizontal axis.
    pub x: String,
    /// The column along the vertical axis.
    pub y: String,
    /// The column that is shown, or whose least value wins.
    pub z: String,
    /// How the horizontal axis is divided.
    pub x_scale: Scale,
    /// How the vertical axis is divided.
    pub y_scale: Scale,
    /// What is shown of z.
    pub show: Show,
    /// Only rows with this value in this column are shown: (column, value as files show it).
    pub filter: Vec<(String, String)>,
    /// An angle in ″: z must be one.
    pub limit: Option<(f64, Unit)>,
}

/// What a map shows of its column z.
#[derive(Debug, Clone, PartialEq)]
pub enum Show {
    /// The value, by a colour that is divided like this.
    Values(Scale),
    /// Which value of this column has the least z.
    Winners(String),
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
