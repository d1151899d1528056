//! The study: what the user wrote, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! Whatever is wrong is found here, before any work, and told with its place in the file.

mod chart;
mod diagnose;
mod expression;
mod file;
mod inputs;
mod key;
mod point;
mod scalar;
mod sweep;
mod ticks;
mod units;

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use serde::Deserialize;
use toml::Spanned;

pub use chart::{Chart, Named};
pub use diagnose::StudyError;
pub use file::{Filler, Kind, Phase, Scale, Streams, schema};
pub use inputs::{Amplitude, Inputs, TickNoise};
pub use key::Key;
pub use point::Point;
pub use sweep::Sweep;
pub(crate) use units::round_12;
pub use units::{Dimension, Quantity, UnitError, parse as parse_quantity};

use diagnose::{Fault, Text, choices};
use file::{StudyFile, TickNoiseTable};
use scalar::Scalar;
use ticks::{Purpose, TickList};

/// Most trials at one point, 2^40.
pub const MOST_TRIALS: u64 = 1 << 40;

/// A study that makes sense: every value is within its limits at every point.
#[derive(Debug, Clone)]
pub struct Study {
    pub title: String,
    /// Empty if the file asks none.
    pub question: String,
    pub kind: Kind,
    pub seed: u64,
    /// At each point.
    pub trials: u64,
    pub streams: Streams,
    /// Before any sweep.
    pub inputs: Inputs,
    /// One or more, each once.
    pub fillers: Vec<Filler>,
    pub sweeps: Vec<Sweep>,
    pub charts: Vec<Chart>,
    points: Vec<Point>,
    text: Text,
}

impl Study {
    /// Reads the study file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and those of [`Study::parse`].
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = std::fs::read_to_string(path).map_err(|error| StudyError::unreadable(path, &error))?;
        Study::parse(&path.display().to_string(), &text)
    }

    /// Reads a study from its `text`; `name` is that of the file, for messages.
    ///
    /// # Errors
    /// The first fault found, with its place in the text.
    ///
    /// # Example
    /// ```
    /// # use sagnac::study::Study;
    /// let error = Study::parse("my.toml", "title = 5 ms").unwrap_err();
    /// assert!(error.render(false, 100).contains("my.toml:1"));
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Study, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        Study::check(&text).map_err(|fault| fault.within(&text))
    }

    /// All points, in order; without a sweep the one that is written.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The file as it was read.
    pub fn text(&self) -> &str {
        self.text.inner()
    }

    /// An error about the bytes `span` of this study, for what only shows later, such as a chart's unknown column.
    ///
    /// `message` says what was found, `help` what is accepted.
    pub fn error_at(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> StudyError {
        Fault::new(span, message, "here", help).within(&self.text)
    }

    /// Where `key`, such as `gyro.tick_noise`, is written, for an error about its value.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        let name = key.rsplit('.').next().unwrap_or(key);
        let text = self.text.inner();
        let mut at = 0;
        for line in text.split_inclusive('\n') {
            let indent = line.len() - line.trim_start().len();
            let rest = line[indent..].strip_prefix(name).map(str::trim_start);
            if rest.is_some_and(|rest| rest.starts_with('=')) {
                return at + indent..at + line.trim_end().len();
            }
            at += line.len();
        }
        0..0
    }

    fn check(text: &Text) -> Result<Study, Fault> {
        let toml = toml::Deserializer::parse(text.inner()).map_err(|error| Fault::from_syntax(&error))?;
        let file = StudyFile::deserialize(toml).map_err(|error| Fault::from_serde(&error))?;
        let seed = match &file.seed {
            Some(seed) => scalar::whole("seed", seed, 0..=i64::MAX)?,
            None => 1,
        };
        let trials = match &file.trials {
            Some(trials) => scalar::whole("trials", trials, 1..=MOST_TRIALS as i64)?,
            None => 1_000_000,
        };
        let (inputs, places) = read_inputs(&file)?;
        let fillers = read_fillers(&file.switching.fillers)?;
        let sweeps = sweep::read_all(&file.sweep)?;
        let base = point::Base {
            inputs,
            places,
            sweeps: &sweeps,
            fillers: &fillers,
            fit_ticks: TickList::read(Purpose::Residual, file.switching.fit_ticks.as_ref())?,
            extrapolation_ticks: TickList::read(
                Purpose::Extrapolation,
                file.switching.extrapolation_ticks.as_ref(),
            )?,
        };
        let points = base.points()?;
        let charts = chart::read_all(file.chart, &sweeps, &fillers)?;
        Ok(Study {
            title: file.title,
            question: file.question,
            kind: file.kind,
            // Both are read as positive numbers.
            seed: seed.cast_unsigned(),
            trials: trials.cast_unsigned(),
            streams: file.streams,
            inputs,
            fillers,
            sweeps,
            charts,
            points,
            text: text.clone(),
        })
    }
}

type Place = (&'static Key, Range<usize>);

/// The inputs as written, and where each stands.
fn read_inputs(file: &StudyFile) -> Result<(Inputs, Vec<Place>), Fault> {
    let written = [
        (&key::TICK, &file.gyro.tick),
        noise_form(&file.gyro.tick_noise)?,
        (&key::AMPLITUDE, &file.motion.amplitude),
        (&key::FREQUENCY, &file.motion.frequency),
        (&key::GAP_TICKS, &file.switching.gap_ticks),
    ];
    // Each number is overwritten by its key.
    let mut inputs = Inputs {
        tick_s: 0.0,
        tick_noise: TickNoise::Std(0.0),
        amplitude: Amplitude::Rate(0.0),
        frequency_hz: 0.0,
        phase: file.motion.phase,
        gap_ticks: 0,
    };
    for (key, value) in written {
        key.set(&mut inputs, key.read(value)?);
    }
    Ok((inputs, written.map(|(key, value)| (key, value.span())).to_vec()))
}

fn noise_form(table: &Spanned<TickNoiseTable>) -> Result<(&'static Key, &Spanned<Scalar>), Fault> {
    let TickNoiseTable { std, three_sigma, angle_random_walk } = table.get_ref();
    match (std, three_sigma, angle_random_walk) {
        (Some(std), None, None) => Ok((&key::NOISE_STD, std)),
        (None, Some(three_sigma), None) => Ok((&key::NOISE_THREE_SIGMA, three_sigma)),
        (None, None, Some(random_walk)) => Ok((&key::NOISE_RANDOM_WALK, random_walk)),
        _ => {
            let help = "accepted: { std = \"0.53 arcsec\" }, { three_sigma = \"1.6 arcsec\" } or \
                        { angle_random_walk = \"0.003 deg/sqrt(h)\" }";
            let message = "gyro.tick_noise needs exactly one of std, three_sigma, angle_random_walk";
            Err(Fault::new(table.span(), message, "not exactly one", help))
        }
    }
}

fn read_fillers(list: &Spanned<Vec<Spanned<Filler>>>) -> Result<Vec<Filler>, Fault> {
    let names = Filler::ALL.map(Filler::name);
    if list.get_ref().is_empty() {
        let message = "switching.fillers is empty, there is nothing to compare";
        return Err(Fault::new(list.span(), message, "no filler", choices("", &names)));
    }
    let mut fillers = Vec::new();
    for filler in list.get_ref() {
        if fillers.contains(filler.get_ref()) {
            let message = format!("switching.fillers lists \"{}\" twice", filler.get_ref().name());
            return Err(Fault::new(filler.span(), message, "listed before", "leave it out here"));
        }
        fillers.push(*filler.get_ref());
    }
    Ok(fillers)
}
