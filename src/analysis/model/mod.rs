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

pub mod report;
pub mod search;
pub mod state_space;
pub mod tables;
pub mod target;
pub mod writers;

use crate::analysis::log::Treatment;
use crate::analysis::log::events::Row;
use crate::analysis::model::search::{Found, find};
use crate::analysis::model::target::{Source, Target};
use crate::analysis::model::writers::Writer;
use sagnac_base::diagnostics::StudyError;
use sagnac_records::fit::Fitting;
use sagnac_theory::allan::{self, Part};

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
