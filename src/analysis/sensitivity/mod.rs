//! Sensitivity: how much of the uncertainty of an answer comes from each uncertain input of a study.
//!
//! ```text
//! study ─ distributions ─▶ points of a Sobol' sequence ─ lower, sample ─▶ answers ─▶ indices, tornado ─▶ which input decides
//! ```
//!
//! The inputs are independent. All points share their random numbers, so that what differs between answers is the effect
//! of the inputs; an answer in closed form is evaluated without sampling.
//!
//! ```
//! use sagnac::analysis::sensitivity::{Sensitivity, SensitivityRequest};
//! use sagnac::progress::Silent;
//! use sagnac::study::Study;
//! use sagnac::verify::select;
//!
//! let study = Study::parse("gap.toml", r#"
//!     title = "A gap"
//!     kind = "gap-fill"
//!     [gyro]
//!     tick = "5 ms"
//!     tick_noise = { std = "0.5 arcsec" }
//!     [motion]
//!     amplitude = "12000 arcsec/s"
//!     frequency = "5 Hz"
//!     [switching]
//!     gap_ticks = 3
//!     fillers = ["quadratic"]
//!     [[sensitivity]]
//!     key = "gyro.tick_noise.std"
//!     normal = { mean = "0.5 arcsec", sd = "0.05 arcsec" }
//!     [[sensitivity]]
//!     key = "motion.frequency"
//!     uniform = { from = "4 Hz", to = "6 Hz" }
//! "#)?;
//! let mut device = select("cpu", 2)?.device;
//! let by = Some("theory_rms".to_owned());
//! let request = SensitivityRequest { by, samples: Some(1024), ..SensitivityRequest::default() };
//! let found = Sensitivity::compute(&study, &request, &mut device, &Silent)?;
//! assert_eq!(found.decisive().key, "gyro.tick_noise.std");
//! assert!(found.decisive().index.first.value > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod report;
pub(crate) mod sobol;

use std::collections::HashMap;

use crate::analysis::design::Found;
use crate::analysis::design::optimum::PARTS;
use crate::analysis::page;
use crate::analysis::sensitivity::report::{Swings, count, joined, points_of_swings};
use crate::analysis::sensitivity::sobol::{indices, points, samples, share};
use crate::use_cases::Outcome;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::{Cells, Column, ColumnError, Role, Table, Usual};
use sagnac_engine::chart::{Chart, Limit, Source};
use sagnac_engine::device::Device;
use sagnac_engine::key::Key;
use sagnac_engine::key::sensitivity::{SENSITIVITY, Uncertain};
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::run::{Plan, RunError};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::{NORMAL_95, Share};
use sagnac_report::page::Provenance;

pub use crate::analysis::sensitivity::report::Input;
pub use crate::analysis::sensitivity::sobol::Index;

/// The request for a sensitivity, beside its study, which has the seed.
#[derive(Debug, Clone, Default)]
pub struct SensitivityRequest {
    /// Column of the points whose value is the answer. If absent, the one by which the study is judged.
    pub by: Option<String>,
    /// Rows of the points, as pairs of a column and its value; those shown by default where a column is not named.
    pub rows: Vec<(String, String)>,
    /// Number of samples, rounded up to 32 times a power of two. If absent, 8192, or 2048 for a sampled answer.
    pub samples: Option<u64>,
    /// Number of trials of each evaluation of a sampled answer; if absent, 4096, or more for few evaluations.
    pub trials: Option<u64>,
}

/// The result of an analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Column of the answer, without cells.
    pub answer: Column,
    /// Rows of the points, as pairs of a column and its value.
    pub rows: Vec<(String, String)>,
    /// Number of samples.
    pub samples: u64,
    /// Number of evaluations.
    pub evaluations: u64,
    /// Trials of each evaluation; absent for an answer in closed form.
    pub trials: Option<u64>,
    /// The answer with all inputs at their nominal values.
    pub nominal: f64,
    /// Mean of the answer.
    pub mean: Found,
    /// Standard deviation of the answer.
    pub sd: Found,
    /// Quantiles of the answer at [`LEVELS`].
    pub quantiles: [f64; 3],
    /// Limit of the study, with the part of all answers that is within it.
    pub within: Option<(Limit, Found)>,
    /// Part of the variance that is at most due to sampling; 0 for an answer in closed form.
    pub noise: f64,
    /// Effect of each input, in the order of the study.
    pub inputs: Vec<Input>,
    /// Notes on the results, each a sentence.
    pub notes: Vec<String>,
}

