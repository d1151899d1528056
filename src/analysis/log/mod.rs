//! The noise of a recorded log: its deviations, its coefficients, and notes on both.
//!
//! ```text
//! Log, NoiseRequest ─ of ─▶ Analysis ─┬─ tables, records ─▶ curve.csv, coefficients.csv, records.csv
//!                              ├─ events ─▶ events.csv
//!                              ├─ figures ─▶ charts
//!                              └─ noise_file ─▶ noise.toml, for studies
//! ```

mod bag_folder;
pub mod events;
pub mod figures;
pub mod noise_file;
pub mod report;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use crate::analysis::data_sheet::{DataSheet, Intervals, Row};
use crate::analysis::temperature::smoothing::Course;
use crate::analysis::temperature::{MIN_CHANGE, smoothing};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_engine::kinds::allan::run::Simulator;
use sagnac_records::allan::{
    Angles, Deviation, Line, MAX_OF_COLUMNS, Minimum, Overdispersion, Point, TauError, Taus, Trend, Unit,
    curve, suppose,
};
use sagnac_records::events::{Event, Events};
use sagnac_records::fit::{Coefficient, Described, Fitting, Terms, Verdict, describe};
use sagnac_records::record::RecordError;
use sagnac_records::record::log::measure::{Data, UnitCheck};
use sagnac_records::record::log::outliers::Outliers;
use sagnac_records::record::log::read::Request;
use sagnac_records::record::log::{Channel, Field, Log, Samples};
use sagnac_theory::allan::{Process, Term};

/// Number of simulated samples from which on the simulation is announced.
const LONG: usize = 1_000_000_000;

/// Endings of the names of recorded logs, in lower case.
pub const ENDINGS: [&str; 21] = [
    "csv", "tsv", "dat", "log", "npy", "npz", "mat", "h5", "hdf5", "nc", "mcap", "bag", "bin", "lvm", "raw",
    "ulg", "db3", "parquet", "gz", "bz2", "zst",
];

/// The request for an analysis.
#[derive(Debug, Clone)]
pub struct NoiseRequest {
    /// Averaging times.
    pub taus: Taus,
    /// Deviations, each a curve.
    pub deviations: Vec<Deviation>,
    /// Probability of the intervals of deviations.
    pub confidence: f64,
    /// Noise that the intervals of deviations suppose.
    pub intervals: Suppose,
    /// The fit, if any.
    pub fitting: Option<Fitting>,
    /// Number of simulated records for the intervals of coefficients, 0 for intervals in closed form; by default as
    /// many as take a few seconds.
    pub simulated: Option<usize>,
    /// The simulator of these records; by default the processor.
    pub simulator: Option<Arc<dyn Simulator>>,
}

impl Default for NoiseRequest {
    /// The overlapping Allan deviation at octaves with 95 % intervals, without a fit; intervals of coefficients in closed form.
    fn default() -> NoiseRequest {
        NoiseRequest {
            taus: Taus::Octave,
            deviations: vec![Deviation::Oadev],
            confidence: 0.95,
            intervals: Suppose::Record,
            fitting: None,
            simulated: Some(0),
            simulator: None,
        }
    }
}

impl NoiseRequest {
    /// Whether events stay in the record: there is no fit, or its terms are given.
    fn keeps_events(&self) -> bool {
        !matches!(self.fitting, Some(Fitting { terms: Terms::Auto(_), .. }))
    }
}

/// The noise that the intervals of deviations suppose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Suppose {
    /// That of the record as a whole: the terms that describe its curve, and at shorter τ its autocorrelation.
    Record,
    /// The power law identified at each τ, as in Stable32.
    Stable32,
}

