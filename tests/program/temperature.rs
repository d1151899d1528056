//! `--temperature` and `--compensate`: files, report, JSON, all commands on logs, and what is refused.

use serde_json::Value;

use crate::desk::{Desk, Row, fact_of, number, row, rows_of, table};
use crate::logs::{desk_with, noise};

/// 4000 samples of 1 s in °/h with 0.5 °/h/K, `temp` of a unit, and a second column without dependence.
fn log(header: &str, temperature: impl Fn(f64) -> f64) -> Desk {
    let mut others: Vec<f64> = noise(8000).collect();
    let second = others.split_off(4000);
    let row = |(i, (a, b)): (usize, (&f64, &f64))| {
        let celsius = 20.0 + 5.0 * (i as f64 / 400.0).sin();
        format!("{i},{},{b},{}\n", a + 0.5 * celsius, temperature(celsius))
    };
    let rows: String = others.iter().zip(&second).enumerate().map(row).collect();
    desk_with("log.csv", format!("{header}\n{rows}"))
}

const WORDS: &str = "allan log.csv --data rate --unit deg/h --bootstrap 0 --out out";

#[test]
fn coefficients_and_compensation_are_in_files_charts_report_and_json() {
    let desk = log("time_s,gx,gy,temp [degC]", |celsius| celsius);
    let words = format!("{WORDS} --column gx,gy --temperature temp");
    let ended = desk.full(&words);
    for piece in ["15 to 25 °C", "°/h/K", "before compensation"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let rows = desk.table("out/temperature.csv");
    let of = |column: &str, name: &str| row(&rows, &[("column", column), ("coefficient", name)]);
    let c1 = of("gx", "T");
    assert_eq!((c1["status"].as_str(), c1["unit"].as_str()), ("estimated", "deg/h/K"));
    assert!(number(c1, "lower") < 0.5 && 0.5 < number(c1, "upper"), "{c1:?}");
    assert!((number(c1, "value") - 0.5).abs() < 0.05, "{c1:?}");
    assert!(number(of("gy", "T"), "lower") < 0.0, "{:?}", of("gy", "T"));
    let compensation = desk.table("out/compensation.csv");
    let of_gx: Vec<_> = compensation.iter().filter(|row| row["column"] == "gx").collect();
    let [first, last] = [of_gx[0], of_gx[of_gx.len() - 1]];
    assert!((number(first, "temperature") - 15.0).abs() < 1e-3, "{first:?}");
    assert!((number(last, "rate") - number(first, "rate") - 5.0).abs() < 0.5, "{first:?} to {last:?}");
    for stem in ["chart-temperature", "chart-rate"] {
        assert!(desk.read(&format!("out/{stem}.svg")).contains("<svg"), "{stem}");
    }
    let document: Value = serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap();
    assert_eq!(rows_of(&document, "temperature")[2]["coefficient"], "T");
    assert_eq!(rows_of(&document, "compensation").len(), compensation.len());
    assert_eq!(rows_of(&document, "curve")[0]["treatment"], "no trend removed");
    // Gyros and accelerometers have a chart each.
    desk.done(&format!("{} --column gx,gy --temperature temp", WORDS.replace("deg/h", "deg/h,mg")));
    for (stem, unit, [own, other]) in [
        ("chart-temperature", "°/h", ["gx", "gy"]),
        ("chart-temperature-accelerometers", "µg", ["gy", "gx"]),
        ("chart-rate", "rate, °/h", ["gx", "gy"]),
        ("chart-rate-accelerometers", "acceleration, µg", ["gy", "gx"]),
    ] {
        let svg = desk.read(&format!("out/{stem}.svg"));
        assert!(svg.contains(unit) && svg.contains(&format!(">{own}<")), "{stem} lacks {unit} or {own}");
        assert!(!svg.contains(&format!(">{other}<")), "{stem} has {other}");
    }
    // Without a temperature the charts of before would be wrong.
    desk.done(&format!("{WORDS} --column gx"));
    assert!(!desk.path("out/chart-temperature.svg").exists());
    assert!(!desk.path("out/chart-rate-accelerometers.png").exists());
}

#[test]
fn results_are_those_of_the_record_unless_it_is_to_be_compensated() {
    let desk = log("time_s,gx,gy,temp [degC]", |celsius| celsius);
    desk.done(&format!("{WORDS} --column gx"));
    let raw = desk.read("out/curve.csv");
    desk.done(&format!("{WORDS} --column gx --temperature temp"));
    assert_eq!(desk.read("out/curve.csv"), raw);
    desk.done(&format!("{WORDS} --column gx --temperature temp --compensate"));
    let rows = desk.table("out/curve.csv");
    assert!(
        rows.iter().all(|row| row["treatment"] == "temperature compensated; no trend removed"),
        "{rows:?}"
    );
    let [before, after] = [table(&raw), rows].map(|rows| number(row(&rows, &[("m", "512")]), "value"));
    assert!(after < 0.1 * before, "{after} after {before}");
}

#[test]
fn units_of_the_temperature_are_those_of_the_header_or_the_option() {
    for (header, option, of_celsius) in [
        ("temp_K", "", (|celsius| celsius + 273.15) as fn(f64) -> f64),
        ("temp (°F)", "", |celsius| 1.8 * celsius + 32.0),
        ("T", " --temperature-unit K", |celsius| celsius + 273.15),
        ("t", "", |celsius| celsius),
    ] {
        let desk = log(&format!("time_s,gx,gy,{header}"), of_celsius);
        let ended = desk.full(&format!("{WORDS} --column gx --temperature 4{option}"));
        assert!(ended.stdout.contains("15 to 25 °C"), "{header}:\n{}", ended.stdout);
        assert_eq!(
            ended.stderr.contains("is taken to be in °C"),
            header == "t",
            "{header}:\n{}",
            ended.stderr
        );
    }
}

#[test]
fn a_wrong_temperature_is_refused_with_what_is_accepted() {
    let desk = log("time_s,gx,gy,temp [volts]", |celsius| celsius);
    for (words, code, pieces) in [
        ("--temperature temp", 3, ["`volts` is not a unit of temperature", "--temperature-unit K"]),
        ("--temperature tempp", 3, ["no column is called `tempp`", "did you mean `temp`"]),
        (
            "--temperature gx --temperature-unit C",
            3,
            ["the column of the temperature is requested as samples", "name each column once"],
        ),
        ("--temperature temp --temperature-terms T2", 2, ["T2 needs T", "T,T2"]),
        ("--temperature temp --temperature-terms T,x", 2, ["`x` is not a term", "warm-up"]),
        ("--compensate", 2, ["--temperature", "required"]),
    ] {
        desk.fails(&format!("{WORDS} --column gx {words}"), code, &pieces);
    }
    for command in ["compare log.csv log.csv", "compare log.csv", "model log.csv"] {
        let words = format!("{command} --data rate --unit deg/h --column gx,gy --temperature temp");
        desk.fails(&words, 2, &["--temperature without --compensate", "give --compensate too"]);
    }
}

/// The log with a second file, `clean.csv`, of the same record without its dependence.
fn log_and_clean() -> Desk {
    let desk = log("time_s,gx,gy,temp [degC]", |celsius| celsius);
    let clean = |row: Row| {
        let of = |name: &str| number(&row, name);
        let gx = of("gx") - 0.5 * of("temp [degC]");
        format!("{},{gx},{},{}\n", of("time_s"), of("gy"), of("temp [degC]"))
    };
    let rows: String = desk.table("log.csv").into_iter().map(clean).collect();
    desk.write("clean.csv", &format!("time_s,gx,gy,temp [degC]\n{rows}"));
    desk
}

const READ: &str = "--data rate --unit deg/h --column gx";
const COMPENSATE: &str = "--temperature temp --compensate";

/// The share of rows whose value lies within the interval that another table has at the same place.
fn share_within(values: &[Row], value: &str, intervals: &[Row]) -> f64 {
    assert_eq!(values.len(), intervals.len());
    let pairs = values.iter().zip(intervals).filter(|(_, interval)| !interval["lower"].is_empty());
    let is_within = |(row, interval): (&Row, &Row)| {
        (number(interval, "lower")..=number(interval, "upper")).contains(&number(row, value))
    };
    let within: Vec<bool> = pairs.map(is_within).collect();
    assert!(within.len() > 10, "{} rows have an interval", within.len());
    within.iter().filter(|is| **is).count() as f64 / within.len() as f64
}

#[test]
fn compensated_spectra_and_models_are_those_of_the_record_without_the_dependence() {
    let desk = log_and_clean();
    for (command, table, value) in [
        ("allan", "psd.csv", "density"),
        // Of models the record, from which events are removed.
        ("model", "model.csv", "record"),
    ] {
        let of = |words: &str| {
            let bound = if command == "model" { " --overbound" } else { "" };
            let ended = desk.full(&format!("{command} {words} {READ}{bound} --out out"));
            (ended.stdout, desk.table(&format!("out/{table}")))
        };
        let (clean, (said, rows)) = (of("clean.csv").1, of(&format!("log.csv {COMPENSATE}")));
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("temperature compensated"), "{command}:\n{said}");
        let share = share_within(&rows, value, &clean);
        assert_eq!(share, 1.0, "{command}: share of 95 % intervals of the clean record around its values");
    }
    // The spectrum of the record as it is is another one at the lowest frequency.
    desk.done(&format!("allan log.csv {READ} --out raw --segment 2000s"));
    desk.done(&format!("allan clean.csv {READ} --out clean --segment 2000s"));
    let [raw, clean] = ["raw/psd.csv", "clean/psd.csv"].map(|name| number(&desk.table(name)[0], "density"));
    assert!(raw > 100.0 * clean, "{raw} beside {clean}");
}

