//! Analyses and designs as the program writes them: the answer, the document, tables, charts and page.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::allan::angles::Trend;
use sagnac::allan::deviation::{Taus, Unit as Curves};
use sagnac::analysis::batch::Batch;
use sagnac::analysis::compare::logs::RatioLimit;
use sagnac::analysis::design::filler_search::band as band_of;
use sagnac::analysis::design::{
    Constraints, Measure, Request as DesignRequest, Search, design as find, report as design_report,
};
use sagnac::analysis::log::{self, Asked, Treatment, navigators};
use sagnac::analysis::model::tables::document;
use sagnac::analysis::model::target::{Source, Target, of_file, of_text};
use sagnac::analysis::model::writers::named;
use sagnac::analysis::model::{self as modelled, Aim, Quantization};
use sagnac::analysis::requirement::Limited;
use sagnac::analysis::sensitivity::{Request, SensitivityError, sensitivity as decide};
use sagnac::analysis::whole::{self, Segments};
use sagnac::analysis::{compare as compared, page};
use sagnac::fit::selection::{Fitting, Terms};
use sagnac::progress::Silent;
use sagnac::quantity::Dimension;
use sagnac::record::log::Log;
use sagnac::report::chart::Picture;
use sagnac::report::page::Page;
use sagnac::report::page::document::{Document, Provenance, json};
use sagnac::run::RunError;
use sagnac::table::Table;
use sagnac::verify::select;

use super::argument::at_least_0;
use super::compute::{compute, compute_on};
use super::failure::{Failure, in_python};
use super::log::{Given, no_temperature, temperature_of};
use super::progress::Listener;
use super::record::{Reading, Times, limits_of, suppose_of, terms_of};
use super::run::{shown, study_of};
use super::table::columns;

