//! Deviations and fits of a record.

use std::ffi::CString;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sagnac::allan::angles::{Angles, Trend};
use sagnac::allan::deviation::{Deviation, Taus};
use sagnac::allan::{Minimum, Point, curve, suppose};
use sagnac::analysis::data_sheet::{DataSheet, Intervals};
use sagnac::analysis::log::report::in_run_bias_stability;
use sagnac::analysis::log::{Suppose, Treatment, events, model, slope, temperatures};
use sagnac::analysis::requirement::{Limit, Limited, Subject, applies, check, decide};
use sagnac::events::{Event, Events};
use sagnac::fit::curve::{FitError, curve_of};
use sagnac::fit::selection::{Fitting, Terms};
use sagnac::record::excess;
use sagnac::record::log::measure::{Data, Doubt, MIN_SAMPLES, Unit};
use sagnac::record::log::outliers::Outliers;
use sagnac::record::log::{Fault, Log, MAX_SAMPLES, Samples};
use sagnac::report::page::{Rows, json};
use sagnac::table::Table;
use sagnac::theory::allan::terms::Term;
use sagnac::theory::allan::{Estimator, FLAT_LEVEL, Part};
use sagnac_base::quantity::number::significant;

use super::argument::word;
use super::compute::{compute_on, read_on};
use super::failure::{Failure, in_python};
use super::log::{Given, check_of, kind_of, unit_of};

/// The kind of the samples, and their treatment.
#[derive(FromPyObject)]
pub struct Reading {
    kind: String,
    unit: String,
    step_s: f64,
    detrend: bool,
    remove_outliers: bool,
    remove_events: bool,
    unit_check: bool,
    pub threads: usize,
}

/// A point of a fitted curve: τ, the deviation, and that of the fit.
type Fitted = (f64, f64, Option<f64>);

/// The places at which coefficients are read off: name, τ and deviation. Those beyond the curve are left out. The bias instability is read
/// off where the fit is least.
fn marks(sheet: &DataSheet, fitted: &[Fitted]) -> Vec<(&'static str, f64, f64)> {
    let known = fitted.iter().filter_map(|&(tau_s, _, value)| Some((tau_s, value?)));
    let plateau = known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(tau_s, _)| tau_s);
    let [first, last] = [fitted.first(), fitted.last()].map(|place| place.map_or(0.0, |(tau_s, ..)| *tau_s));
    let mark = |part: &Part| {
        let name = part.term.symbol();
        sheet.rows.iter().find(|row| row.name == name && row.value.is_some())?;
        match part.term {
            Term::BiasInstability => Some((name, plateau?, FLAT_LEVEL.sqrt() * part.size)),
            term => {
                let tau_s = term.read_at().filter(|tau_s| (first..=last).contains(tau_s))?;
                Some((name, tau_s, part.size))
            }
        }
    };
    sheet.fit.process.parts.iter().filter_map(mark).collect()
}

/// A record prepared for the analysis.
struct Record {
    angles: Angles,
    outliers: Outliers,
    treatment: Treatment,
    step_s: f64,
    /// Names of the columns of temperature, and °C at each increment.
    thermometers: Vec<String>,
    temperatures: Vec<Vec<f64>>,
    missing: usize,
    mean_rate: Option<f64>,
    /// Slope in the unit of the curve per s.
    slope: f64,
    /// What looks doubtful in the samples.
    doubt: Option<String>,
    /// What was inferred about a log.
    notes: Vec<String>,
    unit: sagnac::allan::deviation::Unit,
}

impl Record {
    /// What it holds besides noise.
    fn events(&self) -> Events<'_> {
        self.treatment.events(&self.angles, &self.outliers, &self.temperatures)
    }

    /// The record as it is checked against limits, without what it shows.
    fn subject(&self) -> Subject<'_> {
        Subject {
            label: "record",
            unit: self.unit,
            noise: Ok(None),
            stability: None,
            floor: None,
            stability_tau_s: None,
            samples: self.angles.len().saturating_sub(1),
            step_s: self.step_s,
            spread: self.angles.spread(),
        }
    }
}

/// Averaging times: the name of a choice, or seconds.
#[derive(FromPyObject)]
pub enum Times {
    Named(String),
    Seconds(Vec<f64>),
}

