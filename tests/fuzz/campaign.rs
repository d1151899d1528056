//! Runs of a target: its corpus first, then inputs made for a time; and what is told of them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestError, TestRng, TestRunner};

use crate::cases::Outcome;
use crate::limits::{self, Taken};

/// How long inputs are made where nothing else is asked for.
const SHORT: Duration = Duration::from_secs(10);

/// The most frequent refusals that are listed.
const LISTED: usize = 12;

/// What is fuzzed.
pub struct Target {
    pub name: &'static str,
    /// Of the files of its corpus.
    pub ending: &'static str,
    /// Panics where an input shows a fault.
    pub run: fn(&[u8]) -> Vec<Outcome>,
}

impl Target {
    fn folder(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(self.name)
    }

    /// The files of the corpus with their contents, in the order of their names.
    pub fn corpus(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let entries = std::fs::read_dir(self.folder()).unwrap();
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        let read = |path: PathBuf| std::fs::read(&path).map(|bytes| (path, bytes)).unwrap();
        paths.into_iter().map(read).collect()
    }

    /// Where a failing input is kept.
    fn file_of(&self, input: &[u8]) -> PathBuf {
        self.folder().join(format!("{:08x}.{}", crc32fast::hash(input), self.ending))
    }
}

/// Fuzzes `target` with its corpus and `inputs`.
pub fn fuzz(target: &Target, inputs: impl Strategy<Value = Vec<u8>>) {
    // Memory is counted for the whole program: one target at a time.
    static TURN: Mutex<()> = Mutex::new(());
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let report = RefCell::new(Report::default());
    // A stack that overflows leaves no time to keep the input.
    let running = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzzed.{}", target.ending));
    let run = |input: &[u8]| {
        std::fs::write(&running, input).unwrap();
        let (outcomes, taken) = limits::within(input, target.file_of(input), || (target.run)(input));
        report.borrow_mut().add(&outcomes, taken);
    };
    for (path, input) in target.corpus() {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| run(&input))) {
            eprintln!("{} fails", path.display());
            resume_unwind(panic);
        }
    }
    let (time, seed) = asked();
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let config = Config { failure_persistence: None, max_shrink_time: 60_000, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, rng);
    let started = Instant::now();
    while started.elapsed() < time {
        let input = inputs.new_tree(&mut runner).unwrap();
        let result = runner.run_one(input, |input| {
            run(&input);
            Ok(())
        });
        if let Err(TestError::Fail(why, input)) = result {
            let kept = limits::kept(&input, &target.file_of(&input));
            panic!("{} with seed {seed}: {why}\n{kept}", target.name);
        }
    }
    let report = report.into_inner();
    println!("{}: {report}, seed {seed}", target.name);
    assert!(!report.accepted.is_empty() && !report.refused.is_empty(), "only one side was met");
}

/// How long inputs are made, and from which seed.
fn asked() -> (Duration, u64) {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().expect(name));
    let seconds = number("SAGNAC_FUZZ_SECONDS");
    let seed = number("SAGNAC_FUZZ_SEED").unwrap_or_else(|| match seconds {
        None => 1,
        Some(_) => SystemTime::UNIX_EPOCH.elapsed().map_or(1, |time| time.as_secs()),
    });
    (seconds.map_or(SHORT, Duration::from_secs), seed)
}

/// What came of many inputs.
#[derive(Default)]
struct Report {
    cases: u64,
    accepted: BTreeMap<String, u64>,
    /// By what their messages say.
    refused: BTreeMap<String, u64>,
    longest: Duration,
    bytes: usize,
}

impl Report {
    fn add(&mut self, outcomes: &[Outcome], taken: Taken) {
        self.cases += 1;
        self.longest = self.longest.max(taken.time);
        self.bytes = self.bytes.max(taken.bytes);
        for outcome in outcomes {
            *match outcome {
                Outcome::Accepted(what) => self.accepted.entry(what.clone()).or_default(),
                Outcome::Refused(message) => self.refused.entry(gist(message)).or_default(),
            } += 1;
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Report { cases, accepted, refused, longest, bytes } = self;
        let kinds: Vec<String> = accepted.iter().map(|(what, count)| format!("{what} {count}")).collect();
        write!(
            f,
            "{cases} cases, {} times accepted ({}), {} times refused in {} ways, longest {:.2} s, at most {:.1} MiB",
            accepted.values().sum::<u64>(),
            kinds.join(", "),
            refused.values().sum::<u64>(),
            refused.len(),
            longest.as_secs_f64(),
            *bytes as f64 / f64::from(1 << 20),
        )?;
        let mut often: Vec<(&String, &u64)> = refused.iter().collect();
        often.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let often = often.iter().take(LISTED).map(|(gist, count)| format!("{gist} ({count})"));
        write!(f, "; mostly {}", often.collect::<Vec<_>>().join(", "))
    }
}

/// A message without what is of one input only: its first words, without quotes and numbers.
fn gist(message: &str) -> String {
    let mut words = Vec::new();
    let mut quoted = false;
    for word in message.lines().next().unwrap_or_default().split_whitespace() {
        let quotes = word.matches(['"', '`', '\'']).count();
        let plain = !quoted && quotes == 0 && !word.contains(|c: char| c.is_ascii_digit() || c == '/');
        if plain {
            words.push(word);
        } else if words.last() != Some(&"…") {
            words.push("…");
        }
        quoted ^= quotes % 2 == 1;
    }
    words.truncate(7);
    words.join(" ")
}
