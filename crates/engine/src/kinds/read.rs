//! Reading of a study file: its kind is looked up in [`KINDS`] and reads the rest.
//!
//! ```text
//! text ─ toml ─▶ table ─ keys, units ─▶ inputs, sweeps ─ expand, check ─▶ points
//! ```
//!
//! Every fault of a study is found here, before any work, and is reported with its place in the file.
//!
//! [`KINDS`]: crate::kinds::KINDS

use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use toml::Spanned;
use toml::de::DeTable;

use crate::chart::ground::Ground;
use crate::chart::read::{read_all as read_charts, read_requirement};
use crate::key::common::{KIND, LIMIT, QUESTION, SEED, STREAMS, Streams, TITLE, TRIALS};
use crate::key::places::Places;
use crate::key::precision::PRECISION;
use crate::key::reading::Reading;
use crate::key::renamed;
use crate::key::row::Key;
use crate::key::sensitivity;
use crate::key::sweep::{Sweep, read_all as read_sweeps};
use crate::key::table::Table;
use crate::kinds::keys::checked;
use crate::study::kept::{self, Written};
use crate::study::{MAX_BYTES, Study};
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::{Fault, StudyError, Text, Wrong};
use sagnac_base::source::text_file::{Files, MAX_TOML, read_text};

impl Study {
    /// Reads the study file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or [`Study::parse`] fails.
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        let text = read_text(path, MAX_TOML).map_err(|error| {
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
    /// # use sagnac_engine::study::Study;
    /// let error = Study::parse("my.toml", "title = 5 ms").unwrap_err();
    /// assert!(error.render(false, 100).contains("my.toml:1"));
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Study, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        Study::check(&text, None).map_err(|wrong| wrong.within(&text))
    }

    /// Checks a study. With `joined` sweeps, which belong together, its own sweeps and charts do not apply.
    pub(crate) fn check(text: &Text, joined: Option<Vec<Sweep>>) -> Result<Study, Wrong> {
        if let Some(at) = text.inner().find('\0') {
            let message = "the study is not text in UTF-8: it contains a zero byte, as UTF-16 does";
            return Err(Fault::new(at..at + 1, message, "here", "save it as UTF-8").into());
        }
        let mut root =
            DeTable::parse(text.inner()).map_err(|error| Fault::from_syntax("the study", &error))?;
        let notes = renamed::replace("", root.get_mut());
        let table = Table::root("", &root);
        let (kind, keys) = checked(&table)?;
        let files = Files::of(Path::new(text.name()).parent().unwrap_or(Path::new("")));
        let is_own = joined.is_none();
        let sweeps = match joined {
            Some(joined) => joined,
            None => read_sweeps(&table, &keys.keys, &keys.sweepable)?,
        };
        let own_sweeps = if is_own { &sweeps[..] } else { &[] };
        let uncertain = sensitivity::read_all(&table, &keys.keys, &keys.sweepable, own_sweeps)?;
        let count = |key: &'static Key| -> Result<Option<Spanned<u64>>, Fault> {
            let Some(given) = table.get(key) else { return Ok(None) };
            Ok(Some(Spanned::new(given.span(), given.whole()?.cast_unsigned())))
        };
        let (seed, trials) = (count(&SEED)?, count(&TRIALS)?);
        let places = Places::of(&sweeps);
        let precision = None;
        let mut reading =
            Reading { table: table.clone(), sweeps: &sweeps, files: &files, places, notes, precision };
        reading.note(&[&KIND, &TRIALS, &PRECISION]);
        let subject = (kind.read)(&mut reading)?;
        let Reading { mut places, notes, precision, .. } = reading;
        let bytes = subject.bytes();
        if bytes > MAX_BYTES {
            let span = sweeps.first().map_or_else(|| table.span_of(&KIND), |sweep| Some(sweep.span.clone()));
            let message =
                format!("the points of this study and their tables take {} MiB of memory", bytes >> 20);
            let help =
                "accepted: up to 1024 MiB; sweep fewer values, or take fewer fillers, times or trajectories";
            return Err(Fault::new(span.unwrap_or_default(), message, "too many points", help).into());
        }
        // After the values that are read, which come first where both are written.
        uncertain.iter().for_each(|input| places.add(input.key.name, input.span.clone()));
        let written_text = |key| table.get(key).map_or(String::new(), |given| given.text().to_owned());
        let grounds = subject.grounds();
        let mut charts = if is_own { read_charts(&table, &sweeps, &grounds)? } else { vec![] };
        let requirement = table.get(&LIMIT).map(|given| read_requirement(given, &grounds, &mut charts));
        let requirement = requirement.transpose()?;
        for chart in &mut charts {
            if chart.title.is_empty() {
                chart.title = written_text(&TITLE);
            }
            chart.subtitle = written_text(&QUESTION);
            let ground = grounds.iter().find(|ground| ground.source == chart.source);
            let texts = ground.map(Ground::text_names).unwrap_or_default();
            let apart = sweeps.iter().map(|sweep| sweep.key.name).chain(texts);
            chart.apart = apart.map(str::to_owned).collect();
            let [points, bands] = ground.map_or([""; 2], |ground| ground.legend_of(&chart.estimate().name));
            (chart.points, chart.bands) = (points.to_owned(), bands.to_owned());
        }
        Ok(Study {
            title: written_text(&TITLE),
            question: written_text(&QUESTION),
            seed: seed.as_ref().map_or(1, |seed| *seed.get_ref()),
            trials: trials.as_ref().map_or(kind.trials, |trials| *trials.get_ref()),
            streams: Streams::of(table.get(&STREAMS)),
            charts,
            requirement,
            kind,
            notes,
            precision,
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
            uncertain,
            values: values(&table, &keys.sweepable),
            sweeps,
        })
    }
}

/// The quantities of the keys that a sweep may vary, as far as they are written.
fn values(table: &Table, sweepable: &[&'static Key]) -> Vec<(&'static Key, Quantity)> {
    let written = sweepable.iter().filter_map(|key| Some((*key, table.get(key)?.quantity().ok()?)));
    written.collect()
}
