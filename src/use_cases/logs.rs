//! The use cases of recorded logs: each is a function from a request to an outcome.
//!
//! ```text
//! Log, AllanRequest ─────── allan ─┬─ log::Analysis, densities ─▶ spectrum::Analysis ─┬▶ Outcome
//!                                  ├─ Temperature: before and after compensation ─────┤
//!                                  ├─ Dynamic ────────────────────────────────────────┤
//!                                  └─ navigators ─────────────────────────────────────┘
//! CurveFile ─────────────── fit_curve ─▶ given_curve::Analysis ─▶ Outcome
//! two Logs, CurveFiles or Stated, CompareRequest ─ compare_logs ─▶ Outcome
//! Logs, BatchRequest ─────── BatchRequest::analyze ─▶ log::Analysis ─ compare_units ─▶ Outcome
//! Logs of three units ─── three_cornered_hat ─▶ Outcome
//! Log or noise.toml, ModelRequest ── model_noise ─▶ Outcome
//! ```

use std::path::Path;

use crate::analysis::batch::{Batch, BatchError};
use crate::analysis::compare::logs::{self, CompareError, Compared, RatioLimit};
use crate::analysis::data_sheet::Intervals;
use crate::analysis::dynamic::{self, Dynamic, DynamicError};
use crate::analysis::given_curve;
use crate::analysis::hat::{self, HatError};
use crate::analysis::log::report::heading;
use crate::analysis::log::{self, NoiseRequest, Treatment, noise_file};
use crate::analysis::model::tables::Models;
use crate::analysis::model::target::{Source, Target, of_file, of_text};
use crate::analysis::model::writers::{WRITERS, notes, texts};
use crate::analysis::model::{self, ModelError, ModelRequest};
use crate::analysis::navigators::{self, NavigatorRequest, navigators};
use crate::analysis::page::{
    of_batch, of_comparison, of_curve, of_dynamic, of_hat, of_log, of_model, of_navigators, of_temperature,
};
use crate::analysis::requirement::{Limit, LimitError, applies, check};
use crate::analysis::spectrum::{self, NoSpectrum, densities};
use crate::analysis::temperature::{self, Effects, Temperature};
use crate::use_cases::Outcome;
use sagnac_base::progress::{Progress, Silent};
use sagnac_records::allan::{TauError, Taus, Trend};
use sagnac_records::fit::Fitting;
use sagnac_records::record::curve_file::CurveFile;
use sagnac_records::record::log::Log;
use sagnac_records::spectrum::{Density, Welch};

