//! Analyses and designs as the program writes them: the answer, the document, tables, charts and page.

use std::path::{Path, PathBuf};

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::allan::tau::Taus;
use sagnac::allan::trend::Trend;
use sagnac::analysis::compare::limit::RatioLimit;
use sagnac::analysis::design::searched::band as band_of;
use sagnac::analysis::design::{
    Constraints, Measure, Request as DesignRequest, Search, design as find, report as design_report,
};
use sagnac::analysis::log::{self, Asked};
use sagnac::analysis::model::document::document;
use sagnac::analysis::model::noise::{of_file, of_text};
use sagnac::analysis::model::target::{Source, Target};
use sagnac::analysis::model::writers::named;
use sagnac::analysis::model::{self as modelled, Aim, Quantization};
use sagnac::analysis::requirement::Limited;
use sagnac::analysis::sensitivity::{Request, SensitivityError, sensitivity as decide};
use sagnac::analysis::spectrum::{self, densities};
use sagnac::analysis::{compare as compared, page};
use sagnac::fit::choose::Terms;
use sagnac::fit::range::Fitting;
use sagnac::progress::Silent;
use sagnac::quantity::units::{Dimension, parse};
use sagnac::run::RunError;
use sagnac::spectrum::Welch;
use sagnac::table::Table;
use sagnac::verify::select;
use sagnac::view::chart::picture::Picture;
use sagnac::view::report::document::{Document, Provenance, json};
use sagnac::view::report::sections::Page;

use super::compute::{compute, compute_on, read_on};
use super::failure::{Failure, in_python};
use super::progress::Listener;
use super::record::{Reading, limits_of, side_by_side, terms_of};
use super::run::{shown, study_of};
use super::table::columns;

/// What an analysis has found.
struct Found {
    page: Page,
    /// The document of the program.
    document: String,
    /// Tables that the page does not have.
    tables: Vec<(&'static str, Table)>,
}

impl Found {
    fn new(page: Page, tables: Vec<(&'static str, Table)>, provenance: Option<Provenance>) -> Found {
        let document = json(&Document { provenance, ..page.document(&tables) });
        Found { page, document, tables }
    }

    fn into_python(self, py: Python) -> PyResult<Bound<PyDict>> {
        let Found { page, document, tables } = self;
        let all = tables.iter().chain(&page.tables);
        let tables =
            all.map(|(name, table)| Ok((*name, columns(py, table)?))).collect::<PyResult<Vec<_>>>()?;
        let found = PyDict::new(py);
        found.set_item("title", in_python(&page.title))?;
        found.set_item("answer", shown(&page.answer))?;
        found.set_item("notes", page.notes.iter().map(|note| in_python(note)).collect::<Vec<_>>())?;
        found.set_item("data", document)?;
        found.set_item("tables", tables)?;
        let charts = page.charts().map(|drawn| chart(&drawn.stem, &drawn.picture));
        found.set_item("charts", charts.collect::<Vec<_>>())?;
        found.set_item("report", page.html(&|text: &str| in_python(text)))?;
        Ok(found)
    }
}

/// The name of a chart, the chart as SVG, and its content as JSON.
pub fn chart(stem: &str, picture: &Picture) -> (String, String, String) {
    (stem.to_owned(), picture.svg(), serde_json::to_string(picture).unwrap_or_default())
}

/// The best switching interval and filler of a study.
#[pyfunction]
#[pyo3(signature = (path, text, by, latency, memory, search, band, trials, seed, device, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn design<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    by: String,
    latency: Option<String>,
    memory: Option<u64>,
    search: bool,
    band: Option<String>,
    trials: Option<u64>,
    seed: Option<u64>,
    device: String,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let listener = Listener::new(progress);
    let found = compute(py, || {
        let mut study = study_of(path.as_deref(), &text)?;
        study.trials = trials.unwrap_or(study.trials);
        study.seed = seed.unwrap_or(study.seed);
        let measure = Measure::ALL.into_iter().find(|measure| measure.name() == by).ok_or_else(|| {
            let known = Measure::ALL.map(Measure::name).join(", ");
            Failure::Usage(format!("by=\"{by}\" is not known\naccepted: {known}"))
        })?;
        let mut device = select(&device, threads)?.device;
        let latency_s = latency.as_deref().map(|text| {
            let refused = |what: String| Failure::Usage(format!("latency=\"{text}\": {what}"));
            match parse(text, &[Dimension::Time]) {
                Ok(time) if time.value >= 0.0 => Ok(time.value),
                Ok(_) => Err(refused("it is below 0".to_owned())),
                Err(error) => Err(refused(error.to_string())),
            }
        });
        let latency_s = latency_s.transpose()?;
        let constraints = Constraints { latency_s, memory_bytes: memory };
        let band = band
            .as_deref()
            .map(|text| band_of(text).map_err(|why| Failure::Usage(format!("band=\"{text}\": {why}"))));
        let search = search.then_some(Search { band: band.transpose()? });
        let request = DesignRequest { measure, constraints, search };
        let found = find(&study, &request, &mut device, &listener);
        listener.raised().map_or(Ok(()), |error| Err(Failure::Python(error)))?;
        let found = found.map_err(|error| match error.in_study(&study) {
            Ok(error) => Failure::Study(error),
            Err(error) => Failure::Run(RunError::Gpu(error)),
        })?;
        let figure = design_report::figure(&found);
        let figure = figure.map_err(|error| Failure::Usage(error.to_string()))?;
        let sheet = found.sheet()?;
        let page = page::of_design(&found, sheet.as_ref(), Picture::Curves(figure));
        Ok(Found::new(page, vec![], Some(Provenance::new(study.seed, found.trials))))
    })?;
    found.into_python(py)
}

/// What decides the answer of a study with uncertain inputs.
#[pyfunction]
#[pyo3(signature = (path, text, by, rows, samples, trials, seed, device, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn sensitivity<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    by: Option<String>,
    rows: Vec<(String, String)>,
    samples: Option<u64>,
    trials: Option<u64>,
    seed: Option<u64>,
    device: String,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let listener = Listener::new(progress);
    let found = compute(py, || {
        let mut study = study_of(path.as_deref(), &text)?;
        study.seed = seed.unwrap_or(study.seed);
        let mut device = select(&device, threads)?.device;
        let asked = Request { by, rows, samples, trials };
        let found = decide(&study, &asked, &mut device, &listener);
        listener.raised().map_or(Ok(()), |error| Err(Failure::Python(error)))?;
        let found = found.map_err(|error| match error.in_study(&study) {
            Ok(error) => Failure::Study(error),
            Err(SensitivityError::Run(error)) => Failure::Run(error),
            Err(error) => Failure::Usage(in_python(&error.to_string())),
        })?;
        let provenance = found.trials.map(|trials| Provenance::new(study.seed, trials));
        Ok(Found::new(page::of_sensitivity(&study, &found), vec![], provenance))
    })?;
    found.into_python(py)
}

