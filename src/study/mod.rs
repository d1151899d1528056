//! The study: what the user wrote, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! Whatever is wrong is found here, before any work, and told with its place in the file.

pub mod kept;
pub mod kind;
pub mod refusal;
#[cfg(test)]
pub mod tests;

use std::any::Any;
use std::ops::{Range, RangeInclusive};
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use serde::Deserialize;
use toml::Spanned;

pub use crate::chart::file::{Scale, Source};
pub use crate::chart::law::Law;
pub use crate::chart::{Chart, Limit, Named, Shows};
pub use crate::drift::Drift;
pub use crate::drift::schedule::Schedule;
pub use crate::filler::{Fill, Filler, Method, POLYNOMIALS};
pub use crate::key::explained::{Explained, Swept as SweptKey, explain_key, explained_keys};
pub use crate::key::file::motion::{Phase, Position};
pub use crate::key::file::relock::FirstHalf;
pub use crate::key::file::switching::{Error, FirstMode, Timing};
pub use crate::key::file::{Streams, schema};
pub use crate::key::setting::{Key, Swept};
pub use crate::key::sweep::Sweep;
pub use crate::kinds::allan::Allan;
pub use crate::kinds::allan::point::{Inputs as RecordInputs, Point as RecordPoint};
pub use crate::kinds::drift_budget::{DriftBudget, Point as BudgetPoint};
pub use crate::kinds::gap_fill::GapFill;
pub use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
pub use crate::kinds::gap_fill::point::Point;
pub use crate::kinds::gap_fill::precision::Precision;
pub use crate::kinds::relock::inputs::{Compensation, Relock};
pub use crate::kinds::relock::{RelockInputs, RelockPoint, RelockStudy};
pub use crate::kinds::suspension::{Point as SuspensionPoint, SuspensionStudy};
pub use crate::kinds::switched_run::point::Point as RunPoint;
pub use crate::kinds::switched_run::relock::Relocking;
pub use crate::kinds::switched_run::{Angle as RunAngle, SwitchedRun};
pub use crate::motion::vibration::{Acceleration, Vibration};
pub use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
pub use crate::noise::{Markov, Noise, Sine, WarmUp};
pub use crate::quantity::units::{Dimension, Quantity, UnitError, parse as parse_quantity};
pub use crate::source::diagnose::StudyError;
pub(crate) use crate::source::diagnose::{Fault, Text, nearest};
pub use crate::study::kept::Input;
pub use crate::study::kind::Kind;

use crate::chart;
use crate::chart::ground::Ground;
use crate::key::file::StudyFile;
use crate::key::scalar::Scalar;
use crate::kinds::KINDS;
use crate::source::diagnose::Wrong;
use crate::source::diagnose::choices;
use crate::source::place::Places;
use crate::source::text_file::{Files, MOST_TOML};
use crate::study::kept::Written;
use crate::study::kind::{Reading, Subject};
use crate::study::refusal::Refusal;

/// Most trials at one point, 2^40.
pub const MOST_TRIALS: u64 = 1 << 40;

/// A study that makes sense: every value is within its limits at every point.
#[derive(Debug, Clone)]
pub struct Study {
    /// As written; a line for people.
    pub title: String,
    /// Empty if the file asks none.
    pub question: String,
    /// Of all draws.
    pub seed: u64,
    /// At each point.
    pub trials: u64,
    /// Whether points have the same random numbers.
    pub streams: Streams,
    /// In the order written; the first changes slowest.
    pub sweeps: Vec<Sweep>,
    /// As written, or those that this kind is supplied with.
    pub charts: Vec<Chart>,
    kind: &'static Kind,
    subject: Box<dyn Subject>,
    text: Text,
    places: Places,
    written: Written,
}

impl Study {
    /// Reads the study file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and those of [`Study::parse`].
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = crate::source::text_file::read_text(path, MOST_TOML).map_err(|error| {
            if path.is_dir() {
                return StudyError::of_folder(path);
            }
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

    /// The kind that it is of.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The question of a study of the kind that `T` belongs to, such as [`GapFill`](crate::kinds::gap_fill::GapFill); `None` of
    /// another kind.
    pub fn asked<T: 'static>(&self) -> Option<&T> {
        (self.subject() as &dyn Any).downcast_ref()
    }

    pub(crate) fn subject(&self) -> &dyn Subject {
        self.subject.as_ref()
    }

    /// The columns of text of one of its tables, by which rows are told apart besides the swept keys.
    pub fn text_columns(&self, source: Source) -> Vec<&'static str> {
        let grounds = self.subject.grounds();
        let ground = grounds.iter().find(|ground| ground.source == source);
        ground.map(Ground::text_names).unwrap_or_default()
    }

    /// Whether points stop at a precision rather than after a number of trials.
    pub fn has_stop_rule(&self) -> bool {
        self.subject.has_stop_rule()
    }

    /// Takes all trials at every point, whatever precision the study asks for.
    ///
    /// # Errors
    /// The precision is a table of its own, which cannot be written otherwise in a [resolved](Study::resolved) study.
    pub fn fix_trials(&mut self) -> Result<(), StudyError> {
        let Some(span) = self.written.precision.clone() else { return Ok(()) };
        if !self.text.inner()[span.clone()].starts_with(['"', '\'', '{']) {
            let message = "this precision cannot be left out for all trials to be taken";
            return Err(self.error_at(
                span,
                message,
                "write it as a value, precision = { rms = \"0.5 %\" }, or remove it",
            ));
        }
        self.subject.drop_stop_rule();
        Ok(())
    }

