//! What `sagnac allan` leaves for others: the fit in its chart, and `noise.toml` for studies.

use std::collections::BTreeMap;

use crate::desk::{Desk, Ended, row, rows_of};
use crate::logs::desk_with;
use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::theory::allan::{Part, Process};
use toml::{Table, Value};

const GYRO: [Part; 3] =
    [Part::quantization(0.11), Part::angle_random_walk(0.0288), Part::bias_instability(0.00164, 24)];

/// N = 0.02 ″/√s and K = 0.002 ″/s^1.5, in °/√h and °/h/√h.
const WALK: [Part; 2] = [Part::angle_random_walk(0.02), Part::rate_random_walk(0.002)];

/// Rates in °/h, 1 Hz.
fn rates(parts: &[Part], samples: usize, seed: u64) -> Vec<f64> {
    let process = Process { sample_s: 1.0, parts: parts.to_vec() };
    let angles = crate::noise::record(&process, samples, &mut StdRng::seed_from_u64(seed));
    angles.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// A log of these columns under a header.
fn log(header: &str, columns: &[Vec<f64>]) -> String {
    let row = |i: usize| columns.iter().map(|column| column[i].to_string()).collect::<Vec<_>>().join(",");
    let rows = (0..columns[0].len()).map(|i| row(i) + "\n");
    format!("{header}\n{}", rows.collect::<String>())
}

fn gyro() -> Desk {
    desk_with("gyro.csv", log("gz [deg/h]", &[rates(&GYRO, 32_400, 3)]))
}

fn allan(desk: &Desk, words: &str) -> Ended {
    desk.done(&format!("allan {words} --data rate --rate 1Hz --out out"))
}

fn noise_of(desk: &Desk, name: &str) -> Table {
    let text = desk.read(&format!("out/{name}"));
    text.parse().unwrap_or_else(|error| panic!("{name}: {error}\n{text}"))
}

/// Coefficients as files have them: column and name to value, upper end and unit.
fn coefficients(desk: &Desk) -> BTreeMap<(String, String), (String, String, String)> {
    let rows = desk.table("out/coefficients.csv").into_iter();
    rows.map(|row| {
        let of = |name: &str| row[name].clone();
        ((of("column"), of("coefficient")), (of("value"), of("upper"), of("unit")))
    })
    .collect()
}

/// Value and verdict of a coefficient.
fn verdict(desk: &Desk, name: &str) -> (String, String) {
    let rows = desk.table("out/coefficients.csv");
    let row = row(&rows, &[("coefficient", name)]);
    (row["value"].clone(), row["status"].clone())
}

/// The number in front of a unit.
fn number(quantity: &Value, unit: &str) -> f64 {
    let text = quantity.as_str().unwrap();
    let number = text.strip_suffix(unit).unwrap_or_else(|| panic!("`{text}` is not in {unit}"));
    number.trim().parse().unwrap()
}

fn names(table: &Table) -> Vec<&str> {
    table.keys().map(String::as_str).collect()
}

#[test]
fn the_chart_of_one_column_has_the_fit_and_its_parts() {
    let desk = gyro();
    allan(&desk, "gyro.csv --deviation oadev,hdev");
    let svg = desk.read("out/chart.svg").replace('\u{a0}', " ");
    for piece in [">measured<", ">fit, τ from ", ">parts of the fit of oadev<"] {
        assert!(svg.contains(piece), "{piece} is missing in the chart");
    }
    for (name, unit) in [("Q", "″"), ("N", "°/√h"), ("B", "°/h")] {
        let label = svg.lines().find(|line| line.contains(&format!(">{name} = "))).unwrap_or_default();
        assert!(label.contains(unit), "{name} in {unit}: `{label}`");
    }
    assert!(!svg.contains(">K = "), "K is not identified");
    allan(&desk, "gyro.csv --fit none");
    let svg = desk.read("out/chart.svg");
    assert!(!svg.contains(">fit") && !svg.contains(">measured<") && !svg.contains("parts of"));
    // Of angles there is no closed form.
    allan(&desk, "gyro.csv --deviation oadev,tdev");
    assert!(desk.read("out/chart.svg").contains(">parts of the fit<"));
    let svg = desk.read("out/chart-tdev.svg");
    assert!(!svg.contains(">fit") && !svg.contains("parts of"));
}

#[test]
fn the_axes_are_those_of_the_curve_and_its_fit_and_not_of_the_parts() {
    let desk = gyro();
    let labels = || -> Vec<String> {
        let svg = desk.read("out/chart.svg");
        let text = |line: &str| Some(line.split_once('>')?.1.split_once('<')?.0.to_owned());
        let of_axis = |line: &&str| line.contains("<text") && line.contains("font-size=\"13\"");
        svg.lines().filter(of_axis).filter_map(text).filter(|text| text.parse::<f64>().is_ok()).collect()
    };
    allan(&desk, "gyro.csv");
    let with_parts = labels();
    allan(&desk, "gyro.csv --fit none");
    assert_eq!(with_parts, labels());
}

#[test]
fn several_columns_have_their_fits_and_no_parts() {
    let columns = [rates(&GYRO, 20_000, 4), rates(&WALK, 20_000, 5)];
    let desk = desk_with("gyro.csv", log("gx [deg/h],gy [deg/h]", &columns));
    allan(&desk, "gyro.csv --column gx,gy");
    let svg = desk.read("out/chart.svg");
    assert!(svg.contains(">fit<") && !svg.contains("parts of") && !svg.contains(">N"));
}

#[test]
fn noise_toml_has_the_identified_coefficients_and_says_the_rest() {
    let desk = gyro();
    allan(&desk, "gyro.csv");
    let (found, noise) = (coefficients(&desk), noise_of(&desk, "noise.toml"));
    assert_eq!(names(&noise), ["angle_random_walk", "bias_instability", "quantization"]);
    for (key, name) in [("quantization", "Q"), ("angle_random_walk", "N"), ("bias_instability", "B")] {
        let (value, _, unit) = &found[&("gz".to_owned(), name.to_owned())];
        let (written, value) = (number(&noise[key], unit), value.parse::<f64>().unwrap());
        assert!((written / value - 1.0).abs() < 1e-5, "{key}: {written}, not {value} {unit}");
    }
    let text = desk.read("out/noise.toml");
    let first =
        "# Noise of column gz of gyro.csv: 32400 samples of 1 s, fitted by sagnac allan; no trend removed.";
    assert_eq!(text.lines().next(), Some(first));
    let intervals = text.lines().filter(|line| line.starts_with("# 95 % interval of ")).count();
    assert_eq!(intervals, 3, "{text}");
    let not_identified = text.lines().find(|line| line.starts_with("# Not identified: ")).unwrap();
    let (_, most, unit) = &found[&("gz".to_owned(), "K".to_owned())];
    let most: f64 = most.parse().unwrap();
    let bound = not_identified.split_once("K at most ").unwrap().1.split_once(&format!(" {unit}")).unwrap().0;
    assert!((bound.parse::<f64>().unwrap() / most - 1.0).abs() < 1e-5, "{not_identified}, not {most}");
}

#[test]
fn markov_noise_and_sines_have_their_times_and_frequencies() {
    let (sigma, time_s) = (0.02, 100.0);
    let parts = [
        Part::angle_random_walk(0.03),
        Part::markov(sigma * f64::sqrt(2.0 / time_s), time_s),
        Part::sine(0.1, 0.02),
    ];
    let desk = desk_with("gyro.csv", log("gz [deg/h]", &[rates(&parts, 40_000, 6)]));
    allan(&desk, "gyro.csv --fit N,markov,sine");
    let noise = noise_of(&desk, "noise.toml");
    let near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 0.3, "{found}, not {expected}: {noise}");
    };
    near(number(&noise["markov"]["amplitude"], "deg/h"), sigma);
    near(number(&noise["markov"]["time"], "s"), time_s);
    near(number(&noise["sine"]["amplitude"], "deg/h"), 0.1);
    near(number(&noise["sine"]["frequency"], "Hz"), 0.02);
    let svg = desk.read("out/chart.svg").replace('\u{a0}', " ");
    assert!(svg.contains("Markov: σ = ") && svg.contains("sine: Ω = "));
}

