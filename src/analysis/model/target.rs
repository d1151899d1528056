//! What a model has to describe: a curve with its band, from a record, repeated records, or a `noise.toml`.

use std::path::{Path, PathBuf};

use crate::analysis::given_curve;
use crate::analysis::log::events::{Row, of_column};
use crate::analysis::log::noise_file::{Intervals, intervals_of, parts_of};
use crate::analysis::log::report::heading;
use crate::analysis::log::{self, report};
use crate::analysis::model::{ModelError, ModelRequest, Quantization};
use sagnac_base::diagnostics::listed;
use sagnac_base::quantity::number::significant;
use sagnac_engine::noise::Noise;
use sagnac_records::allan::{Unit, distributions};
use sagnac_records::fit::{Fit, Term};
use sagnac_theory::allan::{self, Part};

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
    /// The word for what is modelled: `record`, or `curve` where there is none.
    pub noun: &'static str,
    /// Sampling rate of the record, Hz; absent for a noise.toml.
    pub rate_hz: Option<f64>,
    /// Topic of ROS from which the record was read, if it is from one.
    pub topic: Option<String>,
    /// Remarks on what was read.
    pub notes: Vec<String>,
}

/// Whether it is the whole name of a topic of ROS.
fn is_of_ros(topic: &str) -> bool {
    topic.starts_with('/') && topic.chars().all(|c| c.is_ascii_alphanumeric() || ['/', '_'].contains(&c))
}

impl Source {
    /// A log that was analysed.
    pub fn of_log(analysis: &log::Analysis) -> Source {
        Source {
            path: analysis.path.clone(),
            heading: format!("{}; {}", heading(analysis), analysis.treatment.summary()),
            noun: "record",
            rate_hz: Some(1.0 / analysis.step_s),
            topic: analysis.columns.iter().find_map(|column| {
                let (field, _) = column.field.as_ref()?;
                Some(field.topic.clone()).filter(|topic| is_of_ros(topic))
            }),
            notes: report::notes(analysis),
        }
    }

    /// A curve that was read from a file.
    pub(crate) fn of_curve(curve: &given_curve::Analysis) -> Source {
        let (path, heading, notes) = (curve.path.clone(), curve.heading(), curve.notes());
        Source { path, heading, noun: "curve", rate_hz: None, topic: None, notes }
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

/// N of a record, in the unit of its curve times √s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct White {
    /// The value.
    pub value: f64,
    /// The ends of its interval.
    pub interval: [f64; 2],
    /// Shortest τ of the fit, s.
    pub from_s: f64,
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
    /// N that the record has; absent where it shows none.
    pub white: Option<White>,
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
            Ok(Target {
                name: column.name.clone(),
                unit: column.unit,
                points: points.collect(),
                quantization: quantization(described),
                white: white(described),
                step_s: Some(analysis.step_s),
                length_s: Some(analysis.length_s()),
                has_band: true,
                events: of_column(analysis, column),
            })
        };
        analysis.columns.iter().map(of).collect()
    }

    /// The curve that was read from a file.
    pub(crate) fn of_curve(curve: &given_curve::Analysis) -> Result<Target, ModelError> {
        if curve.file.unit == Unit::Plain {
            return Err(ModelError::Plain(curve.file.name.clone()));
        }
        let points = curve.file.points.iter().map(|point| {
            let [lower, upper] = point.interval;
            Point { tau_s: point.tau_s, value: point.value, lower, upper, edf: None }
        });
        Ok(Target {
            name: curve.file.name.clone(),
            unit: curve.file.unit,
            points: points.collect(),
            quantization: quantization(curve.fit()),
            white: white(curve.fit()),
            step_s: None,
            length_s: None,
            has_band: true,
            events: vec![],
        })
    }

    /// The points between the requested times, with those just outside if the times are between points, and with the band that noise
    /// without intervals gets.
    ///
    /// # Errors
    /// The curve does not reach the times, or there is no noise.
    pub(crate) fn between(mut self, request: &ModelRequest) -> Result<Target, ModelError> {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return Err(ModelError::NoNoise(self.name));
        };
        let (shortest_s, longest_s) = (first.tau_s, last.tau_s);
        let from_s = request.from_s.unwrap_or(shortest_s);
        let usual = self.length_s.map_or(longest_s, |length_s| (length_s / MAX_TAU_PART).min(longest_s));
        let to_s = request.to_s.unwrap_or(usual);
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
                (point.lower, point.upper) = match request.aim {
                    crate::analysis::model::Aim::Describe => {
                        (point.value * (1.0 - request.margin), point.value * (1.0 + request.margin))
                    }
                    _ => (point.value, point.value),
                };
            }
        }
        if request.quantization == Quantization::White {
            self.quantization = None;
        }
        Ok(self)
    }

    /// Shortest and longest τ, s.
    pub fn taus(&self) -> [f64; 2] {
        [self.points.first(), self.points.last()].map(|point| point.map_or(0.0, |point| point.tau_s))
    }
}

