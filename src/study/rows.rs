//! Which columns choose rows and span axes, and the rows that a chart's `where` chooses.

use std::ops::Range;

use toml::Spanned;

use super::diagnose::{Fault, choices};
use super::file::Error;
use super::filler::Filler;
use super::scalar::Scalar;
use super::sweep::Sweep;
use super::units::Quantity;
use crate::table::{self, Cell, Column, ColumnError, Unit};

/// The columns of text that `where` may name besides swept keys.
pub(super) const FILLER: &str = "filler";
pub(super) const ERROR: &str = "error";

/// The column of Δt·ν, which follows from the inputs of a point.
pub(super) const DT_NU: &str = "dt_nu";

/// The column of A_Ω·T/σ, which does too.
const AMPLITUDE_NOISE: &str = "amplitude_noise";

/// Most values of a sweep that a message lists.
const MOST_LISTED: usize = 12;

/// The column by which rows are told apart that `name` at `span` means: a swept key, `filler` or `error`.
///
/// # Errors
/// It means no such column, or several; `cannot` begins the message: "`where` cannot choose rows by".
pub(super) fn chooser(
    sweeps: &[Sweep],
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    input(sweeps, &[FILLER, ERROR], name, span, cannot)
}

/// The column of numbers known before anything is sampled that `name` at `span` means: a swept key, `dt_nu` or
/// `amplitude_noise`.
///
/// # Errors
/// As those of [`chooser`].
pub(super) fn coordinate(
    sweeps: &[Sweep],
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    input(sweeps, &[DT_NU, AMPLITUDE_NOISE], name, span, cannot)
}

/// The column that `name` means among the swept keys and some `more`.
fn input(
    sweeps: &[Sweep],
    more: &[&str],
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, |value| value.dimension.unit());
    let swept = sweeps.iter().map(|sweep| (sweep.key.name, unit(sweep)));
    let columns: Vec<Column> = swept
        .chain(more.iter().map(|name| (*name, Unit::NONE)))
        .map(|(name, unit)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit,
            cells: vec![],
            band: None,
        })
        .collect();
    let found = table::find(&columns, name).map_err(|error| match error {
        ColumnError::Ambiguous { .. } => {
            Fault::new(span, error.to_string(), "more than one", "write the whole name")
        }
        _ => {
            let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            let label = format!("neither swept nor {}", more.join(" nor "));
            Fault::new(span, format!("{cannot} `{name}`"), label, choices(name, &known))
        }
    })?;
    Ok(found.name.clone())
}

/// The column that one entry of `where` names, and its value there.
pub(super) fn row(
    name: &Spanned<String>,
    value: &Spanned<Scalar>,
    sweeps: &[Sweep],
    fillers: &[Filler],
) -> Result<(String, Cell), Fault> {
    let column = chooser(sweeps, name.get_ref(), name.span(), "`where` cannot choose rows by")?;
    let cell = match sweeps.iter().find(|sweep| sweep.key.name == column) {
        Some(sweep) => swept_value(sweep, value)?.cell(),
        None if column == FILLER => text(FILLER, value, fillers.iter().map(|filler| filler.name.as_str()))?,
        None => text(ERROR, value, Error::ALL.iter().map(|error| error.name()))?,
    };
    Ok((column, cell))
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