#[test]
fn each_column_has_its_noise_file_and_old_ones_go() {
    let columns = [rates(&GYRO, 8000, 7), rates(&GYRO, 8000, 8), rates(&GYRO, 8000, 9)];
    let header = "g/x\u{7}= 1,g?x = 1,gz";
    let desk = desk_with("gyro.csv", log(header, &columns));
    allan(&desk, "gyro.csv --column 1,2,3 --unit deg/h");
    let files = || -> Vec<String> {
        desk.names("out").into_iter().filter(|name| name.starts_with("noise")).collect()
    };
    assert_eq!(files(), ["noise_2_g_x___1.toml", "noise_g_x___1.toml", "noise_gz.toml"]);
    // TOML has no control characters in comments.
    for name in files() {
        let noise = noise_of(&desk, &name);
        assert!(noise.contains_key("angle_random_walk") && !noise.contains_key("x"), "{noise}");
    }
    desk.write("out/noise_mine.toml", "rate_ramp = \"1 deg/h/h\"\n");
    allan(&desk, "gyro.csv --column 3 --unit deg/h");
    assert_eq!(files(), ["noise.toml", "noise_mine.toml"]);
    let plain = allan(&desk, "gyro.csv --column 3 --unit none");
    assert!(plain.stderr.contains("note: gz: no noise.toml"), "{}", plain.stderr);
    assert_eq!(files(), ["noise_mine.toml"]);
    allan(&desk, "gyro.csv --column 3 --unit deg/h");
    allan(&desk, "gyro.csv --column 3 --unit deg/h --fit none");
    assert_eq!(files(), ["noise_mine.toml"]);
}