/// The result for one file.
#[derive(Debug)]
pub struct Analysis {
    /// Path of the log.
    pub path: PathBuf,
    /// Quantity of its samples.
    pub data: Data,
    /// Number of samples, including missing ones.
    pub samples: usize,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Probability of the intervals of deviations.
    pub confidence: f64,
    /// Treatment of the log.
    pub treatment: Treatment,
    /// What was inferred about the file, and what looks doubtful in it, in a line each.
    pub reading: Vec<String>,
    /// Whether events stay in the record, because there is no fit or its terms were given.
    pub keeps_events: bool,
    /// Names of the columns of temperature.
    pub thermometers: Vec<String>,
    /// Requested columns.
    pub columns: Vec<Column>,
}

/// The result for one column of the file.
#[derive(Debug)]
pub struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit of its curves.
    pub unit: Unit,
    /// Unit in the header, where another one was used.
    pub overruled: Option<String>,
    /// The field of messages from which it was read, if it is from one, with the unit of its samples.
    pub field: Option<(Field, String)>,
    /// Number of samples missing in the file, and of outliers and samples of events that were removed.
    pub missing: usize,
    /// Hash of its samples, which is that of an equal record.
    pub digest: u64,
    /// The earlier record that has the same samples.
    pub same_as: Option<String>,
    /// Stretches of samples that are missing in the file.
    pub gaps: Vec<Range<usize>>,
    /// Outliers of the rates or increments in the file.
    pub outliers: Outliers,
    /// What the record holds besides noise.
    pub events: Vec<Event>,
    /// Mean rate or acceleration in the unit of the curve; absent for plain numbers that are not rates.
    pub mean_rate: Option<f64>,
    /// Deviations of its estimates beyond those of Gaussian noise, which intervals contain.
    pub spread: Overdispersion,
    /// Removed slope, in the unit of the curve per s.
    pub slope: f64,
    /// Curves, one for each deviation.
    pub curves: Vec<Curve>,
    /// Noise coefficients; absent where they were not requested, or the reason why they cannot be determined.
    pub noise: Result<Option<DataSheet>, String>,
}

impl Column {
    /// A column whose samples have these outliers, and these angles, without curves and coefficients.
    fn new(channel: &Channel, samples: &Samples, outliers: Outliers, angles: &Angles) -> Column {
        Column {
            name: channel.name.clone(),
            unit: channel.unit.curves,
            overruled: channel.overruled(),
            field: channel.field.clone().map(|field| (field, channel.unit.text.clone())),
            missing: angles.missing(),
            digest: digest(&channel.samples),
            same_as: None,
            gaps: samples.gaps(),
            mean_rate: samples.mean_rate(),
            slope: slope(angles, samples),
            spread: angles.spread().clone(),
            curves: vec![],
            outliers,
            events: vec![],
            noise: Ok(None),
        }
    }

    /// The noise, where there is one.
    pub fn noise(&self) -> Option<&DataSheet> {
        self.noise.as_ref().ok()?.as_ref()
    }

    /// Whether outliers among the `samples` are no spikes, but the tails of the noise.
    pub fn has_long_tails(&self, samples: usize) -> bool {
        !self.outliers.samples.is_empty() && !self.outliers.are_spikes(samples)
    }

    /// The minimum of its first curve of rates, with that curve.
    pub fn minimum(&self) -> Option<(&Curve, &Minimum)> {
        let curve = self.curves.iter().find(|curve| !curve.deviation.is_of_angle())?;
        Some((curve, curve.minimum.as_ref()?))
    }

    /// Its coefficients; empty where there are none.
    pub fn coefficients(&self) -> &[Row] {
        self.noise().map_or(&[], |noise| &noise.rows)
    }
}

/// A deviation of a column.
#[derive(Debug, PartialEq)]
pub struct Curve {
    /// Deviation.
    pub deviation: Deviation,
    /// Points in the order of τ.
    pub points: Vec<Point>,
    /// The lowest point up to an eighth of the record; absent for a time deviation, which rises with τ and does not describe stability.
    pub minimum: Option<Minimum>,
}

