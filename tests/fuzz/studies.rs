//! Study files: whatever they hold, they are refused in words, or every point of them is lowered.

mod tree;
mod words;

use proptest::prelude::*;
use proptest::sample::Index;
use sagnac::study::Study;
use toml::{Table, Value};

use crate::campaign::{Target, fuzz};
use crate::cases::studies::{name, run};
use crate::edits;

const TARGET: Target = Target { name: "studies", ending: "toml", run };

/// What has a meaning in TOML.
const TOKENS: &[&str] = &[
    "\n",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ",",
    "\"",
    "'",
    "\"\"\"",
    "\\",
    "#",
    ".",
    "\r",
    "\0",
    "\u{feff}",
    "\u{85}",
    "é",
    "𝄞",
    "[[sweep]]\n",
    "[chart]\n",
    "a.b.c = 1\n",
    "a.",
    "[a.",
    "{ a = ",
    "\"\\u0000\"",
    "1e999",
    "nan",
    "0x",
    "true",
    "1979-05-27",
];

#[test]
fn studies() {
    let seeds = seeds();
    let study = (any::<Index>(), tree::edits()).prop_map({
        let seeds = seeds.clone();
        move |(seed, edits)| {
            let mut study = seed.get(&seeds).clone();
            tree::apply(&mut study, &edits, &seeds);
            let mut text = toml::to_string(&study).unwrap_or_default().into_bytes();
            text.truncate(edits::MAX_INPUT);
            text
        }
    });
    // Most with their tree edited, some with their text too.
    let of_text = prop_oneof![4 => Just(vec![]).boxed(), 1 => edits::edits(3, TOKENS).boxed()];
    fuzz(
        &TARGET,
        (study, of_text).prop_map(|(mut text, edits)| {
            edits::apply(&mut text, &edits);
            text
        }),
    );
}

/// All studies that are shipped, with fewer points, and those of the corpus that are TOML.
fn seeds() -> Vec<Table> {
    let shipped = std::fs::read_dir(name().parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let mut shipped: Vec<_> =
        shipped.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    shipped.sort();
    let texts = shipped.into_iter().map(|path| std::fs::read_to_string(path).unwrap());
    let corpus = TARGET.corpus().into_iter().filter_map(|(_, bytes)| String::from_utf8(bytes).ok());
    texts.chain(corpus).filter_map(|text| text.parse().ok()).map(shortened).collect()
}

/// The study with two values of each sweep, where none of its charts needs another.
fn shortened(study: Table) -> Table {
    let mut short = study.clone();
    for sweep in short.get_mut("sweep").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(list) = sweep.get_mut("list").and_then(Value::as_array_mut) {
            list.truncate(2);
        }
        for form in ["linear", "log"] {
            if let Some(points) = sweep.get_mut(form).and_then(|spacing| spacing.get_mut("points")) {
                *points = Value::Integer(2);
            }
        }
    }
    let is_study =
        Study::parse(&name().to_string_lossy(), &toml::to_string(&short).unwrap_or_default()).is_ok();
    if is_study { short } else { study }
}