/// The levels of the quantiles of the answer.
pub const LEVELS: [f64; 3] = [0.05, 0.5, 0.95];

/// Samples where none are requested, for an answer in closed form and for a sampled one.
const SAMPLES: [u64; 2] = [8192, 2048];

/// log2 of the trials of all evaluations together where none are requested.
const ALL_TRIALS_LOG2: u32 = 27;

/// Fewest trials of an evaluation, below which a 99.73 % level has no interval.
const MIN_TRIALS: u64 = 4096;

/// Part of the variance from which on the Monte Carlo error is reported.
const REPORTED_NOISE: f64 = 0.01;

/// Finds which uncertain inputs decide the answer of a study: a page with the indices of the inputs, the tornado and the distribution
/// of the answer. `progress` counts evaluations.
///
/// # Errors
/// It fails where [`Sensitivity::compute`] does.
pub fn sensitivity(
    study: &Study,
    request: &SensitivityRequest,
    device: &mut Device,
    progress: &dyn Progress,
) -> Result<Outcome, SensitivityError> {
    let found = Sensitivity::compute(study, request, device, progress)?;
    let name = match &request.by {
        Some(_) => format!("sensitivity_{}", found.answer.name),
        None => "sensitivity".to_owned(),
    };
    let heading = format!("{} · {}", study.title, report::effort(&found));
    let provenance = found.trials.map(|trials| Provenance::new(study.seed, trials));
    Ok(Outcome { name, provenance, ..Outcome::new(heading, page::of_sensitivity(study, &found)) })
}

impl Sensitivity {
    /// Evaluates the answer and analyses it; `progress` counts evaluations.
    ///
    /// # Errors
    /// The study has no uncertain inputs or sweeps something, the answer does not exist or is constant, a point cannot be
    /// represented, or the device fails.
    pub fn compute(
        study: &Study,
        request: &SensitivityRequest,
        device: &mut Device,
        progress: &dyn Progress,
    ) -> Result<Sensitivity, SensitivityError> {
        let uncertain = &study.uncertain;
        if uncertain.is_empty() {
            return Err(SensitivityError::NoInputs);
        }
        if let Some(sweep) = study.sweeps.first() {
            return Err(SensitivityError::SweepValue(sweep.key.name));
        }
        let mut study = study.clone();
        let keys = uncertain.iter().map(|input| input.key).collect();
        let nominal: Vec<SweepValue> = uncertain.iter().map(|input| nominal(&study, input)).collect();
        let (answer, rows, is_exact) = question(&study, request)?;
        let samples = samples(request.samples.unwrap_or(SAMPLES[usize::from(!is_exact)]));
        let evaluations = samples * (uncertain.len() as u64 + 2) + count(uncertain.len());
        let usual = ((1 << ALL_TRIALS_LOG2) / evaluations).next_power_of_two().max(MIN_TRIALS);
        study.trials = request.trials.unwrap_or(usual);
        progress.start("evaluations", 0, evaluations);
        let by = answer.name.clone();
        let (inputs, seed) = (uncertain.len(), study.seed);
        let mut steps = Evaluations::new(study.clone(), keys, by, rows);
        let swings = points_of_swings(&nominal, uncertain);
        let swings = Swings::new(&drive(&mut steps, swings, is_exact, device, progress)?);
        let at = |point: &Vec<f64>| uncertain.iter().zip(point).map(|(input, u)| input.at(*u)).collect();
        let part = |part: u64| {
            let points = points(inputs, samples, part, seed).iter().map(at).collect();
            drive(&mut steps, points, is_exact, device, progress)
        };
        let parts = (0..PARTS).map(part).collect::<Result<Vec<Vec<f64>>, SensitivityError>>()?;
        let found = indices(inputs, &parts);
        let Some(found) = found else {
            let value = significant(swings.nominal, 4);
            return Err(SensitivityError::Constant { column: answer.header(), value });
        };
        let noise = steps.noise / steps.evaluated as f64 / (found.sd.value * found.sd.value);
        let mut all = found.answers.concat();
        all.sort_by(f64::total_cmp);
        let quantile = |level: f64| all[((level * all.len() as f64) as usize).min(all.len() - 1)];
        let limit = limit(&study, &answer);
        let within = limit.map(|limit| (limit, share(&found.answers, |y| y.abs() <= limit.value)));
        Ok(Sensitivity {
            rows: steps.rows,
            samples,
            evaluations,
            trials: (!is_exact).then_some(study.trials),
            nominal: swings.nominal,
            mean: found.mean,
            sd: found.sd,
            quantiles: LEVELS.map(quantile),
            within,
            noise,
            notes: notes(&study, uncertain, noise),
            inputs: joined(uncertain, &nominal, &found, swings),
            answer,
        })
    }

