//! The study: what the user wrote, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! Whatever is wrong is found here, before any work, and told with its place in the file.

pub mod kept;
pub mod kind;
pub mod precision;

use std::any::Any;
use std::ops::Range;

use crate::chart::Chart;
use crate::chart::file::Source;
use crate::chart::ground::Ground;
use crate::chart::law::Law;
use crate::key::common::Streams;
use crate::key::places::Places;
use crate::key::refusal::Refusal;
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::source::diagnose::{Fault, StudyError, Text};
use crate::study::kept::Written;
use crate::study::kind::{Kind, Subject};

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
    pub(crate) kind: &'static Kind,
    pub(crate) subject: Box<dyn Subject>,
    pub(crate) text: Text,
    pub(crate) places: Places,
    pub(crate) written: Written,
}

impl Study {
    /// The kind that it is of.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The question of a study of the kind that `T` belongs to, such as `GapFill`; `None` of
    /// another kind.
    pub fn asked<T: 'static>(&self) -> Option<&T> {
        (self.subject() as &dyn Any).downcast_ref()
    }

    pub(crate) fn subject(&self) -> &dyn Subject {
        self.subject.as_ref()
    }

    /// What is known of one of its tables before anything is sampled.
    pub(crate) fn ground(&self, source: Source) -> Option<Ground> {
        self.subject.grounds().into_iter().find(|ground| ground.source == source)
    }

    /// The columns of text of one of its tables, by which rows are told apart besides the swept keys.
    pub fn text_columns(&self, source: Source) -> Vec<&'static str> {
        self.ground(source).map(|ground| ground.text_names()).unwrap_or_default()
    }

    /// The rows of its points that are meant where nothing is said: (column, value as files show it).
    pub fn usual_rows(&self) -> Vec<(String, String)> {
        let ground = self.ground(Source::Points);
        let rows = ground.iter().flat_map(Ground::usual_rows);
        rows.map(|(column, value)| (column.name, value.text())).collect()
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
}