impl Times {
    pub fn taus(self) -> Result<Taus, Failure> {
        match self {
            Times::Seconds(seconds) => Ok(Taus::Seconds(seconds)),
            Times::Named(name) => match name.as_str() {
                "octave" => Ok(Taus::Octave),
                "decade10" => Ok(Taus::Decade(10)),
                "decade20" => Ok(Taus::Decade(20)),
                "all" => Ok(Taus::All),
                other => Err(Failure::Usage(format!(
                    "taus=\"{other}\" is not known\naccepted: \"octave\", \"decade10\", \"decade20\", \"all\", or seconds as in \
                     [1, 10, 100]"
                ))),
            },
        }
    }
}

impl Reading {
    fn trend(&self) -> Trend {
        if self.detrend { Trend::Linear } else { Trend::None }
    }

    /// The treatment of the samples.
    pub fn treatment(&self) -> Treatment {
        Treatment {
            trend: self.trend(),
            outliers_removed: self.remove_outliers,
            events_removed: self.remove_events,
            unit_check: check_of(self.unit_check),
            ..Treatment::AS_RECORDED
        }
    }

    /// The quantity and the unit of usable samples.
    fn checked(&self, values: &[f64]) -> Result<(Data, Unit), Failure> {
        let data = kind_of(&self.kind)?;
        let unit = unit_of(&self.unit, data)?;
        if values.len() > MAX_SAMPLES {
            let found = format!("the array has {} samples, more than {MAX_SAMPLES}", values.len());
            return Err(Failure::Record(format!("{found}\nanalyse a part of it, or average neighbours")));
        }
        let found = values.iter().enumerate().find_map(|(place, value)| Some((place, excess(*value)?)));
        if let Some((place, excess)) = found {
            let help = "give NaN for missing samples";
            return Err(Failure::Record(format!("sample {place} of the array is {excess}\n{help}")));
        }
        let samples = Samples { data, unit: &unit, step_s: self.step_s, values };
        if let Some(fault) = samples.fault() {
            return Err(Failure::Record(in_words(fault)));
        }
        Ok((data, unit))
    }

    /// The array as a log of one column called `name`.
    ///
    /// # Errors
    /// The samples are unusable, or an argument is not accepted.
    pub fn log(&self, values: &[f64], name: &str) -> Result<Log, Failure> {
        let (data, unit) = self.checked(values)?;
        Ok(Log::of_column(name, data, unit, self.step_s, values.to_vec()))
    }

    /// The samples prepared for the analysis.
    ///
    /// # Errors
    /// The samples of an array are unusable, a log has several columns, or an argument is not accepted.
    fn record(&self, py: Python, given: &Given) -> PyResult<Record> {
        match given {
            Given::Array(data) => {
                let values = side_by_side(data)?;
                read_on(py, self.threads, || {
                    let (data, unit) = self.checked(values)?;
                    let samples = Samples { data, unit: &unit, step_s: self.step_s, values };
                    let doubt = samples.doubt().filter(|_| self.unit_check);
                    let doubt = doubt.map(|doubt| warning(doubt, &unit));
                    Ok(Record { doubt, ..Record::new(&samples, self.treatment()) })
                })
            }
            Given::Log(log) => {
                let log = &log.get().read;
                compute_on(py, self.threads, || {
                    let [channel] = &log.channels[..] else { return Err(several(log)) };
                    let treatment = self.treatment().of(log);
                    let (thermometers, temperatures) = temperatures(log);
                    let notes = log.notes.iter().map(|note| in_python(note)).collect();
                    let record = Record::new(&channel.view(log.data, log.step_s), treatment);
                    Ok(Record { thermometers, temperatures, notes, ..record })
                })
            }
        }
    }
}

impl Record {
    fn new(samples: &Samples, treatment: Treatment) -> Record {
        let (angles, outliers) = treatment.angles(samples, &[]);
        Record {
            doubt: None,
            notes: vec![],
            thermometers: vec![],
            temperatures: vec![],
            missing: angles.missing(),
            mean_rate: samples.mean_rate(),
            slope: slope(&angles, samples),
            outliers,
            treatment,
            step_s: samples.step_s,
            unit: samples.unit.curves,
            angles,
        }
    }
}

/// The error for a log with several columns where one is needed.
fn several(log: &Log) -> Failure {
    let names: Vec<&str> = log.channels.iter().map(|channel| channel.name.as_str()).collect();
    let (first, names) = (names[0], names.join(", "));
    Failure::Usage(format!("the log has several columns: {names}\nchoose one, as in log[\"{first}\"]"))
}