/// The treatment of a log before its curves are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Treatment {
    /// Time left out at the start, s.
    pub skip_s: f64,
    /// End of the part that is used, from the start of the file, s.
    pub until_s: Option<f64>,
    /// Trend removed from the rate or acceleration.
    pub trend: Trend,
    /// Whether outliers are treated as gaps.
    pub outliers_removed: bool,
    /// Whether the events that a record holds besides noise are removed.
    pub events_removed: bool,
    /// Whether rates and accelerations that appear to be in a wrong unit are noted.
    pub unit_check: UnitCheck,
    /// Whether the dependence on temperature was subtracted, as the log says that is analysed.
    pub is_compensated: bool,
}

impl Treatment {
    /// The whole record as it is.
    pub const AS_RECORDED: Treatment = Treatment {
        skip_s: 0.0,
        until_s: None,
        trend: Trend::None,
        outliers_removed: false,
        events_removed: false,
        unit_check: UnitCheck::On,
        is_compensated: false,
    };

    /// Reads the log at `path`, which may be the folder of a recording of ROS 2, cuts and checks it.
    ///
    /// # Errors
    /// The log is refused.
    pub fn read(&self, path: &Path, request: &Request) -> Result<Log, RecordError> {
        self.checked(if path.is_dir() { bag_folder::read(path, request)? } else { Log::read(path, request)? })
    }

    /// Cuts and checks a log that was read.
    ///
    /// # Errors
    /// Nothing is left of it, or its numbers seem to be something else.
    pub fn checked(&self, mut log: Log) -> Result<Log, RecordError> {
        if self.skip_s > 0.0 || self.until_s.is_some() {
            log.cut(self.skip_s, self.until_s)?;
        }
        log.check(self.unit_check)?;
        Ok(log)
    }

    /// The treatment of a log, with what was done to it already.
    pub fn of(&self, log: &Log) -> Treatment {
        Treatment { skip_s: log.start_s, is_compensated: log.is_compensated, ..*self }
    }

    /// The treatment that two logs have in common; one may lack events, or a dependence on temperature, which its notes say.
    pub(crate) fn common(self, other: Treatment) -> Treatment {
        Treatment {
            is_compensated: self.is_compensated || other.is_compensated,
            events_removed: self.events_removed || other.events_removed,
            ..self
        }
    }

    /// The log as it is analysed: where they are to be removed, outliers are missing, and rates or increments are without events.
    /// Without outliers or events angles are not known relative to each other, so only logs of rates and increments can lack them.
    pub fn applied(&self, mut log: Log) -> Log {
        let (_, temperatures) = temperatures(&log);
        for channel in &mut log.channels {
            let samples = channel.view(log.data, log.step_s);
            let (recorded, outliers) = self.recorded(&samples);
            if self.events_removed {
                let events = self.events(&recorded, &outliers, &temperatures);
                channel.samples = samples.of_angles(&events.without);
            } else if self.outliers_removed {
                outliers.samples.iter().for_each(|&sample| channel.samples[sample] = f64::NAN);
            }
        }
        log
    }

    /// The angles of some samples, without outliers and events where they are to be removed, and the outliers among the rates or
    /// increments. `temperatures` are °C at each increment.
    pub fn angles(&self, samples: &Samples, temperatures: &[Vec<f64>]) -> (Angles, Outliers) {
        let (angles, outliers) = self.recorded(samples);
        match self.events_removed {
            true => (self.events(&angles, &outliers, temperatures).without.into_owned(), outliers),
            false => (angles, outliers),
        }
    }

    /// Returns the angles and outliers as [`Treatment::angles`] does, with the events that the samples hold besides noise.
    pub(crate) fn recorded(&self, samples: &Samples) -> (Angles, Outliers) {
        let outliers = samples.outliers();
        let angles = match self.outliers_removed {
            true => samples.angles_without(&outliers, self.trend),
            false => samples.angles(self.trend),
        };
        (angles, outliers)
    }

