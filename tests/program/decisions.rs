//! The answers in which `sagnac allan` and `compare` end: limits are checked against intervals, and every answer says
//! what the numbers say.

use sagnac_base::quantity::number::significant;
use serde_json::{Value, json};

use crate::desk::{Desk, rows_of, unwrapped};
use crate::logs::desk_with;
use crate::noise::white;

const READ: &str = "--data rate --unit deg/h --rate 1Hz";

/// Columns of numbers under their names.
fn text(columns: &[(&str, Vec<f64>)]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row =
        |i: usize| columns.iter().map(|(_, numbers)| numbers[i].to_string()).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = (0..columns[0].1.len()).map(row).collect();
    format!("{}\n{}\n", names.join(","), rows.join("\n"))
}

/// White noise with N = 0.1 °/√h, of which the record does not identify B.
fn gyro() -> Desk {
    desk_with("g.csv", text(&[("gz", white(4096, 6.0, 1))]))
}

/// A document with its limits, as `N=0.1 deg/sqrt(h)`.
fn document(desk: &Desk, words: &str, limits: &[&str]) -> Value {
    let limits: Vec<String> =
        limits.iter().map(|limit| format!("--limit {}", limit.replace(' ', ""))).collect();
    let ended = desk.done(&format!("{words} {} --json", limits.join(" ")));
    serde_json::from_str(&ended.stdout).unwrap()
}

fn allan(desk: &Desk, more: &str, limits: &[&str]) -> Value {
    document(desk, &format!("allan g.csv {READ} --bootstrap 0 {more}"), limits)
}

fn headline(document: &Value) -> &str {
    document["answer"]["headline"].as_str().unwrap()
}

fn status(document: &Value) -> &str {
    document["answer"]["status"]["is"].as_str().unwrap()
}

/// The first fact of this name.
fn fact<'d>(document: &'d Value, name: &str) -> &'d Value {
    let facts = document["answer"]["facts"].as_array().unwrap();
    facts.iter().find(|fact| fact["fact"] == name).unwrap_or(&Value::Null)
}

/// The texts of the table, without its headings.
fn rows(document: &Value) -> Vec<Vec<&str>> {
    fn texts(row: &Value) -> Vec<&str> {
        row.as_array().unwrap().iter().map(|cell| cell["text"].as_str().unwrap()).collect()
    }
    document["answer"]["table"]["rows"].as_array().unwrap().iter().map(texts).collect()
}

/// Value and ends of the first coefficient of this name in a document.
fn coefficient(document: &Value, name: &str) -> [Option<f64>; 3] {
    let row = rows_of(document, "coefficients").iter().find(|row| row["coefficient"] == name).unwrap();
    ["value", "lower", "upper"].map(|end| row[end].as_f64())
}

#[test]
fn a_limit_is_met_missed_or_open_by_the_ends_of_the_interval() {
    let desk = gyro();
    let free = allan(&desk, "", &[]);
    assert_eq!(free["tables"].get("limits"), None);
    assert!(headline(&free).starts_with("N = 0.1") && status(&free) == "no_limit", "{free:#}");
    let [Some(value), Some(low), Some(high)] = coefficient(&free, "N") else { panic!("{free:#}") };
    let held = |limit: f64| allan(&desk, "", &[&format!("N={limit} deg/sqrt(h)")]);
    for (limit, met, verb, standing) in [
        (high * (1.0 + 1e-9), "met", " meets the ", "met"),
        (high * (1.0 - 1e-9), "inconclusive", " may miss the ", "inconclusive"),
        (low * (1.0 + 1e-9), "inconclusive", " may miss the ", "inconclusive"),
        (low * (1.0 - 1e-9), "not_met", " misses the ", "not met"),
    ] {
        let mut found = held(limit);
        assert_eq!(status(&found), met, "{limit}: {:#}", found["answer"]);
        assert_eq!(rows_of(&found, "limits")[0]["status"], standing);
        assert!(headline(&found).contains(verb), "{}", headline(&found));
        // No number of the analysis depends on the limit.
        found["tables"].as_object_mut().unwrap().remove("limits");
        assert_eq!(found["tables"], free["tables"]);
    }
    // 1/√T: the end of the interval has to come to the limit.
    let limit = value * (high / value).powf(0.38);
    let found = held(limit);
    let change = &fact(&found, "change_to_decide")["alternatives"][0];
    let longer = format!("{} h", significant(0.38_f64.powi(-2) * 4096.0 / 3600.0, 2));
    assert_eq!((&change["from"], &change["to"]), (&json!("68 min"), &json!(longer)));
    let found = held(0.5 * value);
    let change = &fact(&found, "change_to_meet")["alternatives"][0];
    assert_eq!((&change["key"], &change["to"]), (&json!("sensors"), &json!("4")));
}