/// Why a use case of logs has no outcome.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// Limits do not fit each other, the fit or the log.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// Limits on ratios do not fit each other or the fit.
    #[error(transparent)]
    RatioLimit(LimitError),
    /// Navigators need the coefficients of a fit.
    #[error("navigators need coefficients\ngive the terms of a fit, as in `fit = auto`")]
    NoFit,
    /// The record has no temperature, on which it could depend.
    #[error("the record has no temperature\ngive its column, as in `temperature = temp`")]
    NoTemperature,
    /// An averaging time is outside the range of the log.
    #[error(transparent)]
    Tau(#[from] TauError),
    /// The windows over time are too short or too long.
    #[error(transparent)]
    Dynamic(#[from] DynamicError),
    /// A segment of the spectrum does not fit.
    #[error(transparent)]
    Spectrum(#[from] NoSpectrum),
    /// Two logs cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Some logs are no batch.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// Some logs have no three-cornered hat.
    #[error(transparent)]
    Hat(#[from] HatError),
    /// There is no model.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl LogError {
    /// Whether the request is wrong, and not the record.
    pub fn is_usage(&self) -> bool {
        match self {
            LogError::Limit(_) | LogError::RatioLimit(_) | LogError::NoFit | LogError::NoTemperature => true,
            LogError::Tau(error) => matches!(error, TauError::NoTime(_)),
            LogError::Batch(error) => !matches!(error, BatchError::Units { .. }),
            LogError::Hat(error) => matches!(error, HatError::Count(_)),
            LogError::Model(error) => error.is_usage(),
            LogError::Compare(error) => {
                matches!(error, CompareError::NothingEstimated | CompareError::NoFit)
            }
            LogError::Dynamic(_) | LogError::Spectrum(_) => false,
        }
    }
}

/// Number of simulated samples that take some seconds, for which it pays to analyse a log twice.
const LONG: usize = 4_000_000_000;

/// The request for the analysis of a log: its noise and its spectra, and what is asked for beside them.
#[derive(Debug, Clone)]
pub struct AllanRequest {
    /// Treatment of the log.
    pub treatment: Treatment,
    /// Deviations and coefficients.
    pub noise: NoiseRequest,
    /// Segments of the spectra; `None` for no spectra.
    pub segments: Option<Segments>,
    /// Terms of the dependence on temperature, for a log with one.
    pub effects: Effects,
    /// Whether the results are those of the log without its dependence on temperature.
    pub is_compensated: bool,
    /// Length of the windows over time, s; inner `None` for the usual length, outer `None` for no windows.
    pub window_s: Option<Option<f64>>,
    /// Navigators with the gyros of the log, if any.
    pub navigators: Option<NavigatorRequest>,
    /// Limits on the noise.
    pub limits: Vec<Limit>,
}

/// The segments of which spectra are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segments {
    /// Length, s; `None` for the usual one.
    pub length_s: Option<f64>,
    /// The trend that is removed from each segment.
    pub trend: Trend,
    /// Whether a log that is too short for the usual length is refused, instead of analysed without spectra.
    pub is_required: bool,
}

impl AllanRequest {
    /// Checks that the limits agree with each other and with the fit, and that what needs a fit has one.
    ///
    /// # Errors
    /// They do not.
    pub fn check(&self) -> Result<(), LogError> {
        check_limits(&self.limits, self.noise.fitting.as_ref())?;
        if self.navigators.is_some() && self.noise.fitting.is_none() {
            return Err(LogError::NoFit);
        }
        Ok(())
    }

    /// The request of a first page, which does not wait for navigators and simulated records: the intervals of coefficients are those
    /// in closed form. `None` where neither takes long.
    pub fn first(&self, log: &Log) -> Option<AllanRequest> {
        let samples = log.samples() * log.channels.len();
        let simulated = samples.saturating_mul(Intervals::simulated(self.noise.simulated, samples).records);
        let is_slow = self.noise.fitting.is_some() && (self.navigators.is_some() || simulated > LONG);
        let noise = NoiseRequest { simulated: Some(0), ..self.noise.clone() };
        is_slow.then(|| AllanRequest { noise, navigators: None, ..self.clone() })
    }

    /// The densities of a log, or why it has none.
    ///
    /// # Errors
    /// A segment of the given length does not fit, or spectra are required.
    fn densities(&self, log: &Log) -> Result<(Vec<Density>, Option<NoSpectrum>), NoSpectrum> {
        let Some(Segments { length_s, trend, is_required }) = self.segments else {
            return Ok((vec![], None));
        };
        let segment = length_s.map(|length_s| libm::round(length_s / log.step_s) as usize);
        match densities(log, &self.treatment, &Welch { segment, trend, confidence: self.noise.confidence }) {
            Ok(densities) => Ok((densities, None)),
            Err(why) if length_s.is_some() || is_required => Err(why),
            Err(why) => Ok((vec![], Some(why))),
        }
    }
}

/// Checks that limits agree with each other and with the fit.
fn check_limits(limits: &[Limit], fitting: Option<&Fitting>) -> Result<(), LimitError> {
    check(limits, fitting.map(|fitting| fitting.terms.all()))
}

/// Checks that a log has a column for each limit.
fn check_units(limits: &[Limit], log: &Log) -> Result<(), LimitError> {
    let units: Vec<_> = log.channels.iter().map(|channel| channel.unit.curves).collect();
    applies(limits, &units)
}

/// The files of [`allan`], of which stars stand for names of columns and units.
const ALLAN_FILES: [&str; 22] = [
    "curve.csv",
    "coefficients.csv",
    "events.csv",
    "psd.csv",
    "lines.csv",
    "white_noise.csv",
    "temperature.csv",
    "compensation.csv",
    "dynamic.csv",
    "stationarity.csv",
    "limits.csv",
    "navigation.csv",
    "noise*.toml",
    "navigation*.toml",
    "chart",
    "chart-accelerometers",
    "chart-numbers",
    "chart-tdev*",
    "chart-temperature*",
    "chart-rate*",
    "chart-dynamic*",
    "psd*",
];

/// Analyses a log that was read from `path`, which becomes the log as it was analysed: with notes on its temperature, and without its
/// dependence on it if that was asked for. Columns that are equal to an `earlier` record, by its digest and name, are noted, and those
/// of this log are added to these.
///
/// # Errors
/// A limit, an averaging time, a window or a segment does not fit the log, or there is no temperature to compensate.
pub fn allan(
    log: &mut Log,
    path: &Path,
    request: &AllanRequest,
    earlier: &mut Vec<(u64, String)>,
    progress: &dyn Progress,
) -> Result<Outcome, LogError> {
    request.check()?;
    check_units(&request.limits, log)?;
    let treatment = &request.treatment;
    let temperature = Temperature::noted(log, treatment, &request.effects);
    if request.is_compensated && temperature.is_none() {
        return Err(LogError::NoTemperature);
    }
    let analyze = |log: &Log| log::Analysis::of(log, path, treatment, &request.noise, progress);
    let mut noise = analyze(log)?;
    // The dependence with the analysis that is not the main one.
    let mut thermal = None;
    if let Some(found) = temperature {
        let mut compensated = found.compensated(log);
        let mut other = analyze(&compensated)?;
        if request.is_compensated {
            std::mem::swap(log, &mut compensated);
            std::mem::swap(&mut noise, &mut other);
        }
        thermal = Some((found, other));
    }
    noise.note_equal(earlier);
    let dynamic = request.window_s.map(|window_s| Dynamic::new(log, treatment, window_s)).transpose()?;
    let (densities, without) = request.densities(log)?;
    let analysis = spectrum::Analysis::of(noise, densities);
    let noise = &analysis.noise;
    let decision = analysis.decision(&request.limits);
    let navigation = request.navigators.as_ref().map(|request| navigators(noise, request, progress));
    // Navigators are what is asked for, unless only coefficients have limits.
    let is_limited = request.navigators.as_ref().is_some_and(|request| request.limit.is_some());
    let is_asked = request.limits.is_empty() || is_limited;
    let (answer, aside) = match navigation.as_deref().and_then(navigators::answer) {
        Some(found) if is_asked => (found, None),
        found => (decision.answer.clone(), found),
    };
    let mut page = of_log(log, &analysis, answer, without.as_ref());
    if let Some((found, other)) = &thermal {
        let sides = if noise.treatment.is_compensated { [other, noise] } else { [noise, other] };
        page.sections.push(of_temperature(found, sides));
        page.tables.push(("temperature.csv", temperature::report::coefficients(found)));
        page.tables.push(("compensation.csv", temperature::report::compensation(found)));
    }
    if let Some(dynamic) = &dynamic {
        page.sections.push(of_dynamic(dynamic));
        page.tables.push(("dynamic.csv", dynamic::report::windows(dynamic)));
        page.tables.push(("stationarity.csv", dynamic::report::octaves(dynamic)));
    }
    page.tables.extend(navigation.as_ref().map(|found| ("navigation.csv", navigators::table(found))));
    page.tables.extend(decision.file());
    page.sections.extend(aside.map(|found| of_navigators(&found)));
    let studies = navigation.iter().flatten().zip(navigators::names(noise));
    let studies = studies.filter_map(|(found, name)| Some((name, found.as_ref().ok()?.study.clone())));
    let files = noise_file::files(noise).into_iter().chain(studies);
    let mut outcome = Outcome::new(heading(noise), page).among(ALLAN_FILES);
    outcome.files = files.map(|(name, text)| (name, text.into_bytes())).collect();
    if !analysis.spectra.is_empty() {
        outcome.tables.push(("psd.csv", spectrum::report::table(&analysis)));
    }
    Ok(outcome)
}

/// Fits the coefficients of noise to a curve that was read from `path`.
///
/// # Errors
/// The limits do not agree with each other, the fit or the unit of the curve.
pub fn fit_curve(
    file: CurveFile,
    path: &Path,
    fitting: Option<&Fitting>,
    limits: &[Limit],
) -> Result<Outcome, LogError> {
    check_limits(limits, fitting)?;
    applies(limits, &[file.unit])?;
    let analysis = given_curve::Analysis::new(file, path, fitting);
    let decision = analysis.decision(limits);
    let mut page = of_curve(&analysis, decision.answer.clone());
    page.tables.extend(decision.file());
    let mut outcome = Outcome::new(analysis.heading(), page).among(ALLAN_FILES);
    let noise = analysis.noise_file().map(|text| ("noise.toml".to_owned(), text.into_bytes()));
    outcome.files = noise.into_iter().collect();
    Ok(outcome)
}

/// The request for the comparison of two logs.
#[derive(Debug, Clone)]
pub struct CompareRequest {
    /// Treatment of both logs.
    pub treatment: Treatment,
    /// The fit of coefficients; without one, only the curves are compared.
    pub fitting: Option<Fitting>,
    /// Largest accepted ratios, the second log over the first.
    pub limits: Vec<RatioLimit>,
}

impl CompareRequest {
    /// Checks that the limits agree with each other and with the fit.
    ///
    /// # Errors
    /// They do not.
    pub fn check(&self) -> Result<(), LogError> {
        let fitted = self.fitting.as_ref().map(|fitting| fitting.terms.all());
        logs::check(&self.limits, fitted).map_err(LogError::RatioLimit)
    }
}

/// The files of [`compare_logs`].
const COMPARE_FILES: [&str; 7] =
    ["coefficients.csv", "compare.csv", "events.csv", "records.csv", "limits.csv", "chart-1", "chart-2"];

/// Compares two logs of a column each, which were read from these paths; a curve may stand for a log, and a noise file for one of them.
///
/// # Errors
/// The limits do not fit the request, or the logs have nothing in common to compare.
pub fn compare_logs(sides: [(&Path, Compared); 2], request: &CompareRequest) -> Result<Outcome, LogError> {
    request.check()?;
    let analysis = logs::Analysis::of(sides, &request.treatment, request.fitting.as_ref())?;
    let decision = analysis.decision(&request.limits);
    let log = |(_, compared)| if let Compared::Log(log) = compared { Some(log) } else { None };
    let page = of_comparison(sides.map(log), &analysis, &decision);
    let heading = analysis.sides.each_ref().map(logs::Side::heading).join(" · ");
    Ok(Outcome::new(heading, page).among(COMPARE_FILES))
}

/// The request for the values of a batch of units.
#[derive(Debug, Clone)]
pub struct BatchRequest {
    /// The fit of coefficients.
    pub fitting: Option<Fitting>,
    /// Limits on the noise of each unit.
    pub limits: Vec<Limit>,
}

impl BatchRequest {
    /// Checks that the limits agree with each other and with the fit.
    ///
    /// # Errors
    /// They do not.
    pub fn check(&self) -> Result<(), LogError> {
        Ok(check_limits(&self.limits, self.fitting.as_ref())?)
    }

    /// Analyses a log of the batch that was read from `path`, each column of which is a unit. Thus the logs need not be in memory
    /// together.
    ///
    /// # Errors
    /// A limit has the unit of no column, or the log is too short.
    pub fn analyze(&self, log: &Log, path: &Path, treatment: &Treatment) -> Result<log::Analysis, LogError> {
        self.check()?;
        check_units(&self.limits, log)?;
        let request = NoiseRequest { fitting: self.fitting.clone(), ..NoiseRequest::default() };
        Ok(log::Analysis::of(log, path, treatment, &request, &Silent)?)
    }
}

/// Pools the units of some logs.
///
/// # Errors
/// They are no batch.
pub fn compare_units(logs: Vec<log::Analysis>, request: &BatchRequest) -> Result<Outcome, LogError> {
    let batch = Batch::new(logs)?;
    let decision = batch.decision(&request.limits);
    let logs = match batch.logs.len() {
        1 => "a log".to_owned(),
        count => format!("{count} logs"),
    };
    let heading = format!("{} units of {logs}", batch.labels.len());
    Ok(Outcome::new(heading, of_batch(&batch, &decision)).among(["limits.csv", "chart-1", "chart-2"]))
}

/// The noise of each of three units that ran together, the columns of logs that were read from these paths.
///
/// # Errors
/// There are not three units, or they were not sampled together.
pub fn three_cornered_hat(logs: &[(&Path, &Log)], treatment: &Treatment) -> Result<Outcome, LogError> {
    let hat = hat::Analysis::of(logs, treatment)?;
    Ok(Outcome::new(hat.heading(), of_hat(&hat)).among(["hat.csv", "chart-1"]))
}

/// The noise that is modelled.
#[derive(Debug, Clone, Copy)]
pub enum ModelSource<'a> {
    /// A log that was read from this path.
    Log(&'a Log, &'a Path),
    /// A curve that was read from this path.
    Curve(&'a CurveFile, &'a Path),
    /// A noise.toml.
    NoiseFile(&'a Path),
    /// The text of a noise.toml with this name.
    NoiseText(&'a str, &'a str),
}

/// Points of the curve of a log per decade of τ.
const PER_DECADE: u32 = 10;

/// Finds the models of some noise for a filter, and writes them for tools.
///
/// # Errors
/// The noise cannot be read, has no curve between the requested times, or no model fits.
pub fn model_noise(
    source: ModelSource,
    request: &ModelRequest,
    progress: &dyn Progress,
) -> Result<Outcome, LogError> {
    let (source, targets) = match source {
        ModelSource::Log(log, path) => {
            // Events are no noise that a filter could have a state for.
            let treatment = Treatment { events_removed: true, ..request.treatment };
            let noise = NoiseRequest {
                taus: Taus::Decade(PER_DECADE),
                confidence: request.confidence,
                fitting: request.fitting.clone(),
                // Only the quantization of the fit is needed.
                ..NoiseRequest::default()
            };
            let analysis = log::Analysis::of(log, path, &treatment, &noise, progress)?;
            (Source::of_log(&analysis), Target::of_log(&analysis)?)
        }
        ModelSource::Curve(file, path) => {
            let curve = given_curve::Analysis::new(file.clone(), path, request.fitting.as_ref());
            (Source::of_curve(&curve), vec![Target::of_curve(&curve)?])
        }
        // Fit and treatment mean nothing for coefficients.
        ModelSource::NoiseFile(path) => {
            of_file(path, request).map(|(source, target)| (source, vec![target]))?
        }
        ModelSource::NoiseText(name, text) => {
            of_text(name, text, request).map(|(source, target)| (source, vec![target]))?
        }
    };
    let analysis = model::Analysis::of(source, targets, request)?;
    let texts = texts(&analysis, &request.writers);
    let files = WRITERS.iter().map(|writer| writer.file);
    let names = ["model.csv", "model", "model-accelerometers"].into_iter().chain(files);
    let mut page = of_model(&analysis, &texts);
    page.notes.splice(0..0, notes(&analysis, &request.writers));
    let mut outcome = Outcome::new(analysis.source.heading.clone(), page).among(names);
    outcome.files = texts.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())).collect();
    outcome.models = Some(Models::new(&analysis));
    Ok(outcome)
}
