//! One log, from its file to its curves.

use std::path::{Path, PathBuf};

use sagnac::allan::curve::{Minimum, Point, curve, minimum};
use sagnac::allan::deviation::Deviation;
use sagnac::allan::tau::TauError;
use sagnac::allan::trend::{Line, Trend};
use sagnac::allan::unit::Unit;
use sagnac::fit::noise::{DataSheet, Row};
use sagnac::quantity::number::significant;
use sagnac::record::log::channel::Log;
use sagnac::record::log::measure::Data;
use sagnac::record::log::outliers::Outliers;
use sagnac::record::log::read::Request;

use crate::allan::options::Options;
use crate::failure::Failure;
use crate::reading::Reading;

/// Simulated samples that take long enough for a word of it.
const LONG: usize = 1_000_000_000;

/// What was found in one file.
pub struct Analysis {
    pub path: PathBuf,
    pub data: Data,
    pub samples: usize,
    pub step_s: f64,
    pub confidence: f64,
    pub treatment: Treatment,
    pub columns: Vec<Column>,
}

/// One column of the file.
pub struct Column {
    pub name: String,
    pub unit: Unit,
    /// What the header says of the unit, where that is something else.
    pub overruled: Option<String>,
    /// Samples missing in the file.
    pub missing: usize,
    /// Of the rates or increments as they stand in the file.
    pub outliers: Outliers,
    /// In the unit of the curve; absent for plain numbers that are no rates.
    pub mean_rate: Option<f64>,
    /// Slope that was removed, in the unit of the curve per s.
    pub slope: f64,
    pub curves: Vec<Curve>,
    /// Absent where it was not asked for; else why it cannot be told.
    pub noise: Result<Option<DataSheet>, String>,
}

impl Column {
    /// The noise, where there is one.
    pub fn noise(&self) -> Option<&DataSheet> {
        self.noise.as_ref().ok()?.as_ref()
    }

    /// Its coefficients; none without.
    pub fn coefficients(&self) -> &[Row] {
        self.noise().map_or(&[], |noise| &noise.rows)
    }
}

/// A deviation of a column.
pub struct Curve {
    pub deviation: Deviation,
    pub points: Vec<Point>,
    pub minimum: Option<Minimum>,
}

/// What was done to a record before its curves were taken.
pub struct Treatment {
    pub skip_s: f64,
    pub until_s: Option<f64>,
    pub trend: Trend,
    pub outliers_removed: bool,
}

impl Treatment {
    /// Of a log that was cut.
    pub fn of(log: &Log, reading: &Reading) -> Treatment {
        Treatment {
            skip_s: log.start_s,
            until_s: reading.until,
            trend: reading.trend(),
            outliers_removed: reading.remove_outliers,
        }
    }

    /// What was left out, in a few words.
    pub fn left_out(&self) -> String {
        let part = |time_s: f64, words: &str| format!("{words} {} s", significant(time_s, 9));
        let parts = [
            (self.skip_s > 0.0).then(|| part(self.skip_s, "from")),
            self.until_s.map(|until_s| part(until_s, "until")),
            self.outliers_removed.then(|| "outliers removed".to_owned()),
        ];
        parts.into_iter().flatten().map(|part| format!("; {part}")).collect()
    }

    /// All of it in a few words, for every output.
    pub fn summary(&self) -> String {
        let trend = match self.trend {
            Trend::None => "; no trend removed",
            Trend::Linear => "; linear trend removed: no R, K too low",
        };
        (self.left_out() + trend).trim_start_matches("; ").to_owned()
    }

    /// What the trend does to the coefficients R and K.
    pub fn effect(&self, length_s: f64) -> String {
        match self.trend {
            Trend::None => {
                "no trend was removed: a rate ramp R and a rate random walk K show as they were recorded"
                    .to_owned()
            }
            Trend::Linear => format!(
                "a linear trend was removed: the rate ramp R is gone with it, and above τ = {} s, a tenth of the record, \
                 the curve and with it the rate random walk K come out too low",
                significant(0.1 * length_s, 6)
            ),
        }
    }
}

impl Analysis {
    /// Reads and analyses the log at `path`.
    ///
    /// # Errors
    /// A log that is refused, or averaging times that it does not have.
    pub fn of(path: &Path, request: &Request, options: &Options) -> Result<Analysis, Failure> {
        let reading = &options.reading;
        let log = reading.log(path, request)?;
        let treatment = Treatment::of(&log, reading);
        let columns =
            (0..log.channels.len()).map(|at| column(&log, at, options)).collect::<Result<_, _>>()?;
        Ok(Analysis {
            path: path.to_owned(),
            data: log.data,
            samples: log.samples(),
            step_s: log.step_s,
            confidence: options.confidence,
            treatment,
            columns,
        })
    }

    pub fn length_s(&self) -> f64 {
        self.samples as f64 * self.step_s
    }

    /// `95 %`
    pub fn percent(&self) -> String {
        format!("{} %", significant(100.0 * self.confidence, 6))
    }
}

fn column(log: &Log, at: usize, options: &Options) -> Result<Column, Failure> {
    let (data, step_s) = (log.data, log.step_s);
    let channel = &log.channels[at];
    let missing = channel.missing();
    let mean_rate = channel.view(data, step_s).mean_rate();
    let factor = channel.unit.factor;
    let (angles, outliers) = options.reading.angles(channel, data, step_s);
    let curves = options.deviation.iter().map(|&deviation| {
        let factors = options.tau.factors(angles.len(), step_s, deviation).map_err(|error| match error {
            TauError::NoTime { .. } => Failure::Usage(error.to_string()),
            _ => Failure::Record(error.to_string()),
        })?;
        let points = curve(&angles, deviation, &factors, options.confidence);
        Ok(Curve { deviation, minimum: minimum(&points), points })
    });
    let unit = if channel.unit.is_angular { Unit::Angular } else { Unit::Plain };
    let terms = options.reading.terms();
    let samples = angles.len().saturating_sub(1);
    let asked = options.simulated(samples);
    let bootstrap = asked.records;
    if terms.is_some() && samples.saturating_mul(bootstrap) > LONG && !options.is_silent() {
        say!(
            "{}: simulating {bootstrap} records of {samples} samples for intervals of coefficients; --bootstrap 0 does \
             without",
            channel.name
        );
    }
    let noise = terms.map(|terms| DataSheet::of(&angles, &terms, unit, asked)).transpose();
    let Line { slope, .. } = angles.removed();
    let per_sample = if data == Data::Rate { factor } else { factor / step_s };
    Ok(Column {
        name: channel.name.clone(),
        unit,
        overruled: channel.unit_in_header.clone().filter(|text| *text != channel.unit.text),
        missing,
        mean_rate,
        slope: slope * per_sample / step_s,
        curves: curves.collect::<Result<_, Failure>>()?,
        outliers,
        noise,
    })
}
