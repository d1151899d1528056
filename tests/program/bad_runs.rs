//! Bad studies of whole runs: each is refused with its place, what was found, what is accepted, and exit code 3.

use crate::desk::{Desk, refused};

mod notes;

/// A gyro whose residuals are given by their largest value.
const BUDGET: &str = r#"title = "Runs"
kind = "switched-run"
[drift]
magnetic = "14 arcsec/s"
warm_up_time = "3000 s"
residual_max = "10 arcsec"
[switching]
interval = "40 s"
[run]
duration = "10 min"
"#;

/// One whose residuals come from fillers.
const FILLED: &str = r#"title = "Runs"
kind = "switched-run"
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
interval = "40 s"
gap_ticks = 3
fillers = ["const", "quadratic"]
[run]
duration = "10 min"
"#;

/// Relock after each switch.
const RELOCK: &str = r#"[relock]
initial_detuning = 0.05
loop_time = "12 ms"
bias_frequency = "80 kHz"
pulse_weight = "2.6 arcsec"
curvature = 40
"#;

fn replaced(study: &str, from: &str, to: &str) -> String {
    assert!(study.contains(from), "`{from}` is not in the study");
    study.replacen(from, to, 1)
}

fn swept(study: &str, key: &str, list: &str) -> String {
    format!("{study}[[sweep]]\nkey = \"{key}\"\nlist = {list}\n")
}

#[test]
fn a_run_shorter_than_an_interval_is_refused_where_either_is_written() {
    let longer = "shorten switching.interval, or lengthen run.duration";
    refused(
        &replaced(BUDGET, "10 min", "30 s"),
        "8:12",
        &["a run of 30 s is shorter than the switching interval of 40 s", "never switch", longer],
    );
    refused(
        &swept(BUDGET, "switching.interval", "[\"20 s\", \"11 min\"]"),
        "13:8",
        &["a run of 600 s is shorter than the switching interval of 660 s", longer],
    );
    refused(&swept(BUDGET, "run.duration", "[\"20 s\", \"11 min\"]"), "13:8", &["a run of 20 s", longer]);
}

#[test]
fn intervals_that_are_no_whole_number_of_ticks_are_rounded_and_that_is_said() {
    let noted = |text: &str, note: &str| {
        let desk = Desk::with(text);
        let said =
            crate::desk::unwrapped(&desk.done("run study.toml --device cpu --trials 100 --out o").stderr);
        assert!(
            said.contains(&format!("note: switching.interval is rounded to whole ticks: {note}")),
            "{said}"
        );
        desk.read("o/points.csv")
    };
    let rounded = noted(&replaced(FILLED, "40 s", "40.002 s"), "40.002 s to 40 s");
    let whole = Desk::with(FILLED);
    let said = whole.done("run study.toml --device cpu --trials 100 --out o").stderr;
    assert!(!said.contains("note:"), "{said}");
    assert_eq!(rounded, whole.read("o/points.csv"), "not the runs of the rounded interval");
    let list = "[\"20.001 s\", \"40.001 s\", \"50 s\", \"60.002 s\"]";
    noted(&swept(FILLED, "switching.interval", list), "20.001 s to 20 s, and 2 others");
}

#[test]
fn intervals_shorter_than_the_ticks_round_a_switch_are_refused() {
    refused(
        &replaced(FILLED, "40 s", "25 ms"),
        "10:12",
        &["interval of 0.025 s is shorter than the ticks round a switch", "accepted: 0.035 s and more"],
    );
    refused(
        &swept(FILLED, "switching.interval", "[\"10 ms\", \"1 s\"]"),
        "17:8",
        &["interval of 0.01 s", "accepted: 0.035 s and more"],
    );
    refused(
        &replaced(
            &replaced(FILLED, "40 s", "100 ms"),
            "gap_ticks",
            "fit_ticks = [\"-20..0\", \"n+1..n+20\"]\ngap_ticks",
        ),
        "10:12",
        &["interval of 0.1 s", "accepted: 0.22 s and more with these fit ticks"],
    );
}

#[test]
fn runs_with_too_many_switches_are_refused_with_the_shortest_interval() {
    refused(
        &replaced(BUDGET, "40 s", "1 ms"),
        "8:12",
        &["a run of 600 s with a switch every 0.001 s has too many switches", "at least 0.01 s here"],
    );
    refused(&replaced(BUDGET, "10 min", "1000 h"), "8:12", &["up to 59999 switches", "at least 60 s here"]);
    refused(
        &swept(BUDGET, "run.duration", "[\"1 min\", \"1000 h\"]"),
        "13:8",
        &["a run of 3.6e6 s with a switch every 40 s", "at least 60 s here"],
    );
}

