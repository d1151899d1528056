//! Everything that may happen to results, at random and for as long as is asked: kills, full disks, damage, shares, merges and
//! salvages. Whatever came before, a run that ends with code 0 has the table of an undisturbed one.
//!
//! 10 s by default. An hour, with a line a minute:
//! `SAGNAC_SOAK_SECONDS=3600 cargo test --release --locked --test program soak -- --nocapture`. The folder of a failing case is kept
//! and named with what was done to it; `SAGNAC_SEED` repeats its choices, though not the moments of its kills.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fmt, fs};

use crate::desk::{Desk, PROGRAM};
use crate::stores::{MOMENTS, ROWS, RUNS};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use sagnac::store::FILE;

/// The studies with the trials of each: a run takes some tenths of a second.
const STUDIES: [(&str, &str, u64); 3] =
    [("moments", MOMENTS, 2_000_000), ("rows", ROWS, 3000), ("runs", RUNS, 200_000)];

/// The folder to which everything is done.
const RESULTS: &str = "results";

/// Exit codes: incomplete, and those of a refusal with a message: 2 is that of a folder without results, as after a kill before
/// the first row, and 6 that of a full disk.
const INCOMPLETE: i32 = 4;
const FULL: i32 = 6;
const REFUSED: [i32; 5] = [1, 2, 3, 5, FULL];

/// How many of each event there were.
#[derive(Default)]
struct Count {
    cases: u64,
    events: BTreeMap<String, u64>,
}

impl Count {
    fn note(&mut self, event: impl Into<String>) {
        *self.events.entry(event.into()).or_default() += 1;
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let events: Vec<String> = self.events.iter().map(|(event, n)| format!("{event} {n}")).collect();
        write!(f, "{} cases end with the table of an undisturbed run; {}", self.cases, events.join(", "))
    }
}

/// A study with the folder that is soaked.
struct Soaked<'a> {
    desk: &'a Desk,
    /// The words of a run of the whole study.
    run: String,
    random: &'a mut SmallRng,
    count: &'a mut Count,
    /// What was done so far.
    done: Vec<String>,
}

impl Soaked<'_> {
    fn note(&mut self, event: &str, detail: &str) {
        self.count.note(event);
        self.done.push(format!("{event} {detail}"));
    }

    /// Runs the program, which must end with 0 or with a refusal in words; returns its exit code.
    fn tried(&mut self, words: &str) -> i32 {
        let ended = self.desk.sagnac(words);
        let known = ended.code == 0 || ended.code == INCOMPLETE || REFUSED.contains(&ended.code);
        assert!(known, "code {} of `sagnac {words}`:\n{}", ended.code, ended.stderr);
        let is_said = ended.code == 0 || ended.code == INCOMPLETE || ended.stderr.contains("error");
        assert!(is_said, "code {} of `sagnac {words}` says nothing", ended.code);
        ended.code
    }

    /// Kills a run of the study or of a share of it after some time.
    fn kill(&mut self, share: &str, folder: &str) {
        let words = format!("{} {share} --out {folder}", self.run);
        let mut child = Command::new(PROGRAM)
            .current_dir(self.desk.0.path())
            .args(words.split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let wait = Duration::from_micros(self.random.random_range(0..400_000));
        std::thread::sleep(wait);
        child.kill().unwrap();
        let is_killed = child.wait().unwrap().code().is_none();
        self.note(if is_killed { "kills" } else { "kills after the end" }, &format!("{share} at {wait:?}"));
    }

    /// Runs with a limit on the size of files, which is met as a full disk is.
    fn fill(&mut self) {
        let blocks = self.random.random_range(8..400);
        let script = format!("ulimit -f {blocks}; exec {PROGRAM} {} --out {RESULTS}", self.run);
        let mut command = Command::new("sh");
        let output = command.arg("-c").arg(&script).current_dir(self.desk.0.path()).output().unwrap();
        let code = output.status.code();
        let said = String::from_utf8_lossy(&output.stderr);
        let known = code.is_some_and(|code| code == 0 || REFUSED.contains(&code));
        assert!(known, "{code:?} at {blocks} blocks:\n{said}");
        self.note(
            if code == Some(FULL) { "full disks" } else { "limits not met" },
            &format!("{blocks} blocks"),
        );
    }

    /// Alters some bytes of the database or its journal, or cuts it off.
    fn damage(&mut self) {
        let name = if self.random.random_range(0..3) == 0 { format!("{FILE}-wal") } else { FILE.to_owned() };
        let path = self.desk.path(&format!("{RESULTS}/{name}"));
        let Ok(mut bytes) = fs::read(&path) else { return };
        if bytes.is_empty() {
            return;
        }
        let mut detail = name;
        if self.random.random_range(0..4) == 0 {
            bytes.truncate(self.random.random_range(0..bytes.len()));
            detail += &format!(" cut to {} bytes", bytes.len());
        } else {
            for _ in 0..self.random.random_range(1..=4) {
                let (at, bit) = (self.random.random_range(0..bytes.len()), self.random.random_range(0..8));
                bytes[at] ^= 1 << bit;
                detail += &format!(" bit {bit} of byte {at}");
            }
        }
        fs::write(&path, bytes).unwrap();
        self.note("damages", &detail);
    }

    /// Samples a share, which may be killed at first, and merges it.
    fn share(&mut self) {
        let of = self.random.random_range(2..=5);
        let share = format!("--shard {}/{of}", self.random.random_range(1..=of));
        let folder = "share";
        if self.random.random() {
            self.kill(&share, folder);
        }
        let words = format!("{} {share} --out {folder}", self.run);
        assert_eq!(self.tried(&words), 0, "a share that nothing damaged");
        let code = self.tried(&format!("merge {folder} --out {RESULTS} --quiet"));
        self.note(if REFUSED.contains(&code) { "merges refused" } else { "merges" }, &share);
        fs::remove_dir_all(self.desk.path(folder)).unwrap();
    }

    /// Takes what is sound of the folder into a new one.
    fn salvage(&mut self) {
        let code = self.tried(&format!("merge {RESULTS} --salvage --out salvaged --quiet"));
        let is_refused = REFUSED.contains(&code);
        self.note(if is_refused { "salvages refused" } else { "salvages" }, &format!("code {code}"));
        let _ = fs::remove_dir_all(self.desk.path(RESULTS));
        if is_refused {
            let _ = fs::remove_dir_all(self.desk.path("salvaged"));
        } else {
            fs::rename(self.desk.path("salvaged"), self.desk.path(RESULTS)).unwrap();
        }
    }

    /// Runs what is left, after a salvage where the folder is refused, and compares the table.
    fn finish(&mut self, table: &str) {
        let words = format!("{} --out {RESULTS}", self.run);
        let code = self.tried(&words);
        if code != 0 {
            self.note("refusals", &format!("code {code}"));
            self.salvage();
            assert_eq!(self.tried(&words), 0, "a folder that was salvaged or is new");
        }
        assert_eq!(self.desk.read(&format!("{RESULTS}/points.csv")), table, "another table");
        let check = self.desk.sagnac(&format!("check {RESULTS}"));
        assert_eq!(check.code, 0, "`check` of a finished folder:\n{}{}", check.stdout, check.stderr);
        self.count.cases += 1;
    }
}

