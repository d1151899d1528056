//! Weights of fillers.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::analysis::firmware::alone::{Alone, KINDS};
use sagnac::analysis::firmware::choice::ChoiceError;
use sagnac::analysis::firmware::design::Firmware;
use sagnac::source::diagnose::StudyError;
use sagnac::study::Study;
use sagnac::view::chart::picture::Picture;

use super::analysis::chart;
use super::compute::compute;
use super::failure::Failure;
use super::run::shown;

/// The parameters of fillers without a study.
#[derive(FromPyObject)]
pub struct Made {
    gap_ticks: u32,
    tick: Option<String>,
    fit_ticks: Option<String>,
    extrapolation_ticks: Option<String>,
    band: Option<String>,
    amplitude: Option<String>,
    noise: Option<String>,
}

/// Keys of the resulting study with the corresponding arguments; longer keys first.
const NAMES: [(&str, &str); 9] = [
    ("switching.extrapolation_ticks", "extrapolation_ticks"),
    ("switching.fit_ticks", "fit_ticks"),
    ("switching.gap_ticks", "gap_ticks"),
    ("switching.fillers", "the filler"),
    ("motion.amplitude", "amplitude"),
    ("motion.frequency", "band"),
    ("gyro.tick_noise.std", "noise"),
    ("gyro.tick_noise", "noise"),
    ("gyro.tick", "tick"),
];

/// An error of that study in terms of the arguments, because the user does not know its text.
fn in_arguments(error: &StudyError) -> Failure {
    let help = miette::Diagnostic::help(error).map_or_else(String::new, |help| format!("\n{help}"));
    Failure::Usage(NAMES.iter().fold(format!("{error}{help}"), |said, (key, name)| said.replace(key, name)))
}

/// The weights of fillers of these kinds.
#[pyfunction]
pub fn of_kinds<'py>(py: Python<'py>, kinds: Vec<String>, made: Made) -> PyResult<Bound<'py, PyDict>> {
    let firmware = compute(py, || {
        if let Some(unknown) = kinds.iter().find(|kind| !KINDS.contains(&kind.as_str())) {
            let known = KINDS.join(", ");
            return Err(Failure::Usage(format!(
                "`{unknown}` is not a filler\naccepted: some of {known}; or the path of a study, as a pathlib.Path or ending in .toml"
            )));
        }
        let has_tick = made.tick.is_some();
        let Made { gap_ticks, tick, fit_ticks, extrapolation_ticks, band, amplitude, noise } = made;
        let alone = Alone { gap_ticks, tick, fit_ticks, extrapolation_ticks, band, amplitude, noise };
        let study = Study::parse("arguments", &alone.study(&kinds)).map_err(|error| in_arguments(&error))?;
        let mut firmware = Firmware::choose(&study, &[], &[]).map_err(|error| match error {
            ChoiceError::Study(error) => in_arguments(&error),
            other => other.into(),
        })?;
        if !has_tick {
            firmware.tick_s = None;
        }
        Ok(firmware)
    })?;
    document(py, &firmware)
}

/// The weights of fillers of a study at one of its points.
#[pyfunction]
pub fn of_study<'py>(
    py: Python<'py>,
    path: PathBuf,
    at: Vec<String>,
    fillers: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let firmware = compute(py, || Ok(Firmware::choose(&Study::read(&path)?, &at, &fillers)?))?;
    document(py, &firmware)
}

fn document<'py>(py: Python<'py>, firmware: &Firmware) -> PyResult<Bound<'py, PyDict>> {
    let document = PyDict::new(py);
    document.set_item("title", &firmware.title)?;
    document.set_item("answer", shown(&firmware.answer()))?;
    let response = chart("response", &Picture::Curves(firmware.response()));
    document.set_item("charts", vec![response])?;
    document.set_item(
        "at",
        firmware.at.iter().map(|(key, value)| (key.name, value.to_string())).collect::<Vec<_>>(),
    )?;
    document.set_item("tick_s", firmware.tick_s)?;
    document.set_item("gap_ticks", firmware.gap_ticks)?;
    document.set_item("no_rms_because", &firmware.unsampled)?;
    let mut fillers = Vec::new();
    for design in &firmware.designs {
        let mut rules = Vec::new();
        for (error, rule, closed) in design.rules() {
            let whole = rule.whole();
            let entry = PyDict::new(py);
            entry.set_item("error", error.name())?;
            entry.set_item("ticks", &rule.ticks)?;
            entry.set_item("denominator", rule.denominator)?;
            entry.set_item("exact", rule.exact)?;
            entry.set_item("rows", &rule.rows)?;
            entry.set_item("noise_gain", whole.noise_gain())?;
            entry.set_item("largest_gain", whole.largest_gain())?;
            entry.set_item("largest_input", rule.largest_input())?;
            entry.set_item("amplitude", closed.amplitude)?;
            entry.set_item("rms", closed.rms)?;
            rules.push(entry);
        }
        fillers.push((&design.name, &design.method, rules));
    }
    document.set_item("fillers", fillers)?;
    document.set_item("header", firmware.header())?;
    Ok(document)
}
