//! The pages of studies and analyses: that of a log, which `sagnac allan` writes, of two which are compared, of a batch, of a
//! model for filters, of a design, of fillers and of a sensitivity.
//!
//! ```text
//! Temperature ─ of_temperature ──┐
//! Dynamic ─ of_dynamic ──────────┴▶ Sections ─┐
//! Log, Analysis with its spectra ─────────────┴ of_log ─▶ Page
//! a curve that was read ──────────────── of_curve ─▶ Page
//! two Logs, their comparison ──────────── of_comparison ─▶ Page
//! Batch, Hat, Design, Firmware ─── of_batch, of_hat, of_design, of_filler ─▶ Page
//! models for filters ─────────────────────────── of_model ─▶ Page
//! Sensitivity ────────────────────────── of_sensitivity ─▶ Page
//! store and tables of a study ─ Results ──────────── page ─▶ Page
//! ```

mod comparison;
mod design;
mod log;
mod model;
mod record;
mod study;

pub use crate::analysis::page::comparison::{of_batch, of_comparison, of_hat};
pub use crate::analysis::page::design::{of_design, of_filler, of_sensitivity};
pub use crate::analysis::page::log::{of_curve, of_dynamic, of_log, of_navigators, of_temperature};
pub use crate::analysis::page::model::of_model;
pub(crate) use crate::analysis::page::study::{Results, agreement};

use crate::analysis::log::{Column, events};
use crate::view::Drawn;
use sagnac_base::quantity::number::{probability, significant, with_unit};
use sagnac_base::table::{self, Role, Table, grouped};
use sagnac_engine::study::Study;
use sagnac_records::allan::Minimum;
use sagnac_records::fit::Fit;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Section};

/// Significant digits of values.
const DIGITS: usize = 4;

/// The section on what records show besides noise.
fn shown(heading: &'static str, rows: &[events::Row]) -> Section {
    let table = (!rows.is_empty()).then(|| events::table_of(rows));
    Section::new("events", heading, table.map(|table| Block::Grid(grid(&table, &[]))))
}

/// The text of a study, with this number of trials.
fn study_file(study: &Study, trials: u64) -> Block {
    Block::File("study.toml".to_owned(), study.resolved(trials))
}

fn chart(stem: &str, picture: Picture) -> Block {
    Block::Chart(Drawn { stem: stem.to_owned(), picture, note: None })
}

/// The range of a fit.
pub(crate) fn range(fit: &Fit) -> String {
    let [from, to] = fit.tau_range.map(|tau_s| significant(tau_s, DIGITS));
    format!("τ from {from} s to {to} s")
}

/// An interval such as `0.199 … 0.201`.
pub(crate) fn interval(ends: [f64; 2]) -> String {
    ends.map(|end| significant(end, DIGITS)).join(" … ")
}

/// A table to read, with the ends of an interval below its value; without columns of these names, and those without values.
pub(crate) fn grid(table: &Table, omitted: &[&str]) -> Grid {
    grid_where(table, omitted, |_| true)
}

/// A [`grid`] of some rows.
pub(crate) fn grid_where(table: &Table, omitted: &[&str], is_meant: impl Fn(usize) -> bool) -> Grid {
    let rows: Vec<usize> = (0..table.rows()).filter(|row| is_meant(*row)).collect();
    let is_shown = |column: &&table::Column| {
        let is_end = matches!(column.role, Role::Lower | Role::Upper);
        let has_value = || rows.iter().any(|&row| !cell(table, column, row).text.is_empty());
        !is_end && !omitted.contains(&column.name.as_str()) && has_value()
    };
    let shown: Vec<&table::Column> = table.columns.iter().filter(is_shown).collect();
    let row = |&row: &usize| shown.iter().map(|column| cell(table, column, row)).collect::<Vec<_>>();
    Grid::new(shown.iter().map(|column| heading(column)), rows.iter().map(row))
}

