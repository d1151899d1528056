//! Which damage of which file is detected: a table in docs/dev/reliability.md.

use std::path::Path;

use sagnac::store::FILE as DATABASE;
use sagnac::store::folder::LIST;

use crate::desk::{Desk, with};

const PAGE: &str = "docs/dev/reliability.md";

/// What stands around the tables.
const MARKS: [&str; 2] =
    ["<!-- detection: written by a test, see CONTRIBUTING.md -->\n", "<!-- end of detection -->\n"];

/// Bytes that stand for a row in files that are no text.
const ROW: usize = 32;

/// Places at which a digit or a byte is changed.
const PLACES: usize = 8;

/// A damage with its name, in one or several ways.
type Damage = (&'static str, fn(&[u8]) -> Vec<Vec<u8>>);

const DAMAGES: [Damage; 5] = [
    ("digit or byte changed", |bytes| (0..PLACES).map(|place| changed(bytes, place)).collect()),
    ("end cut off", |bytes| vec![bytes[..bytes.len() * 3 / 4].to_vec()]),
    ("row removed", |bytes| {
        let mut rows = rows(bytes);
        rows.remove(rows.len() / 2);
        vec![rows.concat()]
    }),
    ("rows swapped", |bytes| {
        let mut rows = rows(bytes);
        let middle = rows.len() / 2;
        let other = (middle + 1..rows.len()).find(|&row| rows[row] != rows[middle]).unwrap_or(0);
        rows.swap(middle, other);
        vec![rows.concat()]
    }),
    ("row appended", |bytes| vec![[bytes, rows(bytes).last().unwrap()].concat()]),
];

/// What may be said of damages, the worst first.
const OUTCOMES: [&str; 4] = ["no", "same", "noted", "yes"];

/// Bytes with another digit of a text, or a bit among the upper ones of a number, at one of the places.
fn changed(bytes: &[u8], place: usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    // Rows of equal length must not be met at the same number each time.
    let start = place * bytes.len() / PLACES + 8 * (place % 4);
    match is_text(&bytes) {
        true => {
            let digit = bytes[start..].iter().position(u8::is_ascii_digit);
            bytes[start + digit.unwrap_or(0)] ^= 1;
        }
        false => bytes[start / 8 * 8 + 6] ^= 0x10,
    }
    bytes
}

fn is_text(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok()
}

/// The lines of a text, or pieces of other files.
fn rows(bytes: &[u8]) -> Vec<&[u8]> {
    if is_text(bytes) {
        bytes.split_inclusive(|byte| *byte == b'\n').collect()
    } else {
        bytes.chunks(ROW).collect()
    }
}

/// A table with a line for each file, of what `found` says of the file after each damage.
fn table(
    heading: &str,
    files: &[String],
    found: impl Fn(&str, &[u8]) -> &'static str,
    sound: impl Fn(&str) -> Vec<u8>,
) -> String {
    let names: Vec<&str> = DAMAGES.iter().map(|(name, _)| *name).collect();
    let lines = files.iter().map(|file| {
        let sound = sound(file);
        let cells: Vec<&str> = DAMAGES
            .iter()
            .map(|(_, damage)| {
                let outcomes = damage(&sound).into_iter().map(|damaged| found(file, &damaged));
                let worst = outcomes.map(|said| OUTCOMES.iter().position(|outcome| *outcome == said)).min();
                OUTCOMES[worst.flatten().unwrap()]
            })
            .collect();
        format!("| `{file}` | {} |\n", cells.join(" | "))
    });
    format!("\n| {heading} | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(DAMAGES.len()))
        + &lines.collect::<String>()
}

/// The files of a results folder, by `sagnac check`.
fn results() -> String {
    let desk = Desk::with(&with("[chart]\nx = \"filler\"\ny = \"rms\"\n"));
    desk.done("run study.toml --trials 4096 --device cpu --out f");
    let files: Vec<String> = desk.names("f").into_iter().filter(|name| name != "tallies.lock").collect();
    let sound = |file: &str| std::fs::read(desk.path("f").join(file)).unwrap();
    let found = |file: &str, damaged: &[u8]| {
        let kept = sound(file);
        std::fs::write(desk.path("f").join(file), damaged).unwrap();
        let code = desk.sagnac("check f --quiet").code;
        std::fs::write(desk.path("f").join(file), kept).unwrap();
        match file {
            _ if code != 0 => "yes",
            // The tables were compared with the tallies, and the list has no numbers.
            DATABASE | LIST => "same",
            _ => "no",
        }
    };
    let table = table("results", &files, found, sound);
    desk.done("check f --quiet");
    table
}

/// Logs with the words that read them.
const LOGS: [(&str, &str); 12] = [
    ("imu.csv", "--column gx,gy,gz"),
    ("imu.npy", "--column 2,3,4 --time 1 --time-unit s"),
    ("imu.npz", "--column gyro.1,gyro.2,gyro.3"),
    ("imu_packed.npz", "--column gyro.1,gyro.2,gyro.3"),
    ("imu.mat", "--column imu.gyro.1,imu.gyro.2,imu.gyro.3"),
    ("imu_packed.mat", "--column gyro.1,gyro.2,gyro.3"),
    ("imu.h5", "--column imu/gyro.1,imu/gyro.2,imu/gyro.3"),
    ("imu_packed.h5", "--column gyro.1,gyro.2,gyro.3"),
    ("imu_v73.mat", "--column gyro.1,gyro.2,gyro.3"),
    ("imu.mcap", "--column gx,gy,gz"),
    ("imu.bag", "--column gx,gy,gz"),
    ("imu_packed.bag", "--column gx,gy,gz"),
];

/// The formats of logs, by `sagnac allan`.
fn logs() -> String {
    let desk = Desk::with("");
    let read = |file: &str| {
        let (_, words) = LOGS.iter().find(|(log, _)| *log == file).unwrap();
        desk.sagnac(&format!("allan {file} {words} --data rate --unit rad/s --table --verbose"))
    };
    let folder = Path::new(crate::ROOT).join("tests/data/formats");
    let sound = |file: &str| std::fs::read(folder.join(file)).unwrap();
    let undisturbed = LOGS.map(|(file, _)| {
        std::fs::write(desk.path(file), sound(file)).unwrap();
        let ended = read(file);
        assert_eq!(ended.code, 0, "{file}: {}", ended.stderr);
        (file, ended)
    });
    let found = |file: &str, damaged: &[u8]| {
        let (_, before) = undisturbed.iter().find(|(log, _)| *log == file).unwrap();
        std::fs::write(desk.path(file), damaged).unwrap();
        let after = read(file);
        match after.code {
            0 if after.stderr != before.stderr => "noted",
            0 if after.stdout == before.stdout => "same",
            0 => "no",
            _ => "yes",
        }
    };
    let files = LOGS.map(|(file, _)| file.to_owned());
    table("logs", &files, found, sound)
}

#[test]
fn the_page_says_which_damage_is_detected() {
    let path = format!("{}/{PAGE}", crate::ROOT);
    let committed = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = committed.split_once(MARKS[0]).expect("the start of the tables");
    let (_, after) = rest.split_once(MARKS[1]).expect("the end of the tables");
    let current = format!("{before}{}{}{}\n{}{after}", MARKS[0], results(), logs(), MARKS[1]);
    if current != committed {
        std::fs::write(format!("{path}.new"), current).unwrap();
        panic!("the tables of detection in {path} are out of date; review {path}.new and rename it");
    }
}
