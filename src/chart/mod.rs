//! The specification of a chart: what a study holds, and what is drawn. Columns are named, not yet looked up in a table.

pub mod columns;
pub mod file;
pub mod ground;
pub mod law;
pub(crate) mod read;
pub mod rows;
pub mod supplied;

use std::ops::Range;

pub use crate::chart::file::Source;
use crate::chart::law::Law;
use crate::key::given::Given;
use crate::key::scale::Scale;
use crate::quantity::number::significant;
use crate::table::{Cell, Unit};

/// A name of a column, and where it stands in the study, so that an unknown one can be pointed at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// As written: `q9973`, `motion.frequency`.
    pub name: String,
    /// Bytes of the text; empty at 0 for a name that is not written but a default.
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

/// One chart of a table: curves, or a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// In bold over the chart.
    pub title: String,
    /// A second, smaller line; may be empty.
    pub subtitle: String,
    /// The table that it draws.
    pub source: Source,
    /// The abscissa.
    pub x: Named,
    /// Of curves the estimate, of a map an axis like x. Bands are drawn, and the closed form where the table has one.
    pub y: Named,
    /// Further columns like y, each a curve of its own colour.
    pub beside: Vec<Named>,
    /// Curves or a map.
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the value: one of those it takes. A chart that is
    /// supplied has those of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// A line, in a unit that the estimate must have, and what the verdict is about.
    pub limit: Option<Limit>,
    /// Of the abscissa.
    pub x_scale: Scale,
    /// Of the ordinate.
    pub y_scale: Scale,
    /// The columns by which the rows of the table are told apart, such as swept keys: only one of them may vary along a
    /// curve. Empty: not checked.
    pub apart: Vec<String>,
    /// What the points are, for the legend: `Monte Carlo`, `measured`. Empty: not said.
    pub points: String,
    /// What the bands are: `95 % band`.
    pub bands: String,
}

impl Default for Chart {
    /// Curves without columns, over logarithmic axes.
    fn default() -> Chart {
        Chart {
            title: String::new(),
            subtitle: String::new(),
            source: Source::Points,
            x: "".into(),
            y: "".into(),
            beside: vec![],
            shows: Shows::Curves { series: vec![], laws: vec![] },
            rows: vec![],
            limit: None,
            x_scale: Scale::Log,
            y_scale: Scale::Log,
            apart: vec![],
            points: String::new(),
            bands: String::new(),
        }
    }
}

/// What is allowed of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Above 0.
    pub value: f64,
    /// Of the column that it is about.
    pub unit: Unit,
}

impl Limit {
    /// For sentences: `10 ″`, `5 %`.
    pub fn text(&self) -> String {
        match self.unit.symbol {
            "" => format!("{} %", significant(100.0 * self.value, 6)),
            symbol => format!("{} {symbol}", significant(self.value, 6)),
        }
    }
}

/// What a chart shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// y over x.
    Curves {
        /// At most two columns whose values make the curves: the first gives the colour, the second the dash. At most one, for
        /// the dash, where several columns are shown.
        series: Vec<Named>,
        /// Each once, angles in ″; with any, x of a study is a swept key or `dt_nu`.
        laws: Vec<Law>,
    },
    /// z by colour, over x and y.
    HeatMap {
        /// The column by colour.
        z: Named,
        /// Of the colours.
        z_scale: Scale,
    },
    /// Over x and y, which value of the column `of`, a swept key, `filler` or `error`, has the least z.
    WinnerMap {
        /// The column that competes, the least wins.
        z: Named,
        /// Who competes.
        of: Named,
    },
}

impl Chart {
    /// The column of the estimates.
    pub fn estimate(&self) -> &Named {
        match &self.shows {
            Shows::Curves { .. } => &self.y,
            Shows::HeatMap { z, .. } | Shows::WinnerMap { z, .. } => z,
        }
    }

    /// The columns that curves show: y and those beside it.
    pub fn columns(&self) -> impl Iterator<Item = &Named> {
        std::iter::once(&self.y).chain(&self.beside)
    }

    /// The columns whose values are told apart.
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

    /// The rows that are drawn: (column, value as files show it).
    pub fn filter(&self) -> Vec<(String, String)> {
        self.rows.iter().map(|(column, value)| (column.name.clone(), value.text())).collect()
    }

    /// The laws drawn beside curves.
    pub fn laws(&self) -> &[Law] {
        match &self.shows {
            Shows::Curves { laws, .. } => laws,
            Shows::HeatMap { .. } | Shows::WinnerMap { .. } => &[],
        }
    }
}
