//! What is to be known of each key of a study file, from its row.

use crate::key::row::one_line;
use crate::key::schema::{OfKind, all};
use crate::quantity::units::{self, Dimension};

/// A key of a study file, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explained {
    /// From the root: `motion.amplitude`.
    pub key: &'static str,
    /// What it means.
    pub meaning: String,
    /// What it holds: `a number with its unit, in quotes`.
    pub holds: String,
    /// Where it is one of some words, each with what it stands for.
    pub choices: Vec<(&'static str, String)>,
    /// As a study file has it.
    pub example: &'static str,
    /// The names of the kinds of studies that have it.
    pub kinds: Vec<&'static str>,
    /// Dimensions, units and range of its values, where it can be swept.
    pub swept: Option<Swept>,
}

/// What a key that a sweep may vary accepts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Swept {
    /// `vibration frequency`
    pub label: &'static str,
    /// `accepted: a frequency in Hz, kHz, 1/s, for example "20 Hz"`; empty of a name.
    pub accepted: String,
    /// `0 to 1e9 arcsec`, or the names that there are.
    pub range: String,
}

/// What is to be known of a key of some kinds of studies; `None` of one that there is not.
pub(crate) fn explain(kinds: &[OfKind], name: &str) -> Option<Explained> {
    let key = all(kinds).into_iter().find(|key| key.name == name)?;
    let choices = match name {
        "kind" => kinds.iter().map(|kind| (kind.name, one_line(kind.meaning))).collect(),
        _ => key.holds.words().iter().map(|word| (word.word, one_line(word.meaning))).collect(),
    };
    let has = |kind: &&OfKind| kind.keys.iter().any(|known| known.name == name);
    let accepts: &[Dimension] = match key.holds.measured() {
        Some(measure) => measure.accepts,
        None => &[Dimension::Count],
    };
    let is_swept = kinds.iter().any(|kind| kind.sweepable.iter().any(|known| known.name == name));
    Some(Explained {
        key: key.name,
        meaning: key.meaning(),
        holds: key.holds.described(),
        choices,
        example: key.example,
        kinds: kinds.iter().filter(has).map(|kind| kind.name).collect(),
        swept: is_swept.then(|| Swept {
            label: key.label,
            accepted: if key.is_name() { String::new() } else { units::accepted(accepts) },
            range: key.range(),
        }),
    })
}
