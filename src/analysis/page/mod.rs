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

mod batch;
mod comparison;
mod design;
mod log;
mod model;
mod record;
mod spectrum;
mod study;

pub use crate::analysis::page::batch::of_batch;
pub use crate::analysis::page::comparison::of_comparison;
pub use crate::analysis::page::design::of_design;
pub use crate::analysis::page::design::of_filler;
pub use crate::analysis::page::design::of_sensitivity;
pub use crate::analysis::page::log::of_log;
pub use crate::analysis::page::model::of_model;
pub use crate::analysis::page::study::{PARTIAL, Results, add_sampled_facts};
pub use crate::analysis::page::study::{of_dynamic, of_navigators, of_temperature};

use crate::analysis::log::{Column, events};
use crate::view::picture::Drawn;
use sagnac_base::quantity::number::{significant, with_unit};
use sagnac_base::table::{self, Role, Table};
use sagnac_engine::study::Study;
use sagnac_records::allan::Minimum;
use sagnac_records::fit::Fit;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Section};

/// Significant digits of values.
const DIGITS: usize = 4;

/// The section on what records show besides noise.
fn shown(heading: &'static str, rows: &[events::Row]) -> Section {
    let grid = (!rows.is_empty()).then(|| Block::Grid(Grid::new(events::HEADING, events::list(rows))));
    Section::new("events", heading, grid)
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
    let is_blank =
        |column: &table::Column| (0..table.rows()).all(|row| column.cells[row] == table::Cell::Blank);
    let is_shown = |column: &&table::Column| {
        let is_end = matches!(column.role, Role::Lower | Role::Upper);
        !is_end && !omitted.contains(&column.name.as_str()) && !is_blank(column)
    };
    let shown: Vec<&table::Column> = table.columns.iter().filter(is_shown).collect();
    let end = |column: &table::Column, role: Role, row: usize| {
        let end = table.columns.iter().find(|end| end.role == role && end.of == column.name)?;
        end.cells[row].number()
    };
    let cell = |column: &table::Column, row: usize| {
        let ends = end(column, Role::Lower, row).zip(end(column, Role::Upper, row));
        let below = ends.map(|ends| interval(ends.into())).unwrap_or_default();
        Cell { text: column.cells[row].rounded(DIGITS), below }
    };
    let rows = (0..table.rows()).map(|row| shown.iter().map(|column| cell(column, row)).collect::<Vec<_>>());
    Grid::new(shown.iter().map(|column| column.title()), rows)
}

/// A value with its unit, if it has one.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    with_unit(value, DIGITS, unit)
}

/// The minimum of the first curve of rates, such as `0.01 °/h (0.009 … 0.012) at τ = 100 s`.
pub(crate) fn stability(column: &Column) -> Option<String> {
    let curve = column.curves.iter().find(|curve| !curve.deviation.is_of_angle())?;
    let Minimum { point, at_end } = curve.minimum?;
    let value = in_unit(point.value?, column.unit.symbol(curve.deviation));
    let ends = point.interval.map(|ends| format!(" ({})", interval(ends.into()))).unwrap_or_default();
    let end = if at_end { ", where the curve ends" } else { "" };
    Some(format!("{value}{ends} at τ = {} s{end}", significant(point.tau_s, DIGITS)))
}
