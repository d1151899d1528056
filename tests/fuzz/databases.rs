//! Results folders: whatever a database holds as bytes or as a schema, and wherever links in the folder lead, it is refused in
//! words, or its study ends with the tables of an undisturbed run; nothing outside the folder changes.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use rusqlite::Connection;
use sagnac::device::Device;
use sagnac::device::cpu::Cpu;
use sagnac::kernel::width::Width;
use sagnac::progress::Silent;
use sagnac::run::Plan;
use sagnac::store::source::Source;
use sagnac::store::{FILE, Store};
use sagnac::study::Study;
use sagnac::tally::share::Share;
use tempfile::TempDir;

use crate::campaign::{Outcome, Target, fuzz};
use crate::edits::{apply, edits};

const TARGET: Target = Target { name: "databases", ending: "db", run };

const STUDY: &str = r#"title = "Tallies"
kind = "gap-fill"
trials = 300
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

/// The header of a database; inputs without it are instructions, one a line.
const MAGIC: &[u8] = b"SQLite format 3\0";

/// A line that begins so makes the first name a link to the second.
const LINK: &str = "link ";

/// What lies outside the folder, where links lead.
const OUTSIDE: &str = "outside";
const KEPT: &str = "of another program";

/// The study, its table and the database of a whole run.
struct Sound {
    study: Study,
    table: Vec<u8>,
    database: Vec<u8>,
}

static SOUND: LazyLock<Sound> = LazyLock::new(|| {
    let study = Study::parse("study.toml", STUDY).expect("a study");
    let folder = TempDir::new().unwrap();
    let table = finished(&study, folder.path()).expect("a whole run");
    let database = fs::read(folder.path().join(FILE)).unwrap();
    Sound { study, table, database }
});

#[test]
fn databases() {
    let tokens =
        &["\0", "\u{1}", "\u{7f}", "CREATE ", "tally", "study", "provenance", "TRIGGER", "WITHOUT ROWID"];
    let sound = || Just(()).prop_map(|()| SOUND.database.clone());
    let bytes = (sound(), edits(4, tokens)).prop_map(|(mut bytes, edits)| {
        apply(&mut bytes, &edits);
        bytes
    });
    let lines =
        vec(prop_oneof![6 => statement(), 1 => link()], 0..5).prop_map(|lines| lines.join("\n").into_bytes());
    fuzz(&TARGET, prop_oneof![1 => sound(), 4 => bytes, 6 => lines]);
}

/// Opens, checks, finishes and merges the folder that the input describes.
pub fn run(input: &[u8]) -> Vec<Outcome> {
    let around = TempDir::new().unwrap();
    let folder = around.path().join("folder");
    fs::create_dir(&folder).unwrap();
    fs::write(around.path().join(OUTSIDE), KEPT).unwrap();
    let file = folder.join(FILE);
    if input.starts_with(MAGIC) {
        fs::write(&file, input).unwrap();
    } else {
        fs::write(&file, &SOUND.database).unwrap();
        let text = String::from_utf8_lossy(input);
        for line in text.lines() {
            follow(&folder, line);
        }
    }
    let outcomes = vec![merged(&folder), resumed(&folder)];
    let outside = fs::read(around.path().join(OUTSIDE)).unwrap();
    assert_eq!(String::from_utf8_lossy(&outside), KEPT, "a file outside the folder was written");
    outcomes
}

/// Makes a link, or changes the database by a statement; what SQLite does not accept changes nothing.
fn follow(folder: &Path, line: &str) {
    if let Some((name, target)) = line.strip_prefix(LINK).and_then(|words| words.split_once(' ')) {
        let plain = |name: &str| {
            !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
        };
        if plain(name) && name != ".." && name != "." {
            let _ = fs::remove_file(folder.join(name));
            #[cfg(unix)]
            let _ = std::os::unix::fs::symlink(target, folder.join(name));
        }
    } else if let Ok(connection) = Connection::open(folder.join(FILE)) {
        let _ = connection.execute_batch(line);
    }
}

/// Runs what is left of the study, whose table must be that of an undisturbed run.
fn resumed(folder: &Path) -> Outcome {
    match finished(&SOUND.study, folder) {
        Ok(table) => {
            assert_eq!(
                String::from_utf8_lossy(&table),
                String::from_utf8_lossy(&SOUND.table),
                "another table"
            );
            Outcome::Accepted("run".to_owned())
        }
        Err(refusal) => Outcome::Refused(refusal),
    }
}

/// Merges the folder into an empty one, where the study then ends as it should.
fn merged(folder: &Path) -> Outcome {
    let target = TempDir::new().unwrap();
    let plan = Plan::new(&SOUND.study).expect("a plan");
    let merge = || -> Result<(), String> {
        let source = Source::open(folder).map_err(|error| error.to_string())?;
        let mut store = Store::open(target.path(), &plan.identity()).map_err(|error| error.to_string())?;
        store.merge(&source, false).map(drop).map_err(|error| error.to_string())
    };
    let outcome = merge();
    // Whether it was taken over or refused, what the target holds is sound.
    let table = finished(&SOUND.study, target.path()).expect("a target that stays sound");
    assert_eq!(
        String::from_utf8_lossy(&table),
        String::from_utf8_lossy(&SOUND.table),
        "another table after a merge"
    );
    match outcome {
        Ok(()) => Outcome::Accepted("merge".to_owned()),
        Err(refusal) => Outcome::Refused(refusal),
    }
}

