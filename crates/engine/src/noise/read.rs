//! Reading of `[noise]` and of the files that it names.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use toml::de::DeTable;

use crate::key::reading::Reading;
use crate::key::renamed;
use crate::key::setting::Setting;
use crate::key::table::{Table, check};
use crate::noise::Noise;
use crate::noise::keys::{FILE, KEYS, LOCK_IN, NOISE, SETTINGS, SWITCHING};
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::{Fault, StudyError, Text, Wrong};
use sagnac_base::source::text_file::{Files, MAX_TOML, read_text};

/// The noise of a table, with the settings written in addition to a file.
pub(crate) struct WrittenNoise {
    pub(crate) noise: Noise,
    pub(crate) written: Vec<(&'static Setting<Noise>, Quantity)>,
}

/// Reads the noise, including that of a file, and records the place of each key.
pub(crate) fn read(reading: &mut Reading) -> Result<WrittenNoise, Wrong> {
    let mut noise = match reading.get(&FILE) {
        Some(file) => {
            let (noise, notes) = read_file(file.text(), file.span(), reading.files)?;
            reading.notes.extend(notes);
            noise
        }
        None => Noise::default(),
    };
    // The table comes before its keys, so that an error about the whole points at it.
    reading.note(&[&NOISE, &FILE, &LOCK_IN, &SWITCHING]);
    let written = reading.set(&mut noise, &SETTINGS)?;
    Ok(WrittenNoise { noise, written })
}

/// Reads the noise file of this name, which is a `[noise]` table by itself; the name is at `span` of the study.
pub(crate) fn read_file(
    name: &str,
    span: Range<usize>,
    files: &Files,
) -> Result<(Noise, Vec<String>), Wrong> {
    let path = files.path(name);
    let text = files.text(name, MAX_TOML).map_err(|error| {
        let message = format!("cannot read the noise {}: {error}", path.display());
        let help = "give the path of a noise.toml, relative to the folder of the study; `sagnac allan` writes such files from records";
        Fault::new(span, message, "named here", help)
    })?;
    let text: Text = Arc::new(NamedSource::new(path.display().to_string(), text.to_string()));
    parse(text.inner()).map_err(|fault| Wrong::Elsewhere(fault.within(&text)))
}

impl Noise {
    /// Reads a noise.toml by itself, and returns its text too.
    ///
    /// # Errors
    /// The file cannot be read, or is no noise.
    pub fn read(path: &Path) -> Result<(Noise, String), StudyError> {
        let text = read_text(path, MAX_TOML).map_err(|error| {
            let help = "give the path of a noise.toml, as `sagnac allan` writes it from a record";
            StudyError::unreadable("the noise", path, &error, help)
        })?;
        Ok((Noise::parse(&path.display().to_string(), &text)?, text))
    }

    /// Parses the text of a noise.toml, which is called `name` in errors.
    ///
    /// # Errors
    /// The text is no noise.
    pub fn parse(name: &str, text: &str) -> Result<Noise, StudyError> {
        let text: Text = Arc::new(NamedSource::new(name, text.to_owned()));
        parse(text.inner()).map(|(noise, _)| noise).map_err(|fault| fault.within(&text))
    }
}

/// The noise of a text, with notes on former names.
fn parse(text: &str) -> Result<(Noise, Vec<String>), Fault> {
    let mut root = DeTable::parse(text).map_err(|error| Fault::from_syntax("the noise", &error))?;
    let notes = renamed::replace(NOISE.name, root.get_mut());
    let table = Table::root(NOISE.name, &root);
    check(&table, KEYS, &|_, _| None)?;
    if let Some(file) = table.get(&FILE) {
        return Err(file.fault("a noise file names another noise file", "here", "copy its keys instead"));
    }
    let mut noise = Noise::default();
    for setting in &SETTINGS {
        if let Some(given) = table.get(setting.key) {
            (setting.set)(&mut noise, given.quantity()?);
        }
    }
    Ok((noise, notes))
}
