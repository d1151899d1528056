//! What is to be known of each key of a study file, from the schema, the examples of messages and the settings.

use serde_json::Value;

use crate::key::expected::{Expected, KEYS};
use crate::key::file::schema;
use crate::key::setting::Key;
use crate::kinds::KINDS;
use crate::quantity::units;
use crate::study::kind::Kind;

/// A key of a study file, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explained {
    /// From the root: `motion.amplitude`.
    pub key: &'static str,
    /// What it means.
    pub meaning: String,
    /// What it holds: `a number with its unit, in quotes`.
    pub holds: &'static str,
    /// Where it is one of some words, each with what it stands for.
    pub choices: Vec<(String, String)>,
    /// As a study file has it.
    pub example: &'static str,
    /// The kinds of studies that have it.
    pub kinds: Vec<&'static Kind>,
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
    pub range: &'static str,
}

/// The names of all keys of study files, in their order.
pub fn explained_keys() -> impl Iterator<Item = &'static str> {
    KEYS.iter().map(|expected| expected.key).filter(|key| !key.ends_with('*'))
}

/// What is to be known of a key; `None` of one that there is not.
///
/// # Example
/// ```
/// # use sagnac::key::explained::explain_key;
/// let tick = explain_key("gyro.tick").unwrap();
/// assert_eq!(tick.example, "tick = \"5 ms\"");
/// assert_eq!(tick.swept.unwrap().range, "1 µs to 1000 s");
/// ```
pub fn explain_key(key: &str) -> Option<Explained> {
    let Expected { key, what, example } = KEYS.iter().find(|expected| expected.key == key)?;
    let schema: Value = serde_json::from_str(&schema()).ok()?;
    let node = key.split('.').try_fold(&schema, |node, name| property(&schema, node, name))?;
    let table = key.split('.').next().unwrap_or(key);
    // A table of its own belongs to some kinds, all else to every one.
    let of_kinds = KINDS.iter().any(|kind| kind.tables.contains(&table));
    let has = |kind: &&Kind| match table {
        "precision" => kind.name == "gap-fill",
        _ => !of_kinds || kind.tables.contains(&table),
    };
    let setting = |kind: &Kind| (kind.keys)().into_iter().find(|setting| setting.name == *key);
    let of_setting = |setting: &Key| Swept {
        label: setting.label,
        accepted: if setting.is_name() { String::new() } else { units::accepted(setting.accepts) },
        range: setting.limits.2,
    };
    Some(Explained {
        key,
        meaning: meaning(&schema, node),
        holds: what,
        choices: choices(&schema, node),
        example,
        kinds: KINDS.into_iter().filter(has).collect(),
        swept: KINDS.into_iter().find_map(setting).map(of_setting),
    })
}

/// The node itself and what it refers to or chooses from, to the bottom.
fn within<'s>(schema: &'s Value, node: &'s Value) -> Vec<&'s Value> {
    let mut found = vec![node];
    let reference = node["$ref"].as_str().and_then(|to| schema.pointer(to.strip_prefix('#')?));
    let parts = ["anyOf", "oneOf", "allOf"].into_iter().filter_map(|list| node[list].as_array()).flatten();
    for part in reference.into_iter().chain(parts).chain(node.get("items")) {
        found.extend(within(schema, part));
    }
    found
}

fn property<'s>(schema: &'s Value, node: &'s Value, name: &str) -> Option<&'s Value> {
    within(schema, node).into_iter().find_map(|part| part["properties"].get(name))
}

/// The descriptions of a node: its own, and that of what it refers to where that says more than one of its words.
fn meaning(schema: &Value, node: &Value) -> String {
    let described = within(schema, node).into_iter().filter(|part| part.get("const").is_none());
    let mut texts: Vec<String> = Vec::new();
    for text in described.filter_map(|part| part["description"].as_str()) {
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if !texts.contains(&text) && texts.len() < 2 {
            texts.push(text);
        }
    }
    texts.join(" ")
}

fn choices(schema: &Value, node: &Value) -> Vec<(String, String)> {
    let words = within(schema, node).into_iter().flat_map(|part| {
        let description = part["description"].as_str().unwrap_or_default();
        let one = part["const"].as_str().map(|word| (word.to_owned(), description.to_owned()));
        let several = part["enum"].as_array().into_iter().flatten().filter_map(Value::as_str);
        one.into_iter().chain(several.map(|word| (word.to_owned(), String::new())))
    });
    words.map(|(word, text)| (word, text.split_whitespace().collect::<Vec<_>>().join(" "))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_explained_and_the_example_names_it() {
        for key in explained_keys() {
            let found = explain_key(key).unwrap_or_else(|| panic!("{key} is not in the schema"));
            let last = key.rsplit('.').next().unwrap();
            assert!(found.example.contains(last), "the example of {key} is {}", found.example);
            assert!(!found.kinds.is_empty(), "{key} is of no kind");
            let said = !found.meaning.is_empty() || !found.choices.is_empty() || found.swept.is_some();
            assert!(said || UNSAID.contains(&key), "nothing is said of {key}");
        }
        for key in KINDS.into_iter().flat_map(|kind| (kind.keys)()) {
            // The ends of bands are swept only.
            assert!(
                explain_key(key.name).is_some() || key.name.ends_with("low") || key.name.ends_with("high"),
                "{}",
                key.name
            );
        }
    }

    /// Keys whose names say all.
    const UNSAID: [&str; 4] = ["sweep.linear.from", "sweep.linear.to", "sweep.log.from", "sweep.log.to"];

    #[test]
    fn the_columns_that_kinds_are_explained_by_are_there() {
        use crate::table::describe::File;
        for kind in KINDS {
            let text = kind.about;
            for name in text.split('`').skip(1).step_by(2).filter(|name| !name.contains(' ')) {
                let files = [File::Points(kind), File::Coefficients];
                assert!(files.iter().any(|file| file.column(name).is_some()), "{kind:?}: {name}");
            }
        }
    }

    #[test]
    fn units_range_choices_and_kinds_are_told() {
        let amplitude = explain_key("motion.amplitude").unwrap();
        assert!(amplitude.meaning.starts_with("Amplitude of the rate"), "{}", amplitude.meaning);
        let swept = amplitude.swept.unwrap();
        assert!(
            swept.accepted.contains("arcsec/s, deg/s") && swept.range.starts_with("0 to 1e9"),
            "{swept:?}"
        );
        let phase = explain_key("motion.phase").unwrap();
        let words: Vec<&str> = phase.choices.iter().map(|(word, _)| word.as_str()).collect();
        assert_eq!(words, ["uniform", "zero-crossing", "extremum"]);
        assert_eq!(
            explain_key("relock.miss").unwrap().kinds.iter().map(|kind| kind.name).collect::<Vec<_>>(),
            ["switched-run", "relock"]
        );
        assert_eq!(explain_key("title").unwrap().kinds.len(), 6);
        assert_eq!(explain_key("motion.amplitud"), None);
    }
}
