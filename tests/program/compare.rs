//! `sagnac compare` as a user meets it: tables, files, pictures and sentences, and what it refuses.

use crate::desk::{Desk, Ended, fact_of, number, rows_of, unwrapped};
use crate::logs::desk_with;
use crate::noise::white;
use serde_json::Value;

const RATE: &str = "--data rate --unit deg/h --rate 1Hz";

fn lines(rates: &[f64]) -> String {
    rates.iter().map(|rate| format!("{rate:.6}\n")).collect()
}

/// Two logs a.csv and b.csv.
fn two(a: impl AsRef<[u8]>, b: impl AsRef<[u8]>) -> Desk {
    let desk = desk_with("a.csv", a);
    std::fs::write(desk.path("b.csv"), b).unwrap();
    desk
}

fn done(desk: &Desk, words: &str) -> Ended {
    let is_brief = ["--json", "--quiet", "--help"].iter().any(|option| words.contains(option));
    let words = format!("compare {words}");
    if is_brief { desk.done(&words) } else { desk.full(&words) }
}

fn refused(desk: &Desk, words: &str, code: i32, pieces: &[&str]) {
    desk.fails(&format!("compare {words}"), code, pieces);
    assert!(!desk.path("results").exists(), "compare {words} left results");
}

#[test]
fn half_the_noise_is_found_in_table_csv_json_answer_and_pictures() {
    let desk = two(lines(&white(4096, 6.0, 1)), lines(&white(4096, 3.0, 2)));
    let ended = done(&desk, &format!("a.csv b.csv {RATE}"));
    for piece in [
        "a.csv, 1: 4096 samples at 1 Hz, 68 min · b.csv, 1: 4096",
        "no trend was removed",
        "ratio",
        "lower",
        "b has 0.49",
        "Test of equality  p < 1e-12, ",
        "results/a_vs_b",
    ] {
        let said = format!("{}{}", ended.stdout, ended.stderr);
        assert!(said.contains(piece), "{piece} is missing in\n{said}");
    }
    let ratios = desk.table("results/a_vs_b/compare.csv");
    assert_eq!(ratios.len(), 12);
    assert_eq!(
        (ratios[3]["tau_s"].as_str(), ratios[3]["m_a"].as_str(), ratios[3]["m_b"].as_str()),
        ("8", "8", "8")
    );
    assert!(number(&ratios[0], "lower") < 0.5 && number(&ratios[0], "upper") > 0.5, "{:?}", ratios[0]);
    assert_eq!((ratios[0]["unit"].as_str(), ratios[0]["status"].as_str()), ("deg/h", "b lower"));
    let coefficients = desk.table("results/a_vs_b/coefficients.csv");
    let n = &coefficients[0];
    assert_eq!(
        (n["coefficient"].as_str(), n["unit"].as_str(), n["status"].as_str()),
        ("N", "deg/sqrt(h)", "b lower")
    );
    assert_eq!((n["log_a"].as_str(), n["log_b"].as_str(), n["described"].as_str()), ("a", "b", "both"));
    // 6 °/h in samples of 1 s are 0.1 °/√h.
    assert!(
        (number(n, "a") / 0.1 - 1.0).abs() < 0.05 && (number(n, "ratio") / 0.5 - 1.0).abs() < 0.1,
        "{n:?}"
    );
    let [low, high] = ["lower", "upper"].map(|end| number(n, end));
    assert!(low < -0.05 && -0.05 < high && high < 0.0, "{n:?}");
    assert!(number(n, "p") < 1e-12 && number(n, "length_needed_s") < 4096.0, "{n:?}");
    for (name, piece) in [
        ("chart-1.svg", ">a<"),
        ("chart-1.svg", ">b<"),
        ("chart-2.svg", "equal"),
        ("chart-2.svg", "ratio of the fits"),
        ("chart-2.svg", "b / a"),
    ] {
        assert!(desk.read(&format!("results/a_vs_b/{name}")).contains(piece), "{piece} is missing in {name}");
    }
    for name in ["chart-1.png", "chart-2.png"] {
        assert!(desk.path("results/a_vs_b").join(name).exists(), "{name}");
    }
    let document: Value =
        serde_json::from_str(&done(&desk, &format!("a.csv b.csv {RATE} --json")).stdout).unwrap();
    assert_eq!(rows_of(&document, "records")[1]["samples"], 4096);
    assert!(
        (rows_of(&document, "coefficients")[0]["a"].as_f64().unwrap() / number(n, "a") - 1.0).abs() < 1e-8
    );
    assert_eq!(rows_of(&document, "compare").len(), 12);
    assert_eq!(fact_of(&document, "test")["name"], "Test of equality");
}

