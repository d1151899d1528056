//! The tables of all shipped studies, with few trials: the same bytes on every machine and in every version.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::browser::Browser;
use crate::desk::Desk;
use crate::gallery::{Asked, pages};
use crate::generated::is_stale;
use crate::noise::units;
use crate::report::words::only_on_page;

/// Trials of each point. Any change of a kernel, a lowering or a statistic shows in the first few.
const TRIALS: u32 = 512;
/// A study of fewer trials keeps them, because each of them takes long.
const FEW: u32 = 256;

/// File names below the root, for messages.
const GOLDEN: &str = "tests/data/tables.sha256";
const NEW: &str = "tests/data/tables.new.sha256";

/// The questions and answers, of which the gallery shows parts.
const ANSWERS: &str = "tests/data/answers.md";

const ABOUT_ANSWERS: &str = "# Questions and answers

The question of every shipped study and of each other command, and its answer as a terminal of 80 columns shows it. A test writes this page
from runs with few trials, so the figures of a full run differ a little.
";

/// Commands besides `run`, with the question that each answers, in the folder of the studies.
const COMMANDS: [(&str, &str); 12] = [
    ("allan data/gyro_at_rest.csv --rate 1Hz", "Which noise does this log show?"),
    (
        "allan data/gyro_at_rest.csv --rate 1Hz --limit N=0.0006deg/sqrt(h) --limit B=0.0018deg/h",
        "Does this log meet the limits?",
    ),
    (
        "allan data/gyro_at_rest.csv --rate 1Hz --navigate 1h --position-limit 0.3nmi",
        "Where is a navigator with this gyro after an hour?",
    ),
    ("compare data/gyro_at_rest.csv half.csv --rate 1Hz", "Is this gyro noisier than that one?"),
    ("compare units.csv --rate 1Hz --column g1,g2,g3,g4,g5", "How even is this batch of gyros?"),
    (
        "compare units.csv --rate 1Hz --column g1,g2,g3,g4,g5 --limit N=0.1deg/sqrt(h)",
        "Which units of this batch meet the limit?",
    ),
    ("model data/gyro_at_rest.csv --rate 1Hz --overbound", "What do I write into my filter?"),
    ("design design_point.toml --trials 512", "How often should the gyro switch?"),
    (
        "sensitivity what_decides.toml --by theory_rms --samples 512",
        "Which uncertain input drives the error?",
    ),
    ("filler which_filler.toml", "Which filler belongs in the firmware?"),
    (
        "filler minimum-variance --gap-ticks 3 --tick 5ms --band 18Hz,22Hz --amplitude 12000arcsec/s --noise 0.5arcsec \
         --limit residual=8arcsec --latency 20ms",
        "How many ticks must a filler read?",
    ),
    ("filler quadratic --gap-ticks 3", "What does a quadratic filler do to the noise?"),
];

/// The studies, and logs besides: the first half of the gyro's, and units of which the fourth has twice the noise.
fn desk_of_commands(root: &Path) -> Desk {
    let desk = Desk::with("");
    let studies = root.join("studies");
    for name in ["design_point.toml", "what_decides.toml", "which_filler.toml"] {
        std::fs::copy(studies.join(name), desk.path(name)).unwrap();
    }
    std::fs::create_dir(desk.path("data")).unwrap();
    let log = std::fs::read_to_string(studies.join("data/gyro_at_rest.csv")).unwrap();
    desk.write("data/gyro_at_rest.csv", &log);
    let half: Vec<&str> = log.lines().take(log.lines().count() / 2).collect();
    desk.write("half.csv", &half.join("\n"));
    desk.write("units.csv", &units());
    desk
}

/// The row and the section of a command on the page of answers.
fn answered(desk: &Desk, (words, question): (&str, &str)) -> [String; 2] {
    let ended = desk.sagnac_with(&format!("{words} --out out"), &[("COLUMNS", "80")]);
    assert_eq!(ended.code, 0, "{words}: {}", ended.stderr);
    std::fs::remove_dir_all(desk.path("out")).unwrap();
    let shown = ended.stdout.trim_end();
    let (headline, counts) = measured(words, shown);
    let anchor = question.trim_end_matches('?').to_lowercase().replace(' ', "-");
    let row = format!("| [{question}](#{anchor}) | {headline} | {} | {} |\n", counts[0], counts[1]);
    [row, format!("\n## {question}\n\n```text\n$ sagnac {words}\n{shown}\n```\n")]
}

/// The headline of an answer, and its number of words and lines.
fn measured(name: &str, shown: &str) -> (String, [usize; 2]) {
    let parts: Vec<&str> = shown.splitn(3, "\n\n").collect();
    let headline =
        parts.get(1).unwrap_or_else(|| panic!("{name} has no headline:\n{shown}")).replace('\n', " ");
    let counts = [headline.split_whitespace().count(), shown.lines().count()];
    assert!(
        counts.iter().zip(MAX_WORDS_AND_LINES).all(|(count, most)| *count <= most),
        "{name}: {counts:?}\n{shown}"
    );
    assert!(shown.lines().all(|line| line.chars().count() <= 80), "{name}: a line is too long\n{shown}");
    (headline, counts)
}

/// Most words of a headline, and most lines of an answer with its heading.
const MAX_WORDS_AND_LINES: [usize; 2] = [12, 20];

/// The row of a study on the page of answers.
fn row(Asked { name, headline, counts, .. }: &Asked) -> String {
    format!("| [{name}](#{name}) | {headline} | {} | {} |\n", counts[0], counts[1])
}

