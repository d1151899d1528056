//! Names of earlier versions. Studies, charts and options take them with a note.

use std::borrow::Cow;
use std::collections::HashSet;
use std::mem::take;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key::row::joined;

/// The release in which the former names go.
pub const GOES: &str = "0.4";

/// Former names with the present ones. Of keys and columns they may be a part between `.` and `_`.
pub const RENAMED: [(&str, &str); 15] = [
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
/// # use sagnac_engine::key::renamed::present;
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
        notes.extend(of_value(&joined(name, key.get_ref()), value.get_mut()));
        table.insert(key, value);
    }
    notes
}

fn of_value(key: &str, value: &mut DeValue) -> Vec<String> {
    match value {
        DeValue::Table(table) => of_entries(key, table),
        DeValue::Array(items) => items.iter_mut().flat_map(|item| of_value(key, item.get_mut())).collect(),
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