/// A grid with the records of a table side by side: a row for each different text of the columns `keys`, with a cell for each
/// text of `column`, which has its `value`, or its bound above the first words of its status.
pub(crate) fn side_by_side(table: &Table, keys: &[&str], is_meant: impl Fn(usize) -> bool) -> Grid {
    let keys: Vec<&table::Column> = keys.iter().filter_map(|key| table.column(key).ok()).collect();
    let [records, status] = ["column", "status"].map(|name| texts(table, name));
    let rows = || (0..table.rows()).filter(|row| is_meant(*row));
    let key = |row: usize| keys.iter().map(|column| cell(table, column, row).text).collect::<Vec<String>>();
    let names = grouped(rows(), |row| records[row].clone());
    let value = table.column("value").ok();
    let of_record = |row: usize| {
        let cell = value.map_or_else(Cell::default, |value| cell(table, value, row));
        let has_bound = cell.below.is_empty() && cell.text.starts_with(['≤', '–']);
        let below = status.get(row).filter(|_| has_bound).and_then(|status| status.split(',').next());
        Cell { below: below.map_or(cell.below, str::to_owned), ..cell }
    };
    let line = |(key, rows): (Vec<String>, Vec<usize>)| {
        let cells = names.iter().map(|(name, _)| {
            rows.iter().find(|&&row| records[row] == *name).map_or_else(Cell::default, |&row| of_record(row))
        });
        key.into_iter().map(Cell::from).chain(cells).collect::<Vec<_>>()
    };
    let head = keys.iter().map(|column| heading(column)).chain(names.iter().map(|(name, _)| name.clone()));
    Grid::new(head, grouped(rows(), key).into_iter().map(line))
}

/// A value above its interval. One that is not known, with an interval from 0, has its upper limit instead.
fn cell(table: &Table, column: &table::Column, row: usize) -> Cell {
    let end = |role: Role| {
        let end = table.columns.iter().find(|end| end.role == role && end.of == column.name)?;
        end.cells[row].number()
    };
    let ends = end(Role::Lower).zip(end(Role::Upper));
    let below = ends.map(|ends| interval(ends.into())).unwrap_or_default();
    match (&column.cells[row], ends) {
        (table::Cell::Blank, Some((0.0, most))) => format!("≤ {}", significant(most, DIGITS)).into(),
        (table::Cell::Blank, Some(_)) => Cell { text: "–".to_owned(), below },
        (value, _) => Cell { text: text(column, value), below },
    }
}

/// The heading of a column; a label that is a name has no better words.
fn heading(column: &table::Column) -> String {
    match column.label == column.name {
        true => column.title().replace('_', " ").replace("tau", "τ").replace("alpha", "α"),
        false => column.title(),
    }
}

/// A value to read: a count with all its digits, a time or a frequency with enough of them to be found in the record.
fn text(column: &table::Column, value: &table::Cell) -> String {
    match (value, &*column.name) {
        (table::Cell::Integer(count), _) => count.to_string(),
        (table::Cell::Number(p), "p" | "p_equal") => {
            probability(*p).trim_start_matches("p = ").trim_start_matches("p ").to_owned()
        }
        (_, "unit") => symbol(&value.text()),
        _ if column.unit == table::Unit::S && column.role == Role::Coordinate => value.rounded(7),
        _ if column.unit == table::Unit::HZ => value.rounded(5),
        _ => value.rounded(DIGITS),
    }
}

/// A unit of files as people write it, such as `°/√h` for `deg/sqrt(h)`.
fn symbol(unit: &str) -> String {
    const SYMBOLS: [(&str, &str); 6] =
        [("arcsec", "″"), ("deg", "°"), ("sqrt(h)", "√h"), ("sqrt(s)", "√s"), ("ug", "µg"), ("^2", "²")];
    SYMBOLS.iter().fold(unit.to_owned(), |unit, (written, symbol)| unit.replace(written, symbol))
}

/// The texts of a column of a table.
pub(crate) fn texts(table: &Table, name: &str) -> Vec<String> {
    table.column(name).map_or(vec![], |column| column.cells.iter().map(table::Cell::text).collect())
}

/// The minimum of the first curve of rates, such as `0.01 °/h (0.009 … 0.012) at τ = 100 s`; its upper bound where the curve still falls.
pub(crate) fn minimum(column: &Column) -> Option<String> {
    let (curve, &Minimum { point, at_end }) = column.minimum()?;
    let (symbol, tau) = (column.unit.symbol(curve.deviation), significant(point.tau_s, DIGITS));
    if at_end {
        let most = in_unit(point.interval?.1, symbol);
        return Some(format!("at most {most}: the curve still falls at τ = {tau} s"));
    }
    let ends = point.interval.map(|ends| format!(" ({})", interval(ends.into()))).unwrap_or_default();
    Some(format!("{}{ends} at τ = {tau} s", in_unit(point.value?, symbol)))
}

/// A value with its unit, if it has one.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    with_unit(value, DIGITS, unit)
}
