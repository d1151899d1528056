//! Charts as asked for: names of columns, not yet looked up in a table.

use std::ops::Range;

use toml::Spanned;

use super::diagnose::{Fault, choices};
use super::file::{ChartTable, Charts, Error, Scale};
use super::filler::Filler;
use super::key::FREQUENCY;
use super::scalar::{self, Scalar};
use super::sweep::Sweep;
use super::units::{Dimension, Quantity};
use crate::table::{self, Cell, Column, ColumnError, Unit};

/// The columns of text that `where` may name besides swept keys.
const FILLER: &str = "filler";
const ERROR: &str = "error";

/// Most values of a sweep that a message lists.
const MOST_LISTED: usize = 12;

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
    /// Only rows in which each column, a swept key, `filler` or `error`, has the value: one of those it takes.
    pub rows: Vec<(Named, Cell)>,
    /// Allowed error, ″, above 0.
    pub limit_arcsec: Option<f64>,
    pub x_scale: Scale,
    pub y_scale: Scale,
}

/// The charts of a study: those written, or one that suits the sweeps.
///
/// # Errors
/// Not one or two `series`, a `limit` that is no angle above 0, a `where` that names another column than a swept key,
/// `filler` and `error`, or a value that it does not take.
pub(super) fn read_all(charts: Charts, sweeps: &[Sweep], fillers: &[Filler]) -> Result<Vec<Chart>, Fault> {
    let read = |table| read(table, sweeps, fillers);
    match charts {
        Charts::Default => Ok(default_for(sweeps).into_iter().collect()),
        Charts::One(table) => Ok(vec![read(*table)?]),
        Charts::Several(tables) => tables.into_iter().map(read).collect(),
    }
}

fn read(table: ChartTable, sweeps: &[Sweep], fillers: &[Filler]) -> Result<Chart, Fault> {
    let series: Vec<Named> = match table.series {
        None => vec![Named::default(FILLER)],
        Some(names) if (1..=2).contains(&names.get_ref().len()) => {
            names.into_inner().into_iter().map(Named::from).collect()
        }
        Some(names) => {
            let message = format!("series names {} columns", names.get_ref().len());
            let help = "accepted: one name (colour) or two (colour, dash), as in [\"filler\", \"gap_ticks\"]";
            return Err(Fault::new(names.span(), message, "not one or two names", help));
        }
    };
    let limit = table.limit.as_ref().map(limit).transpose()?;
    let mut rows = Vec::new();
    let mut chosen: Vec<String> = Vec::new();
    for (name, value) in table.rows.unwrap_or_default() {
        let (column, cell) = row(&name, &value, sweeps, fillers)?;
        if chosen.contains(&column) {
            let message = format!("`where` gives {column} twice");
            return Err(Fault::new(name.span(), message, "one of the two", "leave one of them out"));
        }
        chosen.push(column);
        rows.push((Named::from(name), cell));
    }
    // Without a word on errors a curve would jump between the two.
    if chosen.iter().all(|column| column != ERROR) && series.iter().all(|named| named.name != ERROR) {
        rows.extend(only_residuals());
    }
    Ok(Chart {
        title: table.title,
        x: table.x.into(),
        y: table.y.into(),
        series,
        rows,
        limit_arcsec: limit,
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
    let series = std::iter::once(FILLER).chain(names.first().copied());
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
    vec![(Named::default(ERROR), Cell::Text(Error::Residual.name().to_owned()))]
}

/// A limit in ″.
fn limit(given: &Spanned<Scalar>) -> Result<f64, Fault> {
    let limit = scalar::quantity("chart.limit", given, &[Dimension::Angle])?;
    if limit.value > 0.0 {
        return Ok(limit.value);
    }
    let message = format!("chart.limit = {limit}, and no error stays within that");
    Err(Fault::new(given.span(), message, "not above 0", "accepted: an angle above 0, or no limit"))
}

/// The column that one entry of `where` names, and its value there.
fn row(
    name: &Spanned<String>,
    value: &Spanned<Scalar>,
    sweeps: &[Sweep],
    fillers: &[Filler],
) -> Result<(String, Cell), Fault> {
    let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, |value| value.dimension.unit());
    let swept = sweeps.iter().map(|sweep| (sweep.key.name, unit(sweep)));
    let columns: Vec<Column> = swept
        .chain([(FILLER, Unit::NONE), (ERROR, Unit::NONE)])
        .map(|(name, unit)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit,
            cells: vec![],
            band: None,
        })
        .collect();
    let column = table::find(&columns, name.get_ref()).map_err(|error| match error {
        ColumnError::Ambiguous { .. } => {
            Fault::new(name.span(), error.to_string(), "more than one", "write the whole name")
        }
        _ => {
            let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            let message = format!("`where` cannot choose rows by `{}`", name.get_ref());
            let label = "neither swept nor filler nor error";
            Fault::new(name.span(), message, label, choices(name.get_ref(), &known))
        }
    })?;
    let cell = match sweeps.iter().find(|sweep| sweep.key.name == column.name) {
        Some(sweep) => swept_value(sweep, value)?.cell(),
        None if column.name == FILLER => text(FILLER, value, fillers.iter().map(|filler| filler.name.as_str()))?,
        None => text(ERROR, value, Error::ALL.iter().map(|error| error.name()))?,
    };
    Ok((column.name.clone(), cell))
}

/// The value of a sweep that is meant: the one which tables show like the one given.
fn swept_value(sweep: &Sweep, given: &Spanned<Scalar>) -> Result<Quantity, Fault> {
    let wanted = sweep.key.read(given)?;
    let is_meant = |value: &&Quantity| {
        value.dimension == wanted.dimension && value.cell().text() == wanted.cell().text()
    };
    sweep.values.iter().find(is_meant).copied().ok_or_else(|| {
        let listed: Vec<String> = sweep.values.iter().take(MOST_LISTED).map(Quantity::to_string).collect();
        let more = if sweep.values.len() > MOST_LISTED { ", …" } else { "" };
        let message = format!("no point has {} = {wanted}", sweep.key.name);
        let help = format!("accepted: {}{more}", listed.join(", "));
        Fault::new(given.span(), message, "not among the swept values", help)
    })
}

/// One of the texts that a column takes.
fn text<'a>(
    column: &str,
    given: &Spanned<Scalar>,
    known: impl Iterator<Item = &'a str>,
) -> Result<Cell, Fault> {
    let known: Vec<&str> = known.collect();
    match given.get_ref() {
        Scalar::Text(text) if known.contains(&text.as_str()) => Ok(Cell::Text(text.clone())),
        other => {
            let found = if let Scalar::Text(text) = other { text } else { "" };
            let message = format!("no row has {column} = {other}");
            Err(Fault::new(given.span(), message, "not in this study", choices(found, &known)))
        }
    }
}
