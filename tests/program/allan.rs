//! `sagnac allan` as a user meets it: tables, files and pictures of good logs.

use crate::desk::{Desk, Ended, Row, rows_of};
use crate::logs::{desk_with, log, noise, rows};
use serde_json::Value;

const PHASE: &str = include_str!("../../tests/data/allan/PHASE.DAT");

fn done(desk: &Desk, words: &str) -> Ended {
    let is_brief = ["--json", "--quiet", "--help"].iter().any(|option| words.contains(option));
    let words = format!("allan {words}");
    if is_brief { desk.done(&words) } else { desk.full(&words) }
}

fn curve(desk: &Desk, folder: &str) -> Vec<Row> {
    desk.table(&format!("{folder}/curve.csv"))
}

#[test]
fn a_stable32_file_gives_stable32s_numbers_in_table_csv_json_and_pictures() {
    let desk = desk_with("PHASE.DAT", PHASE);
    let words = "PHASE.DAT --data angle --unit none --rate 1Hz --deviation oadev,tdev --confidence 0.683 \
                 --intervals stable32";
    let ended = done(&desk, words);
    for piece in ["1001 samples at 1 Hz", "0.1057", "68.3 % intervals", "time deviation", "Curve minimum"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let curve_rows = curve(&desk, "results/PHASE");
    let row = curve_rows.iter().find(|row| row["deviation"] == "oadev" && row["m"] == "8").unwrap();
    assert_eq!(
        (row["differences"].as_str(), row["alpha"].as_str(), row["tau_s"].as_str()),
        ("985", "0", "8")
    );
    for (name, expected) in [("lower", 0.10038), ("value", 0.10570), ("upper", 0.11198)] {
        let found: f64 = row[name].parse().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-3, "{name}: {found}, not {expected}");
    }
    assert!(curve_rows.iter().filter(|row| row["m"] == "64").all(|row| row["alpha_from"] == "carried"));
    assert!(curve_rows.iter().all(|row| row["treatment"] == "no trend removed" && row["unit"].is_empty()));
    for name in ["chart.svg", "chart.png", "chart-tdev.svg", "chart-tdev.png"] {
        assert!(desk.path("results/PHASE").join(name).exists(), "{name}");
    }
    let document: Value = serde_json::from_str(&done(&desk, &format!("{words} --json")).stdout).unwrap();
    let point = &rows_of(&document, "curve")[3];
    assert_eq!((point["m"].as_u64(), point["differences"].as_u64()), (Some(8), Some(985)));
    // Without a time deviation its chart of before would be a lie.
    done(&desk, "PHASE.DAT --data angle --unit none --rate 1Hz --quiet");
    assert!(!desk.path("results/PHASE/chart-tdev.png").exists());
}

#[test]
fn the_header_of_the_csv_is_the_documented_one() {
    let desk = desk_with("log.csv", log());
    done(&desk, "log.csv --data rate --time time --column gz --out out");
    let header =
        "column,deviation,m,tau_s,differences,alpha,lower,value,upper,unit,alpha_from,treatment,edf,edf_from";
    assert_eq!(desk.read("out/curve.csv").lines().next(), Some(header));
}

#[test]
fn axes_times_and_units_come_from_the_header_and_the_rate_is_in_degrees_per_hour() {
    let desk = desk_with("log.csv", log());
    done(&desk, "log.csv --data rate --time time --column gx,gz --out out");
    let curve_rows = curve(&desk, "out");
    let value = |column: &str, m: &str| -> f64 {
        let row = curve_rows.iter().find(|row| row["column"] == column && row["m"] == m).unwrap();
        assert_eq!(row["unit"], "deg/h");
        row["value"].parse().unwrap()
    };
    assert!((value("gz", "4") / value("gx", "4") - 2.0).abs() < 1e-6);
    // Uniform noise in −1 … 1 °/s: 3600/√3 °/h.
    assert!((value("gx", "1") / (3600.0 / 3.0_f64.sqrt()) - 1.0).abs() < 0.2, "{}", value("gx", "1"));
    let svg = desk.read("out/chart.svg");
    for piece in [">gx<", ">gz<", "°/h", "95 % intervals", "log.csv: 200 samples at 100 Hz"] {
        assert!(svg.contains(piece), "{piece} is missing in the chart");
    }
}

