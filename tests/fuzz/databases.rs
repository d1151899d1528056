//! Results folders: whatever a database holds as bytes or as a schema, and wherever links in the folder lead, it is refused in
//! words, or its study ends with the tables of an undisturbed run; nothing outside the folder changes.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use sagnac::store::FILE;

use crate::campaign::{Target, fuzz};
use crate::cases::databases::{LINK, database, run};
use crate::edits::{apply, edits};

const TARGET: Target = Target { name: "databases", ending: "db", run };

#[test]
fn databases() {
    let tokens =
        &["\0", "\u{1}", "\u{7f}", "CREATE ", "tally", "study", "provenance", "TRIGGER", "WITHOUT ROWID"];
    let sound = || Just(()).prop_map(|()| database().to_vec());
    let bytes = (sound(), edits(4, tokens)).prop_map(|(mut bytes, edits)| {
        apply(&mut bytes, &edits);
        bytes
    });
    let lines =
        vec(prop_oneof![6 => statement(), 1 => link()], 0..5).prop_map(|lines| lines.join("\n").into_bytes());
    fuzz(&TARGET, prop_oneof![1 => sound(), 4 => bytes, 6 => lines]);
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