#[test]
fn the_headers_of_the_files_are_the_documented_ones() {
    let desk = two(lines(&white(200, 1.0, 1)), lines(&white(200, 1.0, 2)));
    done(&desk, &format!("a.csv b.csv {RATE} --out out --quiet"));
    let header = |name: &str| desk.read(name).lines().next().unwrap().to_owned();
    assert_eq!(header("out/compare.csv"), "tau_s,m_a,m_b,a,b,ratio,lower,upper,unit,p,status,log_a,log_b");
    assert_eq!(
        header("out/coefficients.csv"),
        "coefficient,unit,a,b,difference,lower,upper,p,length_needed_s,status,ratio,ratio_lower,ratio_upper,\
         a_at_most,b_at_most,length_beyond_s,described,log_a,log_b"
    );
}

#[test]
fn equal_noise_is_not_told_apart_and_the_length_that_would_is_named() {
    let desk = two(lines(&white(4096, 6.0, 1)), lines(&white(2048, 6.0, 2)));
    let ended = done(&desk, &format!("a.csv b.csv {RATE}"));
    for piece in ["Test of equality  p = 0.", "No significant difference: N ratio", "To decide"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let n = &desk.table("results/a_vs_b/coefficients.csv")[0];
    assert_eq!(n["status"], "consistent");
    assert!(number(n, "p") > 0.05 && number(n, "lower") < 0.0 && number(n, "upper") > 0.0, "{n:?}");
    let length =
        ["length_needed_s", "length_beyond_s"].into_iter().find_map(|name| n[name].parse::<f64>().ok());
    assert!(length.unwrap() > 4096.0, "{n:?}");
}

#[test]
fn one_record_twice_is_said_to_be_one() {
    let desk = two(lines(&white(4096, 6.0, 1)), "");
    let ended = done(&desk, &format!("a.csv a.csv {RATE}"));
    assert!(ended.stdout.contains("A and B are one record"), "{}", ended.stdout);
    for row in desk.table("results/a_vs_a/compare.csv") {
        assert_eq!((row["ratio"].as_str(), row["p"].as_str()), ("1", "1"), "{row:?}");
    }
    let n = &desk.table("results/a_vs_a/coefficients.csv")[0];
    assert_eq!((n["p"].as_str(), n["difference"].as_str(), n["status"].as_str()), ("1", "0", "equal"));
    assert!(n["length_needed_s"].is_empty() && n["length_beyond_s"].is_empty(), "{n:?}");
}

#[test]
fn two_columns_of_one_log_are_called_by_their_names() {
    let (x, y) = (white(4096, 1.0, 1), white(4096, 2.0, 2));
    let text: String = x.iter().zip(&y).map(|(x, y)| format!("{x},{y}\n")).collect();
    let desk = desk_with("log.csv", format!("gx [deg/h],gy [deg/h]\n{text}"));
    let ended = done(&desk, "log.csv log.csv --data rate --rate 1Hz --column gx,gy");
    assert!(ended.stdout.contains("log gy is 97 % noisier in N ("), "{}", ended.stdout);
    // One name holds for both.
    let ended = done(&desk, "log.csv log.csv --data rate --rate 1Hz --column gy");
    assert!(ended.stdout.contains("are one record"), "{}", ended.stdout);
}

#[test]
fn logs_at_other_rates_meet_at_the_times_that_both_have() {
    let stamped = |step: f64, rates: &[f64]| -> String {
        let rows: String =
            rates.iter().enumerate().map(|(i, y)| format!("{:.4},{y}\n", step * i as f64)).collect();
        format!("t [s],g [deg/h]\n{rows}")
    };
    // The same white noise: a tenth of the step has √10 of the standard deviation.
    let desk = two(stamped(0.1, &white(20_000, 10.0_f64.sqrt(), 1)), stamped(1.0, &white(2000, 1.0, 2)));
    let ended = done(&desk, "a.csv b.csv --data rate --time t");
    assert!(ended.stdout.contains("No significant difference: "), "{}", ended.stdout);
    let rows = desk.table("results/a_vs_b/compare.csv");
    assert_eq!(
        (rows[0]["tau_s"].as_str(), rows[0]["m_a"].as_str(), rows[0]["m_b"].as_str()),
        ("1", "10", "1")
    );
    assert_eq!((rows[9]["m_a"].as_str(), rows[9]["m_b"].as_str(), rows.len()), ("5120", "512", 10));
    // Times that are no multiples of each other.
    std::fs::write(desk.path("b.csv"), stamped(0.73, &white(2000, (1.0_f64 / 0.73).sqrt(), 2))).unwrap();
    let ended = done(&desk, "a.csv b.csv --data rate --time t");
    for piece in ["averaging times of the records are up to", "% apart"] {
        assert!(ended.stderr.contains(piece), "{piece} is missing in\n{}", ended.stderr);
    }
    // And none in common.
    std::fs::write(desk.path("b.csv"), stamped(5000.0, &white(50, 1.0, 2))).unwrap();
    std::fs::remove_dir_all(desk.path("results")).unwrap();
    refused(
        &desk,
        "a.csv b.csv --data rate --time t",
        3,
        &["no averaging time in common", "steps of 0.1 s up to τ = 1000 s", "5000 s"],
    );
}

#[test]
fn gaps_and_outliers_are_said_and_no_fit_leaves_the_curves() {
    let mut rates = white(2000, 1.0, 1);
    rates[700] = 50.0;
    let a = lines(&rates).replacen(&format!("{:.6}\n", rates[300]), "nan\n", 1);
    let desk = two(a, lines(&white(2000, 1.0, 2)));
    let ended = done(&desk, &format!("a.csv b.csv {RATE} --fit none --remove-outliers"));
    for piece in ["a: 2 of 2000 samples are missing", "a: 1 outlier", "treated as gaps"] {
        assert!(ended.stderr.contains(piece), "{piece} is missing in\n{}", ended.stderr);
    }
    assert!(
        ended.stdout.contains("Test of equality  p = ") && ended.stdout.contains(", 10 averaging times"),
        "{}",
        ended.stdout
    );
    assert!(desk.table("results/a_vs_b/coefficients.csv").is_empty());
    // Terms that were given are there whether or not the records show them.
    std::fs::write(desk.path("a.csv"), lines(&white(2000, 1.0, 3))).unwrap();
    done(&desk, &format!("a.csv b.csv {RATE} --fit N,K"));
    let rows = desk.table("results/a_vs_b/coefficients.csv");
    assert_eq!((rows[1]["coefficient"].as_str(), rows[1]["status"].as_str()), ("K", "in neither record"));
    assert!(
        rows[1]["a"].is_empty() && rows[1]["p"].is_empty() && number(&rows[1], "a_at_most") > 0.0,
        "{rows:?}"
    );
}

#[test]
fn noise_that_only_one_record_shows_has_a_p_and_no_value_of_the_other() {
    // A random walk of the rate beside the white noise, or none.
    let mut walk = 0.0;
    let walking: Vec<f64> = white(8192, 1.0, 1)
        .iter()
        .zip(white(8192, 0.03, 3))
        .map(|(white, step)| {
            walk += step;
            white + walk
        })
        .collect();
    let desk = two(lines(&walking), lines(&white(8192, 1.0, 2)));
    let ended = done(&desk, &format!("a.csv b.csv {RATE}"));
    assert!(ended.stdout.contains("a has more K than b (p "), "{}", ended.stdout);
    let rows = desk.table("results/a_vs_b/coefficients.csv");
    let k = rows.iter().find(|row| row["coefficient"] == "K").unwrap();
    assert!(k["b"].is_empty() && k["difference"].is_empty() && number(k, "upper") < 0.0, "{k:?}");
    assert!(number(k, "p") < 0.05 && k["status"] == "b lower", "{k:?}");
    assert!((number(k, "a") / (60.0 * 0.03) - 1.0).abs() < 0.5, "{k:?}");
}

#[test]
fn logs_that_cannot_be_compared_are_refused_with_what_to_do() {
    let desk = two(lines(&white(200, 1.0, 1)), "1\n2\n");
    refused(&desk, &format!("a.csv b.csv {RATE}"), 3, &["b.csv:1:1", "has 2 samples, at least 16"]);
    refused(&desk, &format!("other.csv a.csv {RATE}"), 3, &["cannot read other.csv"]);
    refused(&desk, &format!("a.csv {RATE}"), 2, &["at least two units, found 1"]);
    refused(&desk, "a.csv b.csv --data rate --unit deg/h", 3, &["--rate HZ, or --time COLUMN"]);
    refused(
        &desk,
        &format!("a.csv b.csv {RATE} --column 1,2,3"),
        2,
        &["more than two columns", "--column gx,gy"],
    );
    let of = |unit: &str| format!("g [{unit}]\n{}", lines(&white(200, 1.0, 1)));
    let desk = two(of("deg/h"), of("none"));
    refused(
        &desk,
        "a.csv b.csv --data rate --rate 1Hz",
        3,
        &["a.csv has angular rates, b.csv has plain numbers", "--unit"],
    );
}

#[test]
fn the_help_has_examples() {
    let help = done(&desk_with("a", ""), "--help").stdout;
    for piece in ["Examples:", "sagnac compare before.csv after.csv", "--column gx,gy", "--fit"] {
        assert!(unwrapped(&help).contains(piece), "{piece} is missing in\n{help}");
    }
}

/// Rates at 1 Hz from rates at 2 Hz behind a Butterworth low-pass of the second order at 0.6 Hz, with what it leaves above 0.5 Hz.
fn filtered(rates: &[f64]) -> Vec<f64> {
    let c = 1.0 / (0.3 * std::f64::consts::PI).tan();
    let (d, r) = (c * c + 2_f64.sqrt() * c + 1.0, c * c - 2_f64.sqrt() * c + 1.0);
    let [mut x1, mut x2, mut y1, mut y2] = [0.0; 4];
    let next = |&x: &f64| {
        let y = (x + 2.0 * x1 + x2 - 2.0 * (1.0 - c * c) * y1 - r * y2) / d;
        (x2, x1, y2, y1) = (x1, x, y1, y);
        y
    };
    rates.iter().map(next).step_by(2).collect()
}

fn stamped(rates: &[f64], step_s: f64) -> String {
    let line = |(i, rate): (usize, &f64)| format!("{:.1},{rate:.4}\n", i as f64 * step_s);
    format!("t [s],gz [deg/h]\n{}", rates.iter().enumerate().map(line).collect::<String>())
}

#[test]
fn a_filter_of_one_log_is_no_difference_and_hides_none_of_n() {
    const SAMPLES: usize = 1 << 17;
    for (seed, sigma, is_equal) in [(1, 10.0, true), (2, 10.0, true), (3, 11.0, false)] {
        let desk = two(
            stamped(&filtered(&white(SAMPLES, 10.0, seed)), 1.0),
            stamped(&white(SAMPLES, sigma, 100 + seed), 0.5),
        );
        let ended = done(&desk, "a.csv b.csv --data rate --column gz --json");
        let document: Value = serde_json::from_str(&ended.stdout).unwrap();
        let p = fact_of(&document, "test")["p"].as_f64().unwrap();
        let [event] = rows_of(&document, "events") else { panic!("{document:#}") };
        assert_eq!((&event["column"], &event["event"]), (&"a".into(), &"filter or hump".into()));
        let n = rows_of(&document, "coefficients").iter().find(|row| row["coefficient"] == "N").unwrap();
        let expected = if is_equal { "consistent" } else { "b higher" };
        assert!(p < 1e-4 || is_equal, "seed {seed}: p = {p}");
        assert!((p > 0.05) == is_equal && n["status"] == expected, "seed {seed}: p = {p}, {n}");
    }
}

#[test]
fn a_column_of_temperature_is_found_and_its_effect_is_not_compared() {
    let log = |per_kelvin: f64, seed: u64| {
        let line = |(i, rate): (usize, f64)| {
            let kelvin = 5.0 * (i as f64 / 700.0).sin();
            format!("{:.4},{:.4}\n", rate + per_kelvin * kelvin, 20.0 + kelvin)
        };
        let lines: String = white(8192, 1.0, seed).into_iter().enumerate().map(line).collect();
        format!("gz [deg/h],temp [degC]\n{lines}")
    };
    let desk = two(log(0.0, 1), log(0.5, 2));
    let ended = done(&desk, "a.csv b.csv --data rate --rate 1Hz --json");
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let [event] = rows_of(&document, "events") else { panic!("{document:#}") };
    assert_eq!(event["column"], "b");
    assert_eq!((event["event"].as_str(), event["other"].as_str()), (Some("temperature"), Some("temp")));
    assert!((event["size"].as_f64().unwrap() / 0.5 - 1.0).abs() < 0.1, "{event}");
    assert!(fact_of(&document, "test")["p"].as_f64().unwrap() > 0.05, "{document}");
}