#[test]
fn negative_spreads_and_drifts_out_of_range_are_refused() {
    let more = |line: &str| replaced(BUDGET, "residual_max", &format!("{line}\nresidual_max"));
    for (key, value) in [
        ("magnetic_spread", "\"-1 arcsec/s\""),
        ("non_magnetic_spread", "\"-1 arcsec/s\""),
        ("initial_magnetic_spread", "\"-1 arcsec/s\""),
        ("warm_up_time_spread", "-0.1"),
        ("angle_random_walk", "\"-0.003 deg/sqrt(h)\""),
    ] {
        let column = key.len() + 4;
        let found = format!("drift.{key} = ");
        refused(
            &more(&format!("{key} = {value}")),
            &format!("6:{column}"),
            &[&found, "negative", "accepted: 0 to"],
        );
    }
    refused(&replaced(BUDGET, "10 arcsec", "-10 arcsec"), "6:16", &["negative", "accepted: 0 to 1e6 arcsec"]);
    refused(&more("warm_up_time_spread = \"60 %\""), "6:23", &["too large", "0 to 0.5, or 0 % to 50 %"]);
    refused(&replaced(BUDGET, "14 arcsec/s", "1e7 arcsec/s"), "4:12", &["too large", "-1e6 to 1e6 arcsec/s"]);
    refused(
        &replaced(BUDGET, "14 arcsec/s", "14 arcsec"),
        "4:12",
        &["is an angle", "accepted: an angular rate"],
    );
    refused(&replaced(BUDGET, "3000 s", "0 s"), "5:16", &["drift.warm_up_time = 0 s", "too small"]);
}

#[test]
fn a_spread_of_a_warm_up_that_is_not_there_is_refused() {
    refused(
        &replaced(BUDGET, "warm_up_time = \"3000 s\"", "warm_up_time_spread = \"10 %\""),
        "5:23",
        &[
            "warm_up_time_spread is given without drift.warm_up_time",
            "no time to spread",
            "warm_up_time = \"3000 s\"",
        ],
    );
    refused(
        &replaced(BUDGET, "3000 s\"", "3 s\"\nwarm_up_time_spread = \"10 %\""),
        "6:23",
        &["warm_up_time_spread with an interval of 13.3 and a run of", "intervals up to 4 warm-up times"],
    );
}

#[test]
fn what_gives_the_residual_twice_or_not_at_all_is_refused() {
    let twice = [
        "drift.residual_max conflicts with switching.fillers",
        "a second residual",
        "leave drift.residual_max out",
    ];
    refused(&replaced(FILLED, "[motion]", "[drift]\nresidual_max = \"10 arcsec\"\n[motion]"), "7:16", &twice);
    refused(&swept(FILLED, "drift.residual_max", "[\"1 arcsec\", \"2 arcsec\"]"), "17:8", &twice);
    let of_no_use = |name: &str| format!("{name} determines the residuals, but switching.fillers is missing");
    let without = replaced(FILLED, "fillers = [\"const\", \"quadratic\"]\n", "");
    refused(&without, "3:1", &[&of_no_use("[gyro]"), "no effect without fillers", "give drift.residual_max"]);
    for (table, lines) in [
        ("motion", "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\""),
        ("noise", "angle_random_walk = \"0.003 deg/sqrt(h)\""),
    ] {
        let named = format!("[{table}]");
        refused(&format!("{BUDGET}{named}\n{lines}\n"), "11:1", &[&of_no_use(&named)]);
    }
    for (key, value) in
        [("gap_ticks", "3"), ("fit_ticks", "[-1, 0, \"n+1\"]"), ("extrapolation_ticks", "[-1, 0]")]
    {
        let text = replaced(BUDGET, "[run]", &format!("{key} = {value}\n[run]"));
        refused(&text, &format!("9:{}", key.len() + 4), &[&of_no_use(&format!("switching.{key}"))]);
    }
    for (key, list) in [
        ("motion.frequency", "[\"2 Hz\", \"5 Hz\"]"),
        ("switching.gap_ticks", "[1, 2]"),
        ("gyro.tick", "[\"2 ms\"]"),
    ] {
        let found = format!("{key} is swept, but there are no fillers");
        refused(&swept(BUDGET, key, list), "12:7", &[&found, "add [gyro], [motion] and switching.fillers"]);
    }
    refused(&replaced(FILLED, "gap_ticks = 3\n", ""), "9:1", &["`switching.gap_ticks` is missing"]);
}

