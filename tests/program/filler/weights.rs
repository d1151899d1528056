//! The weights, gains and errors are those of theory, on the terminal, in JSON and in weights.csv.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::fillers::{STUDY, entry, near, rows, tables};
use crate::desk::Desk;

#[test]
fn weights_gains_and_amplitudes_are_those_of_theory() {
    let desk = Desk::with(STUDY);
    let json = tables(&desk, "study.toml");
    assert!(json["question"].as_str().unwrap().ends_with("Weights for a gap of 3 lost ticks of 5 ms"));
    let quadratic = entry(&json, "quadratic", "residual");
    assert_eq!(quadratic["ticks"], serde_json::json!([-1, 0, 4, 5]));
    near(&quadratic["weights"], &[-1.0, 2.5, 2.5, -1.0], 0.0);
    near(&quadratic["noise_gain"], &[3.808], 5e-4);
    near(&quadratic["largest_gain"], &[7.0], 1e-12);
    near(&quadratic["amplitude_arcsec"], &[26.848], 5e-4);
    // The amplitude over the root of 2, and 1.6/3 ″ of noise 3.808 times.
    near(&quadratic["rms_arcsec"], &[19.0926], 2e-3);
    let extrapolation = entry(&json, "quadratic", "extrapolation");
    near(&extrapolation["weights"], &[6.35, -9.05, -6.95, 12.65], 1e-12);
    near(&extrapolation["noise_gain"], &[18.181], 5e-4);
    near(&extrapolation["amplitude_arcsec"], &[260.4], 0.05);
    let linear = entry(&json, "linear", "extrapolation");
    near(&linear["weights"], &[-2.4, -0.3, 1.8, 3.9], 1e-12);
    near(&entry(&json, "const", "residual")["amplitude_arcsec"], &[154.511], 5e-4);
    let best = entry(&json, "mv8+2", "residual");
    assert_eq!(best["ticks"].as_array().unwrap().len(), 10);
    assert_eq!(entry(&json, "given", "residual")["by_tick"], Value::Null);
}

#[test]
fn polynomials_are_those_of_the_reference_table() {
    let rows = reference("gap_weights.csv");
    assert_eq!(rows.len(), 18);
    let desk = Desk::with("");
    for n in 1..=3 {
        let gap = n.to_string();
        let json = tables(&desk, &format!("const linear quadratic --gap-ticks {gap}"));
        for row in rows.iter().filter(|row| row["gap_ticks"] == gap) {
            let number = |column: &str| row[column].parse::<f64>().unwrap();
            let found = entry(&json, &row["order"], &row["error"]);
            near(&found["weights"], &["w1", "w2", "w3", "w4"].map(number), 1e-11);
            near(&found["noise_gain"], &[number("noise_gain")], 1e-10);
            assert_eq!(found["exact"], "yes");
            let sum: i64 = found["numerators"].as_array().unwrap().iter().map(|w| w.as_i64().unwrap()).sum();
            assert_eq!(Some(sum), found["denominator"].as_i64().map(|d| n * d), "{row:?}");
        }
    }
}

#[test]
fn minimum_variance_is_that_of_the_reference_table() {
    let rows = reference("gap_minimum_variance.csv");
    assert_eq!(rows.len(), 36);
    let desk = Desk::with("");
    for row in &rows {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        let (low, high) = (&row["band_lo_hz"], &row["band_hi_hz"]);
        let band = if low == high { format!("{low}Hz") } else { format!("{low}Hz,{high}Hz") };
        let ticks = match &*row["fit_ticks"] {
            "4" => "-1,0,n+1,n+2",
            "8+2" => "-7..0,n+1,n+2",
            _ => "-7..0,n+1..n+8",
        };
        let fixed = "minimum-variance --tick 5ms --amplitude 12000arcsec/s";
        let (n, noise) = (&row["gap_ticks"], 1.6 / 3.0);
        let of_row = format!("--noise {noise}arcsec --gap-ticks {n} --band {band} --fit-ticks {ticks}");
        let json = tables(&desk, &format!("{fixed} {of_row}"));
        let found = entry(&json, "minimum-variance", "residual");
        // The motion is ten thousand times the noise, and the weights are as sensitive to the digits of its covariance.
        let tolerance = 1e-5 * number("noise_gain").max(1.0);
        near(&found["noise_gain"], &[number("noise_gain")], tolerance);
        let weights = found["weights"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap().abs());
        near(&Value::from(weights.fold(0.0, f64::max)), &[number("largest_weight")], tolerance);
        near(&found["rms_arcsec"], &[number("rms_arcsec")], 2e-4 * number("rms_arcsec"));
        assert_eq!(found["exact"], "no");
    }
}

