//! Documentation of keys from their rows: explanations, the JSON schema, and the names of earlier versions.

use std::borrow::Cow;
use std::collections::HashSet;
use std::mem::take;

use serde_json::{Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key::{Key, Measure, ValueType, joined, one_line};
use sagnac_base::quantity::{self, Dimension};

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
        Some(measure) => quantity::accepted(measure.accepts),
        None if key.is_whole() => quantity::accepted(&[Dimension::Count]),
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

/// The keys of a kind of study.
pub(crate) struct OfKind {
    /// Its name in study files.
    pub(crate) name: &'static str,
    /// Its subject.
    pub(crate) meaning: &'static str,
    pub(crate) keys: Vec<&'static Key>,
    /// The tables that it requires.
    pub(crate) needs: &'static [&'static str],
    /// The keys that can be swept.
    pub(crate) sweepable: Vec<&'static Key>,
}

/// The keys of all kinds, each once.
pub(crate) fn all(kinds: &[OfKind]) -> Vec<&'static Key> {
    distinct(kinds.iter().flat_map(|kind| kind.keys.clone()))
}

/// The first of some keys with each name.
pub(crate) fn distinct(keys: impl IntoIterator<Item = &'static Key>) -> Vec<&'static Key> {
    let mut seen = HashSet::new();
    keys.into_iter().filter(|key| seen.insert(key.name)).collect()
}

/// The schema as indented JSON.
pub(crate) fn schema(kinds: &[OfKind]) -> String {
    let mut root = of_table("", &all(kinds));
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    root["title"] = json!("sagnac study");
    root["description"] = json!(
        "A study of sagnac: one question about a laser gyroscope, and all that its answer depends on. Quantities are texts \
         with a unit: \"5 ms\", \"20 Hz\", \"1.6 arcsec\", \"12000 arcsec/s\", \"0.003 deg/sqrt(h)\"."
    );
    let words: Vec<Value> = kinds.iter().map(|kind| of_word(kind.name, kind.meaning)).collect();
    root["properties"]["kind"] = json!({ "description": "Kind of the study.", "oneOf": words });
    let needs = |kind: &OfKind| {
        let is_kind = json!({ "properties": { "kind": { "const": kind.name } } });
        json!({ "if": is_kind, "then": { "required": kind.needs } })
    };
    root["allOf"] = kinds.iter().map(needs).collect();
    // The alternate form of a JSON value is the indented one.
    format!("{root:#}\n")
}

fn of_table(name: &str, keys: &[&'static Key]) -> Value {
    let inner = || keys.iter().filter(|key| key.table() == name);
    let properties = inner().map(|key| (key.last().to_owned(), of_key(key, keys)));
    let required: Vec<&str> = inner().filter(|key| key.required).map(|key| key.last()).collect();
    let properties: serde_json::Map<String, Value> = properties.collect();
    let mut table = json!({ "type": "object", "additionalProperties": false, "properties": properties });
    if !required.is_empty() {
        table["required"] = json!(required);
    }
    table
}

fn of_key(key: &Key, keys: &[&'static Key]) -> Value {
    let mut node = of_value(&key.holds, key, keys);
    node["description"] = json!(key.meaning());
    let example = key
        .example
        .parse::<toml::Table>()
        .ok()
        .and_then(|table| table.into_iter().next())
        .map(|(_, value)| value);
    if let Some(value) = example.filter(|_| !key.holds.is_table()) {
        node["examples"] = json!([value]);
    }
    node
}

fn of_value(holds: &ValueType, key: &Key, keys: &[&'static Key]) -> Value {
    match holds {
        ValueType::Text | ValueType::File | ValueType::Name(_) | ValueType::Percent => {
            json!({ "type": "string" })
        }
        ValueType::Word(words) => {
            let words: Vec<Value> = words.iter().map(|word| of_word(word.word, word.meaning)).collect();
            json!({ "oneOf": words })
        }
        ValueType::Flag => json!({ "type": "boolean" }),
        ValueType::Whole(low, high) => json!({ "type": "integer", "minimum": low, "maximum": high }),
        ValueType::Measure(Measure { accepts: [Dimension::Ratio], .. }) | ValueType::Any => {
            json!({ "type": ["number", "string"] })
        }
        ValueType::Measure(_) => json!({ "type": "string" }),
        ValueType::List(inner) => json!({ "type": "array", "items": of_value(inner, key, keys) }),
        ValueType::Pair(inner) => {
            json!({ "type": "array", "items": of_value(inner, key, keys), "minItems": 2, "maxItems": 2 })
        }
        ValueType::Either(shapes) => {
            let shapes: Vec<Value> = shapes.iter().map(|shape| of_value(shape, key, keys)).collect();
            json!({ "anyOf": shapes })
        }
        ValueType::Table => of_table(key.name, keys),
        ValueType::OneOf => {
            let mut table = of_table(key.name, keys);
            table["minProperties"] = json!(1);
            table["maxProperties"] = json!(1);
            table
        }
        ValueType::Free => {
            json!({ "type": "object", "additionalProperties": { "type": ["number", "string"] } })
        }
    }
}

fn of_word(word: &str, meaning: &str) -> Value {
    json!({ "const": word, "type": "string", "description": one_line(meaning) })
}

/// The release in which the former names go.
pub(crate) const GOES: &str = "0.4";

/// Former names with the present ones. Of keys and columns they may be a part between `.` and `_`.
pub(crate) const RENAMED: [(&str, &str); 15] = [
    ("identified", "detected"),
    ("in_run_stability", "in_run_bias_stability"),
    ("law", "reference"),
    ("laws", "references"),
    ("miss", "initial_detuning"),
    ("normalised", "normalized"),
    ("oracle", "theory"),
    ("q50", "p50"),
    ("q95", "p95"),
    ("q9973", "p99_73"),
    ("quantisation", "quantization"),
    ("terms", "differences"),
    ("verdict", "status"),
    ("--bound", "--overbound"),
    ("--laws", "--references"),
];

/// Keys whose texts are names of columns or keys.
const OF_NAMES: [&str; 7] =
    ["chart.of", "chart.series", "chart.x", "chart.y", "chart.z", "sensitivity.key", "sweep.key"];

/// The present name for a former one; `None` for any other name.
///
/// ```
/// # use sagnac_engine::key::docs::present;
/// assert_eq!(present("oracle_rms_arcsec").as_deref(), Some("theory_rms_arcsec"));
/// assert_eq!(present("noise.quantisation").as_deref(), Some("noise.quantization"));
/// assert_eq!(present("rms"), None);
/// ```
pub fn present(name: &str) -> Option<String> {
    let of = |part: &str| RENAMED.iter().find(|(former, _)| *former == part).map(|(_, present)| *present);
    if let Some(whole) = of(name) {
        return Some(whole.to_owned());
    }
    let parts = name.split_inclusive(['.', '_']).map(|part| {
        let bare = part.trim_end_matches(['.', '_']);
        format!("{}{}", of(bare).unwrap_or(bare), &part[bare.len()..])
    });
    Some(parts.collect()).filter(|present| present != name)
}

/// The note on a former name.
pub fn note(former: &str, present: &str) -> String {
    format!("`{former}` is `{present}` now; the old name goes in {GOES}")
}

/// Replaces the former names in a table called `name`, and returns a note on each. Places stay those of the text.
pub(crate) fn replace(name: &str, table: &mut DeTable) -> Vec<String> {
    let mut notes = of_entries(name, table);
    let mut known = HashSet::new();
    notes.retain(|note| known.insert(note.clone()));
    notes
}

fn of_entries(name: &str, table: &mut DeTable) -> Vec<String> {
    let mut notes = vec![];
    let mut entries: Vec<_> = take(table).into_iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    for (key, mut value) in entries {
        let former = joined(name, key.get_ref());
        let key = match present(key.get_ref()) {
            Some(last) => {
                notes.push(note(&former, &joined(name, &last)));
                Spanned::new(key.span(), Cow::Owned(last))
            }
            None => key,
        };
        notes.extend(renamed_in(&joined(name, key.get_ref()), value.get_mut()));
        table.insert(key, value);
    }
    notes
}

fn renamed_in(key: &str, value: &mut DeValue) -> Vec<String> {
    match value {
        DeValue::Table(table) => of_entries(key, table),
        DeValue::Array(items) => items.iter_mut().flat_map(|item| renamed_in(key, item.get_mut())).collect(),
        DeValue::String(text) if OF_NAMES.contains(&key) => {
            let Some(present) = present(text) else { return vec![] };
            let note = note(text, &present);
            *text = Cow::Owned(present);
            vec![note]
        }
        _ => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_names_of_columns_are_replaced_and_other_texts_are_not() {
        let text = "title = \"oracle\"\nnoise.quantisation = 1\n[[chart]]\ny = [\"rms\", \"oracle_rms\"]\nwhere = { verdict = \"law\" }";
        let mut root = DeTable::parse(text).unwrap();
        let notes = replace("", root.get_mut());
        let former: Vec<&str> = notes.iter().map(|note| note.split('`').nth(1).unwrap()).collect();
        assert_eq!(former, ["noise.quantisation", "oracle_rms", "chart.where.verdict"]);
        let chart = root.get_ref()["chart"].get_ref().as_array().unwrap()[0].get_ref().as_table().unwrap();
        let ys: Vec<_> =
            chart["y"].get_ref().as_array().unwrap().iter().map(|y| y.get_ref().as_str()).collect();
        assert_eq!(ys, [Some("rms"), Some("theory_rms")]);
        assert_eq!(chart["where"].get_ref().as_table().unwrap()["status"].get_ref().as_str(), Some("law"));
        assert_eq!(root.get_ref()["title"].get_ref().as_str(), Some("oracle"));
    }
}
