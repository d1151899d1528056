//! The JSON schema of study files, derived from the rows of keys.

use std::collections::HashSet;

use serde_json::{Value, json};

use crate::key::holds::{Holds, Measure};
use crate::key::row::{Key, one_line};
use sagnac_base::quantity::units::Dimension;

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

fn of_value(holds: &Holds, key: &Key, keys: &[&'static Key]) -> Value {
    match holds {
        Holds::Text | Holds::File | Holds::Name(_) | Holds::Percent => json!({ "type": "string" }),
        Holds::Word(words) => {
            let words: Vec<Value> = words.iter().map(|word| of_word(word.word, word.meaning)).collect();
            json!({ "oneOf": words })
        }
        Holds::Flag => json!({ "type": "boolean" }),
        Holds::Whole(low, high) => json!({ "type": "integer", "minimum": low, "maximum": high }),
        Holds::Measure(Measure { accepts: [Dimension::Ratio], .. }) | Holds::Any => {
            json!({ "type": ["number", "string"] })
        }
        Holds::Measure(_) => json!({ "type": "string" }),
        Holds::List(inner) => json!({ "type": "array", "items": of_value(inner, key, keys) }),
        Holds::Pair(inner) => {
            json!({ "type": "array", "items": of_value(inner, key, keys), "minItems": 2, "maxItems": 2 })
        }
        Holds::Either(shapes) => {
            let shapes: Vec<Value> = shapes.iter().map(|shape| of_value(shape, key, keys)).collect();
            json!({ "anyOf": shapes })
        }
        Holds::Table => of_table(key.name, keys),
        Holds::OneOf => {
            let mut table = of_table(key.name, keys);
            table["minProperties"] = json!(1);
            table["maxProperties"] = json!(1);
            table
        }
        Holds::Free => json!({ "type": "object", "additionalProperties": { "type": ["number", "string"] } }),
    }
}

fn of_word(word: &str, meaning: &str) -> Value {
    json!({ "const": word, "type": "string", "description": one_line(meaning) })
}
