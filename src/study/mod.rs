//! The study: what the user wrote, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! Whatever is wrong is found here, before any work, and told with its place in the file.

mod chart;
mod chart_file;
mod diagnose;
mod expected;
mod expression;
mod file;
mod filler;
mod inputs;
mod key;
mod law;
mod motion;
mod place;
mod point;
mod precision;
mod read_fillers;
mod read_motion;
mod rows;
mod scalar;
mod sweep;
mod ticks;
mod units;

#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::ops::{Range, RangeInclusive};
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use serde::Deserialize;
use toml::Spanned;

pub use chart::{Chart, Named, Shows};
pub use chart_file::Scale;
pub use diagnose::StudyError;
pub(crate) use diagnose::{Fault, Text, choices, render};
pub use file::{Error, Kind, Phase, Position, Streams, schema};
pub use filler::{Fill, Filler, Method, POLYNOMIALS};
pub use inputs::{Inputs, TickNoise};
pub use key::Key;
pub use law::Law;
pub use motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
pub use point::Point;
pub use precision::Precision;
pub use sweep::Sweep;
pub use units::{Dimension, Quantity, UnitError, parse as parse_quantity};
pub(crate) use units::{parse_unit, round_12};

use diagnose::Wrong;
use file::{StudyFile, TickNoiseTable};
use place::Places;
use scalar::Scalar;
use ticks::{Purpose, TickList};

use crate::kernel::launch::MAX_SIDE;

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
    /// Where sampling stops before `trials`.
    pub precision: Option<Precision>,
    pub streams: Streams,
    /// Before any sweep.
    pub inputs: Inputs,
    /// One or more, each once.
    pub fillers: Vec<Filler>,
    /// Which errors of them are found, each once.
    pub errors: Vec<Error>,
    pub sweeps: Vec<Sweep>,
    pub charts: Vec<Chart>,
    points: Vec<Point>,
    text: Text,
    places: Places,
    written: Written,
}

/// What [`Study::resolved`] may have to replace in the text.
#[derive(Debug, Clone)]
struct Written {
    seed: Option<Spanned<u64>>,
    trials: Option<Spanned<u64>>,
    /// The file of a recorded profile, and where it is.
    record: Option<Spanned<String>>,
    /// The end of the value of `kind`, which every study has at its top level.
    kind_end: usize,
}

