//! Simulated records.

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use sagnac::use_cases::{
    MotionText, Numbers, Sensitivity, SimulateError, SimulateRequest, Simulation, Warming,
};

use sagnac::record::write::Form;
use sagnac::verify::select;

use super::argument::word;
use super::compute::compute_on;
use super::failure::{Failure, in_python};

/// Which records are wanted, and as which numbers.
#[derive(FromPyObject)]
pub struct Wanted {
    step_s: Option<f64>,
    length_s: Option<f64>,
    switch_every_s: Option<f64>,
    at: Vec<String>,
    seed: Option<u64>,
    axes: usize,
    /// Axis, path and text of each motion.
    motions: Vec<(usize, String, String)>,
    misalignment: Vec<String>,
    scale_factor: Vec<String>,
    /// Temperatures at both ends, and the rate per kelvin.
    warming: Option<(String, String)>,
    truth: bool,
    data: String,
    first: u64,
    records: usize,
    device: String,
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

impl Wanted {
    fn request(&self) -> Result<SimulateRequest, Failure> {
        fn parsed<T>(argument: &str, text: &str, parse: fn(&str) -> Result<T, String>) -> Result<T, Failure> {
            parse(text).map_err(|why| Failure::Usage(format!("{argument}=\"{text}\": {why}")))
        }
        let misalignment = self.misalignment.iter();
        let misalignment =
            misalignment.map(|text| parsed("misalignment", text, Sensitivity::parse_misalignment));
        let scale_factor = self.scale_factor.iter();
        let scale_factor =
            scale_factor.map(|text| parsed("scale_factor", text, Sensitivity::parse_scale_factor));
        let warming = |(ends, coefficient): &(String, String)| {
            Ok::<_, Failure>(Warming {
                ends: parsed("temperature", ends, Warming::parse_ends)?,
                coefficient: parsed("temperature_coefficient", coefficient, Warming::parse_coefficient)?,
            })
        };
        let motions = self.motions.iter().cloned().map(|(axis, name, text)| MotionText { axis, name, text });
        Ok(SimulateRequest {
            sample_s: self.step_s,
            length_s: self.length_s,
            switch_every_s: self.switch_every_s,
            at: self.at.clone(),
            seed: self.seed,
            three_axes: self.axes == 3,
            motions: motions.collect(),
            sensitivities: misalignment.chain(scale_factor).collect::<Result<_, _>>()?,
            warming: self.warming.as_ref().map(warming).transpose()?,
            has_truth: self.truth,
        })
    }
}

/// Records of a noise or a study, from a file, or from its text if there is no `path`: a row for each, with a row for each column of
/// its file where that has several.
#[pyfunction]
#[pyo3(signature = (path, text, wanted))]
pub fn simulate<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let (values, shape) = compute_on(py, wanted.threads, || {
        let numbers = word("data", &wanted.data, &Numbers::NAMED)?;
        let request = wanted.request()?;
        let simulation = match &path {
            Some(path) => Simulation::read(path, &request)?,
            None => Simulation::parse("given", &text, &request)?,
        };
        simulation.check(numbers, Form::Raw)?;
        let simulation = simulation.on(select(&wanted.device, 1)?.device);
        let (columns, samples) = (simulation.columns(), simulation.samples() as usize);
        let rows = wanted.records * columns;
        let mut values: Vec<f64> = Vec::new();
        let has_room = samples.checked_mul(rows).map(|count| values.try_reserve_exact(count));
        if !matches!(has_room, Some(Ok(()))) {
            let message = format!("{} records of {samples} samples do not fit into memory", wanted.records);
            return Err(Failure::Usage(message + "\ntake fewer at a time with records= and first="));
        }
        values.resize(samples * rows, 0.0);
        values.par_chunks_mut(samples).enumerate().for_each(|(row, values)| {
            let numbers = simulation.numbers(wanted.first + (row / columns) as u64, row % columns, numbers);
            values.iter_mut().zip(numbers).for_each(|(place, value)| *place = value);
        });
        if let Some(failure) = simulation.failure() {
            return Err(Failure::Device(format!("{failure}\nuse device=\"cpu\"")));
        }
        let shape = match columns {
            1 => vec![wanted.records, samples],
            _ => vec![wanted.records, columns, samples],
        };
        Ok((values, shape))
    })?;
    PyArray1::from_vec(py, values).reshape(shape)
}
