//! Weights of fillers.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::analysis::firmware::{
    Alone, Asked, ChoiceError, FillerRequest, FillerSource, Firmware, KINDS, filler, in_properties,
};
use sagnac::study::Study;
use sagnac::use_cases::Outcome;
use sagnac_base::quantity::Dimension;

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
        let properties = Alone { gap_ticks, tick, fit_ticks, extrapolation_ticks, band, amplitude, noise };
        let source = FillerSource::Alone { kinds, properties };
        let request = FillerRequest { source, search: asked(searched)?, vectors: None };
        filler(&request).map_err(|error| match error {
            // Nobody knows the text of this study.
            ChoiceError::Study(error) => Failure::Usage(in_properties(&error, str::to_owned)),
            other => other.into(),
        })
    })?;
    document(py, found)
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
        let source = FillerSource::Study { study: Box::new(Study::read(&path)?), at, names: fillers };
        Ok(filler(&FillerRequest { source, search: asked(searched)?, vectors: None })?)
    })?;
    document(py, found)
}

fn document<'py>(py: Python<'py>, (firmware, found): (Firmware, Outcome)) -> PyResult<Bound<'py, PyDict>> {
    let document = in_dict(py, found)?;
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
