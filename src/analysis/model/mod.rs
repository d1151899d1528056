//! A noise model for a navigation filter: white noise, a random walk and the fewest first-order Gauss–Markov states whose Allan
//! deviation describes or bounds that of a record.
//!
//! ```text
//! Log  ─ log::Analysis ─┐                              ┌─ states ─▶ F, Q, R, P0 at the rate of a filter
//! noise.toml ─ noise ───┴▶ Target ─ search ─▶ Found ───┼─ answer, tables, figures ─▶ model.csv, chart, JSON, page
//!                                                      └─ writers ─▶ files for the tools of others
//! ```
//!
//! **Method.** The Allan variance is linear in N², K² and the variances σ² of Markov states with fixed correlation times. For each
//! number of states, all choices of times on a grid of [six per decade](search::PER_DECADE) are tried. Each is a
//! least-squares problem with non-negative variances, whose constraints are the band of the record: a bound may be nowhere
//! below its upper end, a description stays between both ends. The number of states grows until the bound is near enough.
//!
//! **What the filter sees.** Quantization is an error of the angle that does not accumulate, so it is kept out of the model of the
//! rate and given as the measurement noise R of the angle; [`Quantization::White`] covers it by the rate instead. A sine, a ramp and
//! a warm-up are no noise, but a filter that does not estimate them has to live with them: sine and ramp are part of the
//! curve that is bounded. A warm-up has no curve of its own and is left out with a note.
//!
//! **Limits.** The curve is bounded between the two times that are named and says nothing beyond them. A model whose Allan deviation
//! is above that of the truth is no proof that every linear functional of it is, but those that weigh the same times are
//! (`docs/dev/numerics.md` has the consistency of a Kalman filter).
//!
//! **Linear system.** [`discrete`] gives the model at the rate of a filter, in SI units. The states are the angle that the noise
//! accumulates (the velocity of an accelerometer), the random walk of the rate, and the Markov states. The rate error is the sum of all
//! but the first; white noise drives the angle. With a = e^{−Δ/T}, z = Δ/T the exact transition over a step Δ and the covariance Q of
//! what it adds are, for a Markov state of variance σ²,
//!
//! ```text
//! F = [1  T(1 − a)]      Q = σ² [2T²(z − 2(1 − a) + (1 − a²)/2)   T(1 − a)²]
//!     [0      a   ]             [            T(1 − a)²             1 − a²  ]
//! ```
//!
//! for the random walk F = [1 Δ; 0 1] and Q = K² [Δ³/3 Δ²/2; Δ²/2 Δ], and N²Δ for the angle.

pub mod report;
pub mod search;
pub mod tables;
pub mod target;
pub mod writers;

use crate::analysis::log::Treatment;
use crate::analysis::log::events::Row;
use crate::analysis::model::search::{Found, find};
use crate::analysis::model::target::{Source, Target};
use crate::analysis::model::writers::Writer;
use sagnac_base::diagnostics::StudyError;
use sagnac_base::quantity::expression::STANDARD_GRAVITY;
use sagnac_records::allan::Unit;
use sagnac_records::fit::Fitting;
use sagnac_theory::allan::markov::Step;
use sagnac_theory::allan::{self, Part};
use serde::Serialize;

/// A first-order Gauss–Markov state of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Markov {
    /// Standard deviation, ″/s, or µg.
    pub sigma: f64,
    /// Correlation time, s.
    pub time_s: f64,
}

/// A noise model in ″ and s, or for accelerometers in µg and s.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Model {
    /// White noise N, ″/√s.
    pub white: f64,
    /// Random walk K of the rate, ″/s^1.5.
    pub walk: f64,
    /// Markov states by rising correlation time.
    pub markov: Vec<Markov>,
    /// Rms error Q of the angle, ″, which is measurement noise of the angle.
    pub quantization: f64,
}