/// What an analysis has found.
pub struct Found {
    page: Page,
    /// The document of the program.
    document: String,
    /// Tables that the page does not have.
    tables: Vec<(&'static str, Table)>,
    /// Further files by their names.
    files: Vec<(String, String)>,
}

impl Found {
    pub fn new(page: Page, tables: Vec<(&'static str, Table)>, provenance: Option<Provenance>) -> Found {
        let document = json(&Document { provenance, ..page.document(&tables) });
        Found { page, document, tables, files: vec![] }
    }

    /// Adds further files to the results.
    pub fn with(self, files: Vec<(String, String)>) -> Found {
        Found { files, ..self }
    }

    pub fn into_python(self, py: Python) -> PyResult<Bound<PyDict>> {
        let Found { page, document, tables, files } = self;
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
        found.set_item("files", files)?;
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
        let latency = latency.map(|text| at_least_0("latency", &text, Dimension::Time)).transpose()?;
        let latency_s = latency.map(|latency| latency.value);
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
    records: (Given<'py>, Given<'py>),
    readings: (Reading, Reading),
    names: (String, String),
    terms: Option<Vec<String>>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let a = &*records.0.log(py, &readings.0, &names.0)?;
    let b = &*records.1.log(py, &readings.1, &names.1)?;
    let found = compute_on(py, readings.0.threads, || {
        let treatment = readings.0.treatment();
        let fitting = Fitting::from(terms_of(terms.as_deref(), treatment.trend)?);
        let limits = limits.iter().map(|limit| RatioLimit::parse(limit)).collect::<Result<Vec<_>, _>>()?;
        compared::logs::check(&limits, Some(fitting.terms.all()))?;
        let logs = [(Path::new(&names.0), a), (Path::new(&names.1), b)];
        let analysis = compared::logs::Analysis::of(logs, &treatment, Some(&fitting))
            .map_err(|error| Failure::Record(in_python(&error.to_string())))?;
        let decision = analysis.decision(&limits);
        Ok(Found::new(page::of_comparison([a, b], &analysis, &decision), vec![], None))
    })?;
    found.into_python(py)
}

/// Several records as a batch of units; `names` are what they are called.
#[pyfunction]
pub fn batch<'py>(
    py: Python<'py>,
    records: Vec<Given<'py>>,
    readings: Vec<Reading>,
    names: Vec<String>,
    terms: Option<Vec<String>>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (trend, threads) =
        readings.first().map_or((Trend::None, 0), |one| (one.treatment().trend, one.threads));
    let terms = terms_of(terms.as_deref(), trend)?;
    let fitted = Some(terms.all());
    let asked = Asked { fitting: Some(Fitting::from(terms.clone())), simulated: Some(0), ..Asked::default() };
    let mut analyses = Vec::new();
    // One after the other, because each copy of an array may fill the memory.
    for ((record, reading), name) in records.iter().zip(&readings).zip(&names) {
        let log = record.log(py, reading, name)?;
        analyses.push(compute_on(py, threads, || {
            limits_of(&limits, Limited::OF_BATCH, fitted, &units_of(&log))?;
            Ok(log::Analysis::of(&log, Path::new(name), &reading.treatment(), &asked, &Silent)?)
        })?);
    }
    let found = compute_on(py, threads, || {
        let limits = limits_of(&limits, Limited::OF_BATCH, fitted, &Curves::ALL)?;
        let batch = Batch::of(analyses)?;
        let decision = batch.decision(&limits);
        Ok(Found::new(page::of_batch(&batch, &decision), vec![], None))
    })?;
    found.into_python(py)
}

/// The options of the analysis of a record.
#[derive(FromPyObject)]
pub struct Whole {
    deviations: Vec<String>,
    taus: Times,
    confidence: f64,
    intervals: String,
    is_fitted: bool,
    terms: Option<Vec<String>>,
    range: (Option<f64>, Option<f64>),
    is_forced: bool,
    bootstrap: Option<usize>,
    limits: Vec<String>,
    has_spectrum: bool,
    /// Whether a record that is too short for a spectrum is an error.
    needs_spectrum: bool,
    segment_s: Option<f64>,
    is_linear: bool,
    effects: String,
    is_compensated: bool,
    is_dynamic: bool,
    window_s: Option<f64>,
    navigate_s: Option<f64>,
    position_limit: Option<String>,
}

impl Whole {
    fn asked(self, treatment: &Treatment, units: &[Curves]) -> Result<whole::Asked, Failure> {
        let Whole { range: (from_s, to_s), confidence, segment_s: length_s, .. } = self;
        let terms = self.is_fitted.then(|| terms_of(self.terms.as_deref(), treatment.trend)).transpose()?;
        let limits = limits_of(&self.limits, &Limited::OF_LOG, terms.as_ref().map(Terms::all), units)?;
        let fitting = terms.map(|terms| Fitting { terms, from_s, to_s, is_forced: self.is_forced });
        let deviation = |name: &String| name.parse().map_err(|error| Failure::Usage(format!("{error}")));
        let limit = self.position_limit.as_deref();
        let limit = limit.map(|text| at_least_0("position_limit", text, Dimension::Distance)).transpose()?;
        let trend = if self.is_linear { Trend::Linear } else { Trend::None };
        Ok(whole::Asked {
            noise: Asked {
                taus: self.taus.taus()?,
                deviations: self.deviations.iter().map(deviation).collect::<Result<_, _>>()?,
                confidence,
                intervals: suppose_of(&self.intervals)?,
                fitting,
                simulated: self.bootstrap,
            },
            segments: self.has_spectrum.then_some(Segments { length_s, trend }),
            is_compensated: self.is_compensated,
            window_s: self.is_dynamic.then_some(self.window_s),
            navigators: self.navigate_s.map(|duration_s| navigators::Asked { duration_s, limit }),
            limits,
        })
    }
}

/// The whole analysis of a record called `name`.
#[pyfunction]
pub fn analyze<'py>(
    py: Python<'py>,
    record: Given<'py>,
    reading: Reading,
    name: String,
    asked: Whole,
) -> PyResult<Bound<'py, PyDict>> {
    let log = record.log(py, &reading, &name)?;
    let found = compute_on(py, reading.threads, || {
        let treatment = reading.treatment();
        let mut log = log.into_owned();
        let (needs_spectrum, effects) = (asked.needs_spectrum, asked.effects.clone());
        let asked = asked.asked(&treatment, &units_of(&log))?;
        let temperature = temperature_of(&mut log, &effects, &treatment)?;
        if asked.is_compensated && temperature.is_none() {
            return Err(no_temperature());
        }
        let path = Path::new(&name);
        let whole = whole::Whole::of(log, temperature, path, &treatment, &asked, &mut vec![], &Silent)?;
        if let Some(why) = whole.without.filter(|_| needs_spectrum) {
            return Err(Failure::Record(in_python(&why.to_string())));
        }
        Ok(Found::new(whole.page, whole.tables, None).with(whole.files))
    })?;
    found.into_python(py)
}

/// The units of the curves of a log.
fn units_of(log: &Log) -> Vec<Curves> {
    log.channels.iter().map(|channel| channel.unit.curves).collect()
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
        Ok(Found { page, document, tables: vec![], files: vec![] })
    }
}

/// The noise model of a record called `name`, for a filter.
#[pyfunction]
pub fn model_of_record<'py>(
    py: Python<'py>,
    record: Given<'py>,
    reading: Reading,
    name: String,
    terms: Option<Vec<String>>,
    wanted: Wanted,
) -> PyResult<Bound<'py, PyDict>> {
    let log = record.log(py, &reading, &name)?;
    let found = compute_on(py, reading.threads, || {
        // Events are no noise that a filter could have a state for.
        let treatment = Treatment { events_removed: true, ..reading.treatment() };
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
