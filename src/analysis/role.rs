//! The part that a column, and each filler, plays in the question of a study.

use sagnac_base::table::{Column, ColumnError, Role, Table};
use sagnac_engine::chart::Source;
use sagnac_engine::filler::FILLERS;
use sagnac_engine::kinds::KINDS;
use sagnac_engine::kinds::allan::columns::COEFFICIENT;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::columns::{Tuning, tuned};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::study::Study;

/// Whether a column is a condition instead of a choice: that of a key by its role, of others the names of coefficients.
pub(crate) fn is_given(column: &Column) -> bool {
    let name = if column.of.is_empty() { &column.name } else { &column.of };
    let keys = KINDS.iter().flat_map(|kind| (kind.keys)().into_iter().chain((kind.sweepable)()));
    keys.into_iter()
        .find(|key| key.name == *name)
        .map_or_else(|| name.starts_with(COEFFICIENT), |key| key.role.is_given())
}

/// The columns that distinguish rows, each once, after some `columns`.
pub(crate) fn apart<'t>(
    study: &Study,
    source: Source,
    table: &'t Table,
    mut columns: Vec<&'t Column>,
) -> Result<Vec<&'t Column>, ColumnError> {
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    for name in study.text_columns(source).into_iter().chain(sweeps) {
        if columns.iter().all(|column| column.name != name) {
            columns.push(table.column(name)?);
        }
    }
    Ok(columns)
}

/// Whether less of an estimate is better in all selected rows: its role says so, and none of its values is negative.
pub(crate) fn less_is_better(table: &Table, column: &Column, rows: &[usize]) -> bool {
    let estimate = if column.role == Role::Theory { table.referred(column) } else { Some(column) };
    let signed = rows.iter().any(|&row| column.value(row) < 0.0);
    estimate.is_some_and(|column| column.role.less_is_better()) && !signed
}

/// The fillers that are designed without a band, whose weights firmware cannot have: they follow the motion of each
/// point, or one motion to the last digit. For a motion that is drawn from a band, they are those of the band.
pub(crate) struct Bandless<'a> {
    /// The column of all fillers.
    pub(crate) column: &'a Column,
    pub(crate) names: Vec<&'a str>,
    /// What they are designed for.
    pub(crate) why: &'static str,
}

impl<'a> Bandless<'a> {
    pub(crate) fn of(study: &'a Study, table: &'a Table) -> Option<Bandless<'a>> {
        let column = table.listed_by(FILLERS)?;
        let fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
        let (tuning, names) = tuned(study, fill)?;
        let why = match tuning {
            Tuning::Points => "the very motion of each point",
            Tuning::Frequency => "exactly this motion",
        };
        Some(Bandless { column, names, why })
    }
}