/// The message for refused samples.
fn in_words(fault: Fault) -> String {
    match fault {
        Fault::TooFew(there) => format!(
            "the array has {there} samples, at least {MIN_SAMPLES} are needed\nrecord longer, or remove less"
        ),
        Fault::Constant { there, value } => format!(
            "the array is constant: all {there} samples are {value}\nis it the right column, and was the sensor on? a \
             constant has no deviation to show"
        ),
    }
}

/// The warning on samples whose unit is doubtful.
fn warning(doubt: Doubt, unit: &Unit) -> String {
    let off = "if the unit is right, give unit_check=False";
    let rate = |mean: f64| format!("{} deg/h", significant(mean, 3));
    let in_g = |mean: f64| format!("{} g", significant(1e-6 * mean, 3));
    match doubt {
        Doubt::DegreesAsRadians(mean) => format!(
            "the array looks like degrees taken for radians: its mean is {}\ngive the unit in deg; {off}",
            rate(mean)
        ),
        Doubt::NeverAtRest(mean) => {
            let is_acceleration = unit.curves == sagnac::allan::deviation::Unit::Acceleration;
            let (mean, sensor) =
                if is_acceleration { (in_g(mean), "accelerometer") } else { (rate(mean), "gyro") };
            format!(
                "the array has a mean {} of {mean}, which no {sensor} at rest has\nis {} its unit? is kind= right? {off}",
                unit.curves.measured(),
                unit.text
            )
        }
        Doubt::Gravity { mean, other } => format!(
            "the array looks like {other} taken for {}: its mean is {}, and would be that of gravity\ngive the unit; {off}",
            unit.text,
            in_g(mean)
        ),
    }
}

/// The contiguous samples of an array, without a copy. They are read with Python's lock, because another thread may write to
/// the array.
pub fn side_by_side<'a>(data: &'a PyReadonlyArray1<'_, f64>) -> PyResult<&'a [f64]> {
    data.as_slice().map_err(|error| Failure::Usage(error.to_string()).into())
}

/// The common results of both functions for a record.
fn document<'py>(py: Python<'py>, record: &Record) -> PyResult<Bound<'py, PyDict>> {
    if let Some(doubt) = &record.doubt {
        let message = CString::new(doubt.as_str())?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &message, 2)?;
    }
    let document = PyDict::new(py);
    let outliers: Vec<i64> = record.outliers.samples.iter().map(|&sample| sample as i64).collect();
    document.set_item("notes", &record.notes)?;
    document.set_item("missing", record.missing)?;
    document.set_item("mean_rate", record.mean_rate)?;
    document.set_item("removed_slope_per_s", record.slope)?;
    document.set_item("outliers", PyArray1::from_vec(py, outliers))?;
    document.set_item("outlier_threshold", record.outliers.threshold)?;
    document.set_item("unit", record.unit.in_files(Deviation::Oadev))?;
    Ok(document)
}

/// A table as JSON: its rows as objects.
fn rows_of(table: &Table) -> String {
    json(&Rows(table))
}

/// The events of a record as JSON.
fn shown(record: &Record, events: &[Event], keeps_events: bool) -> String {
    let Record { unit, step_s, ref treatment, ref thermometers, .. } = *record;
    let of = events::Record { name: "", unit, treatment, step_s, keeps_events, thermometers };
    rows_of(&events::table_of(&of.rows(events)))
}

/// The noise that intervals suppose, by its name.
///
/// # Errors
/// The name is unknown.
pub fn suppose_of(name: &str) -> Result<Suppose, Failure> {
    word("intervals", name, &[("record", Suppose::Record), ("stable32", Suppose::Stable32)])
}