#[test]
fn pulses_rates_and_angles_of_the_same_motion_give_the_same_curve() {
    let mut angle = 0.0;
    let increments: Vec<f64> = noise(200).map(|y| (10.0 * y).round()).collect();
    let text = |numbers: Vec<f64>| numbers.iter().map(|x| format!("{x}\n")).collect::<String>();
    let angles: Vec<f64> = std::iter::once(0.0)
        .chain(increments.iter().map(|y| {
            angle += 0.5 * y;
            angle
        }))
        .collect();
    let rates = increments.iter().map(|y| 50.0 * y).collect();
    let desk = desk_with("pulses.csv", text(increments));
    std::fs::write(desk.path("angles.csv"), text(angles)).unwrap();
    std::fs::write(desk.path("rates.csv"), text(rates)).unwrap();
    let curves = [
        "pulses.csv --data increment --scale 0.5arcsec/pulse",
        "angles.csv --data angle --unit arcsec",
        "rates.csv --data rate --unit arcsec/s",
    ]
    .map(|words| {
        done(&desk, &format!("{words} --rate 100Hz --deviation oadev,ohdev,mdev --out out"));
        curve(&desk, "out")
    });
    for (i, row) in curves[0].iter().enumerate() {
        for other in &curves[1..] {
            assert_eq!((&row["m"], &row["differences"]), (&other[i]["m"], &other[i]["differences"]));
            let [a, b] = [row, &other[i]].map(|row| row["value"].parse::<f64>().unwrap());
            assert!((a / b - 1.0).abs() < 1e-8, "{} at m = {}: {a} and {b}", row["deviation"], row["m"]);
        }
    }
}

#[test]
fn gaps_outliers_and_what_was_done_are_said() {
    let text = rows(|i, y| match i {
        30 => format!("{i},nan"),
        60 => format!("{i},99"),
        // 5 rows are not written.
        100.. => format!("{},{y}", i + 5),
        _ => format!("{i},{y}"),
    });
    let desk = desk_with("log.csv", format!("t [s],g [deg/h]\n{text}"));
    let kept = done(&desk, "log.csv --data rate --time t --skip 20s --until 3min --detrend linear");
    for piece in ["g: 6 of 160 samples are missing (3.8 %)", "1 outlier", "at 60 s: kept"] {
        assert!(kept.stderr.contains(piece), "{piece} is missing in\n{}", kept.stderr);
    }
    for piece in
        ["from 20 s; until 180 s", "linear trend was removed", "R is gone", "above τ = 16 s", "Removed trend"]
    {
        assert!(kept.stdout.contains(piece), "{piece} is missing in\n{}", kept.stdout);
    }
    let treatment = &curve(&desk, "results/log")[0]["treatment"];
    assert_eq!(treatment, "from 20 s; until 180 s; linear trend removed: no R, K too low");
    let removed = done(&desk, "log.csv --data rate --time t --remove-outliers");
    assert!(removed.stderr.contains("treated as gaps"), "{}", removed.stderr);
    let first = |ended: &Ended| {
        let mut lines = ended.stdout.lines().skip_while(|line| !line.contains("τ, s"));
        lines.nth(1).unwrap().split_whitespace().nth(3).unwrap().to_owned()
    };
    let [kept, removed]: [f64; 2] = [kept, removed].map(|ended| first(&ended).parse().unwrap());
    assert!(kept > 5.0 && removed < 1.0, "{kept} with the outlier, {removed} without");
}

#[test]
fn the_help_has_examples_and_says_what_is_read() {
    let help = done(&desk_with("a", ""), "--help").stdout;
    for piece in ["Examples:", "--scale", "decade10", "Stable32 .DAT", "Stable32"] {
        assert!(help.contains(piece), "{piece} is missing in\n{help}");
    }
}

