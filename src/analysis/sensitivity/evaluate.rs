//! Answers of a study at other values of its uncertain inputs.

use std::collections::HashMap;

use crate::analysis::sensitivity::SensitivityError;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::table::{Column, Role, Table};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::study::Study;
use sagnac_engine::tally::NORMAL_95;

/// Most points that are lowered and sampled together, whose tallies are held in memory.
const MAX_POINTS: usize = 512;

/// The evaluations that a sensitivity needs, in steps: a driver takes the study of some points by [`next`](Evaluations::next), makes
/// the table of its points, and gives it back by [`put`](Evaluations::put).
pub(crate) struct Evaluations {
    study: Study,
    keys: Vec<&'static Key>,
    /// The column of the answer.
    by: String,
    /// The row of each point, as pairs of a column and its value.
    pub(crate) rows: Vec<(String, String)>,
    /// The points that are now evaluated, and which of them each requested point is. A point that occurs repeatedly is evaluated
    /// once.
    points: Vec<Vec<SweepValue>>,
    places: Vec<usize>,
    /// The answers at the first of these points.
    answers: Vec<f64>,
    /// Number of evaluated points, and the sum over them of the squared standard errors of the answer.
    pub(crate) evaluated: u64,
    pub(crate) noise: f64,
}

impl Evaluations {
    pub(crate) fn new(
        study: Study,
        keys: Vec<&'static Key>,
        by: String,
        rows: Vec<(String, String)>,
    ) -> Evaluations {
        let (points, places, answers) = (vec![], vec![], vec![]);
        Evaluations { study, keys, by, rows, points, places, answers, evaluated: 0, noise: 0.0 }
    }

    /// Requests the answers at points, after those of earlier requests were [taken](Evaluations::take).
    pub(crate) fn request(&mut self, points: Vec<Vec<SweepValue>>) {
        let mut places: HashMap<Vec<u64>, usize> = HashMap::new();
        let bits = |value: &SweepValue| value.quantity().map_or(0, |quantity| quantity.value.to_bits());
        for point in points {
            let place = *places.entry(point.iter().map(bits).collect()).or_insert(self.points.len());
            self.places.push(place);
            if place == self.points.len() {
                self.points.push(point);
            }
        }
    }

    /// The study of the next points; `None` where all are evaluated.
    ///
    /// # Errors
    /// A point is outside the limits of its key or is not a valid one.
    pub(crate) fn next(&self) -> Result<Option<Study>, StudyError> {
        let points = self.next_points();
        (!points.is_empty()).then(|| self.study.at_points(&self.keys, points)).transpose()
    }

    /// Takes the answers from the table of the points that [`next`](Evaluations::next) gave. Returns the number of points.
    ///
    /// # Errors
    /// The choice of rows is wrong, or a point has no answer.
    pub(crate) fn put(&mut self, table: &Table) -> Result<usize, SensitivityError> {
        let points = self.next_points();
        let (column, rows) = chosen(table, &self.by, &self.rows, points.len())?;
        let answer = |(row, point): (&usize, &Vec<SweepValue>)| {
            let value = column.cells[*row].number();
            value.ok_or_else(|| SensitivityError::NoValue { column: column.header(), at: self.place(point) })
        };
        let answers = rows.iter().zip(points).map(answer).collect::<Result<Vec<f64>, SensitivityError>>()?;
        for row in rows {
            let error = match table.beside(column, Role::StandardError) {
                Some(errors) => errors.cells[row].number(),
                None => column.interval(row).map(|(low, high)| 0.5 * (high - low) / NORMAL_95),
            };
            self.noise += error.map_or(0.0, |error| error * error);
        }
        self.evaluated += answers.len() as u64;
        self.answers.extend(&answers);
        Ok(answers.len())
    }

    /// Takes the answers at the requested points, in their order, when all are evaluated.
    pub(crate) fn take(&mut self) -> Vec<f64> {
        let answers = std::mem::take(&mut self.answers);
        self.points.clear();
        self.places.drain(..).map(|place| answers[place]).collect()
    }

    fn next_points(&self) -> &[Vec<SweepValue>] {
        let rest = &self.points[self.answers.len()..];
        &rest[..rest.len().min(MAX_POINTS)]
    }

    /// The values at a point, for messages.
    fn place(&self, point: &[SweepValue]) -> String {
        let values = self.keys.iter().zip(point).map(|(key, value)| format!("{} = {value}", key.name));
        values.collect::<Vec<String>>().join(", ")
    }
}

/// The column of the answer and its row for each of some points.
///
/// # Errors
/// There is no such column or row, or each point has several rows.
pub(crate) fn chosen<'t>(
    table: &'t Table,
    by: &str,
    filter: &[(String, String)],
    points: usize,
) -> Result<(&'t Column, Vec<usize>), SensitivityError> {
    let (column, rows) = (table.column(by)?, table.rows_where(filter)?);
    if rows.len() == points {
        return Ok((column, rows));
    }
    let texts = table.columns.iter().filter(|column| column.role == Role::Key);
    let differ = |column: &&Column| {
        column.cells[rows[0]].number().is_none()
            && rows.iter().any(|row| column.cells[*row] != column.cells[rows[0]])
    };
    let choices = texts.filter(differ).map(|column| {
        let mut values: Vec<String> = Vec::new();
        for row in &rows {
            let text = column.cells[*row].text();
            if !values.contains(&text) {
                values.push(text);
            }
        }
        format!("{} is {}", column.name, values.join(", "))
    });
    Err(SensitivityError::SeveralRows(choices.collect::<Vec<String>>().join("; ")))
}
