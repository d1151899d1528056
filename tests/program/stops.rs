//! Signals and the time limit: what was sampled is kept, the exit code tells why, and the run goes on later to the same tables.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::desk::{Desk, PROGRAM, with};

/// Some seconds on any machine.
fn long() -> String {
    with("[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"4 Hz\", \"8 Hz\", \"12 Hz\", \"16 Hz\"]\n")
}

const RUN: &str = "run study.toml --device cpu --threads 1 --trials 30000000 --out";

fn start(desk: &Desk, words: &str) -> Child {
    Command::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(words.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until rows have been kept: more is in the journal than whose the folder is.
fn begun(folder: &Path) {
    let started = Instant::now();
    while folder.join("tallies.sqlite-wal").metadata().map_or(0, |journal| journal.len()) < 64 << 10 {
        assert!(started.elapsed() < Duration::from_secs(60), "nothing was written");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Exit code and what was said.
fn ended(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// The trials that a message says are kept.
fn kept(said: &str) -> f64 {
    let line = said.lines().find(|line| line.starts_with("stopped by")).unwrap_or_else(|| panic!("{said}"));
    let words: Vec<&str> = line.split(": ").nth(1).unwrap().split(' ').collect();
    let scale = match words[1] {
        "million" => 1e6,
        "thousand" => 1e3,
        _ => 1.0,
    };
    words[0].parse::<f64>().unwrap() * scale
}

#[test]
fn signals_and_the_time_limit_end_a_run_that_goes_on_later() {
    let desk = Desk::with(&long());
    desk.done(&format!("{RUN} whole"));
    for (signal, name, code) in [("INT", "SIGINT", 130), ("TERM", "SIGTERM", 143), ("USR1", "SIGUSR1", 4)] {
        let child = start(&desk, &format!("{RUN} {signal}"));
        begun(&desk.path(signal));
        send(&child, signal);
        let (found, said) = ended(child);
        assert_eq!(found, Some(code), "{said}");
        assert!(
            said.contains(&format!("{name}: stopping after this batch; a second signal leaves at once")),
            "{said}"
        );
        assert!(said.contains(&format!("stopped by {name}: ")) && said.contains("resumable"), "{said}");
        assert!(!desk.path(signal).join("points.csv").exists(), "it had ended before");
        let kept = kept(&said);
        assert!(kept > 0.0 && kept < 1.2e8, "{said}");
        // Every trial that it says is there.
        let resumed = desk.done(&format!("{RUN} {signal}"));
        let first = resumed.stderr.lines().find(|line| line.ends_with("trials done")).unwrap();
        let words: Vec<&str> = first.split(" of ").next().unwrap().split(' ').collect();
        assert!(said.contains(&format!(": {} of 120 million", words.join(" "))), "{first}\n{said}");
        assert_eq!(desk.read(&format!("{signal}/points.csv")), desk.read("whole/points.csv"));
    }
    let run = format!("{RUN} limited --time-limit 300ms");
    let stopped = desk.sagnac(&run);
    assert_eq!(stopped.code, 4, "{}", stopped.stderr);
    assert!(stopped.stderr.contains("stopped by the time limit: "), "{}", stopped.stderr);
    let mut runs = 1;
    while desk.sagnac(&run).code == 4 {
        runs += 1;
        assert!(runs < 1000, "it does not come further");
    }
    assert!(runs > 1, "the limit is too long for this machine");
    assert_eq!(desk.read("limited/points.csv"), desk.read("whole/points.csv"));
}

#[test]
fn a_second_signal_leaves_at_once() {
    // One record of seconds is the least that a batch can be.
    let study = "title = \"A long record\"\nkind = \"allan\"\ntrials = 1\n[record]\nsample = \"1 ms\"\nlength = \"60000 s\"\n\
                 [noise]\nangle_random_walk = \"0.001 deg/sqrt(h)\"\nbias_instability = \"0.001 deg/h\"\n";
    let desk = Desk::with(study);
    let child = start(&desk, "run study.toml --device portable --threads 1 --out out");
    let started = Instant::now();
    while !desk.path("out/resolved_study.toml").exists() {
        assert!(started.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(100));
    send(&child, "INT");
    std::thread::sleep(Duration::from_millis(100));
    send(&child, "TERM");
    let sent = Instant::now();
    let (code, said) = ended(child);
    assert_eq!(code, Some(143), "{said}");
    assert!(sent.elapsed() < Duration::from_secs(1), "it took {:?}", sent.elapsed());
    assert!(
        said.contains("SIGINT: stopping after this batch") && said.contains("stopped by SIGTERM"),
        "{said}"
    );
    desk.done("run study.toml --device cpu --out out --quiet");
}

#[test]
fn a_second_program_is_refused_at_once_and_told_who_is_first() {
    let desk = Desk::with(&long());
    let child = start(&desk, &format!("{RUN} out"));
    begun(&desk.path("out"));
    let holder = format!("out is in use by process {} on ", child.id());
    for words in [format!("{RUN} out"), "check out".to_owned(), "merge out --out copy".to_owned()] {
        let asked = Instant::now();
        desk.fails(&words, 6, &[&holder, "s now"]);
        assert!(asked.elapsed() < Duration::from_secs(2), "{words}: not at once");
    }
    send(&child, "TERM");
    assert_eq!(ended(child).0, Some(143));
    assert_eq!(desk.sagnac("check out").code, 4);
}

#[test]
fn a_closed_or_full_error_stream_changes_neither_results_nor_exit_codes() {
    let desk = Desk::with(&long());
    for (redirection, out) in [("2>/dev/full", "full"), ("2>&-", "closed")] {
        let script = |words: &str| {
            let command = format!("{PROGRAM} {words} {redirection}");
            Command::new("sh").arg("-c").arg(command).current_dir(desk.0.path()).status().unwrap().code()
        };
        assert_eq!(script(&format!("run study.toml --device cpu --trials 2000 --out {out}")), Some(0));
        assert_eq!(script("check nowhere"), Some(2));
    }
    assert_eq!(desk.read("full/points.csv"), desk.read("closed/points.csv"));
    let mut child = Command::new("sh")
        .args(["-c", &format!("exec {PROGRAM} {RUN} out 2>/dev/full")])
        .current_dir(desk.0.path())
        .spawn()
        .unwrap();
    begun(&desk.path("out"));
    send(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
}

#[test]
fn a_run_that_stops_at_a_precision_goes_on_from_what_it_said_is_kept() {
    let desk = Desk::with(&long().replace("kind =", "precision = \"0.005 %\"\nkind ="));
    let run = "run study.toml --device cpu --threads 1 --trials 400000000 --out out --time-limit";
    let first = desk.sagnac(&format!("{run} 1s"));
    assert_eq!(first.code, 4, "{}", first.stderr);
    let line = |text: &str, end: &str| text.lines().find(|line| line.contains(end)).map(str::to_owned);
    let stopped = line(&first.stderr, "are kept").unwrap_or_else(|| panic!("{}", first.stderr));
    let second = desk.sagnac(&format!("{run} 10s"));
    let begins = line(&second.stderr, "trials done").unwrap_or_else(|| panic!("{}", second.stderr));
    let reached = begins.strip_suffix(" trials done").unwrap();
    assert!(!reached.starts_with("0 of") && stopped.contains(reached), "{stopped}\n{begins}");
}

#[test]
fn a_run_that_ends_while_the_points_of_later_batches_are_lowered_goes_on_to_the_same_table() {
    // A batch has the launches of a thousand points at most.
    let desk = Desk::with(&with(
        "[[sweep]]\nkey = \"motion.frequency\"\nlog = { from = \"2 Hz\", to = \"40 Hz\", points = 200 }\n\
         [[sweep]]\nkey = \"motion.amplitude\"\nlog = { from = \"1e3 arcsec/s\", to = \"2e4 arcsec/s\", points = 40 }",
    ));
    let run = "run study.toml --device cpu --threads 1 --trials 5000 --out";
    let child = start(&desk, &format!("{run} cut"));
    begun(&desk.path("cut"));
    send(&child, "TERM");
    let (code, said) = ended(child);
    assert_eq!(code, Some(143), "{said}");
    let kept = kept(&said);
    assert!(kept > 0.0 && kept < 4e7 && !desk.path("cut/points.csv").exists(), "{said}");
    assert_eq!(desk.sagnac("check cut").code, 4, "points are missing");
    desk.done(&format!("{run} cut"));
    desk.done(&format!("{run} whole"));
    assert!(desk.read("cut/points.csv") == desk.read("whole/points.csv"), "the tables differ");
}

/// A study whose points take milliseconds each to plan, because no two share their motion.
const SLOW_TO_PLAN: &str = "title = \"Slow to plan\"\nkind = \"gap-fill\"\ntrials = 64\n[gyro]\ntick = \"1 ms\"\n\
    tick_noise = { std = \"0.1 arcsec\" }\n[motion.suspension]\ngyro = \"LGK-400\"\nalias = true\n\
    random = { psd = [[\"20 Hz\", \"0.001 g^2/Hz\"], [\"2000 Hz\", \"0.001 g^2/Hz\"]] }\n\
    [switching]\ngap_ticks = 3\nfillers = [\"const\"]\n\
    [[sweep]]\nkey = \"gyro.tick\"\nlinear = { from = \"1 ms\", to = \"2 ms\", points = 10000 }\n\
    [[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n";

#[test]
fn planning_is_shown_and_ends_at_once() {
    let desk = Desk::with(SLOW_TO_PLAN);
    for (signal, code) in [("INT", 130), ("TERM", 143), ("USR1", 4)] {
        let mut child = start(&desk, "run study.toml --device cpu --out out");
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let shown = lines.next().unwrap().unwrap();
        assert!(shown.starts_with("planning ") && shown.contains(" of 100 thousand points, "), "{shown}");
        send(&child, signal);
        let sent = Instant::now();
        let said: Vec<String> = lines.map(Result::unwrap).collect();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{said:?}");
        assert!(sent.elapsed() < Duration::from_secs(1), "{:?}: {said:?}", sent.elapsed());
        assert!(said[0].starts_with("stopped by SIG"), "{said:?}");
    }
    let started = Instant::now();
    let limited = desk.sagnac("run study.toml --device cpu --out out --time-limit 500ms");
    assert_eq!(limited.code, 4, "{}", limited.stderr);
    assert!(limited.stderr.contains("stopped by the time limit after planning "), "{}", limited.stderr);
    // It reads the study before, which takes some time too.
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
    assert!(!desk.path("out").exists(), "nothing was sampled");
}