/// Two records compared; `names` are what they are called.
#[pyfunction]
pub fn compare<'py>(
    py: Python<'py>,
    a: PyReadonlyArray1<'py, f64>,
    b: PyReadonlyArray1<'py, f64>,
    readings: (Reading, Reading),
    names: (String, String),
    terms: Option<Vec<String>>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (side_by_side(&a)?, side_by_side(&b)?);
    let (a, b) =
        read_on(py, readings.0.threads, || Ok((readings.0.log(a, &names.0)?, readings.1.log(b, &names.1)?)))?;
    let found = compute_on(py, readings.0.threads, || {
        let treatment = readings.0.treatment();
        let fitting = Fitting::from(terms_of(terms.as_deref(), treatment.trend)?);
        let limits = limits.iter().map(|limit| RatioLimit::parse(limit)).collect::<Result<Vec<_>, _>>()?;
        compared::limit::check(&limits, Some(fitting.terms.all()))?;
        let logs = [(Path::new(&names.0), &a), (Path::new(&names.1), &b)];
        let analysis = compared::logs::Analysis::of(logs, &treatment, Some(&fitting))
            .map_err(|error| Failure::Record(in_python(&error.to_string())))?;
        let decision = analysis.decision(&limits);
        Ok(Found::new(page::of_comparison([&a, &b], &analysis, &decision), vec![], None))
    })?;
    found.into_python(py)
}