#[test]
fn the_coefficients_of_white_noise_are_n_alone_in_the_units_of_data_sheets() {
    let text: String = noise(20_000).map(|y| format!("{y}\n")).collect();
    let desk = desk_with("rest.csv", text);
    let ended = done(&desk, "rest.csv --data rate --unit deg/h --rate 1Hz --out out");
    assert!(ended.stdout.contains("\nCoefficients\n"), "{}", ended.stdout);
    let rows = desk.table("out/coefficients.csv");
    let row = |name: &str| crate::desk::row(&rows, &[("coefficient", name)]);
    let number = |name: &str, column: &str| crate::desk::number(row(name), column);
    // 1/√3 °/h of white rate in samples of 1 s.
    let n = 1.0 / 3.0_f64.sqrt() / 60.0;
    assert_eq!((row("N")["unit"].as_str(), row("N")["status"].as_str()), ("deg/sqrt(h)", "estimated"));
    assert!(number("N", "lower") < n && n < number("N", "upper"), "{rows:?}");
    assert!((number("N", "value") / n - 1.0).abs() < 0.03, "{rows:?}");
    for other in ["Q", "B", "K", "R"] {
        assert!(row(other)["value"].is_empty() && row(other)["status"] != "estimated", "{rows:?}");
    }
    // White noise falls to an eighth of the record, so its minimum there is a bound.
    let curve_rows = curve(&desk, "out");
    let mut counted = curve_rows.iter().filter(|row| 8.0 * crate::desk::number(row, "m") <= 20_000.0);
    let last = counted.next_back().unwrap();
    let stability = row("in_run_bias_stability");
    assert!(stability["value"].is_empty() && stability["status"].contains("still falls"), "{stability:?}");
    assert_eq!(number("in_run_bias_stability", "upper"), crate::desk::number(last, "upper"));
    assert_eq!(number("in_run_bias_stability_tau", "value"), crate::desk::number(last, "tau_s"));

    done(&desk, "rest.csv --data rate --unit deg/h --rate 1Hz --out given --fit N,B");
    assert_eq!(desk.read("given/coefficients.csv").lines().count(), 1 + 2 + 2);
    done(&desk, "rest.csv --data rate --unit deg/h --rate 1Hz --out none --fit none");
    assert_eq!(desk.read("none/coefficients.csv").lines().count(), 1 + 2);
    desk.fails(
        "allan rest.csv --data rate --unit deg/h --rate 1Hz --fit Q,Z",
        2,
        &["`Z` is not a term", "auto, none, or some of Q,N,B,K,R,markov,sine"],
    );
}

#[test]
fn intervals_suppose_the_noise_of_the_record_or_that_of_stable32() {
    let text: String = noise(4096).map(|y| format!("{y}\n")).collect();
    let desk = desk_with("rest.csv", text);
    let rows_of = |words: &str| {
        done(&desk, &format!("rest.csv --data rate --unit deg/h --rate 1Hz --out out {words}"));
        curve(&desk, "out")
    };
    let edf = |row: &Row| row["edf"].parse::<f64>().unwrap();
    let (record, stable32) = (rows_of(""), rows_of("--intervals stable32"));
    assert!(record.iter().all(|row| row["edf_from"] == "model"));
    assert!(stable32.iter().all(|row| row["edf_from"] == "alpha"));
    // Exact for white noise at m = 1, where Greenhall's are 17 % more: (2N/3)(1 + …/N).
    assert!((edf(&record[0]) / (2.0 * 4096.0 / 3.0) - 1.0).abs() < 1e-3, "{:?}", record[0]);
    assert!(edf(&stable32[0]) / edf(&record[0]) > 1.1, "{:?}", stable32[0]);
    for (a, b) in record.iter().zip(&stable32) {
        assert_eq!((&a["value"], &a["alpha"]), (&b["value"], &b["alpha"]));
    }
}
