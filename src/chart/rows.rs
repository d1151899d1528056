//! The columns that can select rows and span axes, and the rows selected by a chart's `where`.

use std::ops::Range;

use crate::chart::Named;
use crate::chart::ground::Ground;
use crate::key::given::Given;
use crate::key::holds::{Holds, unlimited};
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, choices};
use crate::table::{self, Cell, Column, ColumnError, Unit};

/// Values of τ.
const TIMES: Holds = unlimited(&[Dimension::Time]);

/// Most values of a sweep that a message lists.
const MOST_LISTED: usize = 12;

/// Finds the column that `name` at `span` means among those that distinguish rows: a swept key, a text column, or τ.
///
/// # Errors
/// No column or several columns match; `cannot` begins the message, such as "`where` cannot choose rows by".
pub(crate) fn chooser(
    sweeps: &[Sweep],
    ground: &Ground,
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let texts = ground.texts.iter().map(|text| (text.name, Unit::NONE));
    let along = ground.along().map(|column| (column.name, column.unit));
    input(sweeps, &texts.chain(along).collect::<Vec<_>>(), name, span, cannot)
}

/// Finds the column that `name` at `span` means among the numeric columns known before anything is sampled: a swept
/// key, or one that follows from it.
///
/// # Errors
/// The same as for [`chooser`].
pub(crate) fn coordinate(
    sweeps: &[Sweep],
    ground: &Ground,
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let numbers: Vec<_> = ground.coordinates().map(|column| (column.name, column.unit)).collect();
    input(sweeps, &numbers, name, span, cannot)
}

/// Finds the column that `name` means among the swept keys and some `more`.
fn input(
    sweeps: &[Sweep],
    more: &[(&str, Unit)],
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, Swept::unit);
    let swept = sweeps.iter().map(|sweep| (sweep.key.name, unit(sweep)));
    let columns: Vec<Column> = swept
        .chain(more.iter().copied())
        .map(|(name, unit)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit,
            ..Column::default()
        })
        .collect();
    let found = table::find(&columns, name).map_err(|error| match error {
        ColumnError::Ambiguous { .. } => {
            Fault::new(span, error.to_string(), "more than one", "write the whole name")
        }
        _ => {
            let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            let label = match more {
                [] => "not swept".to_owned(),
                more => {
                    let names: Vec<&str> = more.iter().map(|(name, _)| *name).collect();
                    format!("neither swept nor {}", names.join(" nor "))
                }
            };
            Fault::new(span, format!("{cannot} `{name}`"), label, choices(name, &known))
        }
    })?;
    Ok(found.name.clone())
}

/// The column that one entry of `where` names, with its value there.
pub(crate) fn row(
    name: &Named,
    value: Given,
    sweeps: &[Sweep],
    ground: &Ground,
) -> Result<(String, Cell), Fault> {
    let column = chooser(sweeps, ground, &name.name, name.span.clone(), "`where` cannot choose rows by")?;
    let cell = if let Some(sweep) = sweeps.iter().find(|sweep| sweep.key.name == column) {
        swept_value(sweep, value)?.cell()
    } else if let Some(values) = ground.values(&column) {
        text(&column, value, values.iter().map(String::as_str))?
    } else {
        // Whether the table has that τ is found out when the chart is drawn without estimates.
        value.read(&TIMES)?.into()
    };
    Ok((column, cell))
}

/// The value of a sweep that tables show like the given one.
fn swept_value<'s>(sweep: &'s Sweep, given: Given) -> Result<&'s Swept, Fault> {
    let wanted = match sweep.key.is_name() {
        true => Swept::Name(given.text().to_owned()),
        false => Swept::Quantity(given.of(sweep.key).quantity()?),
    };
    let is_meant =
        |value: &&Swept| value.unit() == wanted.unit() && value.cell().text() == wanted.cell().text();
    sweep.values.iter().find(is_meant).ok_or_else(|| {
        let listed: Vec<String> = sweep.values.iter().take(MOST_LISTED).map(Swept::to_string).collect();
        let more = if sweep.values.len() > MOST_LISTED { ", …" } else { "" };
        let message = format!("no point has {} = {wanted}", sweep.key.name);
        let help = format!("accepted: {}{more}", listed.join(", "));
        given.fault(message, "not among the swept values", help)
    })
}

/// One of the values of a text column.
fn text<'a>(column: &str, given: Given, known: impl Iterator<Item = &'a str>) -> Result<Cell, Fault> {
    let known: Vec<&str> = known.collect();
    if given.is_text() && known.contains(&given.text()) {
        return Ok(Cell::Text(given.text().to_owned()));
    }
    let message = format!("no row has {column} = {given}");
    Err(given.fault(message, "not in this study", choices(given.text(), &known)))
}
