//! Weights of fillers.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::analysis::firmware::choice::ChoiceError;
use sagnac::analysis::firmware::design::Firmware;
use sagnac::analysis::firmware::search::Asked;
use sagnac::analysis::firmware::standalone::{Alone, KINDS};
use sagnac::analysis::page::of_filler;
use sagnac::diagnostics::StudyError;
use sagnac::outcome::Outcome;
use sagnac::quantity::Dimension;
use sagnac::study::Study;

use super::analysis::in_dict;
use super::argument::at_least_0;
use super::compute::compute;
use super::failure::Failure;

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

/// What a search of the ticks must meet: a limit on the residual, and a time.
pub type Searched = (Option<String>, Option<String>);

/// The request of a search, if there is one.
fn asked((limit, latency): Searched) -> Result<Option<Asked>, Failure> {
    let value = |name: &str, text: Option<String>, dimension| {
        text.map(|text| at_least_0(name, &text, dimension)).transpose()
    };
    let limit = value("limits", limit, Dimension::Angle)?.map(|limit| limit.value);
    let latency = value("latency", latency, Dimension::Time)?.map(|latency| latency.value);
    Ok(limit.or(latency).is_some().then_some(Asked { limit_arcsec: limit, latency_s: latency }))
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
pub fn of_kinds<'py>(
    py: Python<'py>,
    kinds: Vec<String>,
    made: Made,
    searched: Searched,
) -> PyResult<Bound<'py, PyDict>> {
    let found = compute(py, || {
        if let Some(unknown) = kinds.iter().find(|kind| !KINDS.contains(&kind.as_str())) {
            let known = KINDS.join(", ");
            return Err(Failure::Usage(format!(
                "`{unknown}` is not a filler\naccepted: some of {known}; or the path of a study, as a pathlib.Path or ending in .toml"
            )));
        }
        let Made { gap_ticks, tick, fit_ticks, extrapolation_ticks, band, amplitude, noise } = made;
        let alone = Alone { gap_ticks, tick, fit_ticks, extrapolation_ticks, band, amplitude, noise };
        alone.firmware(&kinds, asked(searched)?).map_err(|error| match error {
            ChoiceError::Study(error) => in_arguments(&error),
            other => other.into(),
        })
    })?;
    document(py, &found)
}

/// The weights of fillers of a study at one of its points.
#[pyfunction]
pub fn of_study<'py>(
    py: Python<'py>,
    path: PathBuf,
    at: Vec<String>,
    fillers: Vec<String>,
    searched: Searched,
) -> PyResult<Bound<'py, PyDict>> {
    let found = compute(py, || {
        let study = Study::read(&path)?;
        Ok(match asked(searched)? {
            Some(asked) => Firmware::searched(&study, &at, asked)?,
            None => {
                let firmware = Firmware::choose(&study, &at, &fillers)?;
                (study, firmware)
            }
        })
    })?;
    document(py, &found)
}

fn document<'py>(py: Python<'py>, (study, firmware): &(Study, Firmware)) -> PyResult<Bound<'py, PyDict>> {
    let files = vec![("sagnac_filler.h".to_owned(), firmware.header().into_bytes())];
    let outcome = Outcome { files, ..Outcome::new(firmware.heading(), of_filler(study, firmware)) };
    let document = in_dict(py, outcome)?;
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
    Ok(document)
}