/// Deviations of a record, each as a tuple of its name, its unit, its columns and its minimum.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn curves<'py>(
    py: Python<'py>,
    given: Given<'py>,
    reading: Reading,
    deviations: Vec<String>,
    taus: Times,
    confidence: f64,
    intervals: &str,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let supposed = suppose_of(intervals)?;
    let record = reading.record(py, &given)?;
    let limits = limits_of(&limits, &[Limited::Stability], None, &[record.unit])?;
    let (record, curves, events) = compute_on(py, reading.threads, || {
        let taus = taus.taus()?;
        let events = record.events();
        let model = (supposed == Suppose::Record).then(|| model(&events.without, reading.trend()));
        let events = shown(&record, &events.list, true);
        let of = |name: &String| {
            let deviation: Deviation = name.parse().map_err(|error| Failure::Usage(format!("{error}")))?;
            let factors = taus.factors(record.angles.len(), record.step_s, deviation)?;
            let mut points = curve(&record.angles, deviation, &factors, confidence);
            if let Some(model) = &model {
                suppose(&mut points, &record.angles, deviation, confidence, model.as_ref());
            }
            Ok((deviation, points))
        };
        let curves = deviations.iter().map(of).collect::<Result<Vec<_>, Failure>>()?;
        Ok((record, curves, events))
    })?;
    let document = document(py, &record)?;
    document.set_item("events", events)?;
    let stability = curves.iter().find(|(deviation, _)| !deviation.is_of_angle());
    let samples = record.angles.len().saturating_sub(1);
    let stability = stability.and_then(|(deviation, points)| {
        let least = Minimum::from_record(points, samples)?;
        Some(in_run_bias_stability(record.unit, *deviation, &least))
    });
    let subject = Subject { stability, ..record.subject() };
    let decision = decide(&[subject], &limits, "record");
    document.set_item("answer", super::run::shown(&decision.answer))?;
    document.set_item("limits", rows_of(&decision.table()))?;
    let curves =
        curves.iter().map(|(deviation, points)| of_curve(py, *deviation, points, samples, record.unit));
    document.set_item("curves", curves.collect::<PyResult<Vec<_>>>()?)?;
    Ok(document)
}

fn of_curve<'py>(
    py: Python<'py>,
    deviation: Deviation,
    points: &[Point],
    samples: usize,
    unit: sagnac::allan::deviation::Unit,
) -> PyResult<Bound<'py, PyDict>> {
    let document = PyDict::new(py);
    let numbers = |of: &dyn Fn(&Point) -> Option<f64>| {
        PyArray1::from_vec(py, points.iter().map(|point| of(point).unwrap_or(f64::NAN)).collect())
    };
    let counts = |of: &dyn Fn(&Point) -> u64| {
        PyArray1::from_vec(py, points.iter().map(|point| of(point) as i64).collect())
    };
    document.set_item("deviation", deviation.name())?;
    document.set_item("unit", unit.in_files(deviation))?;
    document.set_item("m", counts(&|point| point.m as u64))?;
    document.set_item("tau", numbers(&|point| Some(point.tau_s)))?;
    document.set_item("differences", counts(&|point| point.terms))?;
    document.set_item("value", numbers(&|point| point.value))?;
    document.set_item("lower", numbers(&|point| point.interval.map(|ends| ends.0)))?;
    document.set_item("upper", numbers(&|point| point.interval.map(|ends| ends.1)))?;
    document.set_item("alpha", numbers(&|point| point.noise.map(|noise| noise.alpha.into())))?;
    let carried: Vec<bool> = points.iter().map(|p| p.noise.is_some_and(|noise| noise.carried)).collect();
    document.set_item("alpha_carried", PyArray1::from_vec(py, carried))?;
    document.set_item("edf", numbers(&|point| point.edf))?;
    // A time deviation rises with τ, so its minimum does not describe stability.
    let least = Minimum::from_record(points, samples).filter(|_| !deviation.is_of_angle()).map(|least| {
        let ends = least.point.interval.unzip();
        (least.point.tau_s, least.point.value, ends.0, ends.1, least.at_end)
    });
    document.set_item("minimum", least)?;
    Ok(document)
}

