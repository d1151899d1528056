//! The reference lists every key of study files, from the rows that declare them.

use sagnac::key::explained::Explained;
use sagnac::kinds::keys::{explain_key, explained_keys};

/// What stands around the list in the reference.
const MARKS: [&str; 2] =
    ["<!-- keys: written by a test, see CONTRIBUTING.md -->\n", "<!-- end of keys -->\n"];

/// Longest line of the list.
const WIDTH: usize = 140;

#[test]
fn the_reference_lists_all_keys() {
    let path = format!("{}/docs/reference.md", crate::ROOT);
    let committed = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = committed.split_once(MARKS[0]).expect("the start of the list of keys");
    let (_, after) = rest.split_once(MARKS[1]).expect("the end of the list of keys");
    let current = format!("{before}{}{}{}{after}", MARKS[0], list(), MARKS[1]);
    if current != committed {
        std::fs::write(format!("{path}.new"), current).unwrap();
        panic!("the keys in {path} are out of date; review {path}.new and rename it");
    }
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
        let kinds = &own[0].kinds;
        let items: String = own.iter().map(|key| item(key, kinds)).collect();
        format!("\n### {heading}\n\nIn studies of kind {}.\n\n{items}", kinds.join(", "))
    });
    sections.collect::<String>() + "\n"
}

/// The table that a key is in; a table at the top stands under its own heading.
fn table_of(key: &Explained) -> &'static str {
    let is_table = explained_keys().any(|other| other.starts_with(&format!("{}.", key.key)));
    key.key.split_once('.').map_or(if is_table { key.key } else { "" }, |(table, _)| table)
}

/// A key, with its kinds of studies where they are not those of its table.
fn item(key: &Explained, kinds: &[&str]) -> String {
    let limits = Some(&key.range).filter(|range| !range.is_empty() && key.choices.is_empty());
    let facts = std::iter::once(&key.holds).chain(limits).cloned();
    let facts = facts.chain(key.required.then(|| "required".to_owned()));
    let facts = facts.chain(key.swept.map(|_| "can be swept".to_owned()));
    let facts = facts.chain((key.kinds != kinds).then(|| format!("in {}", key.kinds.join(", "))));
    let facts = facts.collect::<Vec<_>>().join("; ");
    let choice = |(word, meaning): &(&str, String)| filled("  - ", &format!("`\"{word}\"`: {meaning}"));
    filled("- ", &format!("`{}`: {} ({facts})", key.key, key.meaning))
        + &key.choices.iter().map(choice).collect::<String>()
}

/// An item of a list, in lines.
fn filled(bullet: &str, text: &str) -> String {
    let mut lines = vec![bullet.to_owned()];
    for word in text.split(' ') {
        let last = lines.last_mut().unwrap();
        if last.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(format!("{:1$}{word}", "", bullet.len()));
        } else if last.ends_with(' ') {
            *last += word;
        } else {
            *last += &format!(" {word}");
        }
    }
    lines.join("\n") + "\n"
}