impl Model {
    /// The parts of the noise.
    pub fn parts(&self) -> Vec<Part> {
        let markov = self
            .markov
            .iter()
            .map(|state| Part::markov(state.sigma * libm::sqrt(2.0 / state.time_s), state.time_s));
        [
            Part::quantization(self.quantization),
            Part::angle_random_walk(self.white),
            Part::rate_random_walk(self.walk),
        ]
        .into_iter()
        .chain(markov)
        .filter(|part| part.size > 0.0)
        .collect()
    }

    /// Allan variance at τ in closed form, (″/s)².
    pub fn variance(&self, tau_s: f64) -> f64 {
        self.parts().iter().filter_map(|part| allan::continuous_variance(part, tau_s)).sum()
    }

    /// Allan deviation at τ, ″/s.
    pub fn deviation(&self, tau_s: f64) -> f64 {
        libm::sqrt(self.variance(tau_s))
    }
}

/// What a model has to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// Lie within the band of the record.
    Describe,
    /// Lie nowhere below the upper end of the band at each τ.
    Bound,
    /// Lie nowhere below the upper end of the band of another record of the same sensor and length, over all τ together.
    BoundRepeat,
}

impl Aim {
    /// Name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Aim::Describe => "describe",
            Aim::Bound => "bound",
            Aim::BoundRepeat => "bound repeat",
        }
    }
}

/// How quantization is treated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Quantization {
    /// As measurement noise of the angle, which does not accumulate.
    #[default]
    Measurement,
    /// As part of the rate, covered by white noise.
    White,
}

/// The request for a model.
#[derive(Debug, Clone)]
pub struct ModelRequest {
    /// Shortest averaging time, s; by default that of the record.
    pub from_s: Option<f64>,
    /// Longest averaging time, s; by default a tenth of the record.
    pub to_s: Option<f64>,
    /// What the model has to do.
    pub aim: Aim,
    /// How far a bound may lie above the band before a state is added, and the width of the band of noise without intervals, as parts
    /// of the deviation.
    pub margin: f64,
    /// Number of Markov states; by default the fewest.
    pub states: Option<usize>,
    /// How quantization is treated.
    pub quantization: Quantization,
    /// Rate of the filter, Hz; by default that of the record.
    pub filter_hz: Option<f64>,
    /// Probability of the band.
    pub confidence: f64,
    /// Treatment of a log.
    pub treatment: Treatment,
    /// The fit of a log, of which quantization and white noise are taken.
    pub fitting: Option<Fitting>,
    /// The tools for which files are written.
    pub writers: Vec<&'static Writer>,
}

/// The models of a log or of a noise.toml.
#[derive(Debug)]
pub struct Analysis {
    /// What was modelled.
    pub source: Source,
    /// The request.
    pub request: ModelRequest,
    /// The model of each column that has one.
    pub columns: Vec<Column>,
    /// The names of the other columns, with why they have none.
    pub without: Vec<(String, ModelError)>,
}

/// The model of a column.
#[derive(Debug)]
pub struct Column {
    /// The curve that is modelled.
    pub target: Target,
    /// The model.
    pub found: Found,
}

impl Analysis {
    /// Finds the model of each target that has one.
    ///
    /// # Errors
    /// The request is wrong; or no target has a curve between the two times and a model, of which the first says why.
    pub fn of(source: Source, targets: Vec<Target>, request: &ModelRequest) -> Result<Analysis, ModelError> {
        let (mut columns, mut without) = (vec![], vec![]);
        for target in targets {
            let name = target.name.clone();
            let found = target.between(request).and_then(|target| {
                let found = find(&target, request)?;
                Ok(Column { target, found })
            });
            match found {
                Ok(column) => columns.push(column),
                Err(error) if error.is_usage() => return Err(error),
                Err(error) => without.push((name, error)),
            }
        }
        match without.first() {
            Some((_, error)) if columns.is_empty() => Err(error.clone()),
            _ => Ok(Analysis { source, request: request.clone(), columns, without }),
        }
    }

    /// What the columns show besides noise.
    pub fn events(&self) -> Vec<Row> {
        self.columns.iter().flat_map(|column| column.target.events.clone()).collect()
    }