    /// What the angles of a record with these outliers hold besides noise. `temperatures` are °C at each increment.
    pub fn events<'a>(
        &self,
        angles: &'a Angles,
        outliers: &Outliers,
        temperatures: &[Vec<f64>],
    ) -> Events<'a> {
        let none = Outliers::default();
        Events::new(angles, if self.outliers_removed { &none } else { outliers }, temperatures)
    }

    /// Time of a sample from the start of the file, s.
    pub(crate) fn time(&self, sample: usize, step_s: f64) -> f64 {
        self.skip_s + sample as f64 * step_s
    }

    /// The parts left out, in a few words.
    pub fn left_out(&self) -> String {
        let part = |time_s: f64, words: &str| format!("{words} {} s", significant(time_s, 9));
        let parts = [
            (self.skip_s > 0.0).then(|| part(self.skip_s, "from")),
            self.until_s.map(|until_s| part(until_s, "until")),
            self.outliers_removed.then(|| "outliers removed".to_owned()),
            self.events_removed.then(|| "events removed".to_owned()),
            self.is_compensated.then(|| "temperature compensated".to_owned()),
        ];
        parts.into_iter().flatten().map(|part| format!("; {part}")).collect()
    }

    /// The whole treatment in a few words, for every output.
    pub fn summary(&self) -> String {
        let trend = match self.trend {
            Trend::None => "; no trend removed",
            Trend::Linear => "; linear trend removed: no R, K too low",
        };
        (self.left_out() + trend).trim_start_matches("; ").to_owned()
    }

    /// The parts left out, if any, and the effect of the trend.
    pub(crate) fn lines(&self, length_s: f64) -> Vec<String> {
        let left_out = Some(self.left_out()).filter(|text| !text.is_empty());
        let left_out = left_out.map(|text| text.trim_start_matches("; ").to_owned());
        left_out.into_iter().chain([self.effect(length_s)]).collect()
    }

    /// The effect of the trend on the coefficients R and K.
    pub fn effect(&self, length_s: f64) -> String {
        match self.trend {
            Trend::None => {
                "no trend was removed: a ramp R and a random walk K show as they were recorded".to_owned()
            }
            Trend::Linear => format!(
                "a linear trend was removed: the ramp R is gone with it, and above τ = {} s, a tenth of the record, the curve \
                 and with it the random walk K come out too low",
                significant(0.1 * length_s, 6)
            ),
        }
    }
}

impl Analysis {
    /// Analyses a log that was read from `path` with this treatment; `progress` receives a note on long simulations.
    ///
    /// # Errors
    /// An averaging time is outside the range of the log.
    pub fn of(
        log: &Log,
        path: &Path,
        treatment: &Treatment,
        request: &NoiseRequest,
        progress: &dyn Progress,
    ) -> Result<Analysis, TauError> {
        let together = log.samples() * log.channels.len();
        if request.taus == Taus::All && together > MAX_OF_COLUMNS {
            return Err(TauError::TooManyTogether(together));
        }
        let (thermometers, temperatures) = temperatures(log);
        let column = |channel: &Channel| column(log, channel, &temperatures, treatment, request, progress);
        let mut columns: Vec<Column> = log.channels.iter().map(column).collect::<Result<_, _>>()?;
        note_equal(&mut columns, &mut vec![], |column| column.name.clone());
        let keeps_events = request.keeps_events();
        let confidence = request.confidence;
        let analysis = Analysis {
            confidence,
            keeps_events,
            columns,
            ..Analysis::new(log, path, treatment, thermometers)
        };
        Ok(analysis.with_actual_treatment())
    }

    /// The analysis whose treatment says that events were removed only if there were any.
    fn with_actual_treatment(mut self) -> Analysis {
        self.treatment.events_removed &= events::are_removed(&self);
        self
    }

    /// A log without an analysis of its columns.
    fn new(log: &Log, path: &Path, treatment: &Treatment, thermometers: Vec<String>) -> Analysis {
        Analysis {
            path: path.to_owned(),
            data: log.data,
            samples: log.samples(),
            step_s: log.step_s,
            confidence: 0.95,
            treatment: treatment.of(log),
            reading: log.notes.clone(),
            keeps_events: false,
            thermometers,
            columns: vec![],
        }
    }

