//! Analyses and designs as the program writes them: the answer, the document, tables, charts and page.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::allan::angles::Trend;
use sagnac::analysis::compare::Stated;
use sagnac::analysis::compare::logs::{Compared, RatioLimit};
use sagnac::analysis::design::filler_search::band as band_of;
use sagnac::analysis::design::{Constraints, DesignError, DesignRequest, Measure, Search, design as find};
use sagnac::analysis::log::{NoiseRequest, Treatment};
use sagnac::analysis::model::writers::named;
use sagnac::analysis::model::{Aim, ModelRequest, Quantization};
use sagnac::analysis::navigators::NavigatorRequest;
use sagnac::analysis::requirement::{Limit, Limited};
use sagnac::analysis::sensitivity::{SensitivityError, SensitivityRequest, sensitivity as decide};
use sagnac::fit::selection::Fitting;
use sagnac::progress::Silent;
use sagnac::record::curve_file::CurveFile;
use sagnac::record::log::Log;
use sagnac::report::chart::Picture;
use sagnac::run::RunError;
use sagnac::use_cases::Outcome;
use sagnac::use_cases::{
    self, AllanRequest, BatchRequest, CompareRequest, ModelSource, Segments, compare_logs, compare_units,
    model_noise, three_cornered_hat,
};
use sagnac::verify::select;
use sagnac_base::quantity::Dimension;

use super::argument::at_least_0;
use super::compute::{compute, compute_on};
use super::curve::Curve;
use super::failure::{Failure, in_python};
use super::log::{Given, effects_of};
use super::progress::Listener;
use super::record::{Reading, Times, suppose_of, terms_of};
use super::run::{shown, study_of};
use super::table::columns;

/// An outcome as a dictionary: the page, the document of the program, tables, charts and files.
pub fn in_dict(py: Python, outcome: Outcome) -> PyResult<Bound<PyDict>> {
    let spell = |text: &str| in_python(text);
    let page = &outcome.page;
    let tables = outcome.all_tables().map(|(name, table)| Ok((*name, columns(py, table)?)));
    let found = PyDict::new(py);
    found.set_item("title", in_python(&page.title))?;
    found.set_item("answer", shown(&page.answer))?;
    found.set_item("notes", page.notes.iter().map(|note| in_python(note)).collect::<Vec<_>>())?;
    found.set_item("data", outcome.json(&spell))?;
    found.set_item("tables", tables.collect::<PyResult<Vec<_>>>()?)?;
    let charts = page.charts().map(|drawn| chart(&drawn.stem, &drawn.picture));
    found.set_item("charts", charts.collect::<Vec<_>>())?;
    let text =
        |(name, contents): &(String, Vec<u8>)| (name.clone(), String::from_utf8_lossy(contents).into_owned());
    found.set_item("files", outcome.files.iter().map(text).collect::<Vec<_>>())?;
    found.set_item("report", page.html(&spell))?;
    Ok(found)
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
            Err(DesignError::Gpu(error)) => Failure::Run(RunError::Gpu(error)),
            Err(DesignError::Decision(error)) => error.into(),
            Err(error) => Failure::Usage(error.to_string()),
        })?;
        Ok(found)
    })?;
    in_dict(py, found)
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
        let request = SensitivityRequest { by, rows, samples, trials };
        let found = decide(&study, &request, &mut device, &listener);
        listener.raised().map_or(Ok(()), |error| Err(Failure::Python(error)))?;
        let found = found.map_err(|error| match error.in_study(&study) {
            Ok(error) => Failure::Study(error),
            Err(SensitivityError::Run(error)) => Failure::Run(error),
            Err(error) => Failure::Usage(in_python(&error.to_string())),
        })?;
        Ok(found)
    })?;
    in_dict(py, found)
}

/// A side of a comparison: a record, a curve, or the path or the text of a noise.toml.
#[derive(FromPyObject)]
pub enum Side<'py> {
    Record(Given<'py>, Reading),
    Curve(Bound<'py, Curve>),
    Stated(Option<PathBuf>, String),
}

/// A side that was read.
enum Read<'a> {
    Log(Cow<'a, Log>),
    Curve(&'a CurveFile),
    Stated(Stated),
}

impl Side<'_> {
    /// The side, which is called `name`.
    fn read(&self, py: Python, name: &str) -> PyResult<Read<'_>> {
        Ok(match self {
            Side::Record(given, reading) => Read::Log(given.log(py, reading, name)?),
            Side::Curve(curve) => Read::Curve(&curve.get().read),
            Side::Stated(Some(path), _) => Read::Stated(Stated::read(path).map_err(Failure::from)?),
            Side::Stated(None, text) => Read::Stated(Stated::parse(name, text).map_err(Failure::from)?),
        })
    }

    /// The treatment and the number of threads of a record.
    fn treatment(&self) -> Option<(Treatment, usize)> {
        if let Side::Record(_, reading) = self { Some((reading.treatment(), reading.threads)) } else { None }
    }
}

impl Read<'_> {
    fn compared(&self) -> Compared<'_> {
        match self {
            Read::Log(log) => Compared::Log(log),
            Read::Curve(curve) => Compared::Curve(curve),
            Read::Stated(stated) => Compared::Stated(stated),
        }
    }
}