    /// The rate of the filter, Hz; absent where neither it nor the rate of the record is known.
    pub fn filter_hz(&self) -> Option<f64> {
        self.request.filter_hz.or(self.source.rate_hz)
    }
}

/// Why there is no model.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ModelError {
    /// A noise.toml cannot be read, or is none.
    #[error(transparent)]
    Noise(#[from] StudyError),
    /// A noise.toml has no averaging times.
    #[error("a noise.toml has no averaging times of its own: give both, as in `from = 1s` and `to = 10000s`")]
    NoTimes,
    /// The two times are in the wrong order.
    #[error(
        "from τ = {from_s} s to {to_s} s there is no averaging time: the first has to be the shorter one"
    )]
    Order {
        /// Shortest requested time.
        from_s: f64,
        /// Longest requested time.
        to_s: f64,
    },
    /// The curve does not reach the requested times.
    #[error(
        "column {column}: the curve with intervals reaches from τ = {shortest_s} s to {longest_s} s, not from {from_s} s to {to_s} s\n\
         give times within it, as in `from = {shortest_s}s` and `to = {longest_s}s`"
    )]
    Beyond {
        /// Name of the column.
        column: Box<str>,
        /// Shortest τ of the curve.
        shortest_s: Box<str>,
        /// Longest τ of the curve.
        longest_s: Box<str>,
        /// Shortest requested time.
        from_s: Box<str>,
        /// Longest requested time.
        to_s: Box<str>,
    },
    /// The noise is 0 everywhere.
    #[error("column {0}: there is no noise to model between these times")]
    NoNoise(String),
    /// The numbers have no unit.
    #[error(
        "a filter needs rates, angles or accelerations: {0} is plain numbers\ngive their unit, as in deg/s"
    )]
    Plain(String),
    /// No model lies within the band.
    #[error(
        "column {column}: no model with up to {most} Markov states lies within the band at all τ from {from_s} s to {to_s} s; the nearest \
         leaves it at τ = {tau_s} s by {percent} %\nask for a bound with `overbound = true`, or for a shorter range of τ"
    )]
    NotWithin {
        /// Name of the column.
        column: Box<str>,
        /// Most Markov states that were tried.
        most: usize,
        /// Shortest τ.
        from_s: Box<str>,
        /// Longest τ.
        to_s: Box<str>,
        /// τ at which the nearest model is farthest outside.
        tau_s: Box<str>,
        /// How far outside.
        percent: Box<str>,
    },
    /// Noise without a record has no repetition.
    #[error(
        "a noise.toml has no record whose repetition could be bounded: give the log, or `overbound = true`"
    )]
    NoRecord,
}

impl ModelError {
    /// Whether the request is wrong, and not the record.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            ModelError::NoTimes | ModelError::Order { .. } | ModelError::NoRecord | ModelError::Plain(_)
        )
    }
}

/// Size of the unit of a model in SI: of ″ in rad, or of µg in m/s².
fn si(unit: Unit) -> f64 {
    match unit {
        Unit::Acceleration => STANDARD_GRAVITY * 1e-6,
        Unit::Angular | Unit::Plain => core::f64::consts::PI / 648_000.0,
    }
}

/// A model at the rate of a filter. Angles are in rad, rates in rad/s; of accelerometers velocities in m/s and accelerations in m/s².
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Discrete {
    /// Step Δ, s.
    pub step_s: f64,
    /// Names of the states.
    #[serde(rename = "states")]
    pub names: Vec<String>,
    /// Transition matrix F, row by row.
    #[serde(rename = "F")]
    pub transition: Vec<Vec<f64>>,
    /// Covariance Q of what a step adds.
    #[serde(rename = "Q")]
    pub added: Vec<Vec<f64>>,
    /// Variance R of a reading of the angle: Q² of the quantization; 0 without it.
    #[serde(rename = "R")]
    pub reading: f64,
    /// Variance of a rate sample over the step: N²/Δ.
    #[serde(rename = "rate_variance")]
    pub rate: f64,
    /// Stationary variance of each state; absent of those that have none.
    #[serde(rename = "stationary_variance")]
    pub stationary: Vec<Option<f64>>,
    /// Variance of each state at the start: 0 for the angle, the stationary one of Markov states, and of the random walk what it
    /// accumulates over the longest τ. The turn-on bias is not part of it.
    #[serde(rename = "initial_variance")]
    pub initial: Vec<f64>,
}