/// The spectrum of a record called `name`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn psd<'py>(
    py: Python<'py>,
    data: PyReadonlyArray1<'py, f64>,
    reading: Reading,
    name: String,
    segment_s: Option<f64>,
    is_linear: bool,
    confidence: f64,
    terms: Option<Vec<String>>,
    bootstrap: Option<usize>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let values = side_by_side(&data)?;
    let log = read_on(py, reading.threads, || reading.log(values, &name))?;
    let found = compute_on(py, reading.threads, || {
        let treatment = reading.treatment();
        let welch = Welch {
            segment: segment_s.map(|length_s| libm::round(length_s / log.step_s) as usize),
            trend: if is_linear { Trend::Linear } else { Trend::None },
            confidence,
        };
        let densities = densities(&log, &treatment, &welch)
            .map_err(|error| Failure::Record(in_python(&error.to_string())))?;
        let terms: Terms = terms_of(terms.as_deref(), treatment.trend)?;
        let unit = log.channels[0].unit.curves;
        let limits = limits_of(&limits, &Limited::OF_LOG, Some(terms.all()), unit)?;
        let asked = Asked {
            confidence,
            fitting: Some(Fitting::from(terms)),
            simulated: bootstrap,
            ..Asked::default()
        };
        let noise = log::Analysis::of(&log, Path::new(&name), &treatment, &asked, &Silent)?;
        let analysis = spectrum::Analysis::of(noise, densities);
        let tables = vec![("psd.csv", spectrum::tables::table(&analysis))];
        let decision = analysis.decision(&limits);
        let mut page = page::of_log(&log, &analysis, decision.answer.clone(), None);
        page.tables.extend(decision.file());
        Ok(Found::new(page, tables, None))
    })?;
    found.into_python(py)
}

/// How a model is to be found.
#[derive(FromPyObject)]
pub struct Wanted {
    from_s: Option<f64>,
    to_s: Option<f64>,
    /// What is bounded; nothing if the model describes the record.
    bound: Option<String>,
    margin: f64,
    states: Option<usize>,
    is_white: bool,
    filter_hz: Option<f64>,
    confidence: f64,
    write: Vec<String>,
}

impl Wanted {
    fn asked(&self) -> modelled::Asked {
        modelled::Asked {
            from_s: self.from_s,
            to_s: self.to_s,
            aim: match self.bound.as_deref() {
                None => Aim::Describe,
                Some("repeat") => Aim::BoundRepeat,
                Some(_) => Aim::Bound,
            },
            margin: self.margin,
            states: self.states,
            quantization: if self.is_white { Quantization::White } else { Quantization::Measurement },
            filter_hz: self.filter_hz,
            confidence: self.confidence,
        }
    }

    fn found(&self, source: Source, targets: Vec<Target>) -> Result<Found, Failure> {
        let names = self.write.join(",");
        let writers = if names.is_empty() { Ok(vec![]) } else { named(&names) };
        let writers = writers.map_err(|why| Failure::Usage(format!("write=\"{names}\": {why}")))?;
        let analysis = modelled::Analysis::of(source, targets, &self.asked())?;
        let page = page::of_model(&analysis, &writers);
        let document = json(&document(&analysis, &page, &writers));
        Ok(Found { page, document, tables: vec![] })
    }
}

/// The noise model of a record called `name`, for a filter.
#[pyfunction]
pub fn model_of_record<'py>(
    py: Python<'py>,
    data: PyReadonlyArray1<'py, f64>,
    reading: Reading,
    name: String,
    terms: Option<Vec<String>>,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyDict>> {
    let values = side_by_side(&data)?;
    let log = read_on(py, reading.threads, || reading.log(values, &name))?;
    let found = compute_on(py, reading.threads, || {
        let treatment = reading.treatment();
        let asked = Asked {
            taus: Taus::Decade(10),
            confidence: wanted.confidence,
            fitting: Some(Fitting::from(terms_of(terms.as_deref(), treatment.trend)?)),
            simulated: Some(0),
            ..Asked::default()
        };
        let analysis = log::Analysis::of(&log, Path::new(&name), &treatment, &asked, &Silent)?;
        wanted.found(Source::of_log(&analysis), Target::of_log(&analysis)?)
    })?;
    found.into_python(py)
}

/// The noise model of the coefficients of a noise.toml, for a filter.
#[pyfunction]
#[pyo3(signature = (path, text, wanted))]
pub fn model_of_noise<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: String,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyDict>> {
    let found = compute_on(py, 0, || {
        let (source, target) = match path {
            Some(path) => of_file(&path, &wanted.asked())?,
            None => of_text("noise", &text, &wanted.asked())?,
        };
        wanted.found(source, vec![target])
    })?;
    found.into_python(py)
}
