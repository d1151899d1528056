//! The study: the user's text, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! All faults are found here, before any work, and reported with their place in the file.

pub mod kept;
pub mod keys;
pub mod kind;
pub mod refusal;
#[cfg(test)]
mod tests;

use std::any::Any;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use toml::Spanned;
use toml::de::DeTable;

pub use crate::chart::Source;
pub use crate::chart::law::Law;
pub use crate::chart::{Chart, Limit, Named, Shows};
pub use crate::drift::Drift;
pub use crate::drift::schedule::Schedule;
pub use crate::filler::keys::Error;
pub use crate::filler::{Fill, Filler, Method, POLYNOMIALS};
pub use crate::key::common::{MOST_TRIALS, Streams};
pub use crate::key::explained::{Explained, Swept as SweptKey};
pub use crate::key::row::Key;
pub use crate::key::scale::Scale;
pub use crate::key::setting::Swept;
pub use crate::key::sweep::Sweep;
pub use crate::kinds::allan::Allan;
pub use crate::kinds::allan::point::{Inputs as RecordInputs, Point as RecordPoint};
pub use crate::kinds::drift_budget::{DriftBudget, Point as BudgetPoint};
pub use crate::kinds::gap_fill::GapFill;
pub use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
pub use crate::kinds::gap_fill::point::Point;
pub use crate::kinds::gap_fill::precision::Precision;
pub use crate::kinds::relock::inputs::FirstHalf;
pub use crate::kinds::relock::inputs::{Compensation, Relock};
pub use crate::kinds::relock::{RelockInputs, RelockPoint, RelockStudy};
pub use crate::kinds::suspension::{Point as SuspensionPoint, SuspensionStudy};
pub use crate::kinds::switched_run::point::Point as RunPoint;
pub use crate::kinds::switched_run::relock::Relocking;
pub use crate::kinds::switched_run::{Angle as RunAngle, SwitchedRun};
pub use crate::kinds::switched_run::{FirstMode, Timing};
pub use crate::motion::keys::{Phase, Position};
pub use crate::motion::vibration::{Acceleration, Vibration};
pub use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
pub use crate::noise::{Markov, Noise, Sine, WarmUp};
pub use crate::quantity::units::{Dimension, Quantity, UnitError, parse as parse_quantity};
pub use crate::source::diagnose::StudyError;
pub(crate) use crate::source::diagnose::{Fault, Text, nearest};
pub use crate::study::kept::Input;
pub use crate::study::keys::{explain_key, explained_keys, schema};
pub use crate::study::kind::Kind;

use crate::chart;
use crate::chart::ground::Ground;
use crate::key::common::{KIND, QUESTION, SEED, STREAMS, TITLE, TRIALS};
use crate::key::places::Places;
use crate::key::reading::Reading;
use crate::key::sweep::read_all as read_sweeps;
use crate::key::table::Table;
use crate::kinds::gap_fill::keys::PRECISION;
use crate::source::diagnose::Wrong;
use crate::source::text_file::{Files, MOST_TOML};
use crate::study::kept::Written;
use crate::study::kind::Subject;
use crate::study::refusal::Refusal;