    /// The input with the largest total index.
    pub fn decisive(&self) -> &Input {
        self.by_total()[0]
    }

    /// The inputs by falling total index; there is at least one.
    pub fn by_total(&self) -> Vec<&Input> {
        let mut inputs: Vec<&Input> = self.inputs.iter().collect();
        inputs.sort_by(|a, b| b.index.total.value.total_cmp(&a.index.total.value));
        inputs
    }
}

/// The answers at points, sampled on a device where they are not in closed form.
fn drive(
    steps: &mut Evaluations,
    points: Vec<Vec<SweepValue>>,
    is_exact: bool,
    device: &mut Device,
    progress: &dyn Progress,
) -> Result<Vec<f64>, SensitivityError> {
    let mut repeated = points.len();
    steps.request(points);
    while let Some(study) = steps.next()? {
        let plan = Plan::new(&study)?;
        let table = if is_exact {
            plan.blank_tables().points
        } else {
            let mut store = Store::in_memory(&plan.identity());
            plan.run(&mut store, device, Share::WHOLE, &Silent)?;
            plan.tables(&store, &Silent)?.points
        };
        let evaluated = steps.put(&table)?;
        repeated -= evaluated;
        progress.advance(evaluated as u64);
    }
    progress.advance(repeated as u64);
    Ok(steps.take())
}

/// The value of an input that the study writes, else its median.
fn nominal(study: &Study, input: &Uncertain) -> SweepValue {
    let median = input.at(0.5);
    let same = |value: &SweepValue| value.unit() == median.unit();
    let written = study.values.iter().find(|(key, _)| std::ptr::eq(*key, input.key));
    written.map(|(_, value)| SweepValue::Quantity(*value)).filter(same).unwrap_or(median)
}

/// The column of the answer, without cells, the rows of the points, and whether the answer is known without sampling.
type Question = (Column, Vec<(String, String)>, bool);

/// The question that is asked of the study.
fn question(study: &Study, request: &SensitivityRequest) -> Result<Question, SensitivityError> {
    let table = Plan::new(study)?.blank_tables().points;
    let name = match &request.by {
        Some(name) => name,
        None => &table.usual(Usual::Answer).ok_or(SensitivityError::NoAnswer)?.name,
    };
    let mut rows = request.rows.clone();
    for (column, value) in study.usual_rows() {
        let own = table.column(&column)?;
        let is_same =
            |(name, _): &(String, String)| table.column(name).is_ok_and(|other| other.name == own.name);
        if !request.rows.iter().any(is_same) {
            rows.push((column, value));
        }
    }
    let (column, places) = chosen(&table, name, &rows, 1)?;
    let is_exact = study.kind().is_exact || column.cells[places[0]].number().is_some();
    Ok((Column { cells: Cells::default(), band: None, band_of_mean: None, ..column.clone() }, rows, is_exact))
}

/// The limit that the study requires of this answer, else that of the first chart that shows it and has one.
fn limit(study: &Study, answer: &Column) -> Option<Limit> {
    let required = study.requirement.filter(|required| answer.name == required.column);
    if let Some(required) = required {
        return Some(required.limit);
    }
    let shows = |chart: &&Chart| chart.source == Source::Points && answer.name == chart.y.name;
    study.charts.iter().filter(shows).find_map(|chart| chart.limit)
}

