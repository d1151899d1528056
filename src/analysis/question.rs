//! A question of a study: the rows that answer it, its options and conditions, and the order of options from the best one on. The
//! key of a column says whether its values are options, between which a designer chooses, or conditions, which are given.

use crate::view::CURVE;
use sagnac_base::diagnostics::listed;
use sagnac_base::table::{Cell, Column, ColumnError, Role, Table, Usual, grouped, worded};
use sagnac_engine::chart::{Limit, Source};
use sagnac_engine::filler::FILLERS;
use sagnac_engine::kinds::KINDS;
use sagnac_engine::kinds::allan::columns::COEFFICIENT;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::columns::{Tuning, tuned};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::study::Study;
use sagnac_report::answer::Reading;
use sagnac_report::answer::reading::{labelled, place, shown};

/// The rows that answer the question of a study.
pub(crate) struct Question<'t> {
    pub(crate) table: &'t Table,
    /// The abscissa of the curves, where there is one.
    pub(crate) x: Option<&'t Column>,
    /// The abscissa of its chart, which may follow from `x`.
    pub(crate) axis: Option<&'t Column>,
    /// The estimate.
    pub(crate) y: &'t Column,
    /// The columns between whose values a designer chooses.
    pub(crate) options: Vec<&'t Column>,
    /// The columns that are given.
    pub(crate) conditions: Vec<&'t Column>,
    pub(crate) rows: Vec<usize>,
    pub(crate) limit: Option<Limit>,
    /// Fillers that firmware cannot have.
    pub(crate) unusable: Option<Bandless<'t>>,
}

/// An option with its rows under each condition.
pub(crate) struct Choice {
    /// Its name in the table.
    pub(crate) name: String,
    /// Its name in a headline.
    pub(crate) long: String,
    /// Whether firmware can have it.
    pub(crate) is_usable: bool,
    /// Its rows under each condition, those of a curve by rising x.
    pub(crate) rows: Vec<Vec<usize>>,
}

impl<'t> Question<'t> {
    /// A question of some rows, which the columns `by` distinguish; columns of a single value do not count.
    pub(crate) fn new(
        study: &'t Study,
        table: &'t Table,
        x: Option<&'t Column>,
        y: &'t Column,
        by: Vec<&'t Column>,
        rows: Vec<usize>,
        limit: Option<Limit>,
    ) -> Question<'t> {
        let varies = |by: &&Column| rows.iter().any(|&row| by.cells[row] != by.cells[rows[0]]);
        let x = x.filter(varies);
        let by: Vec<&Column> = by.into_iter().filter(varies).collect();
        let (conditions, options) = by.into_iter().partition(|by| is_given(by));
        Question {
            table,
            x,
            axis: None,
            y,
            options,
            conditions,
            rows,
            limit,
            unusable: Bandless::new(study, table),
        }
    }

    /// The options with their rows; where there are none, the conditions take their place.
    pub(crate) fn choices(&self) -> Vec<Choice> {
        let (rows_by, columns_by) = self.sides();
        self.grouped_by(rows_by, columns_by)
    }

    /// The options with their rows, a single one without a name where there are none.
    pub(crate) fn under_conditions(&self) -> Vec<Choice> {
        self.grouped_by(&self.options, &self.conditions)
    }

    fn grouped_by(&self, options: &[&Column], conditions: &[&Column]) -> Vec<Choice> {
        let conditions = grouped(self.rows.iter().copied(), |row| key(conditions, row));
        let mut condition_of = vec![0; self.table.rows()];
        for (condition, (_, rows)) in conditions.iter().enumerate() {
            rows.iter().for_each(|&row| condition_of[row] = condition);
        }
        let choice = |(_, rows): (Vec<String>, Vec<usize>)| {
            let mut under = vec![vec![]; conditions.len()];
            rows.iter().for_each(|&row| under[condition_of[row]].push(row));
            if let Some(x) = self.x {
                under.iter_mut().for_each(|rows| rows.sort_by(|&a, &b| x.value(a).total_cmp(&x.value(b))));
            }
            Choice {
                name: name(options, rows[0]),
                long: long(options, rows[0]),
                is_usable: self.unusable.as_ref().is_none_or(|unusable| !unusable.has(rows[0])),
                rows: under,
            }
        };
        grouped(self.rows.iter().copied(), |row| key(options, row)).into_iter().map(choice).collect()
    }

    /// The columns whose values are the rows of the table, and those whose values are its columns.
    fn sides(&self) -> (&[&'t Column], &[&'t Column]) {
        match self.options.is_empty() {
            true => (&self.conditions, &[]),
            false => (&self.options, &self.conditions),
        }
    }

    /// The names of the conditions that are columns, in the order of [`choices`](Question::choices); a single empty one where there
    /// are none.
    pub(crate) fn columns(&self) -> Vec<String> {
        let (_, columns) = self.sides();
        let first = grouped(self.rows.iter().copied(), |row| key(columns, row));
        first.into_iter().map(|(_, rows)| name(columns, rows[0])).collect()
    }

    /// The heading of the rows, in front of columns by a further one.
    pub(crate) fn heading_by(&self, x: &Column) -> String {
        format!("{}, by {}", self.heading(), x.label)
    }

    /// The heading of the rows.
    pub(crate) fn heading(&self) -> String {
        let (rows, columns) = self.sides();
        let labels =
            |columns: &[&Column]| columns.iter().map(|column| column.label.clone()).collect::<Vec<_>>();
        match (&labels(rows)[..], &labels(columns)[..]) {
            (rows, []) => rows.join(", "),
            (rows, columns) => format!("{}, by {}", rows.join(", "), listed(columns)),
        }
    }

    /// The rows among `rows` whose estimate has a value.
    pub(crate) fn known(&self, rows: &[usize]) -> Vec<usize> {
        rows.iter().copied().filter(|&row| self.y.cells[row].number().is_some()).collect()
    }

    /// The label of the estimate.
    pub(crate) fn label(&self) -> String {
        worded(&self.y.label)
    }

    /// The size of the estimate in a row.
    pub(crate) fn size(&self, row: usize) -> f64 {
        self.y.magnitude(row)
    }

    /// The value of a row with its interval, as a magnitude where it has a limit.
    pub(crate) fn reading(&self, row: usize) -> Reading {
        match self.limit.is_some() {
            true => Reading::new(self.y, self.size(row), self.y.interval_of_magnitude(row)),
            false => Reading::of_row(self.y, row),
        }
    }

    /// The least value that the estimate of a row leaves, where there is one.
    pub(crate) fn least_beside(&self, row: usize) -> Option<Reading> {
        let least = self.table.beside(self.y, Role::Least)?;
        // Of several columns below one another, it is that of the first.
        let is_first = |curve: &Column| curve.cells[row] == curve.cells[0];
        self.table.column(CURVE).ok().is_none_or(is_first).then(|| Reading::of_row(least, row))
    }

    /// The row with the largest size among some.
    pub(crate) fn largest(&self, rows: &[usize]) -> Option<usize> {
        self.known(rows).into_iter().max_by(|&a, &b| self.size(a).total_cmp(&self.size(b)))
    }
}

