//! The dependence of a log on temperature, and the log without it.
//!
//! ```text
//! Log ─ Course: smoothed temperature ─ Averages: blocks ─ Search, Model: coefficients ─┬─ tables ─▶ temperature.csv, compensation.csv, JSON
//!  └──────────────────────────── compensated ◀──────────────────────────────────────┴─ figures ─▶ charts
//! ```

pub mod report;
mod search;
pub mod smoothing;

use std::borrow::Cow;

use crate::analysis::log::{Treatment, model};
use crate::analysis::temperature::search::Search;
use crate::analysis::temperature::smoothing::{Averages, Course, MIN_BLOCKS};
use sagnac_base::quantity::number::significant;
use sagnac_engine::key::names;
use sagnac_records::allan::{Deviation, Unit};
use sagnac_records::fit::regression::{Estimate, Posterior};
use sagnac_records::record::log::measure::Data;
use sagnac_records::record::log::{Channel, Log};
use sagnac_theory::allan::Process;

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

/// Shortest time of a warm-up in blocks, and longest as a share of the record; a slower one is nearly a straight line.
const MIN_TIME: f64 = 1.0;
const MAX_TIME: f64 = 0.5;
/// Share of the logarithmic range of times of a warm-up that the next pass searches, unless so many times of this pass lie
/// within the 95 % interval, or the range is so narrow.
const NARROWER: f64 = 0.3;
const RESOLVED: usize = 5;
const NARROW: f64 = 1.0001;

/// The dependence that was found.
#[derive(Debug, Clone)]
pub struct Model {
    /// The findings on all effects, whether they are part of the model or were only tried.
    pub findings: Vec<Finding>,
    /// Rate at the reference temperature, °/h.
    pub offset: f64,
    /// The effects of the model with their coefficients.
    pub coefficients: Vec<(Effect, f64)>,
    /// Time of a warm-up of the model, s, with its 95 % interval where both ends were found.
    pub warm_up_s: Option<(f64, Option<[f64; 2]>)>,
    /// Probability of a residual at least as correlated, if the noise of the regression is that of the record.
    pub p_value: f64,
    /// Whether the intervals are the robust ones, because that probability is too low.
    pub is_robust: bool,
    posterior: Posterior,
}

/// The finding on one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Effect.
    pub effect: Effect,
    /// The coefficient, in the model or if it entered next; absent where it cannot be determined.
    pub estimate: Option<Estimate>,
    /// Whether it is part of the model.
    pub is_used: bool,
    /// The verdict on how well it is known, in words.
    pub verdict: String,
}

/// The effects that may enter a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effects {
    /// Temperature, and those of the others for which there is evidence.
    Auto,
    /// All of these.
    Given(Vec<Effect>),
}

impl Effects {
    /// Reads `auto`, or names of effects separated by commas.
    ///
    /// # Errors
    /// A name is unknown, or the square of the temperature is without the temperature itself.
    pub fn parse(text: &str) -> Result<Effects, String> {
        if text == "auto" {
            return Ok(Effects::Auto);
        }
        let named = |asked: &str| {
            let asked = asked.trim();
            let found = Effect::ALL.into_iter().find(|effect| effect.name().eq_ignore_ascii_case(asked));
            let known = || Effect::ALL.map(Effect::name).join(",");
            found.ok_or_else(|| format!("`{asked}` is not a term; accepted: auto, or some of {}", known()))
        };
        let named = text.split(',').map(named).collect::<Result<Vec<_>, _>>()?;
        // In the order of all of them, and each once.
        let effects: Vec<Effect> = Effect::ALL.into_iter().filter(|effect| named.contains(effect)).collect();
        if effects.contains(&Effect::Square) && !effects.contains(&Effect::Temperature) {
            return Err("T2 needs T beside it, because its zero is arbitrary; write as in T,T2".to_owned());
        }
        Ok(Effects::Given(effects))
    }

    /// The effects in question.
    pub fn candidates(&self) -> &[Effect] {
        match self {
            Effects::Auto => &Effect::ALL,
            Effects::Given(effects) => effects,
        }
    }
}

impl Model {
    /// Fits effects to the averages of a record; `fast` is the noise of the record at short times, white unless it is known.
    /// `Auto` includes temperature and chooses the others.
    ///
    /// # Errors
    /// A sentence that says why there is no model.
    pub fn new(averages: &Averages, asked: &Effects, fast: Option<&Process>) -> Result<Model, String> {
        let candidates = asked.candidates();
        let mut ends = [MIN_TIME * averages.step_s * averages.m as f64, MAX_TIME * averages.length_s()];
        loop {
            let search = Search::new(averages, candidates, ends, fast)?;
            let choices = search.choices();
            let is_allowed = |effects: &[Effect]| match asked {
                Effects::Given(_) => effects.len() == candidates.len(),
                Effects::Auto => effects.contains(&Effect::Temperature),
            };
            let allowed = choices.iter().filter(|choice| is_allowed(&choice.effects));
            let best = allowed.min_by(|a, b| a.score.total_cmp(&b.score));
            let best = best.filter(|best| best.score.is_finite()).ok_or_else(|| {
                "its terms cannot be told from each other in this record: leave out some of them".to_owned()
            })?;
            let is_resolved = search.near(best).len() >= RESOLVED || ends[1] < NARROW * ends[0];
            if !best.effects.contains(&Effect::WarmUp) || is_resolved {
                let best = match asked {
                    Effects::Auto => search.completed(best),
                    Effects::Given(_) => best.clone(),
                };
                return search.model(&best, &choices);
            }
            let narrowed = libm::pow(ends[1] / ends[0], 0.5 * NARROWER);
            ends = [search.time_s(best) / narrowed, search.time_s(best) * narrowed];
        }
    }

    /// The rate that the temperature adds to that at the reference temperature, `from` K above it.
    pub fn at(&self, from: f64) -> Estimate {
        let weight = |(effect, _): &(Effect, f64)| match effect {
            Effect::Temperature => from,
            Effect::Square => from * from,
            _ => 0.0,
        };
        let weights: Vec<f64> = std::iter::once(0.0).chain(self.coefficients.iter().map(weight)).collect();
        self.posterior.sum(&weights)
    }
}

names! {
    /// A term of the model of a rate.
    pub enum Effect {
        /// In proportion to the temperature: T − T_ref, in K.
        Temperature = "T",
        /// In proportion to its square: (T − T_ref)², in K².
        Square = "T2",
        /// In proportion to its change: dT/dt, in K/min.
        Change = "dT",
        /// A decay since the start of the record: exp(−t/τ).
        WarmUp = "warm-up",
        /// A straight line of time, in days.
        Aging = "aging",
    }
}

impl Effect {
    /// Unit of the coefficient in files, for a curve in `unit`.
    pub fn unit(self, unit: Unit) -> String {
        let per = match self {
            Effect::Temperature => "/K",
            Effect::Square => "/K^2",
            Effect::Change => "/(K/min)",
            Effect::WarmUp => "",
            Effect::Aging => "/day",
        };
        match (unit.in_files(Deviation::Oadev), per) {
            ("", "") => String::new(),
            ("", per) => format!("1{per}"),
            (rate, per) => format!("{rate}{per}"),
        }
    }

    /// The name in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Effect::Temperature => "the temperature",
            Effect::Square => "the square of the temperature",
            Effect::Change => "the change of the temperature",
            Effect::WarmUp => "a warm-up",
            Effect::Aging => "aging",
        }
    }
}
