//! The specification of a chart, as given in a study and as drawn. Columns are given by name and not yet looked up in a
//! table.

pub mod file;
pub(crate) mod ground;
pub mod law;
pub(crate) mod read;
pub(crate) mod rows;
pub(crate) mod supplied;

use std::ops::Range;

pub use crate::chart::file::Source;
use crate::chart::law::Law;
use crate::key::given::Given;
use crate::key::scale::Scale;
use sagnac_base::quantity::number::{joined, significant};
use sagnac_base::table::{Cell, Unit};

/// The name of a column, with its place in the study for messages about an unknown one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Named {
    /// Name as written, such as `p99_73` or `motion.frequency`.
    pub name: String,
    /// Bytes in the text; empty at 0 for a default that is not written.
    pub span: Range<usize>,
}

impl From<&str> for Named {
    fn from(name: &str) -> Named {
        Named { name: name.to_owned(), span: 0..0 }
    }
}

impl From<Given<'_>> for Named {
    fn from(given: Given) -> Named {
        Named { span: given.span(), name: given.text().to_owned() }
    }
}

/// One chart of a table: curves, or a map. By default it has curves without columns, over logarithmic axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chart {
    /// Title, in bold above the chart.
    pub title: String,
    /// A second, smaller line, which may be empty.
    pub subtitle: String,
    /// Source of the table.
    pub source: Source,
    /// Column of the abscissa.
    pub x: Named,
    /// Column of the ordinate: of curves the estimate, of a map an axis like x. Bands are drawn, and the closed form
    /// where the table has one.
    pub y: Named,
    /// Further columns like y, each drawn in its own colour.
    pub beside: Vec<Named>,
    /// Content: curves or a map.
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the given value. A supplied chart selects
    /// values of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// A limit in a unit of the estimate, which is drawn as a line and determines the verdict.
    pub limit: Option<Limit>,
    /// Scale of the abscissa.
    pub x_scale: Scale,
    /// Scale of the ordinate.
    pub y_scale: Scale,
    /// The columns that distinguish the rows of the table, such as swept keys; only one of them may vary along a curve.
    /// If empty, this is not checked.
    pub apart: Vec<String>,
    /// Name of the points in the legend, such as `Monte Carlo` or `measured`; empty for none.
    pub points: String,
    /// Name of the bands, such as `95 % band`.
    pub bands: String,
}

/// A limit of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Value, above 0.
    pub value: f64,
    /// Unit of the column to which it applies.
    pub unit: Unit,
}

impl Limit {
    /// Text for sentences, such as `10 ″` or `5 %`.
    pub fn text(&self) -> String {
        match self.unit {
            Unit::NONE => format!("{} %", significant(100.0 * self.value, 6)),
            // As axes have it.
            Unit::ARCSEC_PER_RT_S => joined(&significant(self.value / 60.0, 6), Unit::DEG_PER_SQRT_H.symbol),
            unit => joined(&significant(self.value, 6), unit.symbol),
        }
    }
}

/// A limit that a study as a whole must meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// Table of the limited estimate.
    pub source: Source,
    /// Column of the limited estimate.
    pub column: &'static str,
    /// The limit.
    pub limit: Limit,
}

/// The content of a chart.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// Curves of y over x.
    Curves {
        /// At most two columns whose values make the curves: the first sets the colour, the second the dash. With
        /// several columns y at most one, which sets the dash.
        series: Vec<Named>,
        /// Laws, each once, for angles in ″; with laws, x of a study is a swept key or `dt_nu`.
        laws: Vec<Law>,
    },
    /// A map of z by colour, over x and y.
    HeatMap {
        /// The column shown by colour.
        z: Named,
        /// Scale of the colours.
        z_scale: Scale,
    },
    /// A map over x and y of the value of the column `of`, a swept key, `filler` or `error`, that has the least z.
    WinnerMap {
        /// The compared column; the least value wins.
        z: Named,
        /// The column whose values compete.
        of: Named,
    },
}

impl Default for Shows {
    fn default() -> Shows {
        Shows::Curves { series: vec![], laws: vec![] }
    }
}

impl Chart {
    /// Column of the estimates.
    pub fn estimate(&self) -> &Named {
        match &self.shows {
            Shows::Curves { .. } => &self.y,
            Shows::HeatMap { z, .. } | Shows::WinnerMap { z, .. } => z,
        }
    }

    /// The columns that curves show: y and the further ones.
    pub fn columns(&self) -> impl Iterator<Item = &Named> {
        std::iter::once(&self.y).chain(&self.beside)
    }

    /// The columns whose values distinguish curves.
    pub fn series(&self) -> &[Named] {
        match &self.shows {
            Shows::Curves { series, .. } => series,
            Shows::HeatMap { .. } => &[],
            Shows::WinnerMap { of, .. } => std::slice::from_ref(of),
        }
    }

    /// The second line, if it has one.
    pub fn subtitle(&self) -> Option<String> {
        Some(self.subtitle.clone()).filter(|text| !text.is_empty())
    }

    /// The rows that are drawn, as pairs of a column and its value as files show it.
    pub fn filter(&self) -> Vec<(String, String)> {
        self.rows.iter().map(|(column, value)| (column.name.clone(), value.text())).collect()
    }

    /// The laws drawn with curves.
    pub fn references(&self) -> &[Law] {
        match &self.shows {
            Shows::Curves { laws, .. } => laws,
            Shows::HeatMap { .. } | Shows::WinnerMap { .. } => &[],
        }
    }
}
