//! The curve that a model has to describe or to bound.

use std::path::PathBuf;

use crate::analysis::log;
use crate::analysis::log::events::{Row, of_column};
use crate::analysis::log::notes::{heading, notes};
use crate::analysis::model::{Asked, ModelError, Quantization};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_records::fit::Term;

/// Inverse of the longest τ relative to a record, where none is given.
pub(crate) const MAX_TAU_PART: f64 = 10.0;
/// Relative error of a τ that is on the grid of the curve.
pub(crate) const NEAR: f64 = 1e-9;

/// What was modelled.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Path of the log or of the noise.toml.
    pub path: PathBuf,
    /// What it is, in a line.
    pub heading: String,
    /// Sampling rate of the record, Hz; absent for a noise.toml.
    pub rate_hz: Option<f64>,
    /// Remarks on what was read.
    pub notes: Vec<String>,
}

impl Source {
    /// A log that was analysed.
    pub fn of_log(analysis: &log::Analysis) -> Source {
        Source {
            path: analysis.path.clone(),
            heading: format!("{}; {}", heading(analysis), analysis.treatment.summary()),
            rate_hz: Some(1.0 / analysis.step_s),
            notes: notes(analysis),
        }
    }
}

/// A point of the curve: the deviation with the ends of its band, in the unit of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Deviation of the record.
    pub value: f64,
    /// Lower end of the band.
    pub lower: f64,
    /// Upper end of the band.
    pub upper: f64,
    /// Equivalent degrees of freedom of the variance; absent without a record.
    pub edf: Option<f64>,
}

/// The curve of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Name of the column.
    pub name: String,
    /// Unit of the curve.
    pub unit: Unit,
    /// Points by rising τ.
    pub points: Vec<Point>,
    /// Quantization that the curve shows, with the upper end of its interval, ″; absent where it shows none.
    pub quantization: Option<[f64; 2]>,
    /// N that the record has, in the unit of the curve times √s; 0 where it shows none.
    pub white: f64,
    /// Time from sample to sample of the record, s; absent without one.
    pub step_s: Option<f64>,
    /// Length of the record, s; absent without one.
    pub length_s: Option<f64>,
    /// Whether the points have a band.
    pub has_band: bool,
    /// What the record shows besides noise.
    pub events: Vec<Row>,
}

impl Target {
    /// The curves of the columns of a log, which are overlapping Allan deviations.
    ///
    /// # Errors
    /// A column is plain numbers.
    pub fn of_log(analysis: &log::Analysis) -> Result<Vec<Target>, ModelError> {
        let of = |column: &log::Column| {
            if column.unit == Unit::Plain {
                return Err(ModelError::Plain(column.name.clone()));
            }
            let points = column.curves.iter().flat_map(|curve| &curve.points);
            let points = points.filter_map(|point| {
                let (lower, upper) = point.interval?;
                Some(Point { tau_s: point.tau_s, value: point.value?, lower, upper, edf: point.edf })
            });
            let described = column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described());
            let found = described.and_then(|fit| fit.coefficient(Term::Quantization));
            let quantization = found.and_then(|found| Some([found.value?, found.interval?[1]]));
            Ok(Target {
                name: column.name.clone(),
                unit: column.unit,
                points: points.collect(),
                quantization,
                white: described.and_then(|fit| fit.coefficient(Term::AngleRandomWalk)?.value).unwrap_or(0.0),
                step_s: Some(analysis.step_s),
                length_s: Some(analysis.length_s()),
                has_band: true,
                events: of_column(analysis, column),
            })
        };
        analysis.columns.iter().map(of).collect()
    }

    /// The points between the requested times, with those just outside if the times are between points, and with the band that noise
    /// without intervals gets.
    ///
    /// # Errors
    /// The curve does not reach the times, or there is no noise.
    pub(crate) fn between(mut self, asked: &Asked) -> Result<Target, ModelError> {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return Err(ModelError::NoNoise(self.name));
        };
        let (shortest_s, longest_s) = (first.tau_s, last.tau_s);
        let from_s = asked.from_s.unwrap_or(shortest_s);
        let usual = self.length_s.map_or(longest_s, |length_s| (length_s / MAX_TAU_PART).min(longest_s));
        let to_s = asked.to_s.unwrap_or(usual);
        if from_s >= to_s {
            return Err(ModelError::Order { from_s, to_s });
        }
        if from_s < shortest_s * (1.0 - NEAR) || to_s > longest_s * (1.0 + NEAR) {
            let shown = |tau_s: f64| significant(tau_s, 6).into();
            return Err(ModelError::Beyond {
                column: self.name.into(),
                shortest_s: shown(shortest_s),
                longest_s: shown(longest_s),
                from_s: shown(from_s),
                to_s: shown(to_s),
            });
        }
        let start =
            self.points.partition_point(|point| point.tau_s <= from_s * (1.0 + NEAR)).saturating_sub(1);
        let end = self.points.partition_point(|point| point.tau_s < to_s * (1.0 - NEAR));
        self.points = self.points[start..=end.min(self.points.len() - 1)].to_vec();
        if self.points.iter().all(|point| point.upper <= 0.0) {
            return Err(ModelError::NoNoise(self.name));
        }
        if !self.has_band {
            for point in &mut self.points {
                (point.lower, point.upper) = match asked.aim {
                    crate::analysis::model::Aim::Describe => {
                        (point.value * (1.0 - asked.margin), point.value * (1.0 + asked.margin))
                    }
                    _ => (point.value, point.value),
                };
            }
        }
        if asked.quantization == Quantization::White {
            self.quantization = None;
        }
        Ok(self)
    }

    /// Shortest and longest τ, s.
    pub fn taus(&self) -> [f64; 2] {
        [self.points.first(), self.points.last()].map(|point| point.map_or(0.0, |point| point.tau_s))
    }
}