#[test]
fn compensated_logs_are_compared_and_pooled_as_records_without_the_dependence() {
    let desk = log_and_clean();
    let words = format!("log.csv clean.csv {READ} {COMPENSATE} --json --out out");
    let document = |command: &str| -> Value {
        serde_json::from_str(&desk.done(&format!("{command} {words}")).stdout).unwrap()
    };
    let compared = document("compare");
    assert!(compared["question"].as_str().unwrap().ends_with("Temperature compensated; no trend removed"));
    assert!(fact_of(&compared, "test")["p"].as_f64().unwrap() > 0.5, "{compared:#}");
    for row in desk.table("out/compare.csv") {
        assert!(number(&row, "lower") < 1.0 && 1.0 < number(&row, "upper"), "{row:?}");
    }
    // Both have the in-run bias stability of the batch, or neither shows one.
    let words = format!("log.csv clean.csv {READ} {COMPENSATE} --out out");
    // The former name takes two logs as a batch.
    desk.done(&format!("lot {words}"));
    assert!(desk.read("out/report.html").contains("temperature compensated"));
    let units = desk.table("out/units.csv");
    for name in ["N", "in_run_bias_stability"] {
        let of = |label: &str| row(&units, &[("label", label), ("coefficient", name)]);
        let [log, clean] = ["log", "clean"].map(of);
        let ratio = number(log, "upper") / number(clean, "upper");
        assert!((ratio - 1.0).abs() < 0.1, "{name}: {log:?} beside {clean:?}");
    }
}

#[test]
fn a_record_without_a_dependence_stays_as_it_is_and_every_command_says_so() {
    let desk = log("time_s,gx,gy,temp [degC]", |_| 20.0);
    for (command, of_column) in
        [("allan log.csv", ""), ("compare log.csv log.csv", "log"), ("model log.csv --overbound", "")]
    {
        let column = if of_column.is_empty() { "gx" } else { "gx,gy" };
        let read = READ.replace("gx", column);
        let ended = desk.full(&format!("{command} {read} {COMPENSATE} --out out"));
        let note = "gx: no temperature coefficients, and no compensation: not estimable";
        assert!(ended.stderr.contains(note), "{command}:\n{}", ended.stderr);
        assert!(!ended.stdout.contains("temperature compensated"), "{command}:\n{}", ended.stdout);
    }
}