/// The section of a study on the page of answers.
fn section(Asked { name, question, shown, .. }: &Asked) -> String {
    format!("\n## {name}\n\n{question}\n\n```text\n{shown}\n```\n")
}

/// The question of a study with its answer, and the SHA-256 of each table by its name, as in `error_vs_dtnu/points.csv`. Its page and
/// its pictures say the same words, where there is a browser.
fn digests(study: &Path, browser: Option<&Browser>) -> (Asked, BTreeMap<String, String>) {
    let name = study.file_stem().unwrap().to_str().unwrap();
    let desk = Desk::with("");
    let trials = own_trials(study).filter(|own| *own < FEW).unwrap_or(TRIALS);
    let words = format!("run {} --device cpu --trials {trials} --out {name}", study.display());
    let ended = desk.sagnac_with(&words, &[("COLUMNS", "80")]);
    assert_eq!(ended.code, 0, "{name}: {}", ended.stderr);
    let shown = ended.stdout.trim_end();
    let (headline, counts) = measured(name, shown);
    agree(&desk, &words, name, shown);
    let missing = browser.map(|browser| only_on_page(browser, &desk.path(name))).unwrap_or_default();
    assert!(missing.is_empty(), "{name}: only the page says\n{}", missing.join("\n"));
    let text = std::fs::read_to_string(study).unwrap();
    let question = text.parse::<toml::Table>().unwrap()["question"].as_str().unwrap().to_owned();
    let asked = Asked { name: name.to_owned(), question, headline, shown: shown.to_owned(), counts };
    let tables = desk.names(name).into_iter().filter(|file| file.ends_with(".csv"));
    let tables = tables.map(|file| {
        let digest = Sha256::digest(desk.read(&format!("{name}/{file}")));
        let hex = digest.iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
        (format!("{name}/{file}"), hex)
    });
    (asked, tables.collect())
}

/// Checks that document, page and terminal have the same answer, and document and file the same points.
fn agree(desk: &Desk, words: &str, name: &str, shown: &str) {
    let document: Value = serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap();
    let page = desk.read(&format!("{name}/report.html"));
    let answer = &document["answer"];
    let headline = answer["headline"].as_str().unwrap();
    let is_on_page =
        |text: &str| page.contains(&text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;"));
    let one_line = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(is_on_page(headline) && one_line.contains(headline), "{name}: {headline}");
    for row in answer["table"]["rows"].as_array().unwrap() {
        let cells: Vec<&str> =
            row.as_array().unwrap().iter().map(|cell| cell["text"].as_str().unwrap()).collect();
        assert!(cells.iter().all(|cell| is_on_page(cell)), "{name}: {cells:?}");
        // Further columns may not fit.
        let ends = [cells[0], cells[1]];
        let is_shown = |line: &str| ends.iter().all(|cell| line.contains(cell));
        assert!(shown.lines().any(is_shown), "{name}: {ends:?}");
    }
    let points = desk.points(name);
    let rows = document["tables"]["points"].as_array().unwrap();
    assert_eq!(points.len(), rows.len(), "{name}");
    for (row, cells) in rows.iter().zip(&points) {
        for (column, value) in row.as_object().unwrap() {
            // A file has nine digits.
            let is_same = match value {
                Value::Null => cells[column].is_empty(),
                Value::String(text) => *text == cells[column],
                number => {
                    let (number, written) = (number.as_f64().unwrap(), cells[column].parse::<f64>().unwrap());
                    (number - written).abs() <= 5.1e-9 * number.abs()
                }
            };
            assert!(is_same, "{name}: {column} {value} {}", cells[column]);
        }
    }
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
    let browser = Browser::start();
    let root = Path::new(crate::ROOT);
    let files = std::fs::read_dir(root.join("studies")).unwrap().map(|entry| entry.unwrap().path());
    let mut studies: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    studies.sort();
    let (asked, found): (Vec<Asked>, Vec<BTreeMap<String, String>>) =
        studies.iter().map(|study| digests(study, browser.as_ref())).unzip();
    let answers: Vec<[String; 2]> = asked.iter().map(|asked| [row(asked), section(asked)]).collect();
    let found: BTreeMap<String, String> = found.into_iter().flatten().collect();
    let all = |part: usize| answers.iter().map(|parts| parts[part].as_str()).collect::<String>();
    let heading = "\n| study or question | headline | words | lines |\n|---|---|---|---|\n";
    let desk = desk_of_commands(root);
    let commands: Vec<[String; 2]> = COMMANDS.into_iter().map(|command| answered(&desk, command)).collect();
    let of_commands = |part: usize| commands.iter().map(|parts| parts[part].as_str()).collect::<String>();
    let answers = format!("{ABOUT_ANSWERS}{heading}{}{}{}{}", all(0), of_commands(0), all(1), of_commands(1));
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
    let documents = std::iter::once((ANSWERS.to_owned(), answers)).chain(pages(&asked));
    let stale: Vec<String> =
        documents.filter(|(name, text)| is_stale(crate::ROOT, name, text)).map(|(name, _)| name).collect();
    assert!(
        stale.is_empty(),
        "out of date: {stale:?}; review each NAME.new, then accept it with `mv NAME.new NAME`"
    );
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
    let expected = "acb68a7518d8f9533962f4ad0e2ade155a892833466530c56450cfdfe36ecfe2";
    assert_eq!(digests(&study, None).1["recorded_profile/points.csv"], expected);
}