fn notes(study: &Study, uncertain: &[Uncertain], noise: f64) -> Vec<String> {
    let mut notes = study.notes.clone();
    notes.extend(uncertain.iter().filter_map(Uncertain::truncated));
    if noise > REPORTED_NOISE {
        notes.push(format!(
            "up to {} % of the variance is Monte Carlo error, which all evaluations share for the most part: more trials have less",
            significant(100.0 * noise, 2)
        ));
    }
    notes
}

/// Why an analysis is not possible.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    /// The study has no uncertain inputs.
    #[error("the study has no uncertain inputs")]
    NoInputs,
    /// This key is swept.
    #[error("{0} is swept: a sensitivity is of one point")]
    SweepValue(&'static str),
    /// The answer or its rows cannot be chosen.
    #[error(transparent)]
    Column(#[from] ColumnError),
    /// The study has no column by which it is judged.
    #[error("the study has no usual answer: choose one of its columns by `by = COLUMN`")]
    NoAnswer,
    /// Each point has several rows, which differ in this.
    #[error("each point has several answers: {0}; choose one by `where = COLUMN=VALUE`")]
    SeveralRows(String),
    /// The answer has no number at a point.
    #[error("{column} has no value at {at}; choose another answer by `by = COLUMN`")]
    NoValue {
        /// Column of the answer.
        column: String,
        /// Values at the point.
        at: String,
    },
    /// The answer is the same everywhere.
    #[error("{column} is {value} everywhere: it depends on none of the uncertain inputs")]
    Constant {
        /// Column of the answer.
        column: String,
        /// Its value.
        value: String,
    },
    /// A point is not valid.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The device failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl SensitivityError {
    /// The error at the place in the study that caused it; the same error where the study did not.
    ///
    /// # Errors
    /// The request, the answer or the device caused it.
    pub fn in_study(self, study: &Study) -> Result<StudyError, SensitivityError> {
        let at = |key: &str, help: &str| study.error_at(study.place_of(key), self.to_string(), help);
        Ok(match self {
            SensitivityError::NoInputs => at("kind", &format!("add one as in\n{}", SENSITIVITY.example)),
            SensitivityError::SweepValue(key) => {
                at(key, "give the key one value, or make it an uncertain input instead")
            }
            SensitivityError::Study(error) => error,
            other => return Err(other),
        })
    }
}

/// Most points that are lowered and sampled together, whose tallies are held in memory.
const MAX_POINTS: usize = 512;

/// The evaluations that a sensitivity needs, in steps: a driver takes the study of some points by [`next`](Evaluations::next), makes
/// the table of its points, and gives it back by [`put`](Evaluations::put).
struct Evaluations {
    study: Study,
    keys: Vec<&'static Key>,
    /// The column of the answer.
    by: String,
    /// The row of each point, as pairs of a column and its value.
    rows: Vec<(String, String)>,
    /// The points that are now evaluated, and which of them each requested point is. A point that occurs repeatedly is evaluated
    /// once.
    points: Vec<Vec<SweepValue>>,
    places: Vec<usize>,
    /// The answers at the first of these points.
    answers: Vec<f64>,
    /// Number of evaluated points, and the sum over them of the squared standard errors of the answer.
    evaluated: u64,
    noise: f64,
}

impl Evaluations {
    fn new(study: Study, keys: Vec<&'static Key>, by: String, rows: Vec<(String, String)>) -> Evaluations {
        let (points, places, answers) = (vec![], vec![], vec![]);
        Evaluations { study, keys, by, rows, points, places, answers, evaluated: 0, noise: 0.0 }
    }

    /// Requests the answers at points, after those of earlier requests were [taken](Evaluations::take).
    fn request(&mut self, points: Vec<Vec<SweepValue>>) {
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
    fn next(&self) -> Result<Option<Study>, StudyError> {
        let points = self.next_points();
        (!points.is_empty()).then(|| self.study.at_points(&self.keys, points)).transpose()
    }

    /// Takes the answers from the table of the points that [`next`](Evaluations::next) gave. Returns the number of points.
    ///
    /// # Errors
    /// The choice of rows is wrong, or a point has no answer.
    fn put(&mut self, table: &Table) -> Result<usize, SensitivityError> {
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
    fn take(&mut self) -> Vec<f64> {
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
fn chosen<'t>(
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
