//! The reference lists every key of study files, from the rows that declare them.

use sagnac::key::explained::Explained;
use sagnac::kinds::KINDS;
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
        let heading = if table.is_empty() { "### At the top".to_owned() } else { format!("### `[{table}]`") };
        let items: String = keys.iter().filter(|key| table_of(key) == table).map(item).collect();
        format!("\n{heading}\n\n{items}")
    });
    sections.collect::<String>() + "\n"
}

/// The table that a key is in; a table at the top stands under its own heading.
fn table_of(key: &Explained) -> &'static str {
    let is_table = explained_keys().any(|other| other.starts_with(&format!("{}.", key.key)));
    key.key.split_once('.').map_or(if is_table { key.key } else { "" }, |(table, _)| table)
}

fn item(key: &Explained) -> String {
    let limits = [&key.accepted, &key.range].into_iter().filter(|text| !text.is_empty());
    let facts = std::iter::once(&key.holds).chain(limits).cloned();
    let facts = facts.chain(key.required.then(|| "required".to_owned()));
    let facts = facts.chain(key.swept.map(|_| "can be swept".to_owned())).collect::<Vec<_>>().join("; ");
    let kinds = match key.kinds.len() {
        all if all == KINDS.len() => String::new(),
        _ => format!(" In {}.", key.kinds.join(", ")),
    };
    let choices =
        key.choices.iter().map(|(word, meaning)| filled("  - ", &format!("`\"{word}\"`: {meaning}")));
    filled("- ", &format!("`{}`: {facts}. {}{kinds}", key.key, key.meaning)) + &choices.collect::<String>()
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
