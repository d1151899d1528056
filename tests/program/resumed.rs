//! Runs that continue what earlier ones left, and the same table whatever samples it.

use std::path::Path;
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

use crate::desk::{Desk, PROGRAM, SHIPPED, STUDY, with, with_motion};
use assert_cmd::Command;

#[test]
fn a_second_run_samples_nothing_and_changes_nothing() {
    let desk = Desk::with(SHIPPED);
    desk.done("run study.toml --device cpu --trials 1000");
    let files =
        ["points.csv", "chart-1.svg", "resolved_study.toml"].map(|name| format!("results/study/{name}"));
    let before = files.each_ref().map(|name| desk.read(name));
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("nothing was left to sample"), "{}", ended.stderr);
    assert_eq!(files.each_ref().map(|name| desk.read(name)), before);
}

#[test]
fn more_trials_later_are_the_same_as_all_at_once() {
    let desk = Desk::with(SHIPPED);
    for trials in [1, 1000, 20_000] {
        desk.done(&format!("run study.toml --device cpu --quiet --trials {trials} --out grown"));
    }
    desk.done("run study.toml --device cpu --quiet --trials 20000 --out fresh");
    assert_eq!(desk.read("grown/points.csv"), desk.read("fresh/points.csv"));
    assert_eq!(desk.read("grown/chart-1.svg"), desk.read("fresh/chart-1.svg"));
}

#[test]
fn a_filler_or_a_sweep_value_added_later_is_the_same_as_from_the_start() {
    let sweep = |list: &str| format!("[[sweep]]\nkey = \"motion.frequency\"\nlist = [{list}]\n");
    let (few, all) = (sweep("\"5 Hz\", \"20 Hz\""), sweep("\"5 Hz\", \"10 Hz\", \"20 Hz\""));
    let fillers =
        |text: &str| text.replace("\"const\", \"quadratic\"", "\"const\", \"linear\", \"quadratic\"");
    let desk = Desk::with(&with(&few));
    desk.write("filler.toml", &fillers(&with(&few)));
    desk.write("all.toml", &fillers(&with(&all)));
    for study in ["study", "filler", "all"] {
        desk.done(&format!("run {study}.toml --device cpu --quiet --trials 5000 --out grown"));
    }
    desk.done("run all.toml --device cpu --quiet --trials 5000 --out fresh");
    assert_eq!(desk.read("grown/points.csv"), desk.read("fresh/points.csv"));
}

#[test]
fn a_point_no_longer_asked_for_is_kept_but_not_shown() {
    let sweep = |list: &str| with(&format!("[[sweep]]\nkey = \"motion.frequency\"\nlist = [{list}]"));
    let desk = Desk::with(&sweep("\"5 Hz\", \"20 Hz\""));
    desk.done("run study.toml --device cpu --trials 1000");
    desk.write("study.toml", &sweep("\"5 Hz\""));
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("note: 1 point of earlier runs is kept"), "{}", ended.stderr);
    assert_eq!(desk.points("results/study").len(), 4);
}

/// 12 points; the trials are asked for on the command line.
fn long_study() -> String {
    let sweeps = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"4 Hz\", \"8 Hz\", \"12 Hz\", \"16 Hz\"]\n\
                  [[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]\n";
    with(sweeps)
}

const LONG_TRIALS: u64 = 10_000_000;

/// Bytes of the database with its log.
fn stored(folder: &Path) -> u64 {
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |file| file.len());
    size("tallies.sqlite") + size("tallies.sqlite-wal")
}

/// Device and trials of each run that left something.
fn provenance(folder: &Path) -> Vec<(String, u64)> {
    let store = rusqlite::Connection::open(folder.join("tallies.sqlite")).unwrap();
    let mut statement = store.prepare("SELECT device, trials FROM provenance").unwrap();
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)? as u64))).unwrap();
    rows.map(Result::unwrap).collect()
}

/// Starts a run and kills it once its database has grown by `bytes`.
fn killed(desk: &Desk, words: &str, folder: &str, bytes: u64) {
    let mut child = Process::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(words.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (folder, started) = (desk.path(folder), Instant::now());
    while stored(&folder) < bytes {
        assert!(started.elapsed() < Duration::from_secs(60), "no {bytes} bytes were stored");
        assert!(child.try_wait().unwrap().is_none(), "the run ended before {bytes} bytes were stored");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(child.try_wait().unwrap().is_none(), "the run ended before it was killed");
    child.kill().unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), None, "the run ended by itself");
    assert!(!folder.join("points.csv").exists(), "the run had finished its table");
}

#[test]
fn a_killed_run_resumes_to_the_same_table() {
    let desk = Desk::with(&long_study());
    let run = format!("run study.toml --device cpu --trials {LONG_TRIALS} --json --out");
    desk.done(&format!("{run} whole"));
    let (whole, all) = (desk.read("whole/points.csv"), 12 * LONG_TRIALS);
    for (index, kib) in [150, 500, 1500].into_iter().enumerate() {
        let folder = format!("killed-{index}");
        killed(&desk, &format!("{run} {folder}"), &folder, kib << 10);
        let before = provenance(&desk.path(&folder));
        let resumed = desk.done(&format!("{run} {folder}"));
        let json: serde_json::Value = serde_json::from_str(&resumed.stdout).unwrap();
        let sampled = json["provenance"]["sampled_trials"].as_u64().unwrap();
        assert!(
            (1..all).contains(&sampled),
            "{kib} KiB: {sampled} of {all} trials were sampled after the kill"
        );
        assert!(desk.read(&format!("{folder}/points.csv")) == whole, "{kib} KiB: another table");
        let after = provenance(&desk.path(&folder));
        assert_eq!((before.len(), after.len()), (1, 2), "{kib} KiB: a row for each run");
        assert!(before[0].0.starts_with("CPU"), "{kib} KiB: {before:?}");
        assert_eq!(before[0].1 + sampled, all, "{kib} KiB: the killed run is noted with what it has left");
    }
}

