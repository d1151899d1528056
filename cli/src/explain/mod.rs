//! `sagnac explain`: what a word, a key, a column or an exit code means.

use std::collections::BTreeMap;

use clap::Args;
use sagnac::described::{files, meanings};
use sagnac::study::Kind;
use sagnac_engine::key::docs::Explained;
use sagnac_engine::kinds::{KINDS, explain_key, explained_keys};

use crate::failure::{EXIT_CODES, Failure};
use crate::look;
use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  sagnac explain motion.amplitude
  sagnac explain p99_73_arcsec
  sagnac explain gap-fill
  sagnac explain minimum-variance
  sagnac explain N
  sagnac explain 4";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Key or word of a study file, kind of study, term, column of a results file, or exit code [default: a list of all
    /// of these]
    #[arg(value_name = "WHAT")]
    what: Vec<String>,
}

/// Most names that are suggested for an unknown one.
const OFFERED: usize = 3;

/// Prints all explanations of the word.
pub fn explain(options: &Options) -> Result<(), Failure> {
    // Terms of several words need no quotes.
    match &options.what[..] {
        [] => print(&subjects()),
        words => print(&of(&words.join(" "))?),
    }
}

fn of(what: &str) -> Result<String, Failure> {
    let what = what.strip_prefix("exit code ").unwrap_or(what);
    if what.parse::<u8>().is_ok() {
        let found = EXIT_CODES.iter().find(|(codes, _)| codes.split(", ").any(|code| code == what));
        return found.map(|(_, meaning)| format!("exit code {what}: {meaning}")).ok_or_else(|| {
            let codes: Vec<&str> = EXIT_CODES.iter().map(|(codes, _)| *codes).collect();
            Failure::Usage(format!("there is no exit code {what}\nthe exit codes are {}", codes.join(", ")))
        });
    }
    let exact = all_of(what, |name| name == what);
    let found = match exact.is_empty() {
        true => all_of(&folded(what), |name| folded(name) == folded(what)),
        false => exact,
    };
    if found.is_empty() { Err(Failure::Usage(unknown(what))) } else { Ok(found.join("\n")) }
}

/// The form in which names are compared if none matches exactly.
fn folded(name: &str) -> String {
    name.to_lowercase().replace(['-', '–', ' '], "_")
}

/// The explanations of all kinds, terms, keys, words and columns with a matching name. Keys of which only the last part
/// matches follow after words.
fn all_of(what: &str, is_called: impl Fn(&str) -> bool) -> Vec<String> {
    let kinds = KINDS.into_iter().filter(|kind| is_called(kind.name)).map(of_kind);
    let is_meant = |(names, _): &(Vec<&'static str>, &'static str)| names.iter().any(|name| is_called(name));
    let text =
        |(names, meaning): (Vec<&str>, &str)| format!("{} (term)\n{}", names.join(", "), filled(meaning));
    let terms: Vec<String> = terms().filter(is_meant).map(text).collect();
    // The glossary has a line on each; the terms above have more.
    let short: Vec<String> = match terms[..] {
        [] => glossary().filter(is_meant).map(text).collect(),
        _ => vec![],
    };
    let whole: Vec<&str> = explained_keys().filter(|key| is_called(key)).collect();
    let ends = |key: &&str| key.match_indices('.').any(|(dot, _)| is_called(&key[dot + 1..]));
    let parts = if whole.is_empty() { explained_keys().filter(ends).collect() } else { vec![] };
    let keys = |keys: Vec<&'static str>| keys.into_iter().filter_map(explain_key).map(|key| of_key(&key));
    let words = of_words(&is_called);
    let found = kinds.chain(terms).chain(keys(whole)).chain(words).chain(keys(parts));
    found.chain(of_column(what)).chain(short).collect()
}

/// Terms of the field and of this program that are neither keys nor columns, each with its names and its meaning.
fn terms() -> impl Iterator<Item = (Vec<&'static str>, &'static str)> {
    let entries = include_str!("glossary.txt").split("\n\n").filter_map(|entry| entry.split_once('\n'));
    entries.map(|(names, meaning)| (names.split(", ").collect(), meaning))
}

/// The terms of the glossary of the documents, each with its names and its meaning in a line.
fn glossary() -> impl Iterator<Item = (Vec<&'static str>, &'static str)> {
    let lines = include_str!("../../../docs/explain/glossary.md").lines();
    let entries = lines.filter_map(|line| line.strip_prefix("- **")?.split_once("**: "));
    entries.map(|(names, meaning)| (names.split(", ").map(|name| name.trim_matches('`')).collect(), meaning))
}

/// A kind of study.
fn of_kind(kind: &Kind) -> String {
    let name = kind.name;
    let mut text = format!("{name} (kind of study)\n{}", filled(kind.about));
    text += &filled(&format!(
        "`sagnac new {name}` writes such a study with its keys explained, and `sagnac run` runs it."
    ));
    text + &format!("  Example:\n    kind = \"{name}\"\n")
}

/// The words that keys accept, except the kinds, which have their own explanation.
fn of_words(is_called: impl Fn(&str) -> bool) -> Vec<String> {
    let mut found: Vec<(&str, String, Vec<&str>)> = Vec::new();
    for key in explained_keys().filter(|key| *key != "kind").filter_map(explain_key) {
        for (word, meaning) in key.choices.into_iter().filter(|(word, _)| is_called(word)) {
            match found.iter_mut().find(|(known, said, _)| *known == word && *said == meaning) {
                Some((_, _, keys)) => keys.push(key.key),
                None => found.push((word, meaning, vec![key.key])),
            }
        }
    }
    let text = |(word, meaning, keys): (&str, String, Vec<&str>)| {
        let says = filled(&format!("{meaning} A value of {}.", keys.join(", ")));
        format!("{word} (word of a study file)\n{says}")
    };
    found.into_iter().map(text).collect()
}

