//! `sagnac compare` of a batch as a user meets it: tables, files, pictures and sentences, and what it refuses.

use crate::desk::{Desk, number, row, rows_of};
use crate::logs::desk_with;
use crate::noise;
use serde_json::Value;

const RATE: &str = "--data rate --unit deg/h --rate 1Hz";

/// White rates of standard deviation `sigma`.
fn white(sigma: f64, seed: u64) -> Vec<f64> {
    noise::white(4096, sigma, seed)
}

/// A log with a column for each standard deviation, called g1, g2, ….
fn log(sigmas: &[f64]) -> Desk {
    let columns: Vec<Vec<f64>> = (1..).zip(sigmas).map(|(seed, &sigma)| white(sigma, seed)).collect();
    let names: Vec<String> = (1..=sigmas.len()).map(|place| format!("g{place}")).collect();
    let row = |i: usize| {
        let cells: Vec<String> = columns.iter().map(|column| format!("{:.6}", column[i])).collect();
        cells.join(",") + "\n"
    };
    desk_with("bench.csv", format!("{}\n{}", names.join(","), (0..4096).map(row).collect::<String>()))
}

#[test]
fn an_outlier_is_named_in_table_csv_json_answer_and_pictures() {
    let desk = log(&[6.0, 6.3, 5.8, 12.0, 6.1, 5.9]);
    let ended = desk.full(&format!("compare bench.csv {RATE} --column g1,g2,g3,g4,g5,g6"));
    for piece in [
        "*0.",
        "without outliers",
        "prediction",
        "g4 is an outlier: N 1.98",
        " × the median (p = ",
        "Without outliers, N  0.1",
        "Between units",
    ] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let units = desk.table("results/batch/units.csv");
    let outlier = row(&units, &[("label", "g4"), ("coefficient", "N")]);
    assert_eq!((outlier["outlier"].as_str(), outlier["unit"].as_str()), ("higher", "deg/sqrt(h)"));
    assert!(number(outlier, "p") < 0.01, "{outlier:?}");
    assert_eq!(units.iter().filter(|row| !row["outlier"].is_empty()).count(), 1);
    let batch = desk.table("results/batch/batch.csv");
    let all = row(&batch, &[("coefficient", "N"), ("of", "all")]);
    let rest = row(&batch, &[("coefficient", "N"), ("of", "without outliers")]);
    assert_eq!((all["units"].as_str(), rest["units"].as_str()), ("6", "5"));
    // 6 °/h in samples of 1 s are 0.1 °/√h.
    assert!((number(rest, "value") / 0.1 - 1.0).abs() < 0.05, "{rest:?}");
    assert!(
        number(rest, "prediction_upper") < 0.15 && number(all, "prediction_upper") > 0.2,
        "{rest:?} {all:?}"
    );
    assert!(number(rest, "unit_sd") < 0.06 && number(all, "unit_sd") > 0.2, "{rest:?} {all:?}");
    for chart in ["chart-1.svg", "chart-1.png", "chart-2.svg", "chart-2.png"] {
        assert!(desk.path(&format!("results/batch/{chart}")).is_file(), "{chart} is missing");
    }
    assert!(desk.read("results/batch/chart-1.svg").contains("g4, outlier"));
    let json = desk.done(&format!("compare bench.csv {RATE} --column g1,g2,g3,g4,g5,g6 --json")).stdout;
    let document: Value = serde_json::from_str(&json).unwrap();
    let is_n = |row: &&Value| row["coefficient"] == "N";
    let units: Vec<_> = rows_of(&document, "units").iter().filter(is_n).collect();
    assert_eq!((&units[3]["outlier"], units.len()), (&"higher".into(), 6));
    let batch: Vec<_> = rows_of(&document, "batch").iter().filter(is_n).collect();
    assert_eq!((&batch[1]["of"], &batch[1]["units"]), (&"without outliers".into(), &5.into()));
}

