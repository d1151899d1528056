//! Pages of logs: what they hold is what tables and JSON hold, and nothing of the log becomes part of the page.

use crate::browser::Browser;
use crate::desk::{Desk, rows_of};
use crate::logs::{desk_with, noise};
use serde_json::{Value, json};

const READ: &str = "--data rate --unit deg/h --rate 100Hz --bootstrap 0";

/// Two columns of 8192 rows, the first with a sine of 20 Hz, a gap of 70 samples, and a spike.
fn two_axes(first: &str) -> String {
    let numbers: Vec<f64> = noise(24 * 8192).collect();
    let white = |i: usize| numbers[12 * i..12 * (i + 1)].iter().sum::<f64>();
    let row = |i: usize| {
        let sine = 0.5 * (0.4 * std::f64::consts::PI * i as f64).sin();
        let x = white(i) + sine + if i == 3000 { 30.0 } else { 0.0 };
        let x = if (1000..1070).contains(&i) { String::new() } else { x.to_string() };
        format!("{x},{}\n", 2.0 * white(8192 + i))
    };
    format!("{first},gz\n") + &(0..8192).map(row).collect::<String>()
}

fn page(desk: &Desk, folder: &str) -> String {
    let page = desk.read(&format!("{folder}/report.html"));
    for asked in ["src=\"", "http://", "https://", "url(", "@import"] {
        let places = page.match_indices(asked).map(|(at, _)| &page[at..(at + 60).min(page.len())]);
        // The name of the language of pictures is no address.
        let places: Vec<&str> =
            places.filter(|place| !place.starts_with("http://www.w3.org/2000/svg")).collect();
        assert!(places.iter().all(|place| place.starts_with("url(#")), "{asked}: {places:?}");
    }
    page
}

#[test]
fn the_page_of_a_log_holds_what_its_json_holds() {
    let desk = desk_with("imu.csv", two_axes("gx"));
    let ended = desk.done(&format!("allan imu.csv {READ} --column gx,gz --json"));
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let page = page(&desk, "results/imu");
    let shown = |value: &Value| sagnac_base::quantity::number::significant(value.as_f64().unwrap(), 4);
    let of_fit = |found: &&Value| found["intervals"] != "of the curve" && !found["value"].is_null();
    for found in rows_of(&document, "coefficients").iter().filter(of_fit) {
        for end in ["value", "lower", "upper"] {
            assert!(page.contains(&shown(&found[end])), "{end} of {found} is missing");
        }
    }
    for piece in [
        "Noise of imu.csv",
        "8192 samples at 100 Hz",
        "gx: smallest N, ",
        "one of 0.7 s, 70 samples, at 10 s",
        "one at 30 s",
        "5.5 min (4 × as long), if it is ",
        "consistent",
        "events.csv",
    ] {
        assert!(page.contains(piece), "{piece} is missing in the page");
    }
    let events = desk.read("results/imu/events.csv");
    let rows: Vec<Vec<&str>> = events.lines().map(|line| line.split(',').collect()).collect();
    let begin: Vec<String> = rows.iter().map(|row| row[..5].join(",")).collect();
    assert_eq!(begin[0], "column,event,time_s,length_s,samples");
    assert_eq!(begin[1..3], ["gx,gap,10,0.7,70", "gx,outlier,30,0.01,1"]);
    assert_eq!(begin[3..], ["gx,spikes,30,0.01,1", "gx,line,,,1"]);
    // The line is at 20 Hz.
    let frequency = rows[0].iter().position(|name| *name == "f_hz").unwrap();
    assert!((rows[4][frequency].parse::<f64>().unwrap() - 20.0).abs() < 0.05, "{events}");
    // The same log gives the same bytes.
    desk.done(&format!("allan imu.csv {READ} --column gx,gz --out again"));
    assert_eq!(page, self::page(&desk, "again"));
}

#[test]
fn names_of_columns_and_files_are_text_and_no_part_of_the_page() {
    let desk = desk_with("a<b>&'c.csv", two_axes("<script>alert(1)</script>"));
    desk.done(&format!("allan a<b>&'c.csv {READ} --column 1,2 --out out"));
    let page = page(&desk, "out");
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"), "the name is missing");
    assert!(page.contains("a&lt;b&gt;&amp;'c.csv"), "the file is missing");
    assert!(!page.contains("<script>alert"), "the name is a script");
}

#[test]
fn a_log_that_is_too_short_for_a_spectrum_has_a_page_that_says_so() {
    let row = |i: usize| {
        if i % 80 > 12 { "nan\n".to_owned() } else { format!("{}\n", noise(i + 1).last().unwrap()) }
    };
    let desk = desk_with("short.csv", (1..200).map(row).collect::<String>());
    desk.done(&format!("allan short.csv {READ} --fit none"));
    let page = page(&desk, "results/short");
    assert!(page.contains("There is no spectrum."), "{}", page.len());
    assert!(page.contains("curve minimum "), "{}", page.len());
}

#[test]
fn the_page_of_a_comparison_holds_its_answer_and_coefficients() {
    let desk = desk_with("a.csv", two_axes("gx"));
    desk.write("b.csv", &two_axes("gx").replace(",-", ",-1"));
    let ended =
        desk.done(&format!("compare a.csv b.csv {} --column gz --json", READ.replace(" --bootstrap 0", "")));
    let document: Value = serde_json::from_str(&ended.stdout).unwrap();
    let page = page(&desk, "results/a_vs_b");
    let headline = document["answer"]["headline"].as_str().unwrap();
    assert!(page.contains(headline), "{headline} is missing");
    for piece in ["a and b compared", "b higher", "length needed"] {
        assert!(page.contains(piece), "{piece} is missing");
    }
}

#[test]
fn a_browser_draws_the_page_of_a_log_and_asks_for_nothing() {
    let Some(browser) = Browser::start() else { return };
    let desk = desk_with("imu.csv", two_axes("gx"));
    desk.done(&format!("allan imu.csv {READ} --column gx,gz"));
    browser.open(&desk.path("results/imu/report.html"));
    let drawn = "return [...document.querySelectorAll('.chart')].map((c) => c.querySelectorAll('.drawing .curve').length)";
    assert_eq!(
        browser.ask(drawn, json!(null)),
        json!([2, 2, 2, 2]),
        "curves of deviations, density, record, means"
    );
    // The record has its gap, and no markers.
    let gap = "return document.querySelector('[data-chart=\"2\"] .drawing .curve').getAttribute('d').split('M').length - 1";
    assert_eq!(browser.number(gap), 2.0);
    let marker = "return getComputedStyle(document.querySelector('.trace .drawing .marker')).display";
    assert_eq!(browser.text(marker), "none");
    assert_eq!(browser.console(), Vec::<String>::new(), "the console");
    assert_eq!(browser.number("return performance.getEntriesByType('resource').length"), 0.0, "resources");
    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.chromium("Emulation.setDeviceMetricsOverride", &phone);
    browser.open(&desk.path("results/imu/report.html"));
    assert_eq!(browser.number("return document.documentElement.scrollWidth"), 390.0, "nothing sticks out");
}