impl Study {
    /// Reads the study file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and those of [`Study::parse`].
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = std::fs::read_to_string(path).map_err(|error| {
            StudyError::unreadable("the study", path, &error, "give the path of a study file (TOML, UTF-8)")
        })?;
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
        Study::check(&text).map_err(|wrong| wrong.within(&text))
    }

    /// All points, in order; without a sweep the one that is written.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The laws that any chart draws, each once.
    pub fn laws(&self) -> Vec<Law> {
        let mut laws: Vec<Law> = Vec::new();
        for law in self.charts.iter().flat_map(Chart::laws) {
            if !laws.contains(law) {
                laws.push(*law);
            }
        }
        laws
    }

    /// The file as it was read, but with the seed of this value, so many trials, and the whole path of a record: a study
    /// that repeats this one without further options, wherever it is kept. Comments and layout are kept too.
    pub fn resolved(&self, trials: u64) -> String {
        let Written { seed, trials: written_trials, record, kind_end } = &self.written;
        let mut text = self.text.inner().clone();
        let next_line = text[*kind_end..].find('\n').map(|length| kind_end + length + 1);
        // A key after the kind stands at the top level, and before any table.
        let after_kind = next_line.unwrap_or(text.len());
        let line_end = if next_line.is_some() { "" } else { "\n" };
        let mut edits = Vec::new();
        for (key, value, written) in [("trials", trials, written_trials), ("seed", self.seed, seed)] {
            match written {
                None => edits.push((after_kind..after_kind, format!("{line_end}{key} = {value}\n"))),
                Some(written) if *written.get_ref() != value => {
                    edits.push((written.span(), value.to_string()))
                }
                // As it is written, 1_000_000 or 0xff.
                Some(_) => {}
            }
        }
        if let Some(record) = record {
            edits.push((record.span(), toml::Value::String(record.get_ref().clone()).to_string()));
        }
        // From the end, so that the places of the others hold.
        edits.sort_by_key(|(place, _)| Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place, &new);
        }
        text
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

    /// Where the values of `key` are written, for an error about them: of a sweep over it, else its own. A table such as
    /// `gyro.tick_noise` stands for the keys in it; empty at 0 where nothing is written.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.places.blame(&self.sweeps, &[key])
    }

    fn check(text: &Text) -> Result<Study, Wrong> {
        let toml = toml::Deserializer::parse(text.inner()).map_err(|error| Fault::from_syntax(&error))?;
        let file = StudyFile::deserialize(toml).map_err(|error| Fault::from_serde(&error, text.inner()))?;
        let folder = Path::new(text.name()).parent().unwrap_or(Path::new(""));
        let written = Written {
            seed: read_count("seed", file.seed.as_ref(), 0..=i64::MAX)?,
            trials: read_count("trials", file.trials.as_ref(), 1..=MOST_TRIALS as i64)?,
            record: file
                .motion
                .get_ref()
                .profile
                .as_ref()
                .map(|profile| located(&profile.get_ref().file, folder)),
            kind_end: file.kind.span().end,
        };
        let (inputs, places) = read_inputs(&file, folder)?;
        let written_fillers = read_fillers::read(&file.switching.fillers)?;
        let errors = read_errors(file.switching.errors.as_ref())?;
        let sweeps = sweep::read_all(&file.sweep)?;
        for (sweep, table) in sweeps.iter().zip(&file.sweep) {
            sweep.key.check_applies(&inputs, table.key.span())?;
        }
        let base = point::Base {
            inputs: inputs.clone(),
            places: &places,
            sweeps: &sweeps,
            fillers: &written_fillers,
            fit_ticks: TickList::read(Purpose::Residual, file.switching.fit_ticks.as_ref())?,
            extrapolation_ticks: TickList::read(
                Purpose::Extrapolation,
                file.switching.extrapolation_ticks.as_ref(),
            )?,
        };
        let points = base.points()?;
        let precision = file.precision.as_ref().map(precision::read).transpose()?;
        if let (Some(written), Some(Profile { position: Position::Every, .. })) =
            (&file.precision, &inputs.motion.profile)
        {
            let message =
                "precision stands beside position = \"every\", which is exact in whole replays only";
            let help = "leave precision out, or take position = \"random\"";
            return Err(Fault::new(written.span(), message, "cannot stop early", help).into());
        }
        let fillers: Vec<Filler> = written_fillers.into_iter().map(|written| written.filler).collect();
        let charts = chart::read_all(file.chart, &sweeps, &fillers)?;
        Ok(Study {
            title: file.title,
            question: file.question,
            kind: file.kind.into_inner(),
            seed: written.seed.as_ref().map_or(1, |seed| *seed.get_ref()),
            trials: written.trials.as_ref().map_or(1_000_000, |trials| *trials.get_ref()),
            precision,
            streams: file.streams,
            inputs,
            fillers,
            errors,
            sweeps,
            charts,
            points,
            text: text.clone(),
            places,
            written,
        })
    }
}

/// The whole path of a file that is named from `folder`.
fn located(file: &Spanned<String>, folder: &Path) -> Spanned<String> {
    let path = folder.join(file.get_ref());
    // One that is not there is told of when it is read.
    let path = std::path::absolute(&path).unwrap_or(path);
    Spanned::new(file.span(), path.display().to_string())
}