#[test]
fn logs_of_an_even_batch_have_no_outlier_and_are_called_by_their_files() {
    let desk = log(&[6.0]);
    for (seed, name) in ["a.csv", "b.csv", "c.csv"].into_iter().enumerate() {
        let lines: String = white(6.0, 10 + seed as u64).iter().map(|rate| format!("{rate:.6}\n")).collect();
        desk.write(name, &lines);
    }
    let ended = desk.done(&format!("compare a.csv b.csv c.csv {RATE} --out even"));
    assert!(ended.stdout.contains("No outlier in 3 units: median N 0.1"), "{}", ended.stdout);
    let n = desk.table("even/batch.csv");
    let n = row(&n, &[("coefficient", "N")]);
    assert!(number(n, "p_equal") > 0.01 && number(n, "unit_sd_lower") == 0.0, "{n:?}");
    // The errors of the records allow some spread, whatever was found.
    assert!(number(n, "unit_sd_upper") > 0.01, "{n:?}");
    assert!(number(n, "lower") < 0.1 && 0.1 < number(n, "upper"), "{n:?}");
    let labels: Vec<String> = desk.table("even/units.csv").iter().map(|row| row["label"].clone()).collect();
    assert!(labels.iter().all(|label| ["a", "b", "c"].contains(&label.as_str())), "{labels:?}");
}

#[test]
fn a_unit_that_alone_shows_a_coefficient_is_an_outlier_and_the_others_are_said_to_be_left_out() {
    let desk = log(&[6.0, 6.0, 6.0]);
    // A random walk in the first column, where it dominates the curve at long τ.
    let text = desk.read("bench.csv");
    let (mut walk, steps) = (0.0, white(0.3, 99));
    let lines = text.lines().zip(std::iter::once(&0.0).chain(&steps)).map(|(line, step)| {
        let cells: Vec<&str> = line.split(',').collect();
        walk += step;
        match cells[0].parse::<f64>() {
            Ok(rate) => format!("{:.6},{},{}\n", rate + walk, cells[1], cells[2]),
            Err(_) => format!("{line}\n"),
        }
    });
    desk.write("bench.csv", &lines.collect::<String>());
    let ended = desk.done(&format!("compare bench.csv {RATE} --column g1,g2,g3 --fit N,K"));
    for piece in
        ["g1 is an outlier: K ", ", above all others", "K is estimated in 1 of 3 units, not in g2 and g3"]
    {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let k = desk.table("results/batch/batch.csv");
    let k = row(&k, &[("coefficient", "K"), ("of", "those that show it")]);
    assert_eq!((k["units"].as_str(), k["bounded"].as_str(), k["value"].as_str()), ("1", "2", ""));
}

#[test]
fn what_is_no_batch_is_refused_with_what_to_do() {
    let desk = log(&[6.0, 6.0]);
    let rows: String = white(1.0, 5).iter().map(|y| format!("{y},{y}\n")).collect();
    desk.write("imu.csv", &format!("gx [deg/h],ax [m/s^2]\n{rows}"));
    desk.write("copy.csv", &desk.read("bench.csv"));
    for (words, code, pieces) in [
        (format!("bench.csv {RATE} --column g1"), 2, vec!["at least two units, found 1", "--column gx,gy"]),
        (
            format!("bench.csv bench.csv copy.csv {RATE} --column g1"),
            2,
            vec!["bench.csv g1 and bench.csv g1 are the same record", "each unit once"],
        ),
        (
            format!("bench.csv ./bench.csv copy.csv {RATE} --column g1"),
            2,
            vec!["bench.csv g1 and ./bench.csv g1 are the same"],
        ),
        (
            format!("bench.csv copy.csv ./bench.csv {RATE} --column g1"),
            2,
            vec!["bench.csv g1 and copy.csv g1 are the same record"],
        ),
        (
            "imu.csv --data rate --rate 1Hz --column gx,ax".to_owned(),
            3,
            vec!["gx has angular rates", "ax has accelerations", "--column NAME"],
        ),
        (format!("none.csv {RATE}"), 3, vec!["none.csv"]),
    ] {
        desk.fails(&format!("compare {words}"), code, &pieces);
        assert!(!desk.path("results").exists(), "compare {words} left results");
    }
}

/// Records of three units on a turning table: uniform numbers of these sizes with the same sine, by a congruence that the program
/// behind the expected numbers repeats.
fn on_one_table() -> Desk {
    let numbers = std::iter::successors(Some(1_u64), |n| Some(16_807 * n % 2_147_483_647)).skip(1);
    let mut uniform = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5);
    let columns = [1.0, 2.0, 0.5].map(|size| {
        let rate = |(i, x): (usize, f64)| size * x + 30.0 * (0.01 * i as f64).sin();
        uniform.by_ref().take(1000).enumerate().map(rate).collect::<Vec<f64>>()
    });
    let row = |i: usize| columns.each_ref().map(|column| format!("{:.12}", column[i])).join(",") + "\n";
    desk_with("table.csv", format!("g1,g2,g3\n{}", (0..1000).map(row).collect::<String>()))
}

