//! The tables of all shipped studies, with few trials: the same bytes on every machine and in every version.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::desk::Desk;

/// Trials of each point. Any change of a kernel, a lowering or a statistic shows in the first few.
const TRIALS: u32 = 512;

/// File names below the root, for messages.
const GOLDEN: &str = "tests/data/tables.sha256";
const NEW: &str = "tests/data/tables.new.sha256";

/// SHA-256 of each table of a study by its name, as in `error_vs_dtnu/points.csv`.
fn digests(study: &Path) -> BTreeMap<String, String> {
    let name = study.file_stem().unwrap().to_str().unwrap();
    let desk = Desk::with("");
    desk.done(&format!("run {} --device cpu --trials {TRIALS} --out {name}", study.display()));
    let tables = desk.names(name).into_iter().filter(|file| file.ends_with(".csv"));
    tables
        .map(|file| {
            let digest = Sha256::digest(desk.read(&format!("{name}/{file}")));
            let hex = digest.iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
            (format!("{name}/{file}"), hex)
        })
        .collect()
}

/// After an intended change of results: CONTRIBUTING.md says what else it takes, then rename the new file.
#[test]
fn the_tables_of_shipped_studies_are_the_golden_ones_byte_for_byte() {
    let root = Path::new(crate::ROOT);
    let files = std::fs::read_dir(root.join("studies")).unwrap().map(|entry| entry.unwrap().path());
    let studies: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    let found: BTreeMap<String, String> = studies.iter().flat_map(|study| digests(study)).collect();
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
    let expected = "bd2adc68d93200624f80a84374dbe7bd6ba13fc9f4f26a47f235aaab228b06aa";
    assert_eq!(digests(&study)["recorded_profile/points.csv"], expected);
}