/// A whole number that is not negative, where it is written.
fn read_count(
    key: &str,
    given: Option<&Spanned<Scalar>>,
    range: RangeInclusive<i64>,
) -> Result<Option<Spanned<u64>>, Fault> {
    let Some(given) = given else { return Ok(None) };
    let count = scalar::whole(key, given, range)?;
    Ok(Some(Spanned::new(given.span(), count.cast_unsigned())))
}

/// The inputs as written, and where all that points depend on stands.
fn read_inputs(file: &StudyFile, folder: &Path) -> Result<(Inputs, Places), Wrong> {
    let mut places = Places::default();
    let motion = read_motion::read(file.motion.get_ref(), &mut places, file.motion.span(), folder)?;
    // Each number is overwritten by its key.
    let mut inputs = Inputs {
        tick_s: 0.0,
        tick_noise: TickNoise::Std(0.0),
        readout_lsb: 0.0,
        relock: read_relock(file.gyro.relock.as_ref())?,
        motion,
        gap_ticks: 0,
    };
    let written = [
        Some((&key::TICK, &file.gyro.tick)),
        Some(noise_form(&file.gyro.tick_noise)?),
        file.gyro.readout_lsb.as_ref().map(|lsb| (&key::READOUT_LSB, lsb)),
        Some((&key::GAP_TICKS, &file.switching.gap_ticks)),
    ];
    for (key, value) in written.into_iter().flatten() {
        key.set(&mut inputs, key.read(value)?);
        places.add(key.name, value.span());
    }
    if let Some(relock) = &file.gyro.relock {
        places.add("gyro.relock", relock.span());
    }
    places.add("switching.fillers", file.switching.fillers.span());
    for (key, list) in [
        ("switching.fit_ticks", &file.switching.fit_ticks),
        ("switching.extrapolation_ticks", &file.switching.extrapolation_ticks),
    ] {
        if let Some(list) = list {
            places.add(key, list.span());
        }
    }
    Ok((inputs, places))
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

/// Angles that the relock adds to ticks.
fn read_relock(list: Option<&Spanned<Vec<Spanned<Scalar>>>>) -> Result<Vec<f64>, Fault> {
    let Some(list) = list else { return Ok(vec![]) };
    if list.get_ref().len() > MAX_SIDE {
        let message = format!("gyro.relock lists {} ticks", list.get_ref().len());
        return Err(Fault::new(
            list.span(),
            message,
            "too many",
            format!("accepted: up to {MAX_SIDE} ticks"),
        ));
    }
    let angle = |item: &Spanned<Scalar>| {
        let quantity = scalar::quantity("gyro.relock", item, &[Dimension::Angle])?;
        if quantity.value.abs() <= MOST_RELOCK {
            return Ok(quantity.value);
        }
        let message = format!("gyro.relock = {quantity} is out of range");
        Err(Fault::new(item.span(), message, "too large", "accepted: -1e6 to 1e6 arcsec"))
    };
    list.get_ref().iter().map(angle).collect()
}

/// Largest angle of the relock in one tick, ″.
const MOST_RELOCK: f64 = 1e6;

fn read_errors(list: Option<&Spanned<Vec<Spanned<Error>>>>) -> Result<Vec<Error>, Fault> {
    let Some(list) = list else { return Ok(vec![Error::Residual, Error::Extrapolation]) };
    let help = "accepted: one or more of \"residual\", \"extrapolation\", \"in-gap\", each once";
    if list.get_ref().is_empty() {
        return Err(Fault::new(list.span(), "switching.errors is empty", "no error", help));
    }
    let mut errors = Vec::new();
    for error in list.get_ref() {
        if errors.contains(error.get_ref()) {
            let message = format!("switching.errors lists \"{}\" twice", error.get_ref().name());
            return Err(Fault::new(error.span(), message, "listed before", help));
        }
        errors.push(*error.get_ref());
    }
    // In the order of the kernel, so that tables do not depend on how they are listed.
    Ok(Error::ALL.into_iter().filter(|error| errors.contains(error)).collect())
}
