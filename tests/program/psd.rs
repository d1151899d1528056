//! The spectrum of `sagnac allan` as a user meets it.

use crate::desk::{number, rows_of};
use crate::logs::{desk_with, noise};
use serde_json::Value;

const READ: &str = "--data rate --unit deg/h --rate 100Hz --bootstrap 0";

/// Sums of twelve numbers, 100 a second, whose variance is 4 (°/h)², with a sine of 20 Hz and 0.3 °/h.
fn rates(count: usize) -> Vec<f64> {
    let numbers: Vec<f64> = noise(12 * count).collect();
    let sine = |i: usize| 0.3 * (0.4 * std::f64::consts::PI * i as f64).sin();
    numbers.chunks(12).enumerate().map(|(i, chunk)| chunk.iter().sum::<f64>() + sine(i)).collect()
}

fn text(rates: &[f64]) -> String {
    rates.iter().map(|rate| format!("{rate}\n")).collect()
}

#[test]
fn density_line_and_floor_of_a_log_are_in_files_text_chart_and_json() {
    let desk = desk_with("gyro.csv", text(&rates(16_384)));
    let ended = desk.full(&format!("allan gyro.csv {READ} --plot"));
    for piece in
        ["16384 samples at 100 Hz", "one-sided, Hann window, 15 segments of 20.48 s", "20.0", "consistent"]
    {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    assert!(!ended.stderr.contains("note: 1: the density"), "{}", ended.stderr);
    let header = "column,f_hz,density,lower,upper,model,unit,treatment";
    assert_eq!(desk.read("results/gyro/psd.csv").lines().next(), Some(header));
    let densities = desk.table("results/gyro/psd.csv");
    assert_eq!(densities.len(), 1024);
    // 2·4 (°/h)² over 100 Hz, and half of the square of the amplitude besides.
    let sum: f64 = densities.iter().map(|row| number(row, "density") * 100.0 / 2048.0).sum();
    assert!((sum / 4.045 - 1.0).abs() < 0.05, "{sum}");
    assert!((number(&densities[500], "model") / 0.08 - 1.0).abs() < 0.1, "{:?}", densities[500]);
    let lines = desk.table("results/gyro/lines.csv");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(
        (number(&lines[0], "f_hz") - 20.0).abs() < 0.01 && (number(&lines[0], "amplitude") - 0.3).abs() < 0.1
    );
    let white = desk.table("results/gyro/white_noise.csv");
    let [floor, fit] = &white[..] else { panic!("{white:?}") };
    // √(4 (°/h)²/100 Hz) in °/√h.
    assert!((60.0 * number(floor, "n") / 0.2 - 1.0).abs() < 0.05, "{floor:?}");
    assert_eq!((floor["from"].as_str(), fit["from"].as_str()), ("floor", "fit"));
    let svg = desk.read("results/gyro/psd.svg");
    for piece in ["One-sided power spectral density", "(°/h)²/Hz", "95 % intervals", "parts of the fit"] {
        assert!(svg.contains(piece), "{piece} is missing in the chart");
    }
    assert!(desk.path("results/gyro/psd.png").exists());
    let document: Value =
        serde_json::from_str(&desk.done(&format!("allan gyro.csv {READ} --json")).stdout).unwrap();
    assert_eq!(rows_of(&document, "records")[0]["segments"], 15);
    // The table has nine digits.
    let density = rows_of(&document, "psd")[99]["density"].as_f64().unwrap();
    assert!((density / number(&densities[99], "density") - 1.0).abs() < 1e-8, "{density}");
}

#[test]
fn axes_gaps_and_plain_numbers_have_spectra_too() {
    let numbers = rates(4000);
    let row = |i: usize| match i {
        1500..1600 => format!("nan,{}\n", numbers[i]),
        _ => format!("{},{}\n", numbers[i], 2.0 * numbers[i]),
    };
    let desk = desk_with("log.csv", format!("gx,gy\n{}", (0..4000).map(row).collect::<String>()));
    let ended = desk
        .full("allan log.csv --data rate --unit none --rate 1Hz --column gx,gy --fit none --segment 1000s");
    for piece in ["gx: density", "gy: density", "floor", "no fit"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    for piece in ["gx: 400 of 4000 samples are in no segment", "gx: 100 of 4000 samples are missing"] {
        assert!(ended.stderr.contains(piece), "{piece} is missing in\n{}", ended.stderr);
    }
    let densities = desk.table("results/log/psd.csv");
    assert_eq!(densities.len(), 1000);
    assert!(densities.iter().all(|row| row["unit"].is_empty() && row["model"].is_empty()));
}

#[test]
fn a_log_without_a_spectrum_is_refused_by_name_with_what_to_do() {
    let desk = desk_with("log.csv", text(&rates(200)));
    for (words, code, pieces) in [
        (
            "--segment 3s",
            3,
            vec!["column 1: the segment of 3 s is too long", "stretch without gaps has 2 s", "--segment 2s"],
        ),
        ("--segment 0.1s", 3, vec!["column 1: the segment of 10 samples is too short", "--segment 0.16s"]),
        ("--segment fast", 2, vec!["--segment", "a time in s, ms"]),
        ("--confidence 1", 2, vec!["not between 0 and 1"]),
    ] {
        desk.fails(&format!("allan log.csv {READ} {words}"), code, &pieces);
        assert!(!desk.path("results").exists(), "{words} left results");
    }
}
