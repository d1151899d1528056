//! The tables of all shipped studies, with few trials: the same bytes on every machine and in every version.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::desk::Desk;

/// Trials of each point. Any change of a kernel, a lowering or a statistic shows in the first few.
const TRIALS: u32 = 512;
/// A study of fewer trials keeps them, because each of them takes long.
const FEW: u32 = 256;

/// File names below the root, for messages.
const GOLDEN: &str = "tests/data/tables.sha256";
const NEW: &str = "tests/data/tables.new.sha256";

/// The page of questions and answers, and the one that the test writes.
const ANSWERS: &str = "docs/answers.md";
const NEW_ANSWERS: &str = "docs/answers.md.new";

const ABOUT_ANSWERS: &str = "# Questions and answers

The question of every shipped study, and its answer: the bold line of its page, and what its decision sheet says of the requirement and of the
next lever. A test writes this page from runs with few trials, so the figures of a full run differ a little.
";

/// A section of the page of answers, and the SHA-256 of each table by its name, as in `error_vs_dtnu/points.csv`.
fn digests(study: &Path) -> (String, BTreeMap<String, String>) {
    let name = study.file_stem().unwrap().to_str().unwrap();
    let desk = Desk::with("");
    let trials = own_trials(study).filter(|own| *own < FEW).unwrap_or(TRIALS);
    let ended =
        desk.done(&format!("run {} --device cpu --trials {trials} --json --out {name}", study.display()));
    let document: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let of = |key: &str| document[key].as_str().unwrap().to_owned();
    let (question, answer) = (of("question"), of("answer"));
    assert!(question.ends_with('?') && !answer.is_empty(), "{name}: {question} {answer}");
    let mut section = format!("\n## {name}\n\n{question}\n\n**{answer}**\n");
    let sentences = document["decision"]["sentences"].as_array().cloned().unwrap_or_default();
    for line in [0, 4].into_iter().filter_map(|line| sentences.get(line)) {
        let [heading, sentence] = [&line[0], &line[1]].map(|text| text.as_str().unwrap());
        write!(section, "\n- {heading}: {sentence}").unwrap();
    }
    let section = section.trim_end().to_owned() + "\n";
    let tables = desk.names(name).into_iter().filter(|file| file.ends_with(".csv"));
    let tables = tables.map(|file| {
        let digest = Sha256::digest(desk.read(&format!("{name}/{file}")));
        let hex = digest.iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
        (format!("{name}/{file}"), hex)
    });
    (section, tables.collect())
}

/// The trials that a study asks for.
fn own_trials(study: &Path) -> Option<u32> {
    let text = std::fs::read_to_string(study).unwrap();
    let table: toml::Table = text.parse().unwrap();
    table.get("trials")?.as_integer()?.try_into().ok()
}

/// After an intended change of results: CONTRIBUTING.md says what else it takes, then rename the new file.
#[test]
fn the_tables_of_shipped_studies_are_the_golden_ones_byte_for_byte() {
    let root = Path::new(crate::ROOT);
    let files = std::fs::read_dir(root.join("studies")).unwrap().map(|entry| entry.unwrap().path());
    let mut studies: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    studies.sort();
    let (answers, found): (Vec<String>, Vec<BTreeMap<String, String>>) =
        studies.iter().map(|study| digests(study)).unzip();
    let found: BTreeMap<String, String> = found.into_iter().flatten().collect();
    let answers = format!("{ABOUT_ANSWERS}{}", answers.concat());
    let is_current = std::fs::read_to_string(root.join(ANSWERS)).unwrap_or_default() == answers;
    if !is_current {
        std::fs::write(root.join(NEW_ANSWERS), answers).unwrap();
    }
    let golden = std::fs::read_to_string(root.join(GOLDEN)).unwrap_or_default();
    let golden: BTreeMap<String, String> = golden
        .lines()
        .filter_map(|line| line.split_once("  "))
        .map(|(digest, table)| (table.to_owned(), digest.to_owned()))
        .collect();
    let mut other: Vec<&str> = found.keys().chain(golden.keys()).map(String::as_str).collect();
    other.sort_unstable();
    other.dedup();
    other.retain(|table| found.get(*table) != golden.get(*table));
    if !other.is_empty() {
        let text = found.iter().fold(String::new(), |mut text, (table, digest)| {
            writeln!(text, "{digest}  {table}").unwrap();
            text
        });
        std::fs::write(root.join(NEW), text).unwrap();
        panic!(
            "{} of {} tables differ from {GOLDEN}: {other:?}; the present ones are in {NEW}",
            other.len(),
            found.len()
        );
    }
    assert!(is_current, "{ANSWERS} is out of date; the present answers are in {NEW_ANSWERS}");
}

/// Straight lines between the samples of a record, all of which designs fillers and judges them.
#[test]
fn a_record_in_straight_lines_has_a_golden_table_of_its_own() {
    let studies = Path::new(crate::ROOT).join("studies");
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(studies.join("recorded_profile.toml")).unwrap();
    let lines = text.replace(
        "position = \"every\"",
        "position = \"every\", interpolation = \"linear\", design = \"whole\"",
    );
    assert_ne!(text, lines);
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let record = "data/base_vibration.csv";
    std::fs::copy(studies.join(record), folder.path().join(record)).unwrap();
    let study = folder.path().join("recorded_profile.toml");
    std::fs::write(&study, lines).unwrap();
    let expected = "fc2e9637e7e64891a57d6277973c510edca102b225ce8f335d1d47c17e76b8eb";
    assert_eq!(digests(&study).1["recorded_profile/points.csv"], expected);
}