    /// A column of a log without curves and coefficients, and its record without events, which are left out of a comparison.
    pub(crate) fn of_record(
        log: &Log,
        channel: &Channel,
        path: &Path,
        treatment: &Treatment,
    ) -> (Analysis, Events<'static>) {
        let treatment = &Treatment { events_removed: true, ..*treatment };
        let samples = channel.view(log.data, log.step_s);
        let (recorded, outliers) = treatment.recorded(&samples);
        let (thermometers, temperatures) = temperatures(log);
        let events = treatment.events(&recorded, &outliers, &temperatures).owned();
        let column = Column::new(channel, &samples, outliers, &events.without);
        let columns = vec![Column { events: events.list.clone(), ..column }];
        let analysis = Analysis { columns, ..Analysis::new(log, path, treatment, thermometers) };
        (analysis.with_actual_treatment(), events)
    }

    /// Time from the first sample to the end of the last, s.
    pub fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    /// The units of its columns, in the order of [`Unit::ALL`].
    pub fn units(&self) -> impl Iterator<Item = Unit> {
        Unit::ALL.into_iter().filter(|unit| self.of_unit(*unit).next().is_some())
    }

    /// The columns whose curves have this unit.
    pub fn of_unit(&self, unit: Unit) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(move |column| column.unit == unit)
    }

    /// Time of a sample from the start of the file, s.
    pub(crate) fn time(&self, sample: usize) -> f64 {
        self.treatment.time(sample, self.step_s)
    }

    /// Notes columns whose samples are those of an `earlier` record, by its digest and name, and adds them to these.
    pub fn note_equal(&mut self, earlier: &mut Vec<(u64, String)>) {
        note_equal(&mut self.columns, earlier, |column| format!("{} {}", self.path.display(), column.name));
    }

    /// Times of samples from the start of the file, s.
    pub(crate) fn times<'a>(&'a self, samples: &'a [usize]) -> impl Iterator<Item = f64> + 'a {
        samples.iter().map(|&sample| self.time(sample))
    }

    /// The confidence as a percentage, such as `95 %`.
    pub fn percent(&self) -> String {
        format!("{} %", significant(100.0 * self.confidence, 6))
    }
}

/// The names of the temperatures of a log that change by more than the errors of their sensors, and each at every increment; none
/// for a log without its dependence on them.
pub fn temperatures(log: &Log) -> (Vec<String>, Vec<Vec<f64>>) {
    if log.is_compensated {
        return (vec![], vec![]);
    }
    let block = log.samples().div_ceil(smoothing::MAX_BLOCKS);
    let course = |(name, measured): &(String, Vec<f64>)| {
        let course = Course::new(measured, block);
        let course = if log.data == Data::Angle { course.midway() } else { course };
        let known: Vec<f64> = course.values.iter().copied().filter(|x| x.is_finite()).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        let square = known.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / known.len() as f64;
        // A constant temperature differs from its mean by rounding.
        let least = (MIN_CHANGE * course.error_of_mean(block)).max(1e-9);
        (libm::sqrt(square) > least).then(|| (name.clone(), course.values))
    };
    log.temperature.iter().chain(&log.thermometers).filter_map(course).unzip()
}

/// Notes columns whose samples are those of an earlier one or of an `earlier` record, and adds them to these.
fn note_equal(columns: &mut [Column], earlier: &mut Vec<(u64, String)>, name: impl Fn(&Column) -> String) {
    for column in columns {
        let same = earlier.iter().find(|(digest, _)| *digest == column.digest);
        column.same_as = column.same_as.take().or_else(|| same.map(|(_, name)| name.clone()));
        earlier.push((column.digest, name(column)));
    }
}