#[test]
fn units_that_ran_together_have_the_hat_of_allantools() {
    let desk = on_one_table();
    let shown = desk.done(&format!("compare table.csv {RATE} --column g1,g2,g3 --hat --out hat")).stdout;
    assert!(shown.contains("σ(1 s): g1 0.287, g2 0.578, g3 0.125 °/h"), "{shown}");
    assert!(shown.contains("g3: the variance is negative at"), "{shown}");
    let rows = desk.table("hat/hat.csv");
    // allantools 2024.06: gcodev at τ of 1, 4, 16 and 64 s; the last variance of g3 is negative.
    let expected = [
        ("g1", [0.28738858, 0.14441121, 0.06965169, 0.04442035]),
        ("g2", [0.57768581, 0.29247063, 0.13162727, 0.079772]),
        ("g3", [0.1254121, 0.05901771, 0.03115757, -0.00449466]),
    ];
    for (label, deviations) in expected {
        for (tau, deviation) in ["1", "4", "16", "64"].iter().zip(deviations) {
            let found = row(&rows, &[("label", label), ("tau_s", tau)]);
            let variance = number(found, "variance");
            let expected = deviation * f64::abs(deviation);
            assert!(
                (variance / expected - 1.0).abs() < 1e-5,
                "{label} at {tau} s: {variance}, not {expected}"
            );
            let [low, high] = ["variance_lower", "variance_upper"].map(|end| number(found, end));
            assert!(low < variance && variance < high, "{found:?}");
            assert_eq!(found["deviation"].is_empty(), deviation < 0.0, "{found:?}");
        }
    }
    // The size over √12, though all turn by 30 °/h together.
    let first = |label: &str| number(row(&rows, &[("label", label), ("tau_s", "1")]), "deviation");
    for (label, size) in [("g1", 1.0), ("g2", 2.0), ("g3", 0.5)] {
        assert!((first(label) * 12_f64.sqrt() / size - 1.0).abs() < 0.2, "{label}: {}", first(label));
    }
    assert!(desk.read("hat/chart-1.svg").contains("g3 negative"));
}

#[test]
fn units_that_did_not_run_together_have_no_hat() {
    let desk = on_one_table();
    desk.write("short.csv", "1\n2\n3\n1\n2\n3\n1\n2\n3\n1\n2\n3\n1\n2\n3\n1\n2\n3\n");
    desk.fails(&format!("compare table.csv {RATE} --column g1,g2 --hat"), 2, &["found 2"]);
    desk.fails(
        &format!("compare table.csv {RATE} --column g1,g2,g3 --hat --limit N=1deg/rt(h)"),
        2,
        &["--hat"],
    );
    desk.write("one.csv", &format!("g1\n{}", "1\n2\n3\n".repeat(300)));
    let words = format!("compare one.csv short.csv one.csv {RATE} --hat");
    desk.fails(&words, 3, &["they were not sampled together", "--skip TIME"]);
}