/// The rows of a table of reference values.
fn reference(name: &str) -> Vec<BTreeMap<String, String>> {
    rows(&Path::new(crate::ROOT).join("tests/data").join(name))
}

#[test]
fn rows_by_tick_are_the_polynomial_at_each_lost_tick_and_sum_to_1() {
    let desk = Desk::with(STUDY);
    let json = tables(&desk, "study.toml");
    // Numerators by hand: a line through ticks −3 … 0 has the value Σ (¼ + (j + 1.5)(k + 1.5)/5) P_k at tick j.
    let linear = entry(&json, "linear", "extrapolation");
    let denominator = linear["denominator"].as_f64().unwrap();
    for j in 1..=3 {
        let expected: Vec<f64> = (-3..=0)
            .map(|k| denominator * (0.25 + (f64::from(j) + 1.5) * (f64::from(k) + 1.5) / 5.0))
            .collect();
        near(&linear["by_tick"][j as usize - 1], &expected, 1e-9);
    }
    for filler in ["const", "linear", "quadratic", "mv8+2"] {
        for error in ["residual", "extrapolation"] {
            let entry = entry(&json, filler, error);
            for row in entry["by_tick"].as_array().unwrap() {
                let sum: i64 = row.as_array().unwrap().iter().map(|w| w.as_i64().unwrap()).sum();
                assert_eq!(Some(sum), entry["denominator"].as_i64(), "{filler}, {error}");
            }
        }
    }
}

#[test]
fn the_terminal_shows_exact_fractions_and_says_what_a_filler_does_not_give() {
    let desk = Desk::with(STUDY);
    let ended = desk.full("filler study.toml");
    for piece in [
        "n = 3 lost ticks of 5 ms",
        "given: only the sum over the gap",
        "given: no value while the gap is open",
        "tick E1 E2 E3 sum −3 3/4",
        "127/20",
        "√Σw² = 3.8079",
        "√Σw² = 18.181",
        "Amplitude of the error 26.848″ at 20 Hz and 12000 ″/s",
        "rms error with noise 19.093″",
        "rounded to the nearest with Σw kept, over 2^24",
        "exact, over 130",
    ] {
        let said = ended.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
        let piece = piece.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(&piece), "{piece} is missing:\n{}", ended.stdout);
    }
    assert!(ended.stderr.contains("results/study/filler"), "{}", ended.stderr);
    assert!(!ended.stderr.contains("point 1 of"), "{}", ended.stderr);
}

#[test]
fn a_point_that_cannot_be_sampled_has_weights_but_no_rms() {
    let desk = Desk::with(&STUDY.replace("1.6 arcsec", "1e-9 arcsec"));
    let words = "study.toml --filler quadratic";
    let ended = desk.done(&format!("filler {words}"));
    assert!(ended.stdout.contains("there is no rms: gyro.tick_noise"), "{}", ended.stdout);
    let json = tables(&desk, words);
    assert_eq!(entry(&json, "quadratic", "residual")["rms_arcsec"], Value::Null);
}

#[test]
fn every_weight_has_a_row_in_weights_csv() {
    let desk = Desk::with(STUDY);
    desk.done("filler study.toml --out out");
    let rows = rows(&desk.path("out/weights.csv"));
    let of = |filler: &str, error: &str, row: &str| -> Vec<f64> {
        let wanted =
            |r: &&BTreeMap<String, String>| r["filler"] == filler && r["error"] == error && r["row"] == row;
        rows.iter().filter(wanted).map(|r| r["weight"].parse().unwrap()).collect()
    };
    assert_eq!(of("quadratic", "residual", "sum"), [-1.0, 2.5, 2.5, -1.0]);
    assert_eq!(of("const", "residual", "2"), [0.25; 4]);
    assert_eq!(of("mv8+2", "residual", "1").len(), 10);
    assert_eq!(of("given", "residual", "sum"), [-1.0, 2.5, 2.5, -1.0]);
    assert_eq!((of("given", "residual", "1").len(), of("given", "extrapolation", "sum").len()), (0, 0));
    for row in &rows {
        let [numerator, denominator, weight]: [f64; 3] =
            ["numerator", "denominator", "weight"].map(|column| row[column].parse().unwrap());
        assert_eq!(numerator / denominator, weight, "{row:?}");
    }
    assert!(desk.read("out/response.svg").contains("quadratic"));
    assert_eq!(&std::fs::read(desk.path("out/response.png")).unwrap()[1..4], b"PNG");
}
