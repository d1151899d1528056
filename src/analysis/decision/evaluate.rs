//! Values of an estimate at points of a study, with common random numbers, and the error budget that follows from them.

use crate::analysis::decision::best_option::BestOption;
use crate::analysis::decision::{DecisionError, Figure};
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::table::{Column, Role, Table};
use sagnac_engine::device::Device;
use sagnac_engine::run::{Plan, RunError};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;

/// Number of parts of the trials, whose scatter gives the intervals.
const PARTS: u64 = 16;

/// Half the width of a 95 % interval in standard errors of 16 parts: Student's t with 15 degrees of freedom.
const T_95: f64 = 2.131_450;

/// Most trials of a point, as a decision needs no more figures.
pub(crate) const MAX_TRIALS: u64 = 1 << 17;

/// Most steps of the trials of a point, so that a decision takes seconds beside a long study.
const MAX_STEPS: u64 = 1 << 24;

/// Fewest trials that tell a level of 99.73 %.
const MIN_TRIALS: u64 = 1 << 12;

/// Most steps of the fewest trials of a point, or of all if there are less; beyond it there is no value.
const TOO_MANY_STEPS: u64 = 1 << 29;

/// Part of the trials that is enough to compare mean squares.
const SCREENED: u64 = 8;

/// The value of an estimate at a point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Value {
    pub(crate) value: f64,
    /// The values of parts of the trials; all points have the same parts. Empty for closed forms, which are exact, and
    /// where the parts are too small.
    parts: Vec<f64>,
}

impl Value {
    /// The upper end of the 95 % interval of the size of the value; the size itself where there is no interval.
    pub(crate) fn upper(&self) -> f64 {
        let (value, interval) = self.with(self, |value, _| value.abs());
        interval.map_or(value, |(_, high)| high)
    }

    /// A function of this value and another one, with its 95 % interval where the values have parts.
    pub(crate) fn with(&self, other: &Value, of: impl Fn(f64, f64) -> f64) -> (f64, Option<(f64, f64)>) {
        let value = of(self.value, other.value);
        let parts: Vec<f64> = self.parts.iter().zip(&other.parts).map(|(a, b)| of(*a, *b)).collect();
        if parts.len() < PARTS as usize {
            return (value, None);
        }
        let count = parts.len() as f64;
        let mean = parts.iter().sum::<f64>() / count;
        let squares: f64 = parts.iter().map(|part| (part - mean) * (part - mean)).sum();
        let half = T_95 * libm::sqrt(squares / (count * (count - 1.0)));
        (value, Some((value - half, value + half)))
    }
}

/// The effort for a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effort {
    /// Few trials, enough to compare mean squares, without an interval.
    Screening,
    /// A value with the scatter of its parts.
    Parts,
}

/// Evaluates one row of a study's table at other points.
pub(crate) struct Evaluator<'a> {
    pub(crate) device: &'a mut Device,
    /// Place of the row among those of its point.
    pub(crate) row: usize,
    /// Receives the number of evaluations.
    pub(crate) progress: &'a dyn Progress,
    /// Evaluations that are done, and that are expected.
    pub(crate) count: [u64; 2],
}

impl Evaluator<'_> {
    /// So many more evaluations are to come, at most.
    pub(crate) fn expect(&mut self, more: usize) {
        self.count[1] += more as u64;
        self.progress.start("evaluations", self.count[0], self.count[1]);
    }

    /// The values of a column at all points of a study whose points share their random numbers: in closed form where
    /// it has one at every point, else sampled. `None` where an estimate is missing, or costs too much to sample.
    ///
    /// # Errors
    /// A point cannot be represented, or the processor fails.
    pub(crate) fn values(
        &mut self,
        study: &Study,
        points: usize,
        column: &str,
        effort: Effort,
    ) -> Result<Option<Vec<Value>>, DecisionError> {
        self.count[0] += 1;
        match self.count[0] <= self.count[1] {
            true => self.progress.advance(1),
            // One more than was expected.
            false => self.expect(1),
        }
        let (subject, row) = study.subject.only(self.row).unwrap_or((study.subject.clone(), self.row));
        let mut study = study.clone();
        study.subject = subject;
        let plan = Plan::new(&study)?;
        // Closed forms need no trials, but a kind may compute them only beside a store.
        let blank = plan.tables(&Store::in_memory(&plan.identity()), &Silent)?.points;
        if let Some(exact) = closed(&blank, points, row, column) {
            return Ok(Some(exact));
        }
        let Some(steps) = plan.steps_of_a_trial() else { return Ok(None) };
        let of_point = (steps / points as u64).max(1);
        if of_point > TOO_MANY_STEPS / study.trials.clamp(1, MIN_TRIALS) {
            return Ok(None);
        }
        let most = (MAX_STEPS / of_point).clamp(MIN_TRIALS, MAX_TRIALS);
        let most = if effort == Effort::Screening { most / SCREENED } else { most };
        let mut study = study.clone();
        study.trials = study.trials.min(most);
        let plan = Plan::new(&study)?;
        let estimates = |store: &Store| -> Result<Option<Vec<f64>>, DecisionError> {
            let table = plan.tables(store, &Silent)?.points;
            Ok(table.column(column).ok().and_then(|column| of_rows(&table, points, row, column)))
        };
        // The parts together are the whole.
        let mut whole = Store::in_memory(&plan.identity());
        let count = if effort == Effort::Parts { PARTS } else { 1 };
        let mut parts = vec![];
        for share in (1..=count).filter_map(|number| Share::new(number, count)) {
            let mut store = Store::in_memory(&plan.identity());
            plan.run(&mut store, self.device, share, &Silent)?;
            if effort == Effort::Parts {
                parts.push(estimates(&store)?);
            }
            whole.copy_from(&store).map_err(RunError::from)?;
        }
        let Some(whole) = estimates(&whole)? else { return Ok(None) };
        let parts: Vec<Vec<f64>> = parts.into_iter().collect::<Option<_>>().unwrap_or_default();
        // Points take turns in the shares: the same part of the trials is in another share for each.
        let share = |point: usize, part: usize| (part + parts.len() - point % parts.len()) % parts.len();
        let of_point = |(point, &value): (usize, &f64)| Value {
            value,
            parts: (0..parts.len()).map(|part| parts[share(point, part)][point]).collect(),
        };
        Ok(Some(whole.iter().enumerate().map(of_point).collect()))
    }
}

/// The closed form of a column in the row of every point, from a table without trials: the column itself, or one beside it.
fn closed(table: &Table, points: usize, row: usize, column: &str) -> Option<Vec<Value>> {
    let column = table.column(column).ok()?;
    let all = [Some(column), table.beside(column, Role::Theory)];
    let values = all.into_iter().flatten().find_map(|column| of_rows(table, points, row, column))?;
    Some(values.into_iter().map(|value| Value { value, parts: vec![] }).collect())
}

/// The cells of a column in the row of every point.
fn of_rows(table: &Table, points: usize, row: usize, column: &Column) -> Option<Vec<f64>> {
    let rows = table.rows() / points;
    (0..points).map(|point| column.cells.get(point * rows + row)?.number()).collect()
}

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
    choice: &BestOption,
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