/// A valid study: every value is within its limits at every point.
#[derive(Debug, Clone)]
pub struct Study {
    /// Title as written, in one line.
    pub title: String,
    /// Question that the study answers; empty if the file has none.
    pub question: String,
    /// Seed of all random draws.
    pub seed: u64,
    /// Trials at each point.
    pub trials: u64,
    /// Whether points share their random numbers.
    pub streams: Streams,
    /// Sweeps in the order written; the first changes slowest.
    pub sweeps: Vec<Sweep>,
    /// Charts as written, or those supplied by the kind.
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
    /// The file cannot be read, or [`Study::parse`] fails.
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = crate::source::text_file::read_text(path, MOST_TOML).map_err(|error| {
            if path.is_dir() {
                return StudyError::of_folder(path);
            }
            StudyError::unreadable("the study", path, &error, "give the path of a study file (TOML, UTF-8)")
        })?;
        Study::parse(&path.display().to_string(), &text)
    }

    /// Reads a study from its `text`; `name` is the name of the file in messages.
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

    /// The kind of the study.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The part of the study that belongs to its kind, where that has the type `T`, such as `GapFill`; otherwise
    /// `None`.
    pub fn asked<T: 'static>(&self) -> Option<&T> {
        (self.subject() as &dyn Any).downcast_ref()
    }

    pub(crate) fn subject(&self) -> &dyn Subject {
        self.subject.as_ref()
    }

    /// The properties of one of its tables, as far as they are known before anything is sampled.
    pub(crate) fn ground(&self, source: Source) -> Option<Ground> {
        self.subject.grounds().into_iter().find(|ground| ground.source == source)
    }

    /// The text columns of one of its tables, which distinguish rows in addition to the swept keys.
    pub fn text_columns(&self, source: Source) -> Vec<&'static str> {
        self.ground(source).map(|ground| ground.text_names()).unwrap_or_default()
    }

    /// Whether points stop at a precision instead of after a number of trials.
    pub fn has_stop_rule(&self) -> bool {
        self.subject.has_stop_rule()
    }

    /// Drops the precision of the study, so that every point takes all trials.
    ///
    /// # Errors
    /// The precision is a table of its own, which cannot be replaced in a [resolved](Study::resolved) study.
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

    /// Notes on inputs that are ignored, rounded or assumed, each a sentence.
    pub fn notes(&self) -> &[String] {
        self.subject.notes()
    }

    /// The laws drawn by any chart, each once.
    pub fn laws(&self) -> Vec<Law> {
        let mut laws: Vec<Law> = Vec::new();
        for law in self.charts.iter().flat_map(Chart::laws) {
            if !laws.contains(law) {
                laws.push(*law);
            }
        }
        laws
    }

    /// An error at the bytes `span` of this study, for faults that are only found later, such as a chart's unknown
    /// column.
    ///
    /// `message` states the fault, `help` the accepted values.
    pub fn error_at(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> StudyError {
        Fault::new(span, message, "here", help).within(&self.text)
    }

    /// The error for a point at these swept values that cannot be sampled, at the key that has to change.
    pub(crate) fn refused(&self, swept: &[(&'static str, Swept)], refusal: &Refusal) -> StudyError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
        let Refusal { key, message, help } = refusal;
        self.error_at(self.place_of(key), format!("{message}{place}"), *help)
    }

    /// The place of the values of `key`, for an error about them: those of a sweep over it, else its own value. A table
    /// such as `gyro.tick_noise` stands for the keys in it; the place is empty at 0 where nothing is written.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.places.blame(&self.sweeps, &[key])
    }

    fn check(text: &Text) -> Result<Study, Wrong> {
        let root = DeTable::parse(text.inner()).map_err(|error| Fault::from_syntax("the study", &error))?;
        let table = Table::root("", &root);
        let (kind, keys) = keys::checked(&table)?;
        let files = Files::of(Path::new(text.name()).parent().unwrap_or(Path::new("")));
        let sweeps = read_sweeps(&table, &keys.keys, &keys.sweepable)?;
        let count = |key: &'static Key| -> Result<Option<Spanned<u64>>, Fault> {
            let Some(given) = table.get(key) else { return Ok(None) };
            Ok(Some(Spanned::new(given.span(), given.whole()?.cast_unsigned())))
        };
        let (seed, trials) = (count(&SEED)?, count(&TRIALS)?);
        let mut reading =
            Reading { table: table.clone(), sweeps: &sweeps, files: &files, places: Places::default() };
        reading.note(&[&KIND, &TRIALS, &PRECISION]);
        let subject = (kind.read)(&mut reading)?;
        let places = reading.places;
        let usual =
            [kind.look.along.or(sweeps.first().map(|sweep| sweep.key.name)), Some(kind.look.estimate)];
        let written_text = |key| table.get(key).map_or(String::new(), |given| given.text().to_owned());
        let grounds = subject.grounds();
        let mut charts =
            chart::read_all(&table, &sweeps, &grounds, usual, || subject.default_chart(&sweeps))?;
        for chart in &mut charts {
            if chart.title.is_empty() {
                chart.title = written_text(&TITLE);
            }
            chart.subtitle = written_text(&QUESTION);
            let ground = grounds.iter().find(|ground| ground.source == chart.source);
            let texts = ground.map(Ground::text_names).unwrap_or_default();
            let apart = sweeps.iter().map(|sweep| sweep.key.name).chain(texts);
            chart.apart = apart.map(str::to_owned).collect();
            let points = match chart.source {
                Source::Points => kind.look.points,
                Source::Trajectories => "single runs",
                Source::Coefficients => "Monte Carlo",
            };
            (chart.points, chart.bands) = (points.to_owned(), kind.look.bands.to_owned());
        }
        Ok(Study {
            title: written_text(&TITLE),
            question: written_text(&QUESTION),
            seed: seed.as_ref().map_or(1, |seed| *seed.get_ref()),
            trials: trials.as_ref().map_or(kind.trials, |trials| *trials.get_ref()),
            streams: Streams::of(table.get(&STREAMS)),
            charts,
            kind,
            subject,
            text: text.clone(),
            places,
            written: Written {
                seed,
                trials,
                inputs: kept::inputs(&table, &keys.keys, &sweeps, &files),
                kind_end: table.span_of(&KIND).unwrap_or_default().end,
                precision: table.span_of(&PRECISION),
            },
            sweeps,
        })
    }
}
