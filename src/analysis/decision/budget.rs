//! The error budget: what is left of the error without each of its parts.

use crate::analysis::decision::choice::Choice;
use crate::analysis::decision::evaluate::{Effort, Evaluator};
use crate::analysis::decision::{DecisionError, Figure};
use sagnac_base::table::{Column, Role, Table};
use sagnac_engine::study::Study;

/// A part of the error.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// The fraction of the mean square that is gone without it. Fractions of independent parts add up to 1.
    pub share: Figure,
}

/// The parts of the error at the chosen row, the largest first; empty where its kind has no parts, or they cost too much
/// to sample.
pub(crate) fn budget(
    study: &Study,
    table: &Table,
    choice: &Choice,
    evaluator: &mut Evaluator,
) -> Result<Vec<Part>, DecisionError> {
    let Some((names, dissected)) = study.dissected(choice.point) else { return Ok(vec![]) };
    let points = names.len() + 1;
    if let [name] = names[..] {
        return Ok(vec![Part { name, share: Figure { value: 1.0, interval: None } }]);
    }
    let column = &mean_square(table, choice.column).name;
    let squares = match evaluator.values(&dissected, points, column, Effort::Parts) {
        Ok(Some(found)) => found,
        // Nothing is left of some points without one of their parts.
        Ok(None) | Err(DecisionError::Study(_)) => return Ok(vec![]),
        Err(error) => return Err(error),
    };
    let part = |(at, name): (usize, &&'static str)| Part {
        name,
        share: squares[at + 1]
            .with(&squares[0], |without, whole| 1.0 - (without / whole) * (without / whole))
            .into(),
    };
    let mut parts: Vec<Part> = names.iter().enumerate().map(part).collect();
    parts.sort_by(|a, b| b.share.value.total_cmp(&a.share.value));
    Ok(parts)
}

/// The column whose square adds up over independent parts: the error to which the judged one refers, else the first error in
/// its unit that has a closed form, such as the rms; where there is none, the judged column.
pub(crate) fn mean_square<'t>(table: &'t Table, judged: &'t Column) -> &'t Column {
    let referred =
        table.referred(judged).filter(|column| judged.role == Role::Error && column.role == Role::Error);
    let fits = |column: &&Column| {
        let is_alike = column.role == Role::Error && column.unit == judged.unit;
        is_alike && table.beside(column, Role::Theory).is_some()
    };
    referred.or_else(|| table.columns.iter().find(fits)).unwrap_or(judged)
}