/// The coefficients of a record, each as a tuple, with the fitted curve.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is one of the function in Python")]
pub fn fit<'py>(
    py: Python<'py>,
    given: Given<'py>,
    reading: Reading,
    terms: Option<Vec<String>>,
    range: (Option<f64>, Option<f64>),
    is_forced: bool,
    bootstrap: Option<usize>,
    limits: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let record = reading.record(py, &given)?;
    let (record, sheet, fitted, decision, events) = compute_on(py, reading.threads, || {
        let terms = terms_of(terms.as_deref(), reading.trend())?;
        let known = Term::ALL.map(Limited::Coefficient);
        let limits = limits_of(&limits, &known, Some(terms.all()), &[record.unit])?;
        let simulated = Intervals::simulated(bootstrap, record.angles.len().saturating_sub(1));
        let fitting = Fitting { terms, from_s: range.0, to_s: range.1, is_forced };
        let events = record.events();
        // Terms that are asked for are fitted to the record as it is.
        let keeps_events = matches!(fitting.terms, Terms::Given(_));
        let events = if keeps_events { events.kept(&record.angles) } else { events };
        let sheet = DataSheet::new(&events, &fitting, record.unit, simulated, None)
            .map_err(|why| Failure::Record(format!("no coefficients: {why}")))?;
        let curve = curve_of(&events.without)
            .map_err(|error: FitError| Failure::Record(format!("no coefficients: {error}")))?;
        let fitted: Vec<Fitted> = curve
            .ms()
            .iter()
            .zip(curve.variances())
            .map(|(&m, variance)| {
                let (tau_s, [from_s, to_s]) = (m as f64 * curve.sample_s(), sheet.fit.tau_range);
                let is_fitted = sheet.fit.is_described() && (0.99 * from_s..=1.01 * to_s).contains(&tau_s);
                let model = sheet.fit.process.expected(Estimator::OVERLAPPING, curve.samples(), m);
                (tau_s, variance.sqrt(), model.filter(|_| is_fitted).map(f64::sqrt))
            })
            .collect();
        let subject = Subject { noise: Ok(Some(&sheet)), ..record.subject() };
        let decision = decide(&[subject], &limits, "record");
        let all = [&events.list[..], &sheet.events].concat();
        let events = shown(&record, &all, keeps_events);
        Ok((record, sheet, fitted, decision, events))
    })?;
    let document = document(py, &record)?;
    document.set_item("events", events)?;
    document.set_item("marks", marks(&sheet, &fitted))?;
    let rows = sheet.rows.iter().map(|row| {
        let [lower, upper] = row.interval.map_or([None; 2], |ends| ends.map(Some));
        (row.name, row.unit, row.value, lower, upper, row.verdict)
    });
    document.set_item("answer", super::run::shown(&decision.answer))?;
    document.set_item("limits", rows_of(&decision.table()))?;
    document.set_item("rows", rows.collect::<Vec<_>>())?;
    document.set_item("intervals", sheet.intervals.name())?;
    let why = sheet.intervals.without.as_deref().map(in_python);
    document.set_item("without_bootstrap", why)?;
    document.set_item("described", sheet.fit.is_described())?;
    document.set_item("range", sheet.fit.tau_range)?;
    document.set_item("chi_squared", sheet.fit.chi_squared)?;
    document.set_item("degrees_of_freedom", sheet.fit.degrees_of_freedom)?;
    document.set_item("p_value", sheet.fit.p_value())?;
    let column = |of: &dyn Fn(&Fitted) -> f64| PyArray1::from_vec(py, fitted.iter().map(of).collect());
    document.set_item("tau", column(&|(tau, ..)| *tau))?;
    document.set_item("deviation", column(&|(_, deviation, _)| *deviation))?;
    document.set_item("fitted", column(&|(.., fitted)| fitted.unwrap_or(f64::NAN)))?;
    Ok(document)
}

/// The limits of these texts on some of `known`, for records of these units and a fit of these terms.
///
/// # Errors
/// A text is no limit, or a limit does not fit the record, the fit or another limit.
pub fn limits_of(
    texts: &[String],
    known: &[Limited],
    fitted: Option<&[Term]>,
    units: &[sagnac::allan::deviation::Unit],
) -> Result<Vec<Limit>, Failure> {
    let limits = texts.iter().map(|text| Limit::parse(text, known)).collect::<Result<Vec<_>, _>>()?;
    check(&limits, fitted)?;
    applies(&limits, units)?;
    Ok(limits)
}

/// The terms of these names; without them those that the record supports.
///
/// # Errors
/// A name is not that of a term.
pub fn terms_of(names: Option<&[String]>, trend: Trend) -> Result<Terms, Failure> {
    match names {
        None => Ok(Terms::of_model(trend)),
        Some(names) => Ok(Terms::Given(names.iter().map(|name| term(name)).collect::<Result<_, _>>()?)),
    }
}

fn term(name: &str) -> Result<Term, Failure> {
    let found = Term::ALL.into_iter().find(|term| term.symbol().eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        let known = Term::ALL.map(Term::symbol).join(", ");
        Failure::Usage(format!("terms: `{name}` is not a term\naccepted: \"auto\", or some of {known}"))
    })
}