/// What decides between options.
pub(crate) struct Rank {
    /// Whether firmware can have it.
    pub(crate) is_usable: bool,
    /// The conditions or points for which it is within the limit; 0 where that does not count.
    pub(crate) met: usize,
    /// The value of which less is better.
    pub(crate) cost: f64,
}

/// Sorts options from the best one on: usable ones first, then those that meet the limit most often, then the least costs. Equal
/// ones keep their order.
pub(crate) fn sort_best_first<T>(options: &mut [T], rank: impl Fn(&T) -> Rank) {
    options.sort_by(|a, b| {
        let [a, b] = [rank(a), rank(b)];
        b.is_usable.cmp(&a.is_usable).then(b.met.cmp(&a.met)).then(a.cost.total_cmp(&b.cost))
    });
}

fn key(columns: &[&Column], row: usize) -> Vec<String> {
    columns.iter().map(|column| column.cells[row].text()).collect()
}

/// The name of an option in a headline, a number after its label.
fn long(columns: &[&Column], row: usize) -> String {
    let known = columns.iter().filter(|column| column.cells[row] != Cell::Blank);
    known.map(|column| labelled(column, &column.cells[row])).collect::<Vec<_>>().join(", ")
}

/// The name of a row or a column of the table: without labels where a single column is enough.
fn name(columns: &[&Column], row: usize) -> String {
    match columns {
        [column] => shown(column, &column.cells[row]),
        columns => place(columns, row),
    }
}

/// The filter of the usual rows of a study; an empty one where the study omits them.
pub(crate) fn usual_filter(study: &Study, table: &Table) -> Vec<(String, String)> {
    Some(study.usual_rows()).filter(|rows| table.rows_where(rows).is_ok()).unwrap_or_default()
}

