//! Simulated records.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sagnac::use_cases::{MotionText, Numbers, SimulateError, SimulateRequest, Simulation};

use sagnac::record::write::Form;

use super::argument::word;
use super::compute::compute_on;
use super::failure::{Failure, in_python};

/// Which records are wanted, and as which numbers.
#[derive(FromPyObject)]
pub struct Wanted {
    step_s: Option<f64>,
    length_s: Option<f64>,
    at: Vec<String>,
    seed: Option<u64>,
    /// Path and text of a motion.
    motion: Option<(String, String)>,
    data: String,
    first: u64,
    records: usize,
    threads: usize,
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Failure {
        match error {
            SimulateError::Study(error) => Failure::Study(error),
            SimulateError::Request(message) => Failure::Usage(in_python(&message)),
        }
    }
}

/// Records of a noise or a study, from a file, or from its text if there is no `path`: a row for each.
#[pyfunction]
#[pyo3(signature = (path, text, wanted))]
pub fn simulate<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (values, samples) = compute_on(py, wanted.threads, || {
        let numbers = word("data", &wanted.data, &Numbers::NAMED)?;
        let request = SimulateRequest {
            sample_s: wanted.step_s,
            length_s: wanted.length_s,
            at: wanted.at.clone(),
            seed: wanted.seed,
            motions: wanted
                .motion
                .iter()
                .map(|(name, text)| MotionText { axis: 0, name: name.clone(), text: text.clone() })
                .collect(),
            ..SimulateRequest::default()
        };
        let simulation = match &path {
            Some(path) => Simulation::read(path, &request)?,
            None => Simulation::parse("given", &text, &request)?,
        };
        simulation.check(numbers, Form::Raw)?;
        let samples = simulation.samples() as usize;
        let mut values: Vec<f64> = Vec::new();
        let has_room = samples.checked_mul(wanted.records).map(|count| values.try_reserve_exact(count));
        if !matches!(has_room, Some(Ok(()))) {
            let message = format!("{} records of {samples} samples do not fit into memory", wanted.records);
            return Err(Failure::Usage(message + "\ntake fewer at a time with records= and first="));
        }
        values.resize(samples * wanted.records, 0.0);
        values.par_chunks_mut(samples).enumerate().for_each(|(row, values)| {
            let numbers = simulation.numbers(wanted.first + row as u64, 0, numbers);
            values.iter_mut().zip(numbers).for_each(|(place, value)| *place = value);
        });
        Ok((values, samples))
    })?;
    PyArray1::from_vec(py, values).reshape([wanted.records, samples])
}
