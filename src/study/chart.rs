//! Charts as asked for: names of columns, not yet looked up in a table.

use std::ops::Range;

use toml::Spanned;

use super::diagnose::Fault;
use super::file::{ChartTable, Charts, Scale};
use super::key::FREQUENCY;
use super::scalar::{self, Scalar};
use super::sweep::Sweep;
use super::units::{self, Dimension};
use crate::table::Cell;

/// A name of a column, and where it stands in the study, so that an unknown one can be pointed at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    pub name: String,
    /// Bytes of the text; empty at 0 for a name that is not written but a default.
    pub span: Range<usize>,
}

impl Named {
    fn default(name: &str) -> Named {
        Named { name: name.to_owned(), span: 0..0 }
    }
}

impl From<Spanned<String>> for Named {
    fn from(name: Spanned<String>) -> Named {
        Named { span: name.span(), name: name.into_inner() }
    }
}

/// One chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Absent: the study's.
    pub title: Option<String>,
    pub x: Named,
    pub y: Named,
    /// One or two columns whose values make the curves: the first gives the colour, the second the dash.
    pub series: Vec<Named>,
    /// Only rows in which each column has the value; quantities are in base units, rounded as those of points are.
    pub rows: Vec<(Named, Cell)>,
    /// Allowed error, ″.
    pub limit_arcsec: Option<f64>,
    pub x_scale: Scale,
    pub y_scale: Scale,
}

/// The charts of a study: those written, or one that suits the sweeps.
pub(super) fn read_all(charts: Charts, sweeps: &[Sweep]) -> Result<Vec<Chart>, Fault> {
    match charts {
        Charts::Default => Ok(default_for(sweeps).into_iter().collect()),
        Charts::One(table) => Ok(vec![read(*table)?]),
        Charts::Several(tables) => tables.into_iter().map(read).collect(),
    }
}

fn read(table: ChartTable) -> Result<Chart, Fault> {
    let series = match table.series {
        None => vec![Named::default("filler")],
        Some(names) if (1..=2).contains(&names.get_ref().len()) => {
            names.into_inner().into_iter().map(Named::from).collect()
        }
        Some(names) => {
            let message = format!("series names {} columns", names.get_ref().len());
            let help = "accepted: one name (colour) or two (colour, dash), as in [\"filler\", \"gap_ticks\"]";
            return Err(Fault::new(names.span(), message, "not one or two names", help));
        }
    };
    let limit =
        table.limit.map(|limit| scalar::quantity("chart.limit", &limit, &[Dimension::Angle])).transpose()?;
    let rows = table.rows.map_or_else(only_residuals, |rows| {
        rows.into_iter().map(|(name, value)| (Named::from(name), cell(value.into_inner()))).collect()
    });
    Ok(Chart {
        title: table.title,
        x: table.x.into(),
        y: table.y.into(),
        series,
        rows,
        limit_arcsec: limit.map(|limit| limit.value),
        x_scale: table.x_scale,
        y_scale: table.y_scale,
    })
}

/// Over Δt·ν if the frequency is swept, else over the first swept key; nothing to draw if none is.
fn default_for(sweeps: &[Sweep]) -> Option<Chart> {
    let mut names: Vec<&str> = sweeps.iter().map(|sweep| sweep.key.name).collect();
    let x = match names.iter().position(|name| *name == FREQUENCY.name) {
        Some(frequency) => {
            names.remove(frequency);
            "dt_nu"
        }
        None if names.is_empty() => return None,
        None => names.remove(0),
    };
    let series = std::iter::once("filler").chain(names.first().copied());
    Some(Chart {
        title: None,
        x: Named::default(x),
        y: Named::default("rms"),
        series: series.map(Named::default).collect(),
        rows: only_residuals(),
        limit_arcsec: None,
        x_scale: Scale::default(),
        y_scale: Scale::default(),
    })
}

fn only_residuals() -> Vec<(Named, Cell)> {
    vec![(Named::default("error"), Cell::Text("residual".to_owned()))]
}

fn cell(value: Scalar) -> Cell {
    match value {
        Scalar::Text(text) => match units::parse_any(&text) {
            Ok(quantity) => quantity.cell(),
            Err(_) => Cell::Text(text),
        },
        Scalar::Integer(i) => Cell::Integer(i),
        Scalar::Float(x) => Cell::Number(x),
        Scalar::Bool(b) => Cell::Text(b.to_string()),
    }
}
