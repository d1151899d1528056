//! Damaged databases and journals, taken through every command that reads them: what a command shows equals what it shows
//! of an undisturbed folder, or it says that it does not, or it fails.
//!
//! 24 damages by themselves; `SAGNAC_DAMAGES=1000 cargo test --release --test program damages -- --nocapture` for as many as
//! one likes.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rusqlite::Connection;
use sagnac::run::Plan;
use sagnac::store::{FILE, LOCK, Store};
use sagnac::tally::Share;

use crate::desk::Desk;
use crate::stores::{MOMENTS, ROWS, cpu, folder};
use crate::studies::Silent;

const JOURNAL: &str = "tallies.sqlite-wal";

/// Size of a page of SQLite.
const PAGE: usize = 4096;

/// A way to damage the database or the journal of a folder.
type Damage = fn(&Path, &mut SmallRng);

const DAMAGES: [(&str, Damage); 9] = [
    ("bytes of the database", |folder, random| {
        change(&folder.join(FILE), random, |bytes, random| flip(bytes, random))
    }),
    ("bytes of the journal", |folder, random| {
        change(&folder.join(JOURNAL), random, |bytes, random| flip(bytes, random))
    }),
    ("end of the database", |folder, random| change(&folder.join(FILE), random, cut)),
    ("end of the journal", |folder, random| change(&folder.join(JOURNAL), random, cut)),
    ("pages of the database", |folder, random| {
        change(&folder.join(FILE), random, |bytes, random| swap(bytes, random))
    }),
    ("pages of the journal", |folder, random| {
        change(&folder.join(JOURNAL), random, |bytes, random| swap(bytes, random))
    }),
    ("a key of a row", |folder, random| {
        let altered = [
            "point = substr(point, 1, 7) || x'5a' || substr(point, 9)",
            "estimate = substr(estimate, 1, 7) || x'5a' || substr(estimate, 9)",
            "digest = x'000102030405060708090a0b0c0d0e0f'",
            "first = first + 1024",
            "log2 = log2 + 1",
            "sums = substr(sums, 1, length(sums) - 1)",
            "checksum = checksum + 1",
        ];
        let sql = format!("UPDATE OR REPLACE tally SET {}", altered[random.random_range(0..altered.len())]);
        of_some_row(folder, random, &sql);
    }),
    ("a row is deleted", |folder, random| of_some_row(folder, random, "DELETE FROM tally")),
    ("a line about the study or a session is altered", |folder, random| {
        let altered = [
            "DELETE FROM provenance",
            "UPDATE provenance SET trials = trials + 1",
            "UPDATE provenance SET seconds = seconds * 2",
            "DELETE FROM study WHERE key = 'seed'",
            "UPDATE study SET value = '2' WHERE key = 'seed'",
            "UPDATE study SET value = 'gap_fill 99' WHERE key = 'kernels'",
            "UPDATE study SET value = '1' WHERE key LIKE 'session %'",
            "DELETE FROM study WHERE key LIKE 'share %'",
        ];
        let sql = altered[random.random_range(0..altered.len())];
        Connection::open(folder.join(FILE)).unwrap().execute_batch(sql).unwrap();
    }),
];

fn change(path: &Path, random: &mut SmallRng, how: fn(&mut Vec<u8>, &mut SmallRng)) {
    let mut bytes = std::fs::read(path).unwrap();
    how(&mut bytes, random);
    std::fs::write(path, bytes).unwrap();
}

/// One to three bytes.
fn flip(bytes: &mut [u8], random: &mut SmallRng) {
    for _ in 0..random.random_range(1..=3) {
        let at = random.random_range(0..bytes.len());
        bytes[at] ^= 1 << random.random_range(0..8);
    }
}

fn cut(bytes: &mut Vec<u8>, random: &mut SmallRng) {
    bytes.truncate(random.random_range(0..bytes.len()));
}

fn swap(bytes: &mut [u8], random: &mut SmallRng) {
    let pages = bytes.len() / PAGE;
    let [one, other] = [(); 2].map(|()| random.random_range(0..pages) * PAGE);
    for at in 0..PAGE {
        bytes.swap(one + at, other + at);
    }
}

fn of_some_row(folder: &Path, random: &mut SmallRng, sql: &str) {
    let connection = Connection::open(folder.join(FILE)).unwrap();
    let count: i64 = connection.query_row("SELECT COUNT(*) FROM tally", [], |row| row.get(0)).unwrap();
    let [point, estimate, first] = ["point", "estimate", "first"]
        .map(|key| format!("{key} = (SELECT {key} FROM tally LIMIT 1 OFFSET ?1)"));
    let sql = format!("{sql} WHERE {point} AND {estimate} AND {first}");
    assert!(connection.execute(&sql, [random.random_range(0..count)]).unwrap() > 0, "{sql}");
}

/// A command on the folder `f`, with the files whose content it shows.
struct Shows {
    words: &'static str,
    files: &'static [&'static str],
}

