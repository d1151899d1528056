//! The study: the user's text, read, checked and expanded into points.
//!
//! ```text
//! text ─ toml ─▶ file ─ scalar, units ─▶ Inputs, Sweeps ─ expand, check ─▶ Points
//! ```
//!
//! All faults are found here, before any work, and reported with their place in the file.

pub mod kept;
pub mod kind;
pub(crate) mod part;

use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

use crate::chart::file::Source;
use crate::chart::ground::Ground;
use crate::chart::law::Law;
use crate::chart::{Chart, Requirement};
use crate::key::common::Streams;
use crate::key::places::Places;
pub use crate::key::precision;
use crate::key::precision::Precision;
use crate::key::refusal::Refusal;
use crate::key::row::Key;
use crate::key::sensitivity::Uncertain;
use crate::key::setting::Swept;
use crate::key::sweep::{self, Sweep};
use crate::study::kept::Written;
use crate::study::kind::{Kind, Subject};
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::{Fault, StudyError, Text};

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
    /// The limit that its answer must meet.
    pub requirement: Option<Requirement>,
    /// Its kind.
    pub kind: &'static Kind,
    /// Notes on inputs that are ignored, rounded or assumed, each a sentence.
    pub notes: Vec<String>,
    /// Precision at which points stop instead of after a number of trials.
    pub precision: Option<Precision>,
    /// The part that belongs to its kind.
    pub subject: Arc<dyn Subject>,
    /// Its text, for messages with places.
    pub text: Text,
    /// Places of its keys in the text.
    pub places: Places,
    /// What of the text a resolved study keeps.
    pub written: Written,
    /// Inputs whose values are known only by a range or a distribution.
    pub uncertain: Vec<Uncertain>,
    /// The written quantities of the keys that a sweep may vary.
    pub values: Vec<(&'static Key, Quantity)>,
}

/// Most bytes of memory that the points and the tables of a study may take, and so may the trials of one of its points.
pub(crate) const MAX_BYTES: u64 = 1 << 30;

impl Study {
    /// The kind of the study.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// The part of the study that belongs to its kind, where that has the type `T`, such as `GapFill`; otherwise
    /// `None`.
    pub fn asked<T: 'static>(&self) -> Option<&T> {
        (self.subject.as_ref() as &dyn Any).downcast_ref()
    }

    /// The properties of one of its tables, as far as they are known before anything is sampled.
    pub fn ground(&self, source: Source) -> Option<Ground> {
        self.subject.grounds().into_iter().find(|ground| ground.source == source)
    }

    /// Number of points of its sweeps.
    pub fn points(&self) -> usize {
        sweep::count(&self.sweeps)
    }

    /// Whether a chart shows what the study may be judged by.
    pub fn is_judged_by(&self, chart: &Chart) -> bool {
        self.ground(chart.source).is_none_or(|ground| ground.judges(&chart.estimate().name))
    }

    /// The text columns of one of its tables, which distinguish rows in addition to the swept keys.
    pub fn text_columns(&self, source: Source) -> Vec<&'static str> {
        self.ground(source).map(|ground| ground.text_names()).unwrap_or_default()
    }

    /// The default rows of its points, as pairs of a column and its value as files show it.
    pub fn usual_rows(&self) -> Vec<(String, String)> {
        let ground = self.ground(Source::Points);
        let rows = ground.iter().flat_map(Ground::usual_rows);
        rows.map(|(column, value)| (column.name, value.text())).collect()
    }

    /// Drops the precision of the study, so that every point takes all trials.
    ///
    /// # Errors
    /// The precision is a table of its own, which cannot be replaced in a [resolved](Study::resolved) study.
    pub fn fix_trials(&mut self) -> Result<(), StudyError> {
        let Some(span) = self.written.precision.clone() else { return Ok(()) };
        if !self.text.inner()[span.clone()].starts_with(['"', '\'', '{']) {
            let message = "this precision cannot be left out to sample all trials";
            return Err(self.error_at(
                span,
                message,
                "write it as a value, precision = { rms = \"0.5 %\" }, or remove it",
            ));
        }
        self.precision = None;
        Ok(())
    }

    /// The laws drawn by any chart, each once.
    pub fn laws(&self) -> Vec<Law> {
        let mut laws: Vec<Law> = Vec::new();
        for law in self.charts.iter().flat_map(Chart::references) {
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

    /// Refuses trials of a point that do not fit into [`MAX_BYTES`] where each has these `numbers` in memory, with 32 bytes for
    /// each of them: its sum and what is made of it. `what` names what a trial of this kind is.
    pub(crate) fn check_trials(&self, numbers: usize, what: &str) -> Result<(), StudyError> {
        let most = MAX_BYTES / (32 * numbers.max(1) as u64);
        if self.trials <= most {
            return Ok(());
        }
        let message = format!("{} {what} of a point", self.trials);
        let help = format!("accepted: up to {most} trials, which are {what} here and take 1 GiB of memory");
        Err(self.error_at(self.place_of("trials"), message, help))
    }

    /// The error for a point at these swept values that cannot be sampled, at the key that has to change.
    pub fn refused(&self, swept: &[(&'static str, Swept)], refusal: &Refusal) -> StudyError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
        let Refusal { key, message, help } = refusal;
        self.error_at(self.place_of(key), format!("{message}{place}"), *help)
    }

    /// The place of the values of `key`, for an error about them: those of a sweep over it, else its own value. A table
    /// such as `gyro.tick_noise` stands for the keys in it; the place is empty at 0 where nothing is written.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.places.blame(&[key])
    }
}