/// The model of sensors with this unit at steps of Δ, up to the longest τ.
pub fn discrete(model: &Model, unit: Unit, step_s: f64, longest_s: f64) -> Discrete {
    let size = si(unit);
    let square = |x: f64| size * size * x * x;
    let angle = if unit == Unit::Acceleration { "velocity" } else { "angle" };
    let walks = model.walk > 0.0;
    let count = 1 + usize::from(walks) + model.markov.len();
    let mut found = Discrete {
        step_s,
        names: vec![angle.to_owned()],
        transition: vec![vec![0.0; count]; count],
        added: vec![vec![0.0; count]; count],
        reading: square(model.quantization),
        rate: square(model.white) / step_s,
        stationary: vec![None],
        initial: vec![0.0],
    };
    found.transition[0][0] = 1.0;
    found.added[0][0] = square(model.white) * step_s;
    if walks {
        let k = square(model.walk);
        found.join("walk".to_owned(), Step::walk(k, step_s));
        found.stationary.push(None);
        found.initial.push(k * longest_s);
    }
    for (state, number) in model.markov.iter().zip(1..) {
        let variance = square(state.sigma);
        found.join(format!("markov_{number}"), Step::markov(variance, state.time_s, step_s));
        found.stationary.push(Some(variance));
        found.initial.push(variance);
    }
    found
}

impl Discrete {
    /// Joins a state of the rate: its column of F, and its share of Q for the angle, for both and for itself.
    fn join(&mut self, name: String, Step { onto_angle, own, added: [angle, both, itself] }: Step) {
        let place = self.names.len();
        self.names.push(name);
        self.transition[0][place] = onto_angle;
        self.transition[place][place] = own;
        self.added[0][0] += angle;
        self.added[0][place] = both;
        self.added[place][0] = both;
        self.added[place][place] = itself;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::model::Markov;

    /// Q by the sum of many short steps, each F Q Fᵀ + Q.
    fn by_steps(model: &Model, step_s: f64, parts: u32) -> Vec<Vec<f64>> {
        let short = discrete(model, Unit::Angular, step_s / f64::from(parts), 1.0);
        let count = short.names.len();
        let (f, q) = (&short.transition, &short.added);
        let mut sum = vec![vec![0.0; count]; count];
        for _ in 0..parts {
            let once = |i: usize, j: usize| -> f64 {
                let product: f64 =
                    (0..count).map(|k| (0..count).map(|l| f[i][k] * sum[k][l] * f[j][l]).sum::<f64>()).sum();
                product + q[i][j]
            };
            sum = (0..count).map(|i| (0..count).map(|j| once(i, j)).collect()).collect();
        }
        sum
    }

    #[test]
    fn a_long_step_is_many_short_ones() {
        let markov = vec![Markov { sigma: 0.3, time_s: 0.7 }, Markov { sigma: 2.0, time_s: 900.0 }];
        let model = Model { white: 0.1, walk: 0.02, markov, quantization: 0.5 };
        for step_s in [0.01, 1.0, 40.0] {
            let whole = discrete(&model, Unit::Angular, step_s, 1.0);
            let summed = by_steps(&model, step_s, 64);
            for (i, row) in summed.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    let found = whole.added[i][j];
                    assert!(
                        (found - expected).abs() <= 1e-9 * expected.abs(),
                        "Δ = {step_s}, {i} {j}: {found}, not {expected}"
                    );
                }
            }
            assert!((whole.reading / (si(Unit::Angular) * 0.5).powi(2) - 1.0).abs() < 1e-12);
        }
    }
}
