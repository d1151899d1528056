//! The pages of studies and analyses: that of a log, which `sagnac allan` writes, of two which are compared, of a batch, of a
//! model for filters, of a design, of fillers and of a sensitivity.
//!
//! ```text
//! Temperature ─ of_temperature ──┐
//! Dynamic ─ of_dynamic ──────────┴▶ Sections ─┐
//! Log, Analysis with its spectra ─────────────┴ of_log ─▶ Page
//! two Logs, their comparison ──────────── of_comparison ─▶ Page
//! Batch, Design, Firmware ─── of_batch, of_design, of_filler ─▶ Page
//! models for filters ─────────────────────────── of_model ─▶ Page
//! Sensitivity ────────────────────────── of_sensitivity ─▶ Page
//! store and tables of a study ─ Results ──────────── page ─▶ Page
//! ```

mod comparison;
mod design;
mod log;
mod model;
mod record;
mod spectrum;
mod study;

pub use crate::analysis::page::comparison::{of_batch, of_comparison};
pub use crate::analysis::page::design::of_design;
pub use crate::analysis::page::design::of_filler;
pub use crate::analysis::page::design::of_sensitivity;
pub use crate::analysis::page::log::{of_dynamic, of_log, of_navigators, of_temperature};
pub use crate::analysis::page::model::of_model;
pub use crate::analysis::page::study::{PARTIAL, Results, add_sampled_facts};

use crate::analysis::log::events;
use crate::view::picture::Drawn;
use sagnac_base::quantity::number::{probability, significant, with_unit};
use sagnac_base::table::{self, Role, Table};
use sagnac_engine::study::Study;
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

/// A [`grid`] of some rows. A value that is not known, with an interval from 0, has its upper limit instead.
pub(crate) fn grid_where(table: &Table, omitted: &[&str], is_meant: impl Fn(usize) -> bool) -> Grid {
    let rows: Vec<usize> = (0..table.rows()).filter(|row| is_meant(*row)).collect();
    let end = |column: &table::Column, role: Role, row: usize| {
        let end = table.columns.iter().find(|end| end.role == role && end.of == column.name)?;
        end.cells[row].number()
    };
    let cell = |column: &table::Column, row: usize| {
        let ends = end(column, Role::Lower, row).zip(end(column, Role::Upper, row));
        let below = ends.map(|ends| interval(ends.into())).unwrap_or_default();
        match (&column.cells[row], ends) {
            (table::Cell::Blank, Some((0.0, most))) => format!("≤ {}", significant(most, DIGITS)).into(),
            (table::Cell::Blank, Some(_)) => Cell { text: "–".to_owned(), below },
            (value, _) => Cell { text: text(column, value), below },
        }
    };
    let is_shown = |column: &&table::Column| {
        let is_end = matches!(column.role, Role::Lower | Role::Upper);
        let has_value = || rows.iter().any(|&row| !cell(column, row).text.is_empty());
        !is_end && !omitted.contains(&column.name.as_str()) && has_value()
    };
    let shown: Vec<&table::Column> = table.columns.iter().filter(is_shown).collect();
    let row = |&row: &usize| shown.iter().map(|column| cell(column, row)).collect::<Vec<_>>();
    // A label that is a name has no better words.
    let title = |column: &&table::Column| match column.label == column.name {
        true => column.title().replace('_', " ").replace("tau", "τ"),
        false => column.title(),
    };
    Grid::new(shown.iter().map(title), rows.iter().map(row))
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

/// A value with its unit, if it has one.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    with_unit(value, DIGITS, unit)
}