#[test]
fn a_bound_meets_a_limit_or_decides_nothing() {
    let desk = gyro();
    let free = allan(&desk, "", &[]);
    let [None, _, Some(bound)] = coefficient(&free, "B") else { panic!("{free:#}") };
    let held = |part: f64| allan(&desk, "", &[&format!("B={} deg/h", part * bound)]);
    let (above, below) = (held(1.25), held(0.5));
    assert!(headline(&above).starts_with("B ≤ ") && headline(&above).contains(" meets the "), "{above:#}");
    assert!(headline(&below).starts_with("B ≤ ") && headline(&below).contains(" may miss the "), "{below:#}");
    assert_eq!((status(&above), status(&below)), ("met", "inconclusive"));
    let row =
        |found: &Value| rows(found).into_iter().find(|row| row[0].starts_with("B,")).map(|row| row.join("|"));
    assert!(row(&below).unwrap().ends_with("|inconclusive"), "{:?}", row(&below));
}

#[test]
fn the_table_of_several_axes_has_the_intervals_of_each_coefficient() {
    let mut walk = 0.0;
    let walked = white(4096, 0.3, 3).into_iter().map(|step| {
        walk += step;
        walk
    });
    let gy: Vec<f64> =
        white(4096, 12.0, 2).into_iter().zip(walked).map(|(white, walk)| white + walk).collect();
    let desk = desk_with("log.csv", text(&[("gx", white(4096, 6.0, 1)), ("gy", gy)]));
    let ended = desk.done(&format!("allan log.csv {READ} --bootstrap 0 --column gx,gy --out out"));
    assert!(ended.stdout.contains("gx: smallest N, "), "{}", ended.stdout);
    let rows = desk.table("out/coefficients.csv");
    let lines: Vec<&str> = ended.stdout.lines().collect();
    let mut ends_of = |axis: &str| {
        let at = lines
            .iter()
            .position(|line| line.trim_start_matches('▸').trim_start().starts_with(&format!("{axis} ")))
            .unwrap();
        assert!(lines[at + 1].starts_with("  95 % "), "{}", ended.stdout);
        let is_shown = |row: &&crate::desk::Row| {
            let is_there = ["N", "B", "K"].contains(&&*row["coefficient"]) && !row["value"].is_empty();
            row["column"] == axis && is_there
        };
        (lines[at + 1].matches('–').count(), rows.iter().filter(is_shown).count())
    };
    let [gx, gy] = ["gx", "gy"].map(&mut ends_of);
    assert!(gx.1 > 0 && gy.1 > gx.1, "{rows:?}");
    assert!(gx.0 >= gx.1 && gy.0 >= gy.1, "{gx:?}, {gy:?}\n{}", ended.stdout);
}

