//! The reference lists every key of study files, from the rows that declare them.

use crate::generated::{check, filled};
use sagnac_engine::key::docs::Explained;
use sagnac_engine::kinds::{explain_key, explained_keys};

#[test]
fn the_reference_lists_all_keys() {
    check(crate::ROOT, "docs/reference/study-file.md", &list());
}

/// A heading for each table of studies, and an item for each of its keys.
fn list() -> String {
    let keys: Vec<Explained> = explained_keys().filter_map(explain_key).collect();
    let mut tables: Vec<&str> = vec![];
    for key in &keys {
        let table = table_of(key);
        if !tables.contains(&table) {
            tables.push(table);
        }
    }
    let sections = tables.into_iter().map(|table| {
        let own: Vec<&Explained> = keys.iter().filter(|key| table_of(key) == table).collect();
        let heading = if table.is_empty() { "At the top".to_owned() } else { format!("`[{table}]`") };
        // The kinds that most of its keys are in.
        let count = |key: &Explained| own.iter().filter(|other| other.kinds == key.kinds).count();
        let kinds = &own.iter().max_by_key(|key| count(key)).unwrap().kinds;
        let items: String = own.iter().map(|key| item(key, kinds)).collect();
        let all = explain_key("title").map_or(0, |title| title.kinds.len());
        let kinds = if kinds.len() == all { "all".to_owned() } else { kinds.join(", ") };
        format!("\n### {heading}\n\nKinds: {kinds}.\n\n{items}")
    });
    sections.collect()
}

/// The table that a key is in; a table at the top stands under its own heading.
fn table_of(key: &Explained) -> &'static str {
    let is_table = explained_keys().any(|other| other.starts_with(&format!("{}.", key.key)));
    key.key.split_once('.').map_or(if is_table { key.key } else { "" }, |(table, _)| table)
}

/// A key, with its kinds of studies where they are not those of its table.
fn item(key: &Explained, kinds: &[&str]) -> String {
    // A key like another one has the words and limits of that one.
    let is_alike = key.meaning.starts_with("Like ");
    let limits = Some(key.range.clone()).filter(|_| key.choices.is_empty() && !is_alike);
    let facts = std::iter::once(held(&key.holds).to_owned()).chain(limits).filter(|fact| !fact.is_empty());
    let facts = facts.chain(key.required.then(|| "required".to_owned()));
    let facts = facts.chain((key.kinds != kinds).then(|| format!("in {}", key.kinds.join(", "))));
    let facts = facts.collect::<Vec<_>>().join("; ");
    let facts = if facts.is_empty() { facts } else { format!(" ({facts})") };
    // Scales have the same words.
    let choices =
        key.choices.iter().filter(|_| !is_alike && !["chart.y_scale", "chart.z_scale"].contains(&key.key));
    let choice = |(word, meaning): &(&str, String)| filled("  - ", &format!("`\"{word}\"`: {meaning}"));
    let mark = if key.swept.is_some() { "\\*" } else { "" };
    filled("- ", &format!("`{}`{mark}: {}{facts}", key.key, key.meaning))
        + &choices.map(choice).collect::<String>()
}

/// What a key holds, where neither its limits nor its words say it.
fn held(holds: &str) -> &str {
    match holds {
        "a number with its unit, in quotes"
        | "a number with its unit, in quotes, or a table of one key"
        | "a number with its unit, in quotes, or a list of two ends"
        | "a number, or percent in quotes"
        | "a text in quotes"
        | "a table"
        | "a table of one key"
        | "a list of two ends"
        | "one value" => "",
        "a whole number" => "whole number",
        "a list in brackets" => "list",
        "a list of tables in brackets" => "list of tables",
        "a list of quantities in brackets" => "list of quantities",
        "a list of texts in brackets" => "list of texts",
        "a list of pairs in brackets" => "list of pairs",
        "a percentage in quotes" => "percentage",
        other => other,
    }
}
