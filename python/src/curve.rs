//! Curves of averaging times and deviations, which functions take in place of a record.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::analysis::log::Treatment;
use sagnac::analysis::requirement::{Limit, Limited};
use sagnac::fit::selection::Fitting;
use sagnac::progress::Silent;
use sagnac::record::curve_file::{CurveFile, CurveRequest, Errors};
use sagnac::use_cases::{ModelSource, fit_curve, model_noise};
use sagnac_base::quantity::Dimension;

use super::analysis::{Wanted, in_dict};
use super::argument::at_least_0;
use super::compute::compute_on;
use super::failure::Failure;
use super::record::terms_of;

/// A curve in memory.
#[pyclass(frozen, module = "sagnac._sagnac")]
pub struct Curve {
    pub read: CurveFile,
}

/// Whether the file at `path` has a curve, and not a log.
#[pyfunction]
pub fn is_curve(path: PathBuf) -> bool {
    CurveFile::is_one(&path)
}

/// The errors of points: half their 95 % interval in percent, or the length of their record.
fn errors_of(text: &str) -> Result<Errors, Failure> {
    let wrong = || {
        Failure::Usage(format!(
            "curve_interval=\"{text}\"\naccepted: \"10%\", or the length of a record, \"9 h\""
        ))
    };
    match text.trim().strip_suffix('%') {
        Some(percent) => {
            let percent =
                percent.trim().parse().ok().filter(|percent: &f64| *percent > 0.0 && *percent <= 100.0);
            percent.map(|percent| Errors::Part(0.01 * percent)).ok_or_else(wrong)
        }
        None => {
            let length_s = at_least_0("curve_interval", text, Dimension::Time)?.value;
            if length_s > 0.0 { Ok(Errors::Record(length_s)) } else { Err(wrong()) }
        }
    }
}

/// Reads the curve at `path`.
#[pyfunction]
#[pyo3(signature = (path, unit, interval, step_s))]
pub fn read_curve(
    py: Python,
    path: PathBuf,
    unit: Option<String>,
    interval: Option<String>,
    step_s: Option<f64>,
) -> PyResult<Curve> {
    let errors = interval.as_deref().map(errors_of).transpose()?;
    let request = CurveRequest { unit, errors, step_s, ..CurveRequest::default() };
    compute_on(py, 0, || Ok(Curve { read: CurveFile::read(&path, &request)? }))
}

/// A curve called `name` from its columns: averaging times, s, deviations, and the ends of their 95 % intervals, if there are some.
#[pyfunction]
#[pyo3(signature = (name, columns, unit, interval, step_s))]
pub fn curve_of(
    py: Python,
    name: String,
    columns: Vec<Vec<f64>>,
    unit: String,
    interval: Option<String>,
    step_s: Option<f64>,
) -> PyResult<Curve> {
    const NAMES: [&str; 4] = ["tau", "adev", "low", "high"];
    let names: Vec<&str> = NAMES.into_iter().take(columns.len()).collect();
    let rows = (0..columns.first().map_or(0, Vec::len)).map(|row| {
        // A number in this form is read again as the same bits.
        let cells = columns.iter().filter_map(|column| column.get(row)).map(|x| format!("{x:?}"));
        cells.collect::<Vec<_>>().join(",")
    });
    let text: Vec<String> = std::iter::once(names.join(",")).chain(rows).collect();
    let errors = interval.as_deref().map(errors_of).transpose()?;
    let request = CurveRequest { unit: Some(unit), errors, step_s, ..CurveRequest::default() };
    compute_on(py, 0, || Ok(Curve { read: CurveFile::parse(&name, &text.join("\n"), &request)? }))
}

/// The range of τ of a fit.
type Range = (Option<f64>, Option<f64>);

/// The noise of a curve called `name`; without a fit the curve alone.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn analyze_curve<'py>(
    py: Python<'py>,
    curve: Bound<'py, Curve>,
    name: String,
    is_fitted: bool,
    terms: Option<Vec<String>>,
    range: Range,
    is_forced: bool,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let read = curve.get().read.clone();
    let found = compute_on(py, 0, || {
        let limits =
            limits.iter().map(|text| Limit::parse(text, &Limited::OF_LOG)).collect::<Result<Vec<_>, _>>()?;
        let fitting = |terms| Fitting { terms, from_s: range.0, to_s: range.1, is_forced };
        let terms =
            is_fitted.then(|| terms_of(terms.as_deref(), Treatment::AS_RECORDED.trend)).transpose()?;
        Ok(fit_curve(read, Path::new(&name), terms.map(fitting).as_ref(), &limits)?)
    })?;
    in_dict(py, found)
}

/// The noise model of a curve called `name`, for a filter.
#[pyfunction]
pub fn model_of_curve<'py>(
    py: Python<'py>,
    curve: Bound<'py, Curve>,
    name: String,
    terms: Option<Vec<String>>,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyDict>> {
    let read = &curve.get().read;
    let found = compute_on(py, 0, || {
        let treatment = Treatment::AS_RECORDED;
        let fitting = Fitting::from(terms_of(terms.as_deref(), treatment.trend)?);
        let source = ModelSource::Curve(read, Path::new(&name));
        Ok(model_noise(source, &wanted.request(treatment, Some(fitting))?, &Silent)?)
    })?;
    in_dict(py, found)
}