/// Quantization in a fit, with the upper end of its interval.
fn quantization(fit: Option<&Fit>) -> Option<[f64; 2]> {
    let found = fit?.coefficient(Term::Quantization)?;
    Some([found.value?, found.interval?[1]])
}

/// N of a fit.
fn white(fit: Option<&Fit>) -> Option<White> {
    let found = fit?.coefficient(Term::AngleRandomWalk)?;
    let value = found.value.filter(|value| *value > 0.0)?;
    Some(White { value, interval: found.interval?, from_s: fit?.tau_range[0] })
}

/// The upper ends of the bands of another record, which it exceeds at any τ with a probability of at most 1 − `confidence`.
///
/// The probability is divided among the octaves of τ (Bonferroni), because estimates within an octave are of the same differences.
///
/// # Errors
/// There is no record.
pub(crate) fn repeated(target: &Target, confidence: f64) -> Result<Vec<f64>, ModelError> {
    let [from_s, to_s] = target.taus();
    let octaves = libm::ceil(libm::log2(to_s / from_s)).max(0.0) + 1.0;
    let of = |point: &Point| {
        let edf = point.edf.ok_or(ModelError::NoRecord)?;
        let ratio = distributions::f_quantile(1.0 - (1.0 - confidence) / octaves, edf, edf);
        let width =
            distributions::chi_squared_quantile(0.5 * (1.0 - confidence), edf).map(|quantile| edf / quantile);
        let factor = ratio.zip(width).map(|(ratio, width)| libm::sqrt(ratio * width));
        Ok(factor.map_or(f64::NAN, |factor| factor * point.value))
    };
    target.points.iter().map(of).collect()
}

/// Points of the curve per decade of τ.
const PER_DECADE: f64 = 40.0;

/// A part of the noise with the ends of the interval of its coefficient, in parts of it.
struct Known {
    part: Part,
    ends: [f64; 2],
}

impl Known {
    /// The Allan variance with its ends. A sine beyond its first zero is taken at its crests.
    fn at(&self, tau_s: f64) -> [f64; 3] {
        let turns = self.part.shape * tau_s;
        let variance = match self.part.term {
            allan::Term::Sine if turns > 0.5 => {
                let crest = self.part.size / (core::f64::consts::PI * turns);
                crest * crest
            }
            _ => allan::continuous_variance(&self.part, tau_s).unwrap_or(0.0),
        };
        let [low, high] = self.ends.map(|end| variance * end * end);
        [low, variance, high]
    }
}

/// The curve of the noise.toml at `path` between the requested times.
///
/// # Errors
/// The file cannot be read, or is no noise; or the times are not given.
pub fn of_file(path: &Path, request: &ModelRequest) -> Result<(Source, Target), ModelError> {
    let (noise, text) = Noise::read(path)?;
    of_noise(&noise, &text, path, request)
}

/// The curve of the text of a noise.toml, which is called `name`.
///
/// # Errors
/// The text is no noise, or the times are not given.
pub fn of_text(name: &str, text: &str, request: &ModelRequest) -> Result<(Source, Target), ModelError> {
    of_noise(&Noise::parse(name, text)?, text, Path::new(name), request)
}