const COMMANDS: [Shows; 5] = [
    Shows { words: "chart f", files: &["f/redrawn.svg"] },
    Shows { words: "report f", files: &["f/report.html"] },
    Shows { words: "check f", files: &[] },
    Shows { words: "run f/resolved_study.toml --device cpu", files: &["f/points.csv", "f/chart.svg"] },
    Shows { words: "merge f --out m", files: &["m/points.csv", "m/chart.svg"] },
];

/// What a command shows: its files and, where it has none, what it prints.
fn shown(desk: &Desk, command: &Shows) -> (i32, Vec<String>, String) {
    let ended = desk.sagnac(command.words);
    let mut shown: Vec<String> = command
        .files
        .iter()
        .map(|file| std::fs::read_to_string(desk.path(file)).unwrap_or_default())
        .collect();
    if shown.is_empty() {
        shown.push(ended.stdout.clone());
    }
    let said = format!("{}{}{}", ended.stdout, ended.stderr, shown.concat());
    (ended.code, shown, said)
}

/// A folder of complete results, a part of which is still in the journal.
fn whole(text: &str, trials: u64) -> Desk {
    let desk = Desk(folder());
    desk.write("study.toml", text);
    let run = |trials: u64| format!("run study.toml --device cpu --out f --trials {trials}");
    desk.done(&run(trials / 2));
    let study = crate::stores::study(text, trials, 1);
    let plan = Plan::new(&study).unwrap();
    let mut store = Store::open(&desk.path("f"), &plan.identity()).unwrap();
    plan.run(&mut store, &mut cpu(1), Share::WHOLE, &Silent).unwrap();
    let held = [FILE, JOURNAL].map(|name| (name, std::fs::read(desk.path("f").join(name)).unwrap()));
    drop(store);
    // The other files are those of all trials.
    desk.done(&run(trials));
    for (name, bytes) in held {
        std::fs::write(desk.path("f").join(name), bytes).unwrap();
    }
    desk
}

fn copied(from: &Desk) -> Desk {
    let desk = Desk(folder());
    std::fs::create_dir(desk.path("f")).unwrap();
    for name in from.names("f").iter().filter(|name| *name != LOCK) {
        std::fs::copy(from.path("f").join(name), desk.path("f").join(name)).unwrap();
    }
    desk
}

#[test]
fn no_damage_changes_what_a_command_shows_unless_it_says_so() {
    let wanted: usize = std::env::var("SAGNAC_DAMAGES").map_or(24, |text| text.parse().unwrap());
    let seed: u64 = std::env::var("SAGNAC_SEED").map_or(1, |text| text.parse().unwrap());
    let mut random = SmallRng::seed_from_u64(seed);
    let started = Instant::now();
    let chart = "[chart]\nx = \"frequency\"\ny = \"rms\"\nseries = [\"filler\"]\n";
    let curve = "[chart]\nx = \"tau\"\ny = \"adev\"\n";
    let folders = [whole(&format!("{MOMENTS}{chart}"), 40_000), whole(&format!("{ROWS}{curve}"), 60)];
    let undisturbed = folders.each_ref().map(|from| {
        COMMANDS.each_ref().map(|command| {
            let (code, shown, said) = shown(&copied(from), command);
            assert_eq!(code, 0, "{}: {said}", command.words);
            shown
        })
    });
    let mut outcomes: BTreeMap<(&str, &str), [usize; 3]> = BTreeMap::new();
    for attempt in 0..wanted {
        let (name, damage) = DAMAGES[attempt % DAMAGES.len()];
        let at = attempt / DAMAGES.len() % folders.len();
        let damaged = copied(&folders[at]);
        damage(&damaged.path("f"), &mut random);
        for (command, wanted) in COMMANDS.iter().zip(&undisturbed[at]) {
            let (code, shown, said) = shown(&copied(&damaged), command);
            let says = ["ncomplete", "are missing", "damaged"].iter().any(|piece| said.contains(piece));
            let outcome = match (code, &shown == wanted) {
                (0, true) => 0,
                (0, false) if says => 2,
                (0, false) => panic!(
                    "attempt {attempt}, seed {seed}, {name}: `sagnac {}` shows something else and does not say so:\n{said}",
                    command.words
                ),
                _ => 1,
            };
            outcomes.entry((name, command.words)).or_default()[outcome] += 1;
        }
    }
    for ((damage, words), [equal, refused, said]) in &outcomes {
        let command = words.split(' ').next().unwrap();
        println!("{damage}: {command}: {equal} equal, {refused} refused, {said} said");
    }
    let of = |outcome: usize| outcomes.values().map(|counts| counts[outcome]).sum::<usize>();
    let [equal, refused, said] = [0, 1, 2].map(of);
    println!(
        "seed {seed}, {wanted} damages, {equal} outputs equal, {refused} refused, {said} say so, {:.1} s",
        started.elapsed().as_secs_f64()
    );
    assert!(equal > 0 && refused > 0, "{equal} equal, {refused} refused");
}