/// Two sides compared; `names` are what they are called.
#[pyfunction]
pub fn compare<'py>(
    py: Python<'py>,
    sides: (Side<'py>, Side<'py>),
    names: (String, String),
    terms: Option<Vec<String>>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (a, b) = (sides.0.read(py, &names.0)?, sides.1.read(py, &names.1)?);
    let treated = sides.0.treatment().or(sides.1.treatment());
    let (treatment, threads) = treated.unwrap_or((Treatment::AS_RECORDED, 0));
    let found = compute_on(py, threads, || {
        let fitting = Some(Fitting::from(terms_of(terms.as_deref(), treatment.trend)?));
        let limits = limits.iter().map(|limit| RatioLimit::parse(limit)).collect::<Result<_, _>>()?;
        let request = CompareRequest { treatment, fitting, limits };
        let sides = [(Path::new(&names.0), a.compared()), (Path::new(&names.1), b.compared())];
        Ok(compare_logs(sides, &request)?)
    })?;
    in_dict(py, found)
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
    let fitting = Some(Fitting::from(terms_of(terms.as_deref(), trend)?));
    let limits = limits.iter().map(|text| Limit::parse(text, Limited::OF_BATCH)).collect::<Result<_, _>>();
    let request = BatchRequest { fitting, limits: limits.map_err(Failure::from)? };
    request.check().map_err(Failure::from)?;
    let mut analyses = Vec::new();
    // One after the other, because each copy of an array may fill the memory.
    for ((record, reading), name) in records.iter().zip(&readings).zip(&names) {
        let log = record.log(py, reading, name)?;
        analyses.push(compute_on(py, threads, || {
            Ok(request.analyze(&log, Path::new(name), &reading.treatment())?)
        })?);
    }
    in_dict(py, compute_on(py, threads, || Ok(compare_units(analyses, &request)?))?)
}

/// The noise of each of three units that ran together; `names` are what the records are called.
#[pyfunction]
pub fn hat<'py>(
    py: Python<'py>,
    records: Vec<Given<'py>>,
    readings: Vec<Reading>,
    names: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let each = records.iter().zip(&readings).zip(&names);
    let logs =
        each.map(|((record, reading), name)| record.log(py, reading, name)).collect::<PyResult<Vec<_>>>()?;
    let first = readings.first().map(|one| (one.treatment(), one.threads));
    let (treatment, threads) = first.unwrap_or((Treatment::AS_RECORDED, 0));
    let logs: Vec<(&Path, &Log)> = names.iter().map(Path::new).zip(logs.iter().map(|log| &**log)).collect();
    in_dict(py, compute_on(py, threads, || Ok(three_cornered_hat(&logs, &treatment)?))?)
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
    fn request(self, treatment: Treatment) -> Result<AllanRequest, Failure> {
        let Whole {
            range: (from_s, to_s), confidence, segment_s: length_s, needs_spectrum: is_required, ..
        } = self;
        let terms = self.is_fitted.then(|| terms_of(self.terms.as_deref(), treatment.trend)).transpose()?;
        let limits = self.limits.iter().map(|text| Limit::parse(text, &Limited::OF_LOG));
        let fitting = terms.map(|terms| Fitting { terms, from_s, to_s, is_forced: self.is_forced });
        let deviation = |name: &String| name.parse().map_err(|error| Failure::Usage(format!("{error}")));
        let limit = self.position_limit.as_deref();
        let limit = limit.map(|text| at_least_0("position_limit", text, Dimension::Distance)).transpose()?;
        let trend = if self.is_linear { Trend::Linear } else { Trend::None };
        Ok(AllanRequest {
            treatment,
            noise: NoiseRequest {
                taus: self.taus.taus()?,
                deviations: self.deviations.iter().map(deviation).collect::<Result<_, _>>()?,
                confidence,
                intervals: suppose_of(&self.intervals)?,
                fitting,
                simulated: self.bootstrap,
                simulator: None,
            },
            segments: self.has_spectrum.then_some(Segments { length_s, trend, is_required }),
            effects: effects_of(&self.effects)?,
            is_compensated: self.is_compensated,
            window_s: self.is_dynamic.then_some(self.window_s),
            navigators: self.navigate_s.map(|duration_s| NavigatorRequest { duration_s, limit }),
            limits: limits.collect::<Result<_, _>>()?,
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
        let request = asked.request(reading.treatment())?;
        let mut log = log.into_owned();
        Ok(use_cases::allan(&mut log, Path::new(&name), &request, &mut vec![], &Silent)?)
    })?;
    in_dict(py, found)
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
    /// The request, of a record with this treatment and fit.
    pub fn request(&self, treatment: Treatment, fitting: Option<Fitting>) -> Result<ModelRequest, Failure> {
        let names = self.write.join(",");
        let writers = if names.is_empty() { Ok(vec![]) } else { named(&names) };
        Ok(ModelRequest {
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
            treatment,
            fitting,
            writers: writers.map_err(|why| Failure::Usage(format!("write=\"{names}\": {why}")))?,
        })
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
        let treatment = reading.treatment();
        let fitting = Fitting::from(terms_of(terms.as_deref(), treatment.trend)?);
        let source = ModelSource::Log(&log, Path::new(&name));
        Ok(model_noise(source, &wanted.request(treatment, Some(fitting))?, &Silent)?)
    })?;
    in_dict(py, found)
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
        let source = match &path {
            Some(path) => ModelSource::NoiseFile(path),
            None => ModelSource::NoiseText("noise", &text),
        };
        Ok(model_noise(source, &wanted.request(Treatment::AS_RECORDED, None)?, &Silent)?)
    })?;
    in_dict(py, found)
}

/// Convention, value and unit.
type Converted = (&'static str, f64, &'static str);

/// The name of the coefficient that a text gives, its value in the units and conventions of data sheets, and the lines of a noise
/// file of which one is its own.
#[pyfunction]
pub fn convert(text: &str) -> PyResult<(&'static str, Vec<Converted>, Vec<String>)> {
    let found = use_cases::convert(text).map_err(|error| Failure::Usage(error.to_string()))?;
    let rows = found.rows.iter().map(|row| (row.convention, row.value, row.unit));
    Ok((found.quantity, rows.collect(), found.lines))
}