#[test]
fn one_thread_gives_the_same_table() {
    let desk = Desk::with(&long_study());
    desk.done("run study.toml --device cpu --quiet --trials 100000 --out all");
    let ended = desk
        .sagnac_with("run study.toml --device cpu --trials 100000 --out one", &[("RAYON_NUM_THREADS", "1")]);
    assert!(ended.stderr.contains("1 thread"), "{}", ended.stderr);
    assert_eq!(desk.read("all/points.csv"), desk.read("one/points.csv"));
}

#[test]
fn an_adapter_gives_the_same_table() {
    let desk = Desk::with(SHIPPED);
    let devices = desk.done("devices").stdout;
    let adapters: Vec<&str> =
        devices.lines().filter_map(|line| Some(line.strip_prefix("gpu:")?.split_once(": ")?.1)).collect();
    // The software rasterizer where it is: the same program on every machine.
    let software = adapters.iter().find(|name| name.contains("llvmpipe"));
    let adapter = software.or(adapters.first()).unwrap_or_else(|| {
        panic!(
            "no adapter to compare with the CPU: run ./test, which installs a Vulkan software rasterizer (llvmpipe), \
             then this test again"
        )
    });
    desk.done("run study.toml --device cpu --quiet --trials 20000 --out cpu");
    let words = ["run", "study.toml", "--trials", "20000", "--out", "gpu", "--device", adapter];
    let output = Command::new(PROGRAM).current_dir(desk.0.path()).args(words).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains(&format!("device: {adapter}")), "{said}");
    assert_eq!(desk.read("cpu/points.csv"), desk.read("gpu/points.csv"));
    assert_eq!(desk.read("cpu/chart-1.svg"), desk.read("gpu/chart-1.svg"));
}

#[test]
fn the_resolved_study_of_a_record_repeats_the_run_from_where_it_lies() {
    let record = "profile = { file = \"data/record.csv\", position = \"every\" }";
    let desk = Desk::with(&with_motion(record));
    std::fs::create_dir(desk.path("data")).unwrap();
    let samples: String = (0..400).map(|i| format!("{}, {}\n", 5 * i, i % 7)).collect();
    desk.write("data/record.csv", &format!("time [ms], rate [deg/s]\n{samples}"));
    let ended = desk.done("run study.toml --device cpu --trials 300");
    assert!(ended.stderr.contains("538 trials per point instead of 300: whole replays"), "{}", ended.stderr);
    let table = desk.read("results/study/points.csv");
    let again = desk.done("run results/study/resolved_study.toml --device cpu");
    assert!(again.stderr.contains("nothing was left to sample"), "{}", again.stderr);
    assert!(!again.stderr.contains("whole replays"), "{}", again.stderr);
    desk.done("run results/study/resolved_study.toml --device cpu --out afresh");
    assert_eq!(
        [desk.read("results/study/points.csv"), desk.read("afresh/points.csv")],
        [table.clone(), table]
    );
}

#[test]
fn a_record_whose_first_half_changed_is_resampled_for_the_fillers_that_are_designed_from_it() {
    let record = "profile = { file = \"data/record.csv\", position = \"every\" }";
    let least = "{ kind = \"minimum-variance\", name = \"mv\", fit_ticks = [-1, 0, \"n+1\", \"n+2\"] }";
    let study = with_motion(record).replace("[\"const\", \"quadratic\"]", &format!("[\"const\", {least}]"));
    let desk = Desk::with(&study);
    std::fs::create_dir(desk.path("data")).unwrap();
    let write = |first_half: f64| {
        let rate = |i: usize| 3.0 * (0.7 * i as f64).sin() * if i < 380 { first_half } else { 1.0 };
        let noise = |i: usize| ((i * 7919) % 101) as f64 / 101.0;
        let samples: String = (0..800).map(|i| format!("{}, {}\n", 5 * i, rate(i) + noise(i))).collect();
        desk.write("data/record.csv", &format!("time [ms], rate [deg/s]\n{samples}"));
    };
    write(1.0);
    desk.done("run study.toml --device cpu --trials 300");
    write(0.1);
    let said = desk.done("run study.toml --device cpu --trials 300").stderr;
    assert!(
        said.contains("record.csv changed since the last run; the affected points are resampled"),
        "{said}"
    );
    assert!(!said.contains("nothing was left to sample"), "{said}");
    desk.done("run study.toml --device cpu --trials 300 --out afresh");
    assert_eq!(desk.read("results/study/points.csv"), desk.read("afresh/points.csv"));
}

#[test]
fn fewer_trials_than_are_held_are_told_and_the_resolved_study_has_those_held() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 5000");
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stderr.contains("5000 trials per point instead of 1000"), "{}", ended.stderr);
    assert!(desk.read("results/study/resolved_study.toml").contains("trials = 5000"));
}
