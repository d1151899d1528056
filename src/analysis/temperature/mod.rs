//! The dependence of a log on temperature, and the log without it.
//!
//! ```text
//! Log ─ Course: smoothed temperature ─ Averages: blocks ─ Search, Model: coefficients ─┬─ tables ─▶ temperature.csv, compensation.csv, JSON
//!  └──────────────────────────── compensated ◀──────────────────────────────────────┴─ figures ─▶ charts
//! ```

pub mod regressors;
pub mod report;
mod search;
pub mod smoothing;

use std::borrow::Cow;

use crate::analysis::log::{Treatment, model};
use crate::analysis::temperature::regressors::{Effect, Effects, Model};
use crate::analysis::temperature::smoothing::{Averages, Course, MIN_BLOCKS};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::{Channel, Log};

/// Least standard deviation of the temperature of blocks, in errors of these means: below it, the errors of the sensor make
/// a coefficient come out too small by more than a tenth.
pub(crate) const MIN_CHANGE: f64 = 3.0;

/// The dependence of all columns of a log.
#[derive(Debug, Clone)]
pub struct Temperature {
    /// The temperature at every sample.
    pub course: Course,
    /// Time between samples, s.
    pub step_s: f64,
    /// Number of samples without a temperature in the file, and of those for which none could be filled in.
    pub missing: [usize; 2],
    /// What was found of each column.
    pub columns: Vec<Column>,
}

/// The dependence of one column.
#[derive(Debug, Clone)]
pub struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit of its curves.
    pub unit: Unit,
    /// What was found, or the reason why there is nothing.
    pub found: Result<Dependence, String>,
}

/// A dependence with the blocks from which it was found.
#[derive(Debug, Clone)]
pub struct Dependence {
    /// Coefficients.
    pub model: Model,
    /// Averages over blocks.
    pub averages: Averages,
}

impl Temperature {
    /// Finds the dependence as [`Temperature::new`] does, and adds its [notes](report::notes) to the log.
    pub fn noted(log: &mut Log, treatment: &Treatment, effects: &Effects) -> Option<Temperature> {
        let found = Temperature::new(log, treatment, effects);
        log.notes.extend(found.iter().flat_map(report::notes));
        found
    }

    /// The dependence of a log that was read with its temperature; nothing for a log without one.
    pub fn new(log: &Log, treatment: &Treatment, effects: &Effects) -> Option<Temperature> {
        let (_, measured) = log.temperature.as_ref()?;
        let block = log.samples().div_ceil(smoothing::MAX_BLOCKS);
        let course = Course::new(measured, block);
        let unknown = |x: &[f64]| x.iter().filter(|x| x.is_nan()).count();
        let missing = [unknown(measured), unknown(&course.values)];
        let of_rates = course_of(log.data, &course);
        let column = |channel: &Channel| Column {
            name: channel.name.clone(),
            unit: channel.unit.curves,
            found: dependence(log, channel, &of_rates, treatment, effects),
        };
        let columns = log.channels.iter().map(column).collect();
        Some(Temperature { step_s: log.step_s, missing, columns, course })
    }

    /// The log without the effects that were found; samples without temperature are missing. Columns without a model stay
    /// as they are.
    pub fn compensated(&self, log: &Log) -> Log {
        let course = course_of(log.data, &self.course);
        let mut log = log.clone();
        log.is_compensated = self.columns.iter().any(|column| column.found.is_ok());
        for (channel, column) in log.channels.iter_mut().zip(&self.columns) {
            let Ok(found) = &column.found else { continue };
            let rate = |i: usize| found.rate(&course, i) / channel.unit.factor;
            match log.data {
                Data::Rate => channel.samples.iter_mut().enumerate().for_each(|(i, x)| *x -= rate(i)),
                Data::Increment => {
                    channel.samples.iter_mut().enumerate().for_each(|(i, x)| *x -= rate(i) * log.step_s);
                }
                Data::Angle => {
                    let mut sum = 0.0;
                    for (i, x) in channel.samples.iter_mut().enumerate().skip(1) {
                        // Without temperature the angle is unknown, but not those behind it.
                        let turned = rate(i - 1) * log.step_s;
                        sum += if turned.is_nan() { 0.0 } else { turned };
                        *x -= if turned.is_nan() { turned } else { sum };
                    }
                }
            }
        }
        log
    }
}

impl Dependence {
    /// Whether the model contains the temperature itself.
    pub fn is_of_temperature(&self) -> bool {
        self.model.coefficients.iter().any(|(effect, _)| *effect == Effect::Temperature)
    }

    /// The rate that the model adds at a sample to that at the reference temperature, °/h.
    fn rate(&self, course: &Course, i: usize) -> f64 {
        let time_s = self.model.warm_up_s.map_or(1.0, |(time_s, _)| time_s);
        let part = |(effect, size): &(Effect, f64)| size * self.averages.at(*effect, time_s, course, i);
        self.model.coefficients.iter().map(part).sum()
    }
}

/// The course at the rates of a log: midway between angles.
fn course_of(data: Data, course: &Course) -> Cow<'_, Course> {
    if data == Data::Angle { Cow::Owned(course.midway()) } else { Cow::Borrowed(course) }
}

/// The dependence of a channel; `course` is that at its rates.
fn dependence(
    log: &Log,
    channel: &Channel,
    course: &Course,
    treatment: &Treatment,
    asked: &Effects,
) -> Result<Dependence, String> {
    let samples = channel.view(log.data, log.step_s);
    let per_sample = if log.data == Data::Rate { 1.0 } else { log.step_s };
    let mut rates: Vec<f64> =
        samples.increments().iter().map(|x| x * channel.unit.factor / per_sample).collect();
    let (angles, outliers) = treatment.angles(&samples, &[]);
    if treatment.outliers_removed {
        outliers.samples.iter().for_each(|&i| rates[i] = f64::NAN);
    }
    let averages = Averages::new(&rates, course, log.step_s).ok_or_else(|| {
        format!(
            "fewer than {MIN_BLOCKS} blocks of the record have both samples and temperatures: record longer, or give a \
             temperature for more of the samples"
        )
    })?;
    let (changes, least) = (averages.scatter(), MIN_CHANGE * course.error_of_mean(averages.m));
    let is_of_temperature =
        |effect: &Effect| matches!(effect, Effect::Temperature | Effect::Square | Effect::Change);
    // A constant temperature differs from its mean by rounding.
    if changes <= least.max(1e-9) && asked.candidates().iter().any(is_of_temperature) {
        return Err(format!(
            "not estimable: the temperature hardly changes, by a standard deviation of {} K, and its sensor has an error of {} K",
            significant(changes, 3),
            significant(course.error_of_mean(averages.m), 3)
        ));
    }
    let fast = model(&angles, treatment.trend).map(|(process, _)| process);
    let model = Model::new(&averages, asked, fast.as_ref())?;
    Ok(Dependence { model, averages })
}