#[test]
fn several_limits_are_judged_together_and_the_worst_one_says_what_limits() {
    let desk = gyro();
    let found = allan(
        &desk,
        "",
        &["angle_random_walk=0.05 deg/sqrt(h)", "B=100 deg/h", "in_run_bias_stability=100 deg/h"],
    );
    let limits = rows_of(&found, "limits").iter();
    let names: Vec<&str> = limits.map(|one| one["coefficient"].as_str().unwrap()).collect();
    assert_eq!(names, ["N", "B", "in_run_bias_stability"]);
    assert!(headline(&found).starts_with("N 0.1"), "{found:#}");
    assert_eq!(found["answer"]["status"], json!({ "is": "partly_met", "met": 2, "of": 3 }));
    assert_eq!(found["answer"]["limit"]["value"], json!(0.05));
}

#[test]
fn what_the_fit_does_not_describe_decides_nothing() {
    let desk = gyro();
    // No ramp and no random walk is like white noise at any averaging time.
    for force in ["", "--force"] {
        let found = allan(&desk, &format!("--fit K,R {force}"), &["K=1e6 deg/h/sqrt(h)"]);
        assert_eq!(rows_of(&found, "limits")[0]["status"], "unknown");
        assert_eq!((headline(&found), status(&found)), ("K is unknown, limit 1e6 °/h/√h", "inconclusive"));
        assert_eq!(
            fact(&found, "caveat")["text"],
            "the fit describes no range of τ and says nothing about K"
        );
    }
}

#[test]
fn gyros_and_accelerometers_have_limits_in_their_own_units() {
    let axes = [("gx [deg/h]", 6.0), ("gy [deg/h]", 12.0), ("gz [deg/h]", 7.0), ("ax [ug]", 50.0)];
    let columns: Vec<(&str, Vec<f64>)> =
        (1..).zip(axes).map(|(seed, (name, sigma))| (name, white(4096, sigma, seed))).collect();
    let desk = desk_with("imu.csv", text(&columns));
    let read = "allan imu.csv --data rate --rate 1Hz --bootstrap 0";
    let found = document(&desk, read, &["N=0.15 deg/sqrt(h)", "N=0.1 m/s/sqrt(h)"]);
    let limits = rows_of(&found, "limits").iter();
    let standings: Vec<(&str, &str)> =
        limits.map(|one| (one["record"].as_str().unwrap(), one["status"].as_str().unwrap())).collect();
    assert_eq!(standings, [("gx", "met"), ("gy", "not met"), ("gz", "met"), ("ax", "met")]);
    assert!(headline(&found).starts_with("gy: N 0.19") && rows(&found)[0][0] == "gy", "{found:#}");
    assert_eq!(found["answer"]["status"], json!({ "is": "partly_met", "met": 3, "of": 4 }));
    assert_eq!(fact(&found, "change_to_meet")["alternatives"][0]["to"], "2");
    // 50 µg in samples of 1 s.
    let n = &rows_of(&found, "limits")[3];
    assert!((n["value"].as_f64().unwrap() / (50e-6 * 9.80665 * 60.0) - 1.0).abs() < 0.05, "{n}");
    let free = document(&desk, read, &[]);
    assert!(headline(&free).starts_with("gx: smallest N, 0.1"), "{free:#}");
    let names: Vec<&str> = rows(&free).into_iter().map(|row| row[0]).collect();
    assert_eq!(names, ["gx", "gz", "gy", "ax"]);
    desk.fails(
        &format!("{read} --column gx --limit N=1m/s/sqrt(h)"),
        2,
        &["is for accelerations, which no column has"],
    );
}

#[test]
fn noise_behind_a_filter_is_held_against_limits_by_its_n_and_not_by_its_curve() {
    // The mean of three samples: N stays 0.1 °/√h, while the deviation at one sample falls by √3.
    let x = white(16_386, 6.0, 1);
    let rates: Vec<f64> = x.windows(3).map(|x| (x[0] + x[1] + x[2]) / 3.0).collect();
    let desk = desk_with("g.csv", text(&[("gz", rates)]));
    let found = allan(&desk, "", &["N=0.08 deg/sqrt(h)"]);
    let first = rows_of(&found, "curve")[0]["value"].as_f64().unwrap();
    assert!(first / 60.0 < 0.07, "{first}");
    assert_eq!(status(&found), "not_met", "{:#}", found["answer"]);
    assert_eq!(status(&allan(&desk, "", &["N=0.12 deg/sqrt(h)"])), "met");
    // The fit starts beyond the filter.
    assert!(fact(&found, "fit")["tau_s"][0].as_f64().unwrap() > 1.0, "{found:#}");
}

