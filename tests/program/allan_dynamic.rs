//! `sagnac allan --dynamic`: the deviation over time, and a change that is named.

use crate::desk::{Desk, number, row, rows_of};
use crate::logs::desk_with;
use crate::noise::white;
use serde_json::Value;

const READ: &str = "allan log.csv --data rate --unit deg/h --rate 1Hz --bootstrap 0";

/// White rates of 6 °/h, after 5000 of 8192 samples of `factor` times as much, without those from 1000 to 1600.
fn log(factor: f64) -> Desk {
    let row = |(i, rate): (usize, &f64)| match i {
        1000..1600 => "nan\n".to_owned(),
        ..5000 => format!("{rate:.6}\n"),
        _ => format!("{:.6}\n", factor * rate),
    };
    desk_with("log.csv", white(8192, 6.0, 3).iter().enumerate().map(row).collect::<String>())
}

#[test]
fn a_step_of_n_is_named_with_its_time_and_windows_within_a_gap_are_blank() {
    let desk = log(1.3);
    let ended = desk.full(&format!("{READ} --dynamic 512s"));
    // 6 °/h in samples of 1 s are 0.1 °/√h.
    assert!(ended.stdout.contains("N changes: 0.1"), "{}", ended.stdout);
    let windows = desk.table("results/log/dynamic.csv");
    // Windows of 512 samples every 256, each with the octaves up to a quarter.
    assert_eq!(windows.len(), 31 * 8);
    let at = |start: &str| row(&windows, &[("start_s", start), ("tau_s", "1")]);
    assert!((number(at("0"), "value") / 6.0 - 1.0).abs() < 0.1, "{:?}", at("0"));
    assert!((number(at("7168"), "value") / 7.8 - 1.0).abs() < 0.1, "{:?}", at("7168"));
    let within = at("1024");
    assert!(within["value"].is_empty() && within["upper"].is_empty(), "{within:?}");
    let tests = desk.table("results/log/stationarity.csv");
    assert!(
        number(&tests[0], "p") < 1e-6 && (number(&tests[0], "at_s") - 5000.0).abs() < 400.0,
        "{:?}",
        tests[0]
    );
    // Parts have 128 samples: four are within the gap, and one loses half of its samples.
    assert_eq!(tests[0]["parts"], "59");
    for chart in
        ["chart-dynamic.svg", "chart-dynamic.png", "chart-dynamic-ratio.svg", "chart-dynamic-ratio.png"]
    {
        assert!(desk.path(&format!("results/log/{chart}")).is_file(), "{chart} is missing");
    }
    // A chart that somebody else put there.
    desk.write("results/log/chart-dynamic-3.svg", "");
    desk.done(READ);
    for name in ["dynamic.csv", "stationarity.csv", "chart-dynamic.svg", "chart-dynamic-ratio.png"] {
        assert!(!desk.path(&format!("results/log/{name}")).exists(), "{name} of the earlier run is left");
    }
}

#[test]
fn a_record_without_a_change_tells_the_step_that_it_would_have_shown() {
    let desk = log(1.0);
    let ended = desk.done(&format!("{READ} --json --dynamic"));
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let window = &rows_of(&document, "dynamic")[0];
    assert_eq!(window["end_s"].as_f64().unwrap() - window["start_s"].as_f64().unwrap(), 512.0);
    let page = desk.read("results/log/report.html");
    assert!(page.contains("no change seen (p = ") && page.contains("a step of N by"), "{page}");
    let visible = rows_of(&document, "stationarity")[0]["visible"].as_f64().unwrap();
    assert!((0.02..0.15).contains(&visible), "{visible}");
}

#[test]
fn windows_that_show_nothing_are_refused_with_those_that_do() {
    let desk = log(1.0);
    for (window, pieces) in [
        ("20s", ["it has 20 samples and needs 64", "--dynamic 64s"]),
        ("2h", ["too long for a record of 8192 s", "--dynamic 4096s"]),
    ] {
        desk.fails(&format!("{READ} --dynamic {window}"), 3, &pieces);
        assert!(!desk.path("results").exists(), "--dynamic {window} left results");
    }
    desk.fails(&format!("{READ} --dynamic fast"), 2, &["--dynamic", "a time in s, ms"]);
}
