//! What a record shows besides noise heads the output of every command that reads a log, and its page.

use serde_json::Value;

use crate::desk::{Desk, rows_of};
use crate::logs::{desk_with, noise};

const READ: &str = "--data rate --unit deg/h --rate 100Hz";

/// White noise with a sine of 20 Hz.
fn with_line() -> String {
    let numbers: Vec<f64> = noise(12 * 8192).collect();
    let sums = numbers.chunks(12).map(|chunk| chunk.iter().sum::<f64>());
    sums.enumerate()
        .map(|(i, y)| format!("{}\n", y + (0.4 * std::f64::consts::PI * i as f64).sin()))
        .collect()
}

fn document(desk: &Desk, words: &str) -> Value {
    serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap()
}

/// The events of a record by its name, without single gaps and outliers.
fn events<'d>(document: &'d Value, record: &str) -> Vec<&'d Value> {
    let is_event =
        |row: &&Value| row["column"] == record && row["event"] != "gap" && row["event"] != "outlier";
    rows_of(document, "events").iter().filter(is_event).collect()
}

/// The kinds of the events of a record, with what was done with them.
fn kinds<'d>(document: &'d Value, record: &str) -> Vec<[&'d str; 2]> {
    let rows = events(document, record).into_iter();
    rows.map(|row| [row["event"].as_str().unwrap(), row["done"].as_str().unwrap()]).collect()
}

#[test]
fn model_and_allan_list_the_events_of_a_record_in_text_json_and_page() {
    let desk = desk_with("gyro.csv", with_line());
    for (command, folder, done) in [
        ("allan gyro.csv --bootstrap 0", "gyro", "subtracted for the fit"),
        ("model gyro.csv --overbound", "gyro_model", "removed"),
    ] {
        let words = format!("{command} {READ}");
        let text = desk.full(&words).stdout;
        assert!(text.contains("What this record shows\n") && text.contains(done), "{command}: {text}");
        let page = desk.read(&format!("results/{folder}/report.html"));
        assert!(page.contains("<h2>What this record shows</h2>"), "{command}");
        let found = document(&desk, &words);
        assert_eq!(kinds(&found, "1"), [["line", done]], "{command}");
    }
}

#[test]
fn what_is_removed_has_no_option_that_removes_it() {
    let desk = desk_with("gyro.csv", with_line());
    let words = format!("allan gyro.csv {READ} --bootstrap 0");
    let option = |more: &str| events(&document(&desk, &format!("{words} {more}")), "1")[0]["option"].clone();
    assert_eq!(option(""), "--remove-events");
    assert_eq!(option("--remove-events"), Value::Null);
}

#[test]
fn a_record_given_twice_is_noted_with_the_name_of_the_first() {
    let desk = desk_with("a.csv", with_line());
    desk.write("b.csv", &with_line());
    let found = document(&desk, &format!("allan a.csv b.csv {READ} --bootstrap 0"));
    assert_eq!(kinds(&found[0], "1")[0][0], "line");
    let other = &events(&found[1], "1")[0]["other"];
    assert_eq!((kinds(&found[1], "1")[0], other), (["same record", "noted"], &"a.csv 1".into()));

    let words = format!("compare a.csv b.csv {READ}");
    let found = document(&desk, &words);
    assert_eq!(kinds(&found, "a"), [["line", "removed"]]);
    assert_eq!(kinds(&found, "b"), [["same record", "noted"], ["line", "removed"]]);
    let text = desk.full(&words).stdout;
    let list = text.split("\nWhat these records show\n").nth(1).unwrap();
    let rows: Vec<Vec<&str>> =
        list.lines().skip(1).take(3).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<&str>>(), ["a", "b", "b"], "{text}");
    let page = desk.read("results/a_vs_b/report.html");
    assert!(page.contains("<h2>What these records show</h2>"));
}

#[test]
fn lines_that_only_a_noise_burst_makes_are_none_and_its_samples_count_as_missing() {
    let numbers: Vec<f64> = noise(12 * 16_384).collect();
    let sums = numbers.chunks(12).map(|chunk| chunk.iter().sum::<f64>());
    let louder = |i: usize| if (4000..6000).contains(&i) { 10.0 } else { 1.0 };
    let text = sums.enumerate().map(|(i, y)| format!("{}\n", louder(i) * y)).collect::<String>();
    let desk = desk_with("gyro.csv", text);
    let spectrum = document(&desk, &format!("allan gyro.csv {READ} --bootstrap 0"));
    assert_eq!(kinds(&spectrum, "1"), [["noise burst", "left out of the fit"]]);
    assert!(rows_of(&spectrum, "lines").is_empty());

    let missing = |more: &str| {
        let found = document(&desk, &format!("allan gyro.csv {READ} --bootstrap 0 {more}"));
        rows_of(&found, "records")[0]["missing"].as_u64().unwrap()
    };
    let removed = missing("--remove-events");
    assert!(missing("") == 0 && removed.abs_diff(2000) < 100, "{removed}");
}

#[test]
fn every_event_of_the_reference_is_explained() {
    let reference = include_str!("../../docs/reference/log-formats.md");
    let table = reference.split("| event | found by | in the fit |\n|---|---|---|\n").nth(1).unwrap();
    let names = table.lines().take_while(|line| line.starts_with('|'));
    let names: Vec<&str> =
        names.flat_map(|line| line.split('|').nth(1).unwrap().trim().split(", ")).collect();
    assert_eq!(names.len(), 13, "{names:?}");
    let glossary = include_str!("../../cli/src/explain/glossary.txt");
    let explained = glossary.split("\n\n").filter(|entry| entry.contains("\n    Event of a log"));
    let explained: Vec<&str> =
        explained.flat_map(|entry| entry.lines().next().unwrap().split(", ")).collect();
    assert_eq!(names, explained);
}