    /// What of the inputs is left out, rounded or assumed, each in a sentence.
    pub fn notes(&self) -> &[String] {
        self.subject.notes()
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

    /// The error of a point at these swept values, which cannot be sampled, at the key that has to change.
    pub(crate) fn refused(&self, swept: &[(&'static str, Swept)], refusal: &Refusal) -> StudyError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
        let Refusal { key, message, help } = refusal;
        self.error_at(self.place_of(key), format!("{message}{place}"), *help)
    }

    /// Where the values of `key` are written, for an error about them: of a sweep over it, else its own. A table such as
    /// `gyro.tick_noise` stands for the keys in it; empty at 0 where nothing is written.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.places.blame(&self.sweeps, &[key])
    }

    fn check(text: &Text) -> Result<Study, Wrong> {
        let toml = toml::Deserializer::parse(text.inner())
            .map_err(|error| Fault::from_syntax("the study", &error))?;
        let file = StudyFile::deserialize(toml).map_err(|error| Fault::from_serde(&error, text.inner()))?;
        let files = Files::of(Path::new(text.name()).parent().unwrap_or(Path::new("")));
        let kind = read_kind(&file.kind)?;
        check_tables(&file, kind)?;
        let sweeps = crate::key::sweep::read_all(&file.sweep, &(kind.keys)())?;
        let mut written = Written {
            seed: read_count("seed", file.seed.as_ref(), 0..=i64::MAX)?,
            trials: read_count("trials", file.trials.as_ref(), 1..=MOST_TRIALS as i64)?,
            inputs: vec![],
            kind_end: file.kind.span().end,
            precision: file.precision.as_ref().map(Spanned::span),
        };
        let mut places = Places::default();
        places.add("kind", file.kind.span());
        if let Some(trials) = &written.trials {
            places.add("trials", trials.span());
        }
        if let Some(precision) = &file.precision {
            places.add("precision", precision.span());
        }
        if kind.is_exact {
            check_exact(&file)?;
        }
        let subject = (kind.read)(&Reading { file: &file, sweeps: &sweeps, files: &files }, &mut places)?;
        written.inputs = crate::study::kept::inputs(&file, &sweeps, &files);
        let charts =
            chart::read_all(file.chart, &sweeps, &subject.grounds(), || subject.default_chart(&sweeps))?;
        Ok(Study {
            title: file.title,
            question: file.question,
            seed: written.seed.as_ref().map_or(1, |seed| *seed.get_ref()),
            trials: written.trials.as_ref().map_or(kind.trials, |trials| *trials.get_ref()),
            streams: file.streams,
            sweeps,
            charts,
            kind,
            subject,
            text: text.clone(),
            places,
            written,
        })
    }
}

/// The kind that a file names.
fn read_kind(written: &Spanned<String>) -> Result<&'static Kind, Fault> {
    let found = written.get_ref();
    KINDS.iter().copied().find(|kind| kind.name == found).ok_or_else(|| {
        let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
        let message = format!("unknown value \"{found}\"");
        Fault::new(written.span(), message, "not one of the choices", choices(found, &names))
    })
}

/// Refuses what means nothing where nothing is sampled.
fn check_exact(file: &StudyFile) -> Result<(), Fault> {
    let Some(precision) = &file.precision else { return Ok(()) };
    let kind = file.kind.get_ref();
    let message = format!("precision is no key of a study of kind = \"{kind}\", which is exact");
    Err(Fault::new(precision.span(), message, "not of this kind", "leave it out"))
}

/// The key of a table that a study of this kind needs.
pub(crate) fn needed_key<'a, T, U>(
    value: Option<&'a Spanned<T>>,
    key: &'static str,
    table: &Spanned<U>,
) -> Result<&'a Spanned<T>, Fault> {
    value.ok_or_else(|| Fault::missing_key(key, table.span()))
}

/// The table that a study of this kind needs.
pub(crate) fn needed<'a, T>(
    table: Option<&'a Spanned<T>>,
    name: &'static str,
    file: &StudyFile,
) -> Result<&'a Spanned<T>, Fault> {
    table.ok_or_else(|| Fault::missing_table(name, file.kind.get_ref(), file.kind.span()))
}

/// Refuses tables that belong to other kinds.
fn check_tables(file: &StudyFile, kind: &Kind) -> Result<(), Fault> {
    match file.tables().into_iter().find(|(name, place)| place.is_some() && !kind.tables.contains(name)) {
        Some((name, place)) => {
            let message = format!("[{name}] is no table of a study of kind = \"{}\"", kind.name);
            let others = KINDS.iter().filter(|other| other.tables.contains(&name));
            let others: Vec<String> = others.map(|other| format!("kind = \"{}\"", other.name)).collect();
            let help = format!("leave it out, or write {}", others.join(" or "));
            Err(Fault::new(place.unwrap_or_default(), message, "not of this kind", help))
        }
        None => Ok(()),
    }
}

/// A whole number that is not negative, where it is written.
fn read_count(
    key: &str,
    given: Option<&Spanned<Scalar>>,
    range: RangeInclusive<i64>,
) -> Result<Option<Spanned<u64>>, Fault> {
    let Some(given) = given else { return Ok(None) };
    let count = crate::key::scalar::whole(key, given, range)?;
    Ok(Some(Spanned::new(given.span(), count.cast_unsigned())))
}
