//! A study as stored beside its results: the text that repeats it, and the files that it names.

use std::cmp::Reverse;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;

use crate::key::precision::NONE as NO_PRECISION;
use crate::key::row::Key;
use crate::key::sweep::Sweep;
use crate::key::table::Table;
use crate::study::Study;
use sagnac_base::source::text_file::{Files, MAX_RECORD};

/// The folder, beside a stored study, of the files that it names.
pub(crate) const INPUTS: &str = "inputs";

/// The parts of a study's text that may have to be replaced when it is stored.
#[derive(Debug, Clone)]
pub struct Written {
    pub(crate) seed: Option<Spanned<u64>>,
    pub(crate) trials: Option<Spanned<u64>>,
    /// The named files, with the places of their names.
    pub(crate) inputs: Vec<Spanned<Input>>,
    /// The end of the value of `kind`, which every study has at its top level.
    pub(crate) kind_end: usize,
    /// The place of the precision.
    pub(crate) precision: Option<Range<usize>>,
}

/// A file that a study names: a record, or noise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name in a stored study, relative to that study, such as `inputs/LGK-400.toml`.
    pub name: String,
    /// Its contents when the study was read.
    pub text: Arc<str>,
    path: PathBuf,
}

/// The files that a study names. A file that could not be read is missing; it has been reported, or is not needed.
pub(crate) fn inputs(
    study: &Table,
    keys: &[&'static Key],
    sweeps: &[Sweep],
    files: &Files,
) -> Vec<Spanned<Input>> {
    let written = keys.iter().filter(|key| key.is_file()).filter_map(|key| study.get(key));
    let written = written.map(|given| Spanned::new(given.span(), given.text().to_owned()));
    let named = written.chain(sweeps.iter().flat_map(|sweep| sweep.files.clone()));
    let mut inputs: Vec<Spanned<Input>> = Vec::new();
    for file in named {
        let Ok(text) = files.text(file.get_ref(), MAX_RECORD) else { continue };
        let path = files.path(file.get_ref());
        let known = inputs.iter().map(Spanned::get_ref).find(|input| input.path == path);
        let input = known.cloned().unwrap_or_else(|| Input { name: name(&path, &inputs), text, path });
        inputs.push(Spanned::new(file.span(), input));
    }
    inputs
}

/// A name that no other file has, even where names are not case-sensitive. It ends like the path, because tables name
/// gyros by it.
fn name(path: &Path, taken: &[Spanned<Input>]) -> String {
    let last = path.file_name().unwrap_or_default().to_string_lossy();
    let numbered = (2_u32..).map(|number| format!("{INPUTS}/{number}/{last}"));
    let mut names = std::iter::once(format!("{INPUTS}/{last}")).chain(numbered);
    let is_free =
        |name: &String| taken.iter().all(|input| input.get_ref().name.to_lowercase() != name.to_lowercase());
    names.find(is_free).unwrap_or_default()
}

impl Study {
    /// The study as read, but with its current seed, `trials` trials, its files in `inputs` beside it, and without a
    /// precision that was [left out](Study::fix_trials). Together with [its files](Study::inputs) it repeats this study
    /// without further options, wherever it is stored. Comments and layout are preserved. Seed and trials are left out
    /// where nothing is sampled.
    pub fn resolved(&self, trials: u64) -> String {
        let Written { seed, trials: written_trials, inputs, kind_end, precision } = &self.written;
        let mut text = self.text.inner().clone();
        let next_line = text[*kind_end..].find('\n').map(|length| kind_end + length + 1);
        // A key right after the kind is at the top level, before any table.
        let after_kind = next_line.unwrap_or(text.len());
        let line_end = if next_line.is_some() { "" } else { "\n" };
        let mut edits = Vec::new();
        for (key, value, written) in [("trials", trials, written_trials), ("seed", self.seed, seed)] {
            match written {
                _ if self.kind.is_exact => {}
                None => edits.push((after_kind..after_kind, format!("{line_end}{key} = {value}\n"))),
                Some(written) if *written.get_ref() != value => {
                    edits.push((written.span(), value.to_string()))
                }
                // An unchanged value keeps its notation, such as 1_000_000 or 0xff.
                Some(_) => {}
            }
        }
        if let Some(span) = precision.clone().filter(|_| self.precision.is_none()) {
            edits.push((span, format!("\"{NO_PRECISION}\"")));
        }
        for input in inputs {
            edits.push((input.span(), toml::Value::String(input.get_ref().name.clone()).to_string()));
        }
        // Edits go from the end, so that the places of the others remain valid.
        edits.sort_by_key(|(place, _)| Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place, &new);
        }
        text
    }

    /// The text from which it was read.
    pub fn text(&self) -> &str {
        self.text.inner()
    }

    /// The files that it names, each once.
    pub fn inputs(&self) -> Vec<&Input> {
        let mut inputs: Vec<&Input> = Vec::new();
        for input in self.written.inputs.iter().map(Spanned::get_ref) {
            if !inputs.contains(&input) {
                inputs.push(input);
            }
        }
        inputs
    }
}