/// Whether a column is a condition instead of a choice: that of a key by its role, of others the names of coefficients.
pub(crate) fn is_given(column: &Column) -> bool {
    let name = if column.of.is_empty() { &column.name } else { &column.of };
    let keys = KINDS.iter().flat_map(|kind| (kind.keys)().into_iter().chain((kind.sweepable)()));
    keys.into_iter()
        .find(|key| key.name == *name)
        .map_or_else(|| name.starts_with(COEFFICIENT), |key| key.role.is_given())
}

/// The columns that distinguish rows, each once.
pub(crate) fn apart<'t>(
    study: &Study,
    source: Source,
    table: &'t Table,
) -> Result<Vec<&'t Column>, ColumnError> {
    let mut columns: Vec<&Column> = vec![];
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
    pub(crate) fn new(study: &'a Study, table: &'a Table) -> Option<Bandless<'a>> {
        let column = table.listed_by(FILLERS)?;
        let fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
        let (tuning, names) = tuned(study, fill)?;
        let why = match tuning {
            Tuning::Points => "the very motion of each point",
            Tuning::Frequency => "exactly this motion",
        };
        Some(Bandless { column, names, why })
    }

    /// Whether a row has one of them.
    pub(crate) fn has(&self, row: usize) -> bool {
        self.names.contains(&self.column.cells[row].text().as_str())
    }
}

/// The part of both values beside it that a notch stays below.
const DEPTH: f64 = 0.5;

/// Power of the averaging time that is steeper than any course of σ(τ), whose slopes are ±1 at most.
const STEEP: f64 = 1.5;

/// The averaging times at which a curve of some has a notch: a deterministic part of the angle, such as a sine or an alternating drift,
/// cancels where the averaging time is an even multiple of its period. The curve dips there to values that say nothing of its course,
/// and whether a grid of averaging times meets such a place is a coincidence. All curves leave them out, so that they are compared at the same
/// averaging times.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Notches {
    places: Vec<f64>,
}

impl Notches {
    /// The notches of curves of `y` over `x`, each with its rows by rising x. There are none over other abscissas than the
    /// averaging time.
    pub(crate) fn new<'r>(x: &Column, y: &Column, curves: impl Iterator<Item = &'r [usize]>) -> Notches {
        if x.usual != Some(Usual::Abscissa) {
            return Notches::default();
        }
        let at = |row: usize| [x.value(row), y.value(row).abs()];
        let is_notch = |three: &&[usize]| {
            let [before, here, after] = [three[0], three[1], three[2]].map(at);
            let is_below = |beside: [f64; 2]| {
                let step = libm::fabs(libm::log(beside[0] / here[0]));
                here[1] < beside[1] * DEPTH.min(libm::exp(-STEEP * step))
            };
            is_below(before) && is_below(after)
        };
        let places = curves.flat_map(|rows| rows.windows(3).filter(is_notch).map(|three| x.value(three[1])));
        Notches { places: places.collect() }
    }

    /// Whether there are any.
    pub(crate) fn are_any(&self) -> bool {
        !self.places.is_empty()
    }

    /// Whether a curve has a notch at this averaging time.
    pub(crate) fn are_at(&self, x: f64) -> bool {
        self.places.contains(&x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Cell;

    /// The notches of curves over 1, 2, 4, … s.
    fn notches<const N: usize>(curves: &[[f64; N]], usual: Option<Usual>) -> Vec<f64> {
        let column = |cells: Vec<f64>| Column {
            usual,
            cells: cells.into_iter().map(Cell::Number).collect::<Vec<_>>().into(),
            ..Column::default()
        };
        let x = column(curves.iter().flat_map(|_| (0..N).map(|at| f64::from(1 << at))).collect());
        let rows: Vec<Vec<usize>> =
            (0..curves.len()).map(|curve| (curve * N..(curve + 1) * N).collect()).collect();
        Notches::new(&x, &column(curves.concat()), rows.iter().map(Vec::as_slice)).places
    }

    #[test]
    fn a_dip_that_no_slope_leads_to_is_a_notch_and_a_valley_is_none() {
        let time = Some(Usual::Abscissa);
        // At 1, 2, 4, … s, with slopes of ±1, a dip, and one at the last place but one.
        let valley = [8.0, 4.0, 2.0, 1.0, 2.0, 4.0, 8.0];
        assert_eq!(notches(&[valley], time), [0.0; 0]);
        let dips = [9.0, 8.0, 7.0, 0.1, 5.0, 1.0, 4.5];
        assert_eq!(notches(&[valley, dips], time), [8.0, 32.0]);
        assert_eq!(notches(&[dips], None), [0.0; 0]);
        // The ends of a curve are no notches.
        assert_eq!(notches(&[[0.1, 9.0, 8.0, 7.0, 0.1]], time), [0.0; 0]);
    }
}