#[test]
fn times_that_no_run_has_and_times_listed_twice_are_refused() {
    let with = |times: &str| format!("{BUDGET}times = {times}\n");
    let late = "run.times lists 660 s, after the end of a run of 600 s";
    refused(&with("[\"5 min\", \"11 min\"]"), "11:9", &[late, "lengthen run.duration"]);
    refused(
        &swept(&with("[\"5 min\"]"), "run.duration", "[\"1 min\", \"10 min\"]"),
        "14:8",
        &["run.times lists 300 s, after the end of a run of 60 s"],
    );
    refused(&with("[\"5 min\", \"300 s\"]"), "11:19", &["run.times lists 300 s twice", "leave it out here"]);
    refused(&with("[\"0 s\"]"), "11:10", &["run.times lists 0 s", "not above 0"]);
    refused(&with("[\"-1 s\"]"), "11:10", &["run.times lists -1 s", "not above 0"]);
    refused(&with("[60]"), "11:10", &["a bare number", "accepted: a time"]);
    refused(&with("\"5 min\""), "11:9", &["must be a list of quantities in brackets"]);
    let many: Vec<String> = (1..=101).map(|second| format!("\"{second} s\"")).collect();
    refused(&with(&format!("[{}]", many.join(", "))), "11:9", &["lists 101 times", "accepted: up to 100"]);
}

#[test]
fn trajectories_out_of_range_and_charts_of_none_are_refused() {
    let with = |given: &str| format!("{BUDGET}trajectories = {given}\n");
    refused(&with("1001"), "11:16", &["run.trajectories = 1001", "too large", "from 0 to 1000"]);
    refused(&with("-1"), "11:16", &["run.trajectories = -1", "too small", "from 0 to 1000"]);
    refused(&with("2.5"), "11:16", &["not a whole number"]);
    let chart = |study: &str, more: &str| {
        format!("{study}[chart]\ntable = \"trajectories\"\nx = \"time\"\ny = \"error\"\n{more}")
    };
    refused(
        &chart(BUDGET, "series = [\"run\"]"),
        "12:9",
        &["the chart is of trajectories, and none are kept", "trajectories = 20"],
    );
    refused(
        &chart(&with("2"), "where = { run = \"3\" }"),
        "16:17",
        &["no row has run = \"3\"", "accepted: 1, 2"],
    );
    refused(
        &chart(&with("2"), "references = [\"noise\"]"),
        "16:15",
        &["is a reference curve of gap fillers", "leave it out"],
    );
    refused(
        &replaced(&chart(&with("2"), ""), "\"error\"", "\"drift_rms\""),
        "15:5",
        &["no column is called `drift_rms`", "run, time_s, error_arcsec", "trajectories.csv"],
    );
    refused(
        &replaced(&chart(BUDGET, ""), "\"trajectories\"", "\"coefficients\""),
        "12:9",
        &["no such table", "leave chart.table out"],
    );
}

#[test]
fn what_belongs_to_other_kinds_is_refused() {
    refused(
        &format!("precision = \"1 %\"\n{BUDGET}"),
        "1:13",
        &["precision is not a key", "kind = \"gap-fill\""],
    );
    refused(
        &replaced(FILLED, "fillers", "errors = [\"residual\"]\nfillers"),
        "12:10",
        &["switching.errors is not a key", "kind = \"gap-fill\""],
    );
    let gap_fill =
        replaced(&replaced(FILLED, "switched-run", "gap-fill"), "[run]\nduration = \"10 min\"\n", "");
    refused(&gap_fill, "10:12", &["switching.interval is not a key", "\"gap-fill\"", "leave it out"]);
    let without = replaced(&gap_fill, "interval = \"40 s\"\n", "");
    for (key, value, place) in [("first_mode", "positive", "10:14"), ("timing", "random", "10:10")] {
        let written = replaced(&without, "gap_ticks", &format!("{key} = \"{value}\"\ngap_ticks"));
        refused(
            &written,
            place,
            &[
                &format!("switching.{key} is not a key"),
                "\"gap-fill\"",
                "leave it out, or write kind = \"switched-run\"",
            ],
        );
        let budget = replaced(BUDGET, "switched-run", "drift-budget");
        refused(
            &replaced(&budget, "[run]", &format!("{key} = \"{value}\"\n[run]")),
            &place.replace("10:", "9:"),
            &[&format!("switching.{key} is not a key"), "\"drift-budget\"", "leave it out"],
        );
    }
    refused(
        &format!("{without}[run]\nduration = \"1 h\"\n"),
        "12:1",
        &["[run] is not a table of a study of kind = \"gap-fill\"", "kind = \"switched-run\""],
    );
    let budget = replaced(BUDGET, "switched-run", "drift-budget");
    refused(&format!("{budget}times = [\"1 s\"]\n"), "11:9", &["run.times is not a key", "\"drift-budget\""]);
    refused(&format!("{budget}trajectories = 3\n"), "11:16", &["run.trajectories is not a key"]);
    refused(
        &format!("{BUDGET}[record]\nsample = \"1 s\"\nlength = \"1 h\"\n"),
        "11:1",
        &["[record] is not a table", "kind = \"allan\""],
    );
    refused(&format!("{BUDGET}[drifts]\n"), "11:2", &["unknown key `drifts`", "did you mean `drift`?"]);
    refused(&replaced(BUDGET, "interval", "intervall"), "8:1", &["did you mean `interval`?"]);
    refused(
        &replaced(BUDGET, "[run]", "first_mode = \"up\"\n[run]"),
        "9:14",
        &["positive, negative, random"],
    );
    refused(&replaced(BUDGET, "[run]", "timing = \"now\"\n[run]"), "9:10", &["accepted: random, periodic"]);
}