#[test]
fn spikes_are_left_out_of_the_fit_that_is_held_against_a_limit() {
    let mut rates = white(4096, 6.0, 1);
    let clean = allan(&gyro(), "", &["N=0.12 deg/sqrt(h)"]);
    for i in 0..8 {
        rates[2000 + 31 * i] = 400.0;
    }
    let desk = desk_with("g.csv", text(&[("gz", rates)]));
    let kept = allan(&desk, "", &["N=0.12 deg/sqrt(h)"]);
    let removed = allan(&desk, "--remove-outliers", &["N=0.12 deg/sqrt(h)"]);
    for found in [&clean, &removed, &kept] {
        assert_eq!(status(found), "met", "{:#}", found["answer"]);
    }
    let mut events = rows_of(&kept, "events").iter();
    let spikes = events.find(|row| row["event"] != "outlier").unwrap();
    assert_eq!((&spikes["event"], &spikes["samples"]), (&json!("spikes"), &json!(8)), "{spikes}");
}

#[test]
fn a_spectrum_and_the_page_end_in_the_decision_of_the_log() {
    let desk = gyro();
    let limits = ["floor=0.2 deg/sqrt(h)", "N=0.2 deg/sqrt(h)"];
    let found = document(&desk, &format!("allan g.csv {READ} --bootstrap 0"), &limits);
    assert_eq!(status(&found), "met");
    let floor = &rows_of(&found, "white_noise")[0];
    assert_eq!((&floor["from"], &floor["n"]), (&json!("floor"), &rows_of(&found, "limits")[0]["value"]));
    let ended =
        desk.done(&format!("allan g.csv {READ} --bootstrap 0 --limit floor=0.2deg/sqrt(h) --out out"));
    let page = desk.read("out/report.html");
    let told = "N of the floor 0.1";
    assert!(
        page.contains(told) && page.contains("meets the 0.2 °/√h limit"),
        "the answer is missing in the page"
    );
    assert!(unwrapped(&ended.stdout).contains(told), "{}", ended.stdout);
}

#[test]
fn a_comparison_is_held_against_limits_on_the_ratio() {
    let desk = desk_with("a.csv", text(&[("gz", white(4096, 6.0, 1))]));
    desk.write("b.csv", &text(&[("gz", white(4096, 3.0, 2))]));
    let compared = |limits: &[&str]| document(&desk, &format!("compare a.csv b.csv {READ}"), limits);
    let free = compared(&[]);
    assert_eq!(status(&free), "no_limit");
    assert!(
        headline(&free).starts_with("b has 0.49") && headline(&free).contains(" × the N of a ("),
        "{free:#}"
    );
    let row = rows_of(&free, "coefficients").iter().find(|row| row["coefficient"] == "N").unwrap();
    let [low, high] = ["ratio_lower", "ratio_upper"].map(|end| row[end].as_f64().unwrap());
    for (limit, met) in
        [(high * (1.0 + 1e-9), "met"), (high * (1.0 - 1e-9), "inconclusive"), (low * (1.0 - 1e-9), "not_met")]
    {
        let found = compared(&[&format!("N={limit}")]);
        assert_eq!(status(&found), met, "{limit}: {:#}", found["answer"]);
        assert_eq!(rows_of(&found, "limits")[0]["value"], row["ratio"]);
        let heads = json!(["coefficient", "ratio (95 %)", "status", "a", "b"]);
        assert_eq!(found["answer"]["table"]["columns"], heads);
        assert_eq!((rows(&found)[0][0], rows(&found)[0][2]), ("N", &*met.replace('_', " ")));
    }
    let same = document(&desk, &format!("compare a.csv a.csv {READ}"), &["N=2"]);
    assert_eq!(status(&same), "inconclusive");
    assert_eq!(fact(&same, "caveat")["text"], "both logs are one record");
    let compare = format!("compare a.csv b.csv {READ} --limit");
    desk.fails(
        &format!("{compare} N=0.1deg/sqrt(h)"),
        2,
        &["is not a positive number", "the ratio of the second log over the first"],
    );
    desk.fails(&format!("{compare} N=1 --limit n=2"), 2, &["limit the same"]);
    desk.fails(&format!("{compare} K=1 --fit N,B"), 2, &["K is not fitted"]);
}