fn finished(study: &Study, folder: &Path) -> Result<Vec<u8>, String> {
    let plan = Plan::new(study).expect("a plan");
    let mut device = Device::Cpu(Cpu::new(Width::widest(), 1).expect("a thread"));
    let mut store = Store::open(folder, &plan.identity()).map_err(|error| error.to_string())?;
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).map_err(|error| error.to_string())?;
    let tables = plan.tables(&store, &Silent).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    tables.points.write_csv(&mut bytes).unwrap();
    Ok(bytes)
}

/// A name of the schema, or another one.
fn name() -> impl Strategy<Value = &'static str> {
    select(vec!["study", "tally", "provenance", "sqlite_schema", "other"])
}

fn column() -> impl Strategy<Value = &'static str> {
    select(vec![
        "key", "value", "point", "estimate", "first", "log2", "digest", "sums", "checksum", "session",
        "finished", "program", "device", "trials", "seconds",
    ])
}

/// A value of any of SQLite's types, among them the largest.
fn value() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<i64>().prop_map(|number| number.to_string()),
        select(vec![
            "NULL",
            "''",
            "x''",
            "0",
            "-1",
            "9223372036854775807",
            "9e999",
            "zeroblob(100000)",
            "'\u{1b}[2J'"
        ])
        .prop_map(str::to_owned),
        vec(any::<u8>(), 0..40).prop_map(|bytes| {
            let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            format!("x'{digits}'")
        }),
    ]
}

/// A query that a view or a trigger holds; some of them never end.
fn query() -> impl Strategy<Value = String> {
    let endless = "WITH RECURSIVE n(key, value) AS (SELECT 'x', 'y' UNION ALL SELECT key, value FROM n) SELECT * FROM n";
    prop_oneof![
        (column(), name()).prop_map(|(column, name)| format!("SELECT {column} FROM {name}")),
        name().prop_map(|name| format!("SELECT * FROM {name}, {name}, {name}")),
        value().prop_map(|value| format!("SELECT {value}")),
        Just(endless.to_owned()),
    ]
}

/// A statement that changes the schema or the rows.
fn statement() -> impl Strategy<Value = String> {
    let event = || select(vec!["INSERT", "UPDATE", "DELETE"]);
    let time = || select(vec!["BEFORE", "AFTER"]);
    let kind = || select(vec!["TEXT", "BLOB", "INTEGER", "REAL", "ANY", ""]);
    prop_oneof![
        (time(), event(), name()).prop_map(|(time, event, name)| format!(
            "CREATE TRIGGER odd_{event} {time} {event} ON {name} BEGIN SELECT RAISE(IGNORE); END"
        )),
        (event(), name(), name()).prop_map(|(event, on, from)| format!(
            "CREATE TRIGGER less_{event} AFTER {event} ON {on} BEGIN DELETE FROM {from}; END"
        )),
        (name(), query()).prop_map(|(name, query)| format!("DROP TABLE IF EXISTS {name}; CREATE VIEW {name} AS {query}")),
        (name(), column(), kind(), column(), kind()).prop_map(|(name, one, kind, two, other)| format!(
            "DROP TABLE IF EXISTS {name}; CREATE TABLE {name} ({one} {kind} PRIMARY KEY, {two} {other}) WITHOUT ROWID"
        )),
        (name(), column()).prop_map(|(name, column)| format!("CREATE INDEX by_{column} ON {name} ({column})")),
        (name(), name()).prop_map(|(name, to)| format!("ALTER TABLE {name} RENAME TO {to}2")),
        (name(), column(), kind()).prop_map(|(name, column, kind)| format!("ALTER TABLE {name} ADD {column}2 {kind}")),
        (name(), column(), value()).prop_map(|(name, column, value)| format!("UPDATE {name} SET {column} = {value}")),
        (name(), column(), value()).prop_map(|(name, column, value)| format!("DELETE FROM {name} WHERE {column} > {value}")),
        (name(), vec(value(), 2..8)).prop_map(|(name, values)| format!("INSERT OR REPLACE INTO {name} VALUES ({})", values.join(", "))),
        (select(vec!["user_version", "application_id", "page_size", "auto_vacuum", "encoding", "schema_version"]), any::<u16>())
            .prop_map(|(pragma, value)| format!("PRAGMA {pragma} = {value}; VACUUM")),
        select(vec![
            "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = 2",
            "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'INTEGER', 'TEXT')",
            "PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name = 'provenance'",
            "PRAGMA journal_mode = DELETE",
        ])
        .prop_map(str::to_owned),
    ]
}

/// A link in the place of a file that the program reads or writes.
fn link() -> impl Strategy<Value = String> {
    let file = select(vec![
        FILE.to_owned(),
        format!("{FILE}-wal"),
        format!("{FILE}-shm"),
        format!("{FILE}-journal"),
        "tallies.lock".to_owned(),
        "points.csv".to_owned(),
    ]);
    let target = select(vec!["../outside", "/dev/zero", "/dev/full", "missing", "tallies.lock", "."]);
    (file, target).prop_map(|(file, target)| format!("{LINK}{file} {target}"))
}