#[test]
fn runs_in_which_nothing_happens_are_refused() {
    let still = ["there is no drift and no residual of a switch", "magnetic = \"14 arcsec/s\""];
    let without = replaced(BUDGET, "residual_max = \"10 arcsec\"\n", "");
    let nothing = replaced(&without, "magnetic = \"14 arcsec/s\"\n", "");
    refused(&nothing, "4:16", &still);
    refused(&replaced(&nothing, "[drift]\nwarm_up_time = \"3000 s\"\n", ""), "2:8", &still);
    refused(&swept(&without, "drift.magnetic", "[\"0 arcsec/s\"]"), "12:8", &still);
    let quiet = replaced(FILLED, "three_sigma = \"1.6 arcsec\"", "std = \"0 arcsec\"");
    let tone = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n";
    refused(&replaced(&quiet, tone, "rate = \"0 deg/s\"\n"), "2:8", &still);
    // One point at which something happens is enough.
    let desk = Desk::with(&swept(&without, "drift.magnetic", "[\"0 arcsec/s\", \"1 arcsec/s\"]"));
    desk.done("run study.toml --device cpu --trials 100");
}

#[test]
fn a_relock_that_has_no_ticks_or_no_time_to_settle_is_refused() {
    let relocking = format!("{FILLED}{RELOCK}");
    refused(
        &replaced(&relocking, "interval = \"40 s\"", "interval = \"50 ms\""),
        "17:13",
        &[
            "a loop of 0.012 s does not settle within a switching interval of 0.05 s",
            "an interval of at least",
        ],
    );
    refused(
        &swept(&relocking, "switching.interval", "[\"50 ms\", \"40 s\"]"),
        "23:8",
        &["does not settle within a switching interval of 0.05 s"],
    );
    let slow = replaced(&relocking, "loop_time = \"12 ms\"", "loop_time = \"40 ms\"");
    let desk = Desk::with(&slow);
    desk.fails(
        "run study.toml --device cpu",
        3,
        &["37 % of the apparent angle of the relock comes after tick 4", "up to 8 ticks"],
    );
    refused(&format!("{BUDGET}{RELOCK}"), "11:1", &["[relock] needs fillers", "or leave [relock] out"]);
    refused(
        &replaced(&relocking, "[motion]", "relock = [\"20.3 arcsec\"]\n[motion]"),
        "6:10",
        &["gyro.relock conflicts with [relock]", "leave one of them out"],
    );
    refused(
        &format!("{relocking}compensation = \"both\"\n"),
        "21:16",
        &["accepted: none, frequency, detuning"],
    );
    refused(
        &swept(FILLED, "relock.adc_noise", "[0.001, 0.002]"),
        "16:7",
        &["relock.adc_noise is swept, but there is no [relock]"],
    );
}

#[test]
fn missing_tables_and_keys_are_named() {
    refused(
        &replaced(BUDGET, "interval = \"40 s\"\n", ""),
        "7:1",
        &["`switching.interval` is missing", "40 s"],
    );
    refused(&replaced(BUDGET, "duration = \"10 min\"\n", ""), "9:1", &["`run.duration` is missing", "1 h"]);
    refused(&replaced(BUDGET, "[run]\nduration = \"10 min\"\n", ""), "2:8", &["needs the table [run]"]);
    refused(
        &replaced(BUDGET, "[switching]\ninterval = \"40 s\"\n", ""),
        "2:8",
        &["needs the table [switching]"],
    );
}

#[test]
fn what_cannot_be_swept_is_said() {
    let sweep = |key: &str, list: &str| swept(BUDGET, key, list);
    refused(&sweep("run.trajectories", "[1, 2]"), "12:7", &["holds for the whole study", "run.duration"]);
    refused(&sweep("run.times", "[\"1 s\"]"), "12:7", &["run.times is a list"]);
    refused(&sweep("switching.first_mode", "[\"positive\"]"), "12:7", &["switching.first_mode is text"]);
}