/// The curve of noise; `text` is that of the file, for its intervals.
///
/// Upper and lower ends are those of independent coefficients: the distances of their variances from the value, added as squares.
///
/// # Errors
/// The times are not given.
fn of_noise(
    noise: &Noise,
    text: &str,
    path: &Path,
    request: &ModelRequest,
) -> Result<(Source, Target), ModelError> {
    let (Some(from_s), Some(to_s)) = (request.from_s, request.to_s) else { return Err(ModelError::NoTimes) };
    if from_s >= to_s || from_s <= 0.0 {
        return Err(ModelError::Order { from_s, to_s });
    }
    let Intervals { known: ends, unknown } = intervals_of(text);
    let mut parts = parts_of(noise);
    let residual = noise.switching.map_or(0.0, |switching| switching.residual_density());
    let is_warm_up = |part: &Part| allan::continuous_variance(part, from_s).is_none();
    let left_out = parts.iter().any(is_warm_up);
    parts.retain(|part| !is_warm_up(part));
    let known: Vec<Known> = parts
        .into_iter()
        .map(|part| {
            let [size, _] = noise.of(part.term);
            let of = ends.iter().find(|(term, _)| *term == part.term && size != 0.0);
            let ends = of.map_or([1.0; 2], |(_, ends)| ends.map(|end| end / size.abs()));
            Known { part, ends: [ends[0].min(1.0), ends[1].max(1.0)] }
        })
        .collect();
    let count = libm::ceil(PER_DECADE * libm::log10(to_s / from_s)).max(1.0);
    let points = (0..=count as u32).map(|i| {
        let tau_s = from_s * libm::pow(to_s / from_s, f64::from(i) / count);
        point(&known, tau_s)
    });
    let quantized = known.iter().filter(|known| known.part.term == allan::Term::Quantization);
    let square = |end: f64| end * end;
    let quantization = quantized.fold([0.0; 2], |[value, upper], known| {
        let size = known.part.size;
        [value + square(size), upper + square(size * known.ends[1])]
    });
    let has_band = known.iter().any(|known| known.ends != [1.0; 2]);
    let target = Target {
        name: "noise".to_owned(),
        unit: Unit::Angular,
        points: points.collect(),
        quantization: (quantization[0] > 0.0).then(|| quantization.map(libm::sqrt)),
        white: None,
        step_s: None,
        length_s: None,
        has_band,
        events: vec![],
    };
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let heading = format!(
        "{file}: the curve of its coefficients{}",
        if has_band { " and their intervals" } else { "" }
    );
    let notes = notes(noise, left_out, &unknown, residual);
    Ok((Source { path: path.to_owned(), heading, noun: "curve", rate_hz: None, topic: None, notes }, target))
}

fn point(known: &[Known], tau_s: f64) -> Point {
    let all: Vec<[f64; 3]> = known.iter().map(|known| known.at(tau_s)).collect();
    let value: f64 = all.iter().map(|[_, value, _]| value).sum();
    let away =
        |end: usize| -> f64 { all.iter().map(|ends| (ends[end] - ends[1]) * (ends[end] - ends[1])).sum() };
    let (lower, upper) = ((value - libm::sqrt(away(0))).max(0.0), value + libm::sqrt(away(2)));
    let [value, lower, upper] = [value, lower, upper].map(libm::sqrt);
    Point { tau_s, value, lower, upper, edf: None }
}

fn notes(noise: &Noise, left_out: bool, unknown: &[&'static str], residual: f64) -> Vec<String> {
    let rate = significant(libm::sqrt(residual) / 60.0, 3);
    let has_sawtooth = noise
        .switching
        .is_some_and(|switching| switching.magnetic != 0.0 || switching.initial_magnetic != 0.0);
    [
        left_out.then(|| "the warm-up is left out: it is no noise, and a filter has to estimate it or to wait".to_owned()),
        has_sawtooth
            .then(|| "the drift that switches alternate is left out: it is no noise, and it returns to 0 with every pair of switches".to_owned()),
        (residual > 0.0).then(|| format!("the residuals of switches are taken as white noise of {rate} °/√h")),
        (!unknown.is_empty()).then(|| {
            format!(
                "the record behind the file did not identify {}; a bound does not cover them beyond the τ of that record, for which the log has to \
                 be given",
                listed(unknown)
            )
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}