/// White noise with two sines, too slow for the spectrum and too fast for the search of slow events, which Q, N, B, K, R and one sine
/// describe over no range.
fn undescribed() -> Vec<f64> {
    let mut rng = StdRng::seed_from_u64(3);
    let sine = |i: usize, hz: f64| 10.0 * (core::f64::consts::TAU * hz * i as f64).sin();
    (0..65_536).map(|i| crate::noise::normal(&mut rng) + sine(i, 0.0015) + sine(i, 0.0009)).collect()
}

#[test]
fn several_columns_without_coefficients_show_the_bounds_of_their_minima() {
    let columns = [1, 2].map(|seed| rates(&[Part::angle_random_walk(0.0288)], 4096, seed));
    let desk = desk_with("gyro.csv", log("gx [deg/h],gy [deg/h]", &columns));
    let shown = allan(&desk, "gyro.csv --column gx,gy --fit K --bootstrap 0").stdout;
    let [gx, gy] = ["▸ gx", "  gy"].map(|name| shown.lines().find(|line| line.starts_with(name)).unwrap());
    assert!(gx.contains("≤ ") && gy.contains("≤ "), "{shown}");
}

#[test]
fn a_curve_that_is_not_described_gives_no_coefficient_to_any_output_unless_forced() {
    let desk = desk_with("gyro.csv", log("gz [deg/h]", &[undescribed()]));
    let ended = allan(&desk, "gyro.csv --bootstrap 0");
    let said = crate::desk::unwrapped(&ended.stderr);
    assert!(said.contains("over no range of τ") && said.contains("--fit-from 1s"), "{said}");
    assert!(ended.stdout.contains("\nNo noise model fits; curve minimum "), "{}", ended.stdout);
    assert_eq!(ended.stdout.matches("model rejected").count(), 5, "{}", ended.stdout);
    for name in ["Q", "N", "B", "K", "R"] {
        assert_eq!(verdict(&desk, name), (String::new(), "model rejected".to_owned()), "{name}");
    }
    assert!(!desk.path("out/noise.toml").exists());
    let json: serde_json::Value =
        serde_json::from_str(&allan(&desk, "gyro.csv --bootstrap 0 --json").stdout).unwrap();
    let of_fit = |row: &&serde_json::Value| row["intervals"] != "of the curve";
    let coefficients: Vec<_> = rows_of(&json, "coefficients").iter().filter(of_fit).collect();
    assert_eq!(coefficients.len(), 5);
    for row in coefficients {
        assert!(row["value"].is_null() && row["upper"].is_null(), "{row}");
        assert_eq!(row["status"], "model rejected");
    }
    desk.fails(
        "allan gyro.csv --data rate --rate 1Hz --kalibr imu.yaml",
        2,
        &["sagnac model LOG --write kalibr"],
    );
    desk.write("other.csv", &log("gz [deg/h]", &[undescribed().iter().map(|x| 2.0 * x).collect()]));
    let compared = desk.done("compare gyro.csv other.csv --data rate --rate 1Hz");
    assert!(compared.stderr.contains("no coefficients: model rejected"), "{}", compared.stderr);

    allan(&desk, "gyro.csv --bootstrap 0 --force");
    assert!(desk.read("out/noise.toml").contains("# Not described"), "{}", desk.read("out/noise.toml"));
    let forced = verdict(&desk, "N");
    assert!(!forced.0.is_empty() && forced.1 == "model rejected", "{forced:?}");

    let ended = allan(&desk, "gyro.csv --bootstrap 0 --fit-to 8s");
    assert!(ended.stdout.contains("τ 1–8 s, χ²"), "{}", ended.stdout);
    assert_eq!(verdict(&desk, "N").1, "estimated");
}

#[test]
fn the_filter_of_a_sensor_is_said_and_stays_out_of_noise_toml() {
    let white = rates(&[Part::angle_random_walk(0.6)], 32_401, 21);
    let halves: Vec<f64> = white.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let desk = desk_with("gyro.csv", log("gz [deg/h]", &[halves]));
    let ended = allan(&desk, "gyro.csv");
    let said = crate::desk::unwrapped(&ended.stderr);
    assert!(said.contains("the sensor filters its rate") && said.contains("from 2 s on"), "{said}");
    assert_eq!((verdict(&desk, "L").1.as_str(), verdict(&desk, "B").0.as_str()), ("estimated", ""));
    // 0.6 ″/√s in °/√h.
    let (n, found) = verdict(&desk, "N");
    assert!(found == "estimated" && (n.parse::<f64>().unwrap() / 0.01 - 1.0).abs() < 0.05, "{n}: {found}");
    let table: Table = desk.read("out/noise.toml").parse().unwrap();
    assert_eq!(table.keys().collect::<Vec<_>>(), ["angle_random_walk"]);
}