/// A key of a study file.
fn of_key(key: &Explained) -> String {
    let mut text = format!("{} (key of a study file)\n", key.key);
    let mut line = |words: &str| text += &filled(words);
    line(&key.meaning);
    line(&format!("Holds {}.", key.holds));
    for (word, meaning) in &key.choices {
        line(&format!("\"{word}\": {meaning}"));
    }
    let inner: Vec<&str> =
        explained_keys().filter_map(|other| other.strip_prefix(&format!("{}.", key.key))).collect();
    if !inner.is_empty() {
        line(&format!("As a table it has the keys {}.", inner.join(", ")));
    }
    for (what, text) in [("Accepted", &key.accepted), ("Range", &key.range)] {
        if !text.is_empty() {
            line(&format!("{what}: {text}."));
        }
    }
    if let Some(label) = key.swept {
        line(&format!(
            "Can be swept with key = \"{}\"; the label in tables and charts is \"{label}\".",
            key.key
        ));
    }
    if key.required {
        line("Required.");
    }
    let kinds = &key.kinds;
    let table =
        key.key.split_once('.').map_or_else(String::new, |(table, _)| format!(" that use a table [{table}]"));
    line(&format!("Used in studies of kind {}{table}.", kinds.join(", ")));
    let example: String = key.example.lines().map(|line| format!("    {line}\n")).collect();
    text + "  Example:\n" + &example
}

/// A column, with the files that contain it; for a name that is also a swept key, only if a file has a column with
/// exactly this name.
fn of_column(name: &str) -> Option<String> {
    let found = meanings(name);
    let is_key = explain_key(name).is_some()
        && found.iter().all(|(_, files)| {
            files.iter().all(|file| !file.columns.iter().any(|column| column.name == name))
        });
    if found.is_empty() || is_key {
        return None;
    }
    let mut text = format!("{name} (column)\n");
    for (meaning, files) in found {
        let files: Vec<String> = files.iter().map(|file| file.title()).collect();
        text += &filled(&format!("{meaning} In {}.", files.join(", ")));
    }
    Some(text)
}

/// Everything that can be explained.
fn subjects() -> String {
    let mut tables: BTreeMap<usize, (&str, Vec<&str>)> = BTreeMap::new();
    for (at, key) in explained_keys().enumerate() {
        let (table, rest) = key.split_once('.').map_or(("", key), |(table, rest)| (table, rest));
        let is_table = explained_keys().any(|other| other.starts_with(&format!("{key}.")));
        let is_value_too = || explain_key(key).is_some_and(|key| key.holds.contains("or a table"));
        if is_table && table.is_empty() && !is_value_too() {
            continue;
        }
        let place = tables.iter().find(|(_, (known, _))| *known == table).map_or(at, |(place, _)| *place);
        tables.entry(place).or_insert((table, vec![])).1.push(rest);
    }
    let kinds: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    let mut text =
        format!("Kinds of studies, as in `sagnac explain gap-fill`\n{}\n", filled(&kinds.join(", ")));
    text += "Keys of study files, as in `sagnac explain motion.amplitude`\n";
    for (table, keys) in tables.values() {
        let table = if table.is_empty() { "at the top".to_owned() } else { format!("[{table}]") };
        text += &filled(&format!("{table}: {}", keys.join(", ")));
    }
    text += "\nColumns of results, as in `sagnac explain rms`\n";
    for file in files() {
        let columns: Vec<&str> = file.columns.iter().map(|column| column.name).collect();
        text += &filled(&format!("{}: {}", file.title(), columns.join(", ")));
    }
    let longer: Vec<&str> = terms().flat_map(|(names, _)| names).collect();
    let further = glossary().filter(|(names, _)| !names.iter().any(|name| longer.contains(name)));
    let terms: Vec<&str> = terms().chain(further).map(|(names, _)| names[0]).collect();
    text += &format!("\nTerms, as in `sagnac explain N`\n{}", filled(&terms.join(", ")));
    text += "\nExit codes, as in `sagnac explain 4`\n";
    for (codes, meaning) in EXIT_CODES {
        text += &filled(&format!("{codes}: {meaning}"));
    }
    text
}

/// The message for an unknown name, with the most similar known ones.
fn unknown(what: &str) -> String {
    let columns = files().into_iter().flat_map(|file| file.columns).map(|column| column.name);
    let kinds = KINDS.iter().map(|kind| kind.name);
    let terms = terms().chain(glossary()).flat_map(|(names, _)| names);
    let mut known: Vec<&str> = explained_keys().chain(columns).chain(kinds).chain(terms).collect();
    known.sort_unstable();
    known.dedup();
    let likeness = |name: &str| {
        let bare = name.rsplit('.').next().unwrap_or(name);
        let whole = strsim::normalized_damerau_levenshtein(what, name);
        whole.max(strsim::normalized_damerau_levenshtein(what, bare))
    };
    known.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
    let near: Vec<String> = known
        .iter()
        .take(OFFERED)
        .filter(|name| likeness(name) >= 0.5)
        .map(|name| format!("`{name}`"))
        .collect();
    let offer = if near.is_empty() { String::new() } else { format!("did you mean {}? ", near.join(", ")) };
    format!(
        "`{what}` is not a known kind, key, word, term, column or exit code\n{offer}`sagnac explain` lists all of them"
    )
}

/// A text in indented lines no wider than the terminal.
fn filled(words: &str) -> String {
    let words: Vec<&str> = words.split_whitespace().collect();
    look::wrapped(&format!("  {}", words.join(" ")), look::width().clamp(40, 110)) + "\n"
}
