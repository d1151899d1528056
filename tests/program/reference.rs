//! The generated parts of the reference: commands with their options, columns of tables, and the form of JSON documents.

use std::collections::BTreeMap;
use std::process::Command;

use crate::desk::{Desk, PROGRAM};
use crate::generated::{check, filled};
use sagnac::described::{By, files};
use sagnac::table::{About, Role};
use serde_json::Value;

/// The commands in the order of the help.
const COMMANDS: [&str; 19] = [
    "run",
    "design",
    "sensitivity",
    "filler",
    "allan",
    "compare",
    "model",
    "simulate",
    "convert",
    "report",
    "merge",
    "check",
    "new",
    "explain",
    "schema",
    "device list",
    "device verify",
    "device bench",
    "completions",
];

/// The help of a command in parts.
struct Help {
    about: String,
    /// Arguments and options with their texts.
    entries: Vec<(String, String)>,
}

fn help(command: &str) -> Help {
    let output = Command::new(PROGRAM).args(command.split(' ')).arg("--help").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let (about, rest) = text.split_once("Usage: ").unwrap();
    let (_, rest) = rest.split_once('\n').unwrap();
    let mut entries: Vec<(String, String)> = vec![];
    // Of values with texts of their own, the names.
    let mut values: Option<Vec<&str>> = None;
    let close = |entries: &mut Vec<(String, String)>, values: &mut Option<Vec<&str>>| {
        if let Some(names) = values.take() {
            entries.last_mut().unwrap().1 += &format!(" [possible values: {}]", names.join(", "));
        }
    };
    for line in rest.split("\nExamples:\n").next().unwrap().lines() {
        let indent = line.len() - line.trim_start().len();
        let text = line.trim();
        match indent {
            _ if text.is_empty() => {}
            0..10 => {
                close(&mut entries, &mut values);
                if indent > 0 {
                    entries.push((text.to_owned(), String::new()));
                }
            }
            _ if text == "Possible values:" => values = Some(vec![]),
            _ if values.is_some() && !text.starts_with('[') => {
                let name = text.strip_prefix("- ").and_then(|value| value.split(':').next());
                values.as_mut().unwrap().extend(name);
            }
            _ => {
                close(&mut entries, &mut values);
                let own = &mut entries.last_mut().unwrap().1;
                *own += if own.is_empty() { "" } else { " " };
                *own += text;
            }
        }
    }
    close(&mut entries, &mut values);
    entries.retain(|(name, _)| !name.contains("--help"));
    let about = about.trim().split("\n\n").map(|part| part.split_whitespace().collect::<Vec<_>>().join(" "));
    let about = about.map(|part| format!("{}.", part.trim_end_matches('.'))).collect::<Vec<_>>().join(" ");
    Help { about, entries }
}

/// An item with an argument or option: marks around values are those of code, not of links.
fn entry((name, text): &(String, String)) -> String {
    filled("- ", &format!("`{name}`: {}", escaped(text)))
}

/// Text whose signs mean nothing in Markdown.
fn escaped(text: &str) -> String {
    text.replace('<', "\\<").replace('*', "\\*").replace('|', "\\|")
}

#[test]
fn the_reference_lists_all_commands_and_options() {
    let listed_by_help = Desk::with("").done("--help").stdout;
    let lines = listed_by_help.lines().filter_map(|line| line.strip_prefix("  "));
    let in_help = |name: &&str| COMMANDS.iter().any(|own| own.split(' ').next() == Some(name));
    let commands =
        lines.filter(|line| !line.starts_with([' ', '-'])).filter_map(|line| line.split(' ').next());
    let commands: Vec<&str> =
        commands.filter(|name| name.chars().all(|letter| letter.is_ascii_lowercase())).collect();
    assert!(
        commands.len() > 12 && commands.iter().all(|name| *name == "sagnac" || in_help(name)),
        "{commands:?}"
    );
    let helps: Vec<(&str, Help)> = COMMANDS.iter().map(|name| (*name, help(name))).collect();
    // An option with one text in several commands is listed once, under these commands.
    let mut commands: BTreeMap<&(String, String), Vec<&str>> = BTreeMap::new();
    let mut order: Vec<&(String, String)> = vec![];
    for (name, help) in &helps {
        for entry in &help.entries {
            let of = commands.entry(entry).or_default();
            if of.is_empty() {
                order.push(entry);
            }
            of.push(name);
        }
    }
    let own = |name: &str, help: &Help| {
        let entries = help.entries.iter().filter(|entry| commands[*entry].len() == 1);
        let about = filled("", &escaped(&help.about));
        format!("\n## `sagnac {name}`\n\n{about}\n{}", entries.map(entry).collect::<String>())
    };
    let mut groups: Vec<(&Vec<&str>, Vec<String>)> = vec![];
    for shared in order.into_iter().filter(|entry| commands[entry].len() > 1) {
        match groups.iter_mut().find(|(names, _)| **names == commands[shared]) {
            Some((_, entries)) => entries.push(entry(shared)),
            None => groups.push((&commands[shared], vec![entry(shared)])),
        }
    }
    let groups = groups.iter().map(|(names, entries)| {
        let names = if names.len() == COMMANDS.len() { "all commands".to_owned() } else { listed(names) };
        format!("\n### Of {names}\n\n{}", entries.concat())
    });
    let text = helps.iter().map(|(name, help)| own(name, help)).collect::<String>()
        + "\n## Options of several commands\n"
        + &groups.collect::<String>();
    check(crate::ROOT, "docs/reference/commands.md", &text);
}