/// The hash of some samples, by which records are told apart.
fn digest(samples: &[f64]) -> u64 {
    // That of rustc, which takes a tenth of the time of a hash for foreign keys.
    let next = |hash: u64, word: u64| (hash.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95);
    let of = |part: &[f64]| part.iter().map(|sample| sample.to_bits()).fold(0, next);
    let parts: Vec<u64> = samples.par_chunks(1 << 16).map(of).collect();
    parts.into_iter().fold(samples.len() as u64, next)
}

fn column(
    log: &Log,
    channel: &Channel,
    temperatures: &[Vec<f64>],
    treatment: &Treatment,
    request: &NoiseRequest,
    progress: &dyn Progress,
) -> Result<Column, TauError> {
    let (data, step_s) = (log.data, log.step_s);
    let samples = channel.view(data, step_s);
    let (recorded, outliers) = treatment.recorded(&samples);
    let mut events = treatment.events(&recorded, &outliers, temperatures);
    let angles = if treatment.events_removed { &*events.without } else { &recorded };
    let model = (request.intervals == Suppose::Record).then(|| model(&events.without, treatment.trend));
    let curves = request.deviations.iter().map(|&deviation| {
        let factors = request.taus.factors(angles.len(), step_s, deviation)?;
        let mut points = curve(angles, deviation, &factors, request.confidence);
        if let Some(model) = &model {
            suppose(&mut points, angles, deviation, request.confidence, model.as_ref());
        }
        let samples = angles.len().saturating_sub(1);
        let minimum = if deviation.is_of_angle() { None } else { Minimum::from_record(&points, samples) };
        Ok(Curve { deviation, minimum, points })
    });
    let curves = curves.collect::<Result<_, TauError>>()?;
    let unit = channel.unit.curves;
    let count = angles.len().saturating_sub(1);
    let simulated = Intervals::simulated(request.simulated, count * log.channels.len());
    let records = simulated.records;
    if request.fitting.is_some() && count.saturating_mul(records) > LONG {
        progress.note(&format!(
            "{}: simulating {records} records of {count} samples for the intervals of coefficients; in closed form they take no \
             time",
            channel.name
        ));
    }
    let column = Column::new(channel, &samples, outliers, angles);
    if request.keeps_events() && !treatment.events_removed {
        events = events.kept(&recorded);
    }
    let simulator = request.simulator.as_deref();
    let sheet = |fitting: &Fitting| DataSheet::new(&events, fitting, unit, simulated, simulator);
    let noise = request.fitting.as_ref().map(sheet).transpose();
    Ok(Column { curves, events: listed(events.list, &noise), noise, ..column })
}

/// The events of a record with those that its fit shows.
fn listed(events: Vec<Event>, noise: &Result<Option<DataSheet>, String>) -> Vec<Event> {
    let of_fit = noise.as_ref().ok().and_then(Option::as_ref).map(|noise| noise.events.clone());
    events.into_iter().chain(of_fit.into_iter().flatten()).collect()
}

/// The noise that describes the curve of a record, with the shortest τ from which it does; `None` where none does.
pub fn model(angles: &Angles, trend: Trend) -> Option<(Process, f64)> {
    let request = Fitting::from(Terms::of_model(trend));
    let Described { mut fit, is_described, .. } = describe(&request.curve(angles).ok()?, &request).ok()?;
    let is_ramp = |found: &Coefficient| found.term == Term::RateRamp && found.verdict == Verdict::Identified;
    // A ramp within its bound would make estimates at long τ look certain.
    let has_ramp = fit.coefficients.iter().any(is_ramp);
    fit.process.parts.retain(|part| part.term != Term::RateRamp || has_ramp);
    is_described.then_some((fit.process, fit.tau_range[0]))
}

/// The slope removed from some samples, in the unit of the curve per s.
pub fn slope(angles: &Angles, samples: &Samples) -> f64 {
    let Line { slope, .. } = angles.removed();
    let factor = samples.unit.factor;
    let per_sample = if samples.data == Data::Rate { factor } else { factor / samples.step_s };
    slope * per_sample / samples.step_s
}
