//! `sagnac allan --record`: the record as it is analysed, which is read again with the kind of its numbers alone.

use crate::desk::Desk;
use crate::logs::{desk_with, noise};

/// 4000 samples at 100 Hz in two columns, with gaps, outliers, a step, and a temperature on which the first column depends.
fn desk() -> Desk {
    // Nearly Gaussian.
    let others: Vec<f64> = noise(20_000).skip(4000).collect();
    let second: Vec<f64> = others.chunks(4).map(|four| four.iter().sum()).collect();
    let row = |(i, y): (usize, f64)| {
        let celsius = 20.0 + 5.0 * (i as f64 / 400.0).sin();
        let spike = if i % 1000 == 500 { 40.0 } else { 0.0 };
        let step = if i > 2500 { 1.5 } else { 0.0 };
        let first = if i % 700 == 3 { String::new() } else { (y + 0.5 * celsius + spike).to_string() };
        format!("{},{first},{},{celsius}\n", i as f64 * 0.01, second[i] + step)
    };
    let rows: String = noise(4000).enumerate().map(row).collect();
    desk_with("log.csv", format!("time_s,a,b,temp [degC]\n{rows}"))
}

/// Analyses the log, writes the record, and expects the same curve of the record, apart from the words on its treatment.
fn same_curve(desk: &Desk, words: &str, kind: &str, treatment: &str) {
    // There may be one of an earlier call.
    let _ = std::fs::remove_file(desk.path("again.csv"));
    desk.done(&format!("allan log.csv --data {kind} --bootstrap 0 --record again.csv --out log {words}"));
    desk.done(&format!("allan again.csv --data {kind} --bootstrap 0 --out again"));
    let [log, again] = ["log", "again"].map(|folder| desk.read(&format!("{folder}/curve.csv")));
    assert!(log.contains(treatment), "{words}: {log}");
    assert_eq!(log.replace(treatment, ""), again, "{words}");
}

#[test]
fn a_record_as_it_is_analysed_gives_the_curve_of_its_log() {
    let desk = desk();
    for (words, kind, treatment) in [
        (
            "--unit deg/h --column a,b --temperature temp --compensate --remove-outliers",
            "rate",
            "outliers removed; temperature compensated; ",
        ),
        ("--unit mg --column a --temperature temp --compensate", "rate", "temperature compensated; "),
        ("--scale 0.5arcsec/pulse --column a,b --remove-outliers", "increment", "outliers removed; "),
        ("--unit none --column b --temperature temp --compensate", "angle", "temperature compensated; "),
        ("--unit deg/h --column a", "rate", ""),
    ] {
        same_curve(&desk, words, kind, treatment);
    }
    let record = desk.read("again.csv");
    let mut lines = record.lines();
    assert_eq!(lines.next(), Some("time_s,a [deg/h]"));
    assert_eq!(lines.nth(3), Some("0.03,"), "a missing sample is an empty cell");
    assert_eq!(lines.count(), 3996);
}

#[test]
fn a_record_without_events_has_none() {
    let desk = desk();
    let words = "--data rate --bootstrap 0";
    desk.done(&format!(
        "allan log.csv --unit deg/h --column b --remove-events --record again.csv --out log {words}"
    ));
    desk.done(&format!("allan again.csv --out again {words}"));
    assert!(desk.read("log/events.csv").contains(",step,"));
    assert!(!desk.read("again/events.csv").contains(",step,"), "{}", desk.read("again/events.csv"));
    desk.done(&format!(
        "allan log.csv --unit deg/h --column a --temperature temp --remove-events --out spikes {words}"
    ));
    let outliers: Vec<String> = desk
        .table("spikes/events.csv")
        .iter()
        .filter(|row| row["event"] == "outlier")
        .map(|row| row["done"].clone())
        .collect();
    assert_eq!(outliers, ["removed"; 4]);
    // Sums of rates are rounded, so values are the same to nine digits, as files have them.
    let curves = ["log", "again"].map(|folder| desk.table(&format!("{folder}/curve.csv")));
    for (log, again) in curves[0].iter().zip(&curves[1]) {
        assert_eq!((&log["m"], &log["value"]), (&again["m"], &again["value"]));
    }
    assert_eq!(curves[0].len(), curves[1].len());
}

#[test]
fn a_record_never_replaces_a_log_and_is_refused_where_it_cannot_be_written() {
    let desk = desk();
    let before = desk.read("log.csv");
    for (words, pieces) in [
        ("log.csv --data rate --record log.csv", ["--record log.csv would replace a file", "another FILE"]),
        ("log.csv --data rate --record ./results/../log.csv", ["would replace a file", "another FILE"]),
        ("log.csv log.csv --data rate --record again.csv", ["--record names one file", "one by one"]),
        (
            "log.csv --data angle --remove-outliers --record again.csv",
            ["angles of which increments are missing", "leave out --remove-outliers"],
        ),
    ] {
        std::fs::create_dir_all(desk.path("results")).unwrap();
        desk.fails(&format!("allan {words} --unit none --column a"), 2, &pieces);
    }
    assert_eq!(desk.read("log.csv"), before);
    assert!(!desk.path("again.csv").exists());
}
