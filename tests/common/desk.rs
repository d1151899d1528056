//! A folder of its own, and the program run in it as a user would.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_sagnac");
pub const SHIPPED: &str = include_str!("../../studies/error_vs_dtnu.toml");

/// One point, two fillers, four rows; every line has the number that the tests below expect.
pub const STUDY: &str = r#"title = "A study"
kind = "gap-fill"
[gyro]
tick = "5 ms"
tick_noise = { std = "1 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = ["const", "quadratic"]
"#;

pub const HEADER: &str = "dt_nu,amplitude_noise,filler,error,trials,mean_arcsec,rms_arcsec,rms_se_arcsec,max_arcsec,p99_73_arcsec,\
                      p99_73_lo_arcsec,p99_73_hi_arcsec,theory_rms_arcsec,theory_max_arcsec,z,representation";

/// STUDY with `old` replaced.
pub fn replaced(old: &str, new: &str) -> String {
    assert!(STUDY.contains(old), "{old} is not in the study");
    STUDY.replace(old, new)
}

pub fn with(end: &str) -> String {
    format!("{STUDY}{end}\n")
}

/// A folder of its own, and what the program does there.
pub struct Desk(pub TempDir);

/// How a command ended.
pub struct Ended {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Desk {
    /// With a file `study.toml`.
    pub fn with(text: &str) -> Desk {
        let desk = Desk(TempDir::new().unwrap());
        desk.write("study.toml", text);
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program with `words` as its arguments.
    pub fn sagnac(&self, words: &str) -> Ended {
        self.sagnac_with(words, &[])
    }

    pub fn sagnac_with(&self, words: &str, variables: &[(&str, &str)]) -> Ended {
        let mut command = Command::new(PROGRAM);
        command.current_dir(self.0.path()).args(words.split_whitespace()).envs(variables.iter().copied());
        let output = command.timeout(Duration::from_secs(600)).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        assert!(!stderr.contains("panicked"), "`sagnac {words}` panicked:\n{stderr}");
        let code =
            output.status.code().unwrap_or_else(|| panic!("`sagnac {words}` ended by a signal:\n{stderr}"));
        Ended { code, stdout, stderr }
    }

    /// Runs the program and expects it to succeed.
    pub fn done(&self, words: &str) -> Ended {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, 0, "sagnac {words}\n{}", ended.stderr);
        ended
    }

    /// Runs the program with all tables and notes and expects exit code 0.
    pub fn full(&self, words: &str) -> Ended {
        self.done(&format!("{words} --table --verbose"))
    }

    /// Runs the program and expects an exit code and every piece in what it says on stderr.
    pub fn fails(&self, words: &str, code: i32, pieces: &[&str]) {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, code, "sagnac {words}\n{}", ended.stderr);
        assert_eq!(ended.stdout, "", "sagnac {words}");
        let said = unwrapped(&ended.stderr);
        for piece in pieces {
            assert!(said.contains(piece), "`{piece}` is missing after `sagnac {words}`:\n{}", ended.stderr);
        }
    }

    /// The table of a results folder.
    pub fn points(&self, folder: &str) -> Vec<Row> {
        self.table(&format!("{folder}/points.csv"))
    }

    pub fn table(&self, name: &str) -> Vec<Row> {
        table(&self.read(name))
    }
}

/// The cells of a row by the names of their columns.
pub type Row = BTreeMap<String, String>;

/// The rows of a table as text.
pub fn table(text: &str) -> Vec<Row> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
}

/// The rows of a table of a document.
#[track_caller]
pub fn rows_of<'d>(document: &'d Value, table: &str) -> &'d [Value] {
    let rows = document["tables"][table].as_array();
    rows.unwrap_or_else(|| panic!("no table {table} in {document:#}"))
}

/// The fact of this name in the answer of a document.
#[track_caller]
pub fn fact_of<'d>(document: &'d Value, name: &str) -> &'d Value {
    let facts = document["answer"]["facts"].as_array().unwrap();
    let found = facts.iter().find(|fact| fact["fact"] == name || fact["name"] == name);
    found.unwrap_or_else(|| panic!("no fact {name} in {document:#}"))
}

/// The first row with these cells.
pub fn row<'a>(rows: &'a [Row], cells: &[(&str, &str)]) -> &'a Row {
    let found = rows.iter().find(|row| cells.iter().all(|(name, value)| row[*name] == *value));
    found.unwrap_or_else(|| panic!("no row with {cells:?} in {rows:?}"))
}

pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

/// A report without the line breaks and the frame that the width of the terminal gives it.
pub fn unwrapped(report: &str) -> String {
    report.replace(['│', '×'], " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A bad study: exit 3, its place, every piece, help, and nothing left behind.
pub fn refused(text: &str, place: &str, pieces: &[&str]) {
    let desk = Desk::with(text);
    let place = format!("[study.toml:{place}]");
    let all: Vec<&str> = [place.as_str(), "help:", "╰──"].iter().chain(pieces).copied().collect();
    desk.fails("run study.toml --device cpu --trials 100", 3, &all);
    assert_eq!(desk.names("."), ["study.toml"], "something was left behind");
}

/// A bad record `record.csv` beside a study that names it: exit 3, every piece, and nothing left behind.
pub fn record_refused(record: &[u8], pieces: &[&str]) {
    let desk = Desk::with(&with_motion("profile = { file = \"record.csv\" }"));
    std::fs::write(desk.path("record.csv"), record).unwrap();
    let all: Vec<&str> = ["help:"].iter().chain(pieces).copied().collect();
    desk.fails("run study.toml --device cpu --trials 100", 3, &all);
    assert_eq!(desk.names("."), ["record.csv", "study.toml"], "something was left behind");
}

/// STUDY with another motion, whose lines begin at line 7.
pub fn with_motion(lines: &str) -> String {
    replaced("amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"", lines)
}

/// Two sweeps of two values each, with a chart of these lines from line 19 on.
pub fn swept_chart(lines: &str) -> String {
    with(&format!(
        "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n[[sweep]]\n\
         key = \"motion.amplitude\"\nlist = [\"10 arcsec/s\", \"12000 arcsec/s\"]\n[chart]\n{lines}"
    ))
}