/// Names in a sentence.
fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => quoted.concat(),
    }
}

/// Whether a column only accompanies another one, as the head of the document explains for all.
fn is_companion(column: &About) -> bool {
    use Role::{Law, Lower, Representation, StandardError, Theory, Trials, Upper, Z};
    matches!(column.role, Law | Lower | Representation | StandardError | Theory | Trials | Upper | Z)
}

#[test]
fn the_reference_lists_all_columns() {
    let mut text = String::new();
    let mut listed: Vec<(&str, String)> = vec![];
    for file in files() {
        let by = match file.by {
            By::Study(kind, _) => kind.name,
            By::Command(command) => command,
        };
        text += &format!("\n## `{by}`: `{}`\n\n", file.name);
        let mut again: Vec<String> = vec![];
        let is_listed = |column: &&About| !is_companion(column) && !["unit", "column"].contains(&column.name);
        for column in file.columns.iter().filter(is_listed) {
            let label = labelled(column);
            let found = (column.name, label.clone());
            if listed.contains(&found) {
                again.push(format!("`{}`", header(column)));
            } else {
                listed.push(found);
                text += &filled("- ", &format!("`{}`: {}", header(column), escaped(&label)));
            }
        }
        if !again.is_empty() {
            text += &filled("- ", &format!("as above: {}", again.join(", ")));
        }
    }
    check(crate::ROOT, "docs/reference/columns.md", &text);
}

/// The header of a column in its file.
fn header(column: &About) -> String {
    match column.unit.suffix {
        "" => column.name.to_owned(),
        _ if column.name.ends_with(']') => column.name.to_owned(),
        suffix => format!("{}_{suffix}", column.name),
    }
}

/// The label of a column; where that only repeats the name, the first sentence of the meaning.
fn labelled(column: &About) -> String {
    let is_name = column.label.is_empty() || column.label.replace(' ', "_") == column.name;
    let first =
        column.meaning.split(". ").next().and_then(|first| first.split("; ").next()).unwrap_or_default();
    if is_name { first.trim_end_matches('.').to_owned() } else { column.label.to_owned() }
}

/// The types that the reference shows; the schema has all of them.
const SHOWN: [&str; 7] = ["Document", "Answer", "Reading", "AnswerTable", "Status", "Fact", "Provenance"];

#[test]
fn the_reference_lists_the_form_of_documents() {
    let schema = std::fs::read_to_string(format!("{}/schema/document.schema.json", crate::ROOT)).unwrap();
    let schema: Value = serde_json::from_str(&schema).unwrap();
    let types = schema["$defs"].as_object().unwrap();
    let text: String = SHOWN.into_iter().map(|name| of_type(name, &types[name])).collect();
    check(crate::ROOT, "docs/reference/json.md", &text);
}

/// A type of documents with its keys.
fn of_type(name: &str, schema: &Value) -> String {
    let meaning = |value: &Value| value["description"].as_str().unwrap_or_default().to_owned();
    let mut text = format!("\n### {name}\n\n{}\n", filled("", &meaning(schema)));
    for (key, value) in schema["properties"].as_object().into_iter().flatten() {
        text += &filled("- ", &format!("`{key}`{}: {}", type_of(value), escaped(&meaning(value))));
    }
    for variant in schema["oneOf"].as_array().into_iter().flatten() {
        let word = variant["const"].as_str().map(str::to_owned);
        let mut consts = variant["properties"].as_object().into_iter().flatten();
        let tag = consts.find_map(|(_, value)| value["const"].as_str().map(str::to_owned));
        let keys = variant["properties"].as_object().into_iter().flatten();
        let keys = keys.filter(|(_, value)| value["const"].is_null());
        let keys: Vec<String> = keys.map(|(key, value)| format!("`{key}`{}", type_of(value))).collect();
        let keys = if keys.is_empty() { String::new() } else { format!(" Keys: {}.", keys.join(", ")) };
        let name = word.or(tag).unwrap_or_default();
        text += &filled("- ", &format!("`\"{name}\"`: {}{keys}", escaped(&meaning(variant))));
    }
    text
}

/// The type that a value refers to, as a link.
fn type_of(value: &Value) -> String {
    let inner = [&value["$ref"], &value["items"]["$ref"], &value["anyOf"][0]["$ref"]];
    let found = inner.into_iter().find_map(|link| link.as_str()?.rsplit('/').next());
    found.map_or(String::new(), |name| match name {
        name if !SHOWN.contains(&name) => String::new(),
        name => format!(" ([{name}](#{}))", name.to_lowercase()),
    })
}
