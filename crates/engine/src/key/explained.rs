//! Explanations of the keys of a study file, from their rows.

use crate::key::row::one_line;
use crate::key::schema::{OfKind, all};
use sagnac_base::quantity::units::{self, Dimension};

/// A key of a study file, explained as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explained {
    /// Its path from the root, such as `motion.amplitude`.
    pub key: &'static str,
    /// Its meaning.
    pub meaning: String,
    /// The values that it holds, such as `a number with its unit, in quotes`.
    pub holds: String,
    /// Its words where it takes one of several, each with its meaning.
    pub choices: Vec<(&'static str, String)>,
    /// An example as written in a study file.
    pub example: &'static str,
    /// Names of the kinds of study that have it.
    pub kinds: Vec<&'static str>,
    /// Whether its table requires it.
    pub required: bool,
    /// Accepted quantities, such as `a frequency in Hz, kHz, 1/s, for example "20 Hz"`; empty if it holds none.
    pub accepted: String,
    /// Range such as `0 to 1e9 arcsec`, or the available names; empty without limits.
    pub range: String,
    /// Its label, such as `vibration frequency`, if it can be swept.
    pub swept: Option<&'static str>,
}

/// Explains a key of some kinds of study; `None` for an unknown key.
pub(crate) fn explain(kinds: &[OfKind], name: &str) -> Option<Explained> {
    let key = all(kinds).into_iter().find(|key| key.name == name)?;
    let choices = match name {
        "kind" => kinds.iter().map(|kind| (kind.name, one_line(kind.meaning))).collect(),
        _ => key.holds.words().iter().map(|word| (word.word, one_line(word.meaning))).collect(),
    };
    let has = |kind: &&OfKind| kind.keys.iter().any(|known| known.name == name);
    let accepted = match key.holds.measured() {
        Some(measure) => units::accepted(measure.accepts),
        None if key.is_whole() => units::accepted(&[Dimension::Count]),
        None => String::new(),
    };
    let is_swept = kinds.iter().any(|kind| kind.sweepable.iter().any(|known| known.name == name));
    Some(Explained {
        key: key.name,
        meaning: key.meaning(),
        holds: key.holds.described(),
        choices,
        example: key.example,
        kinds: kinds.iter().filter(has).map(|kind| kind.name).collect(),
        required: key.required,
        accepted: accepted.trim_start_matches("accepted: ").to_owned(),
        range: key.range(),
        swept: is_swept.then_some(key.label),
    })
}
