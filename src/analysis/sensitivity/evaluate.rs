//! Answers of a study at other values of its uncertain inputs.

use std::collections::HashMap;

use crate::analysis::sensitivity::SensitivityError;
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::table::{Column, Role, Table};
use sagnac_engine::device::Device;
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::run::Plan;
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::{NORMAL_95, Share};

/// Most points that are lowered and sampled together, whose tallies are held in memory.
const MAX_POINTS: usize = 512;

/// Evaluates the answer of a study at points.
pub(crate) struct Evaluator<'a> {
    pub(crate) study: &'a Study,
    pub(crate) keys: Vec<&'static Key>,
    /// The column of the answer.
    pub(crate) by: String,
    /// The row of each point, as pairs of a column and its value.
    pub(crate) rows: Vec<(String, String)>,
    pub(crate) device: &'a mut Device,
    pub(crate) progress: &'a dyn Progress,
    /// Whether the answer is known without sampling.
    pub(crate) is_exact: bool,
    /// Number of evaluated points, and the sum over them of the squared standard errors of the answer.
    pub(crate) evaluated: u64,
    pub(crate) noise: f64,
}

impl Evaluator<'_> {
    /// The answers at points, in their order. A point that occurs repeatedly is evaluated once.
    ///
    /// # Errors
    /// A point cannot be represented, the choice of rows is wrong, or the device fails.
    pub(crate) fn at(&mut self, points: &[Vec<SweepValue>]) -> Result<Vec<f64>, SensitivityError> {
        let mut places: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut different: Vec<Vec<SweepValue>> = Vec::new();
        let bits = |value: &SweepValue| value.quantity().map_or(0, |quantity| quantity.value.to_bits());
        let place_of = |point: &Vec<SweepValue>| {
            *places.entry(point.iter().map(bits).collect()).or_insert_with(|| {
                different.push(point.clone());
                different.len() - 1
            })
        };
        let of_points: Vec<usize> = points.iter().map(place_of).collect();
        let mut answers = Vec::with_capacity(different.len());
        for some in different.chunks(MAX_POINTS) {
            answers.extend(self.of_some(some)?);
            self.progress.advance(some.len() as u64);
        }
        self.progress.advance((points.len() - different.len()) as u64);
        Ok(of_points.into_iter().map(|place| answers[place]).collect())
    }

    fn of_some(&mut self, points: &[Vec<SweepValue>]) -> Result<Vec<f64>, SensitivityError> {
        let study = self.study.at_points(&self.keys, points)?;
        let table = self.table(&study)?;
        let (column, rows) = chosen(&table, &self.by, &self.rows, points.len())?;
        for &row in &rows {
            let error = match table.beside(column, Role::StandardError) {
                Some(errors) => errors.cells[row].number(),
                None => column.interval(row).map(|(low, high)| 0.5 * (high - low) / NORMAL_95),
            };
            self.noise += error.map_or(0.0, |error| error * error);
        }
        self.evaluated += points.len() as u64;
        let answer = |(row, point): (usize, &Vec<SweepValue>)| {
            let value = column.cells[row].number();
            value.ok_or_else(|| SensitivityError::NoValue { column: column.header(), at: self.place(point) })
        };
        rows.into_iter().zip(points).map(answer).collect()
    }

    fn table(&mut self, study: &Study) -> Result<Table, SensitivityError> {
        let plan = Plan::new(study)?;
        if self.is_exact {
            return Ok(plan.blank_tables().points);
        }
        let mut store = Store::in_memory(&plan.identity());
        plan.run(&mut store, self.device, Share::WHOLE, &Silent)?;
        Ok(plan.tables(&store, &Silent)?.points)
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