#[test]
fn a_batch_is_held_against_limits_unit_by_unit_and_without_its_outlier() {
    let sigmas = [6.0, 6.3, 5.8, 12.0, 6.1, 5.9];
    let names = ["g1", "g2", "g3", "g4", "g5", "g6"];
    let columns: Vec<(&str, Vec<f64>)> = (1..)
        .zip(names.into_iter().zip(sigmas))
        .map(|(seed, (name, sigma))| (name, white(4096, sigma, seed)))
        .collect();
    let desk = desk_with("batch.csv", text(&columns));
    let batch = format!("compare batch.csv {READ} --column g1,g2,g3,g4,g5,g6");
    let found = document(&desk, &batch, &["N=0.12 deg/sqrt(h)"]);
    assert!(headline(&found).starts_with("g4: N 0.19") && rows(&found)[0][0] == "g4", "{found:#}");
    assert_eq!(found["answer"]["status"], json!({ "is": "partly_met", "met": 5, "of": 6 }));
    let facts = found["answer"]["facts"].as_array().unwrap();
    let next = facts.iter().find(|fact| fact["name"] == "Next unit, 95 %").unwrap();
    // Without the outlier the next one is expected below the limit.
    let [low, high] = [0, 1].map(|end| next["value"]["interval"][end].as_f64().unwrap());
    assert!(0.08 < low && high < 0.12, "{next}");
    let wide = document(&desk, &batch, &["N=0.3 deg/sqrt(h)"]);
    assert_eq!(status(&wide), "met");
    let free = document(&desk, &batch, &[]);
    assert!(headline(&free).starts_with("g4 is an outlier: N 1.98 × the median (p = "), "{free:#}");
    assert_eq!((rows(&free)[0][0], rows(&free)[0][4]), ("g4", "outlier"));
    desk.fails(&format!("{batch} --limit floor=1deg/sqrt(h)"), 2, &["unknown limit `floor`"]);
}

#[test]
fn limits_that_make_no_sense_are_refused_before_anything_is_written() {
    let desk = gyro();
    for (limit, pieces) in [
        ("--limit N", ["has no `=`", "N=0.003 deg/sqrt(h)"]),
        ("--limit M=1", ["unknown limit `M`", "accepted: Q, N, B, K, R"]),
        ("--limit N=1deg/h", ["is an angular rate", "deg/sqrt(h) for gyros"]),
        ("--limit N=0deg/sqrt(h)", ["0 is not a positive number", "deg/sqrt(h)"]),
        ("--limit N=1", ["is for plain numbers, which no column has", "in deg/sqrt(h)"]),
        ("--limit N=1deg/sqrt(h) --limit n=2deg/sqrt(h)", ["limit the same", "give each limit once"]),
        ("--limit K=1deg/h/sqrt(h) --fit N,B", ["K is not fitted", "fit this term too"]),
        ("--limit N=1deg/sqrt(h) --fit none", ["none are fitted", "leave out the limit"]),
        ("--limit R=1deg/h/h --detrend linear", ["R is not fitted", "leave out the limit"]),
    ] {
        desk.fails(&format!("allan g.csv {READ} {limit}"), 2, &pieces);
    }
    assert!(!desk.path("results").exists(), "a refused limit left results");
}
