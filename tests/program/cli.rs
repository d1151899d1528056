//! The program as a user meets it: commands, files, messages and exit codes.

use std::io::{BufRead, BufReader};
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

use crate::desk::{Desk, HEADER, PROGRAM, SHIPPED, STUDY, replaced, unwrapped};
use sagnac_kernel::KERNELS;

#[test]
fn a_bad_study_among_good_ones_stops_all_before_the_first_starts() {
    let desk = Desk::with(STUDY);
    desk.write("bad.toml", &replaced("20 Hz", "20"));
    desk.fails("run study.toml bad.toml --device cpu", 3, &["[bad.toml:8:13]"]);
    assert_eq!(desk.names("."), ["bad.toml", "study.toml"]);
}

#[test]
fn wrong_usage_ends_with_2_and_leaves_nothing() {
    let desk = Desk::with(STUDY);
    desk.write("other.toml", STUDY);
    desk.fails(
        "run study.toml other.toml --device cpu --out all",
        2,
        &["--out names one folder", "without --out"],
    );
    desk.fails("run study.toml --device abacus", 2, &["no device is called `abacus`", "auto, cpu, gpu"]);
    assert!(
        desk.done("run study.toml --device portable --trials 10 --out p").stderr.contains("CPU (portable")
    );
    std::fs::remove_dir_all(desk.path("p")).unwrap();
    desk.fails("run study.toml --device=", 2, &["no device is called ``", "auto, cpu, gpu"]);
    desk.fails("run study.toml --device cpu --trials 0", 2, &["--trials", "1..=1099511627776"]);
    desk.fails("run study.toml --device cpu --trials many", 2, &["--trials", "1_000_000 or 1e6"]);
    desk.fails("run study.toml --device cpu --trials 1.5", 2, &["--trials", "not whole"]);
    desk.done("run study.toml --device cpu --trials 1e1 --seed 1_0 --out p");
    std::fs::remove_dir_all(desk.path("p")).unwrap();
    desk.fails("run study.toml --device cpu --seed=-1", 2, &["--seed"]);
    desk.fails("run --device cpu", 2, &["<STUDY>"]);
    desk.fails("verify --device abacus", 2, &["no device is called `abacus`"]);
    desk.fails("walk", 2, &["walk"]);
    assert_eq!(desk.names("."), ["other.toml", "study.toml"]);
}

#[test]
fn two_studies_never_share_a_default_folder() {
    let desk = Desk::with(STUDY);
    std::fs::create_dir(desk.path("more")).unwrap();
    desk.write("more/study.toml", &replaced("20 Hz", "10 Hz"));
    desk.fails("run study.toml more/study.toml --device cpu", 2, &["results/study", "study.toml", "--out"]);
    assert_eq!(desk.names("."), ["more", "study.toml"]);
}

#[test]
fn a_folder_of_another_study_is_left_as_it_is() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000 --seed 1 --out kept");
    let points = desk.read("kept/points.csv");
    desk.fails(
        "run study.toml --device cpu --trials 1000 --seed 2 --out kept",
        3,
        &["kept", "another study", "seed 1", "--out"],
    );
    assert_eq!(desk.read("kept/points.csv"), points);
    desk.done("run study.toml --device cpu --trials 1000 --seed 1 --out kept");
}

#[test]
fn a_folder_that_cannot_be_written_is_a_storage_failure() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000 --out";
    let pieces = ["cannot use the results folder", "--out DIR"];
    desk.fails(&format!("{run} study.toml/results"), 6, &pieces);
    desk.fails(&format!("{run} study.toml"), 6, &pieces);
    if cfg!(target_os = "linux") {
        desk.fails(&format!("{run} /proc/sagnac"), 6, &["cannot use the results folder /proc/sagnac"]);
    }
    assert_eq!(desk.names("."), ["study.toml"]);
}

#[test]
fn a_folder_in_use_is_a_storage_failure_that_says_so() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let holder = rusqlite::Connection::open(desk.path("results/study/tallies.sqlite")).unwrap();
    holder.execute_batch("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE;").unwrap();
    desk.fails(run, 6, &["results/study/tallies.sqlite is in use", "--out DIR"]);
    drop(holder);
    assert!(desk.done(run).stderr.contains("nothing was left to sample"));
}