#[test]
fn whatever_happens_to_results_a_run_that_ends_well_has_their_table() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().expect(name));
    let time = Duration::from_secs(number("SAGNAC_SOAK_SECONDS").unwrap_or(10));
    let seed = number("SAGNAC_SEED").unwrap_or(1);
    let mut random = SmallRng::seed_from_u64(seed);
    let desk = Desk::with("");
    let studies = STUDIES.map(|(name, text, trials)| {
        desk.write(&format!("{name}.toml"), text);
        let run = format!("run {name}.toml --device cpu --threads 1 --trials {trials} --quiet");
        desk.done(&format!("{run} --out whole-{name}"));
        (run, desk.read(&format!("whole-{name}/points.csv")))
    });
    let (mut count, started, mut minutes) = (Count::default(), Instant::now(), 0);
    while count.cases == 0 || started.elapsed() < time {
        let (run, table) = &studies[random.random_range(0..studies.len())];
        let mut soaked =
            Soaked { desk: &desk, run: run.clone(), random: &mut random, count: &mut count, done: vec![] };
        let case = AssertUnwindSafe(|| {
            for _ in 0..soaked.random.random_range(1..=6) {
                match soaked.random.random_range(0..6) {
                    0 | 1 => soaked.kill("", RESULTS),
                    2 => soaked.fill(),
                    3 => soaked.damage(),
                    4 => soaked.share(),
                    _ => drop(soaked.tried(&format!("check {RESULTS}"))),
                }
            }
            soaked.finish(table);
        });
        if let Err(panic) = catch_unwind(case) {
            let done = soaked.done.join("\n  ");
            eprintln!("seed {seed}, after {count}\n{run}\n  {done}\nkept in {}", desk.0.keep().display());
            resume_unwind(panic);
        }
        let _ = fs::remove_dir_all(desk.path(RESULTS));
        if started.elapsed().as_secs() / 60 > minutes {
            minutes = started.elapsed().as_secs() / 60;
            println!("{minutes} min: {count}");
        }
    }
    println!("soak, seed {seed}, {:.0} s: {count}", started.elapsed().as_secs_f64());
}