#[test]
fn a_damaged_database_is_a_storage_failure() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let path = desk.path("results/study/tallies.sqlite");
    let sound = std::fs::read(&path).unwrap();
    let points = desk.read("results/study/points.csv");
    let all_bad = vec![0x5a; sound.len()];
    let later_pages_bad = [&sound[..4096], &all_bad[4096..]].concat();
    for bytes in [b"not a database, only some text\n".to_vec(), all_bad, later_pages_bad] {
        std::fs::write(&path, bytes).unwrap();
        desk.fails(run, 6, &["results/study/tallies.sqlite"]);
        assert_eq!(desk.read("results/study/points.csv"), points);
    }
    std::fs::write(&path, sound).unwrap();
    desk.done(run);
}

#[test]
fn a_damaged_row_is_found_by_its_checksum() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000";
    desk.done(run);
    let store = rusqlite::Connection::open(desk.path("results/study/tallies.sqlite")).unwrap();
    let changed = store.execute("UPDATE tally SET checksum = checksum + 1 WHERE first = 0", []).unwrap();
    assert_eq!(changed, 4, "each of 4 estimates has one block that begins with the first trial");
    drop(store);
    desk.fails(run, 6, &["results/study/tallies.sqlite", "damaged", "checksum"]);
}

#[test]
fn a_run_writes_the_table_the_chart_and_the_study() {
    let desk = Desk::with(SHIPPED);
    let ended = desk.done("run study.toml --device cpu --trials 1000");
    assert!(ended.stdout.starts_with("Residual error of the gap fillers"), "{}", ended.stdout);
    assert!(ended.stderr.contains("report results/study/report.html"), "{}", ended.stderr);
    let charts = ["chart-1", "chart-2", "chart-3"].map(|stem| [format!("{stem}.png"), format!("{stem}.svg")]);
    let files = [
        "points.csv",
        "report.html",
        "resolved_study.toml",
        "tallies.lock",
        "tallies.sqlite",
        "written_by_sagnac.jsonl",
    ]
    .map(str::to_owned);
    assert_eq!(desk.names("results/study"), [charts.concat(), files.into()].concat());
    let table = desk.read("results/study/points.csv");
    let laws = "reference_taylor_extremum_arcsec,reference_taylor_zero_crossing_arcsec";
    let header = format!("motion.frequency_hz,switching.gap_ticks,{HEADER},{laws}");
    assert_eq!(table.lines().next(), Some(header.as_str()));
    assert_eq!(desk.points("results/study").len(), 24 * 3 * 3 * 2);
    let png = std::fs::read(desk.path("results/study/chart-1.png")).unwrap();
    assert_eq!(&png[..16], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    assert!(png.ends_with(b"IEND\xaeB`\x82"));
    let svg = desk.read("results/study/chart-1.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
}

#[test]
fn the_resolved_study_repeats_the_run_without_options() {
    let shipped = "trials = 1_000_000";
    let written = SHIPPED.replace(shipped, "trials = 1_000_000 # many");
    assert_ne!(written, SHIPPED);
    let neither = SHIPPED.replace("seed = 1\n", "").replace(&format!("{shipped}\n"), "");
    let inserted = neither.replace("\"gap-fill\"\n", "\"gap-fill\"\nseed = 7\ntrials = 1000\n");
    let replaced = written.replace("seed = 1\n", "seed = 7\n").replace("1_000_000 #", "1000 #");
    for (text, expected) in [(&written, &replaced), (&neither, &inserted)] {
        let desk = Desk::with(text);
        desk.done("run study.toml --device cpu --trials 1000 --seed 7");
        let table = desk.read("results/study/points.csv");
        assert_eq!(desk.read("results/study/resolved_study.toml"), *expected);
        desk.done("run results/study/resolved_study.toml --device cpu --out fresh");
        assert_eq!(desk.read("fresh/points.csv"), table);
        let again = desk.done("run results/study/resolved_study.toml --device cpu --out results/study");
        assert!(again.stderr.contains("nothing was left to sample"), "{}", again.stderr);
        assert_eq!(desk.read("results/study/points.csv"), table);
        assert_eq!(desk.read("results/study/resolved_study.toml"), *expected);
    }
}

/// Ends a command whose standard output goes to `stdout`.
fn printed_to(desk: &Desk, words: &str, stdout: impl Into<Stdio>) -> (Option<i32>, String) {
    let mut command = Process::new(PROGRAM);
    command.current_dir(desk.0.path()).args(words.split_whitespace()).stdout(stdout);
    let output = command.stderr(Stdio::piped()).spawn().unwrap().wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn output_that_is_lost_is_a_failure_and_a_reader_that_left_is_none() {
    let desk = Desk::with(STUDY);
    let commands =
        ["schema", "run study.toml --device cpu --trials 1000 --json", "verify --device cpu --trials 64"];
    for words in commands {
        if cfg!(target_os = "linux") {
            let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
            let (code, said) = printed_to(&desk, words, full);
            assert_eq!(code, Some(6), "{words}: {said}");
            assert!(said.contains("cannot write to the standard output"), "{words}: {said}");
        }
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (code, said) = printed_to(&desk, words, writer);
        assert_eq!((code, said.contains("error:")), (Some(0), false), "{words}: {said}");
    }
}

#[test]
fn help_lists_only_exit_codes_that_exist() {
    let help = unwrapped(&Desk::with(STUDY).done("--help").stdout);
    assert!(help.contains("3 invalid study") && help.contains("5 a check failed"), "{help}");
    assert!(!help.contains("resumable"), "{help}");
}

/// Time from the start of a run to its first line of progress.
fn time_to_progress(desk: &Desk, out: &str) -> Duration {
    let started = Instant::now();
    let mut child = Process::new(PROGRAM)
        .current_dir(desk.0.path())
        .args(["run", "study.toml", "--device", "cpu", "--trials", "1000000000", "--out", out])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let seen = lines.into_iter().any(|line| line.contains("trials done"));
    let elapsed = started.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(seen, "the run ended without progress");
    elapsed
}

#[test]
fn progress_is_seen_within_100_ms() {
    let desk = Desk::with(SHIPPED);
    // Other programs can only make it longer: one start of twenty within the time is enough.
    let mut starts = (0..20).map(|start| time_to_progress(&desk, &format!("out-{start}")));
    assert!(starts.any(|time| time < Duration::from_millis(100)));
}

#[test]
fn a_quiet_run_prints_its_headline() {
    let desk = Desk::with(STUDY);
    let ended = desk.done("run study.toml --device cpu --trials 1000 --quiet");
    assert!(ended.stdout.starts_with("Quadratic: 99.73 % error "), "{}", ended.stdout);
    assert_eq!((ended.stdout.lines().count(), ended.stderr.as_str()), (1, ""));
    assert!(desk.path("results/study/points.csv").exists());
}

#[test]
fn schema_prints_the_committed_one_and_devices_lists_the_cpu() {
    let desk = Desk::with(STUDY);
    let committed = include_str!("../../schema/study.schema.json");
    assert_eq!(desk.done("schema").stdout.trim_end(), committed.trim_end());
    let devices = desk.done("devices").stdout;
    assert!(devices.starts_with("cpu: portable"), "{devices}");
    assert!(devices.contains("\ngpu:0: "), "{devices}");
}

#[test]
fn verify_prints_a_digest_for_each_kernel_and_the_same_ones_again() {
    let desk = Desk::with(STUDY);
    let first = desk.done("verify --device cpu --trials 4096").stdout;
    let (of_kernels, _) = first.split_once("digest of all kernels ").unwrap();
    let kernels: Vec<&str> = of_kernels
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["identical", kernel, digest] => {
                let hex = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
                assert!(digest.len() == 16 && digest.chars().all(hex), "{line}");
                kernel
            }
            _ => panic!("{line}"),
        })
        .collect();
    let all: Vec<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
    assert_eq!(kernels, all);
    assert_eq!(desk.done("verify --device cpu --trials 4096").stdout, first);
}

#[test]
fn noise_coefficients_are_converted_between_units_and_conventions() {
    let desk = Desk::with("");
    let shown = desk.done("convert 0.0135 deg/s/sqrt(Hz)").stdout;
    for line in [
        "angle random walk N = 0.0135 deg/s/sqrt(Hz)",
        "  N                                     0.81 °/√h",
        "  density of the rate, one-sided        68.7308 °/h/√Hz",
        "  N, if the density given is one-sided  0.572756 °/√h",
        "  angle_random_walk = \"0.572756 °/√h\"  # N, if the density given is one-sided",
    ] {
        assert!(shown.lines().any(|shown| shown == line), "no `{line}` in\n{shown}");
    }
    let refused = desk.sagnac("convert 5 s");
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("is a time") && refused.stderr.contains("give a number with its unit"));
}
