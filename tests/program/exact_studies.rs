//! Studies in closed form: their tables against the references, and what the program does with them.

use crate::desk::{Desk, rows_of};
use crate::studies::{parsed, rows};
use sagnac::run::Plan;
use sagnac::table::Table;

/// The paper's case, figures 4 and 5.
const BUDGET: &str = r#"title = "Budget"
kind = "drift-budget"
[drift]
magnetic = "14 arcsec/s"
warm_up_time = "3000 s"
non_magnetic = "0.05 arcsec/s"
residual_max = "10 arcsec"
[switching]
interval = "40 s"
[run]
duration = "1 h"
"#;

/// The same with an exact end.
fn exact() -> String {
    format!("{BUDGET}end = \"exact\"\n")
}

const SUSPENSION: &str = r#"title = "Suspension"
kind = "suspension"
[suspension]
gyro = "LGK-400"
frequency = "380 Hz"
"#;

fn table(text: &str) -> Table {
    let study = parsed("study.toml", text);
    Plan::new(&study).unwrap().blank_tables().points
}

fn reference(name: &str) -> Vec<Vec<f64>> {
    let path = format!("{}/tests/data/{name}.csv", crate::ROOT);
    let number = |record: csv::StringRecord| record.iter().map(|cell| cell.parse().unwrap()).collect();
    csv::Reader::from_path(path).unwrap().into_records().map(|record| number(record.unwrap())).collect()
}

const RUNS: &str = "[[sweep]]\nkey = \"run.duration\"\nlist = [\"600 s\", \"900 s\", \"1 h\", \"10 h\"]\n";

#[test]
fn the_budget_of_the_paper_is_that_of_the_reference() {
    let intervals = "[[sweep]]\nkey = \"switching.interval\"\nlist = [\"10 s\", \"20 s\", \"40 s\", \"60 s\", \"100 s\", \
                     \"150 s\", \"300 s\"]\n";
    let table = table(&format!("{BUDGET}{RUNS}{intervals}"));
    let expected = reference("drift_budget");
    assert_eq!(table.rows(), expected.len());
    // The optimum of the reference is a least value's place, known to the root of its rounding.
    let columns = [
        ("run.duration", 1e-9),
        ("switching.interval", 1e-9),
        ("bound", 1e-9),
        ("optimum", 1e-7),
        ("optimum_bound", 1e-9),
        ("optimum_as_published", 1e-9),
        ("optimum_limit", 1e-9),
    ];
    for (row, expected) in rows(&table).zip(&expected) {
        for ((name, within), expected) in columns.iter().zip(expected) {
            let off = row.number(name) / expected - 1.0;
            assert!(off.abs() < *within, "{name}: off by {off:e}: {}", row.place());
        }
        let parts = ["bound_non_magnetic", "bound_quasi_non_magnetic", "bound_magnetic", "bound_residual"];
        let sum: f64 = parts.iter().map(|part| row.number(part)).sum();
        assert!((sum / row.number("bound") - 1.0).abs() < 1e-12, "{}", row.place());
    }
}

#[test]
fn mean_drifts_and_switches_of_runs_are_those_of_the_reference() {
    let mut expected = reference("drift_run");
    let runs = "[[sweep]]\nkey = \"run.duration\"\nlist = [\"600 s\", \"1 h\", \"10 h\"]\n";
    let intervals = "[[sweep]]\nkey = \"switching.interval\"\nlist = [\"20 s\", \"40 s\", \"60 s\", \"100 s\", \"150 s\", \
                     \"300 s\"]\n";
    let table = table(&format!("{}{runs}{intervals}", exact()));
    assert_eq!(table.rows(), expected.len());
    for (row, expected) in rows(&table).zip(&mut expected) {
        let names = ["run.duration", "switching.interval", "switches", "mean_drift"];
        for (name, expected) in names.iter().zip(expected.iter()) {
            let off = row.number(name) / expected - 1.0;
            assert!(off.abs() < 1e-9, "{name}: off by {off:e}: {}", row.place());
        }
        let angle = (expected[3] - 0.05) * expected[0];
        let off = row.number("magnetic_angle") / angle - 1.0;
        assert!(off.abs() < 1e-9, "magnetic_angle: off by {off:e}: {}", row.place());
        let both = row.number("mean_drift") + row.number("mean_drift_negative");
        assert!((both - 0.1).abs() < 1e-12, "{}", row.place());
    }
}

/// Averaged over the phase of switching, what the last interval leaves is a twelfth of its square, and its mean nothing.
#[test]
fn a_budget_whose_end_is_averaged_is_that_of_the_closed_form() {
    let table = table(&format!("{BUDGET}{RUNS}"));
    for row in rows(&table) {
        let t = row.number("run.duration");
        // Of a magnetic drift that grows over the interval, first order in MT/τ.
        let rate = 14.0 * (1.0 - (-t / 3000.0_f64).exp());
        let found = row.number("switching_drift");
        assert!((found / (rate * 40.0 / 12.0_f64.sqrt() / t) - 1.0).abs() < 0.01, "{}", row.place());
        assert!((row.number("mean_drift") - 0.05).abs() < 0.002, "{}", row.place());
        let residuals = 50.0 * (t / 40.0 - 0.5) / (t * t);
        let rms = row.number("rms_switching");
        assert!((rms * rms / (found * found + residuals) - 1.0).abs() < 1e-9, "{}", row.place());
        let least = row.number("optimum_true_rms");
        assert!(least <= rms * 1.001, "{least}, but {rms} at 40 s: {}", row.place());
    }
}

/// The optimum is that of a column of the same study, found by sweeping the interval.
#[test]
fn the_best_interval_is_the_one_with_the_least_drift_in_the_table_whatever_the_initial_magnetic_drift() {
    let study = "title = \"Budget\"\nkind = \"drift-budget\"\n\
                 [drift]\nmagnetic = \"5 arcsec/s\"\nwarm_up_time = \"1800 s\"\nresidual_max = \"3 arcsec\"\n\
                 [switching]\ninterval = \"40 s\"\n[run]\nduration = \"1 h\"\n\
                 [[sweep]]\nkey = \"drift.initial_magnetic\"\n\
                 list = [\"-5 arcsec/s\", \"0 arcsec/s\", \"0.3 arcsec/s\", \"2 arcsec/s\", \"5 arcsec/s\"]\n\
                 [[sweep]]\nkey = \"switching.interval\"\nlog = { from = \"5 s\", to = \"40 s\", points = 201 }\n";
    let table = table(study);
    let rows: Vec<_> = rows(&table).collect();
    for initial in [-5.0, 0.0, 0.3, 2.0, 5.0] {
        let own = rows.iter().filter(|row| row.number("drift.initial_magnetic") == initial);
        let least =
            own.min_by(|a, b| a.number("rms_switching").total_cmp(&b.number("rms_switching"))).unwrap();
        let [interval, rms, best, best_rms] =
            ["switching.interval", "rms_switching", "optimum_true", "optimum_true_rms"]
                .map(|name| least.number(name));
        assert!((best / interval - 1.0).abs() < 0.02, "Ω_m0 = {initial} ″/s: {best} s, not {interval} s");
        assert!((best_rms / rms - 1.0).abs() < 0.001, "Ω_m0 = {initial} ″/s: {best_rms} ″/s, not {rms} ″/s");
    }
}

#[test]
fn a_root_that_is_not_there_is_blank() {
    let table =
        table(&format!("{BUDGET}[[sweep]]\nkey = \"run.duration\"\nlist = [\"40655 s\", \"40656 s\"]\n"));
    let found: Vec<bool> = rows(&table).map(|row| row.maybe("optimum_as_published").is_some()).collect();
    assert_eq!(found, [true, false]);
}

#[test]
fn without_a_warm_up_time_the_magnetic_drift_is_there_from_the_start() {
    let table = table(&exact().replace("warm_up_time = \"3000 s\"\n", "").replace("40 s", "3599 s"));
    let row = rows(&table).next().unwrap();
    assert!((row.number("bound_magnetic") - 14.0 * 3599.0 / 3600.0).abs() < 1e-9, "{}", row.place());
    assert_eq!(row.number("bound_quasi_non_magnetic"), 0.0);
    assert!((row.number("mean_drift") - 0.05 - 14.0 * 3598.0 / 3600.0).abs() < 1e-9, "{}", row.place());
}

#[test]
fn without_residuals_there_is_no_best_interval_and_its_limits_are_blank() {
    let table = table(&BUDGET.replace("10 arcsec", "0 arcsec"));
    let row = rows(&table).next().unwrap();
    let names =
        ["optimum", "optimum_as_published", "optimum_expanded", "optimum_limit", "optimum_limit_small"];
    assert_eq!(names.map(|name| row.maybe(name)), [None; 5]);
}

#[test]
fn that_the_response_of_a_known_suspension_is_assumed_is_said() {
    let note = "Q factors and responses of the suspension of LGK-400 are assumed";
    let notes = |text: &str| parsed("study.toml", text).notes.join("\n");
    assert!(notes(SUSPENSION).contains(note), "{}", notes(SUSPENSION));
    let own = "modes = [{ frequency = \"380 Hz\", q = 50, response = \"1 deg/s/g\" }]";
    assert_eq!(notes(&SUSPENSION.replace("gyro = \"LGK-400\"", own)), "");
}

#[test]
fn a_suspension_responds_at_its_useful_mode_as_it_says() {
    let table = table(&format!(
        "{SUSPENSION}[[sweep]]\nkey = \"suspension.gyro\"\nlist = [\"LGV-1\", \"LGK-400\"]\n"
    ));
    let found: Vec<(String, f64)> =
        rows(&table).map(|row| (row.text("suspension.gyro"), row.number("normalized"))).collect();
    assert_eq!(found[1], ("LGK-400".to_owned(), 1.0));
    assert!(found[0].1 < 0.1, "{found:?}");
}

#[test]
fn closed_forms_need_no_device_and_say_that_trials_have_no_use() {
    let desk = Desk::with(&format!("{BUDGET}{RUNS}"));
    let ended = desk.sagnac("run study.toml --trials 10 --device none --table");
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("trials, seed and device are not used"), "{}", ended.stderr);
    assert!(!ended.stderr.contains("device: "), "{}", ended.stderr);
    assert!(ended.stdout.contains("drift: bound, Z(7), ″/s"), "{}", ended.stdout);
    let names = desk.names("results/study");
    let written = [
        "chart.png",
        "chart.svg",
        "points.csv",
        "report.html",
        "resolved_study.toml",
        "tallies.lock",
        "tallies.sqlite",
        "written_by_sagnac.jsonl",
    ];
    assert_eq!(names, written);
    assert_eq!(desk.read("results/study/resolved_study.toml"), desk.read("study.toml"));
    let ended = desk.sagnac("run study.toml --json");
    let document: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(document.get("provenance"), None, "nothing is sampled");
    assert_eq!(rows_of(&document, "points").len(), 4);
}

#[test]
fn a_single_point_is_shown_whole() {
    let desk = Desk::with(BUDGET);
    let ended = desk.done("run study.toml --table");
    for piece in ["drift: bound, Z(7), ″/s", "0.500802", "best interval: Z(9) as published, s", "61.1993"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
}

#[test]
fn each_column_of_a_list_is_a_curve_with_a_row_of_its_own() {
    let chart = "[chart]\nx = \"duration\"\ny = [\"bound\", \"switching_drift\"]\nlimit = \"0.5 arcsec/s\"\n";
    let desk = Desk::with(&format!("{BUDGET}{RUNS}{chart}"));
    let ended = desk.done("run study.toml");
    for piece in ["left by switching       everywhere", "bound, Z(7)             ≥ 61.1 min"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let svg = desk.read("results/study/chart.svg");
    assert!(svg.contains(">drift, ″/s<") && svg.contains(">bound, Z(7)<"), "labels are missing");
}

/// What is said of a study that is refused: where, and pieces of it.
fn refused(text: &str, place: &str, pieces: &[&str]) {
    let desk = Desk::with(text);
    desk.fails("run study.toml", 3, &[&[&*format!("[study.toml:{place}]")], pieces].concat());
}

#[test]
fn budgets_that_make_no_sense_are_refused() {
    let with = |old: &str, new: &str| {
        assert!(BUDGET.contains(old), "{old}");
        BUDGET.replace(old, new)
    };
    refused(&with("1 h", "30 s"), "9:12", &["a run of 30 s is shorter than the switching interval of 40 s"]);
    refused(&with("residual_max = \"10 arcsec\"\n", ""), "3:1", &["drift.residual_max` is missing"]);
    refused(&with("interval = \"40 s\"\n", ""), "8:1", &["switching.interval` is missing"]);
    refused(
        &with("interval = \"40 s\"", "interval = \"40 s\"\ngap_ticks = 3"),
        "10:13",
        &["gap_ticks is not a key"],
    );
    let spread = with("non_magnetic =", "non_magnetic_spread = \"1 arcsec/s\"\nnon_magnetic =");
    refused(
        &spread,
        "6:23",
        &["drift.non_magnetic_spread is not a key of a study of kind = \"drift-budget\""],
    );
    refused(
        &with("10 arcsec", "-10 arcsec"),
        "7:16",
        &["drift.residual_max = -10″ is out of range", "negative"],
    );
    refused(
        &format!("precision = \"1 %\"\n{BUDGET}"),
        "1:13",
        &["precision is not a key", "kind = \"gap-fill\""],
    );
    refused(
        &format!("{BUDGET}[motion]\nrate = \"1 deg/s\"\n"),
        "12:1",
        &["[motion] is not a table of a study"],
    );
    let sweep = "[[sweep]]\nkey = \"drift.magnetic_spread\"\nlist = [\"1 arcsec/s\"]\n";
    refused(&format!("{BUDGET}{sweep}"), "13:7", &["there is no key `drift.magnetic_spread` to sweep"]);
}

#[test]
fn suspensions_that_make_no_sense_are_refused() {
    let with = |old: &str, new: &str| {
        assert!(SUSPENSION.contains(old), "{old}");
        SUSPENSION.replace(old, new)
    };
    refused(
        &with("LGK-400", "LGK-40"),
        "4:8",
        &["there is no suspension \"LGK-40\"", "did you mean `LGK-400`?"],
    );
    refused(&with("gyro = \"LGK-400\"\n", ""), "3:1", &["needs exactly one of gyro, modes"]);
    refused(&with("frequency = \"380 Hz\"\n", ""), "3:1", &["suspension.frequency` is missing"]);
    let modes = |mode: &str| with("gyro = \"LGK-400\"", &format!("modes = [{mode}]"));
    refused(&modes(""), "4:9", &["suspension.modes has 0 modes", "1 to 16 modes"]);
    let mode = |q: &str, response: &str| {
        modes(&format!("{{ frequency = \"380 Hz\", q = {q}, response = \"{response}\" }}"))
    };
    refused(&mode("0.1", "1 deg/s/g"), "4:38", &["suspension.modes.q = 0.1 is out of range", "0.5 to 10000"]);
    refused(&mode("\"high\"", "1 deg/s/g"), "4:38", &["suspension.modes.q: \"high\" is not a ratio"]);
    refused(&mode("50", "1 deg/s"), "4:53", &["is an angular rate", "arcsec/s/g"]);
    let sweep = |list: &str| format!("{SUSPENSION}[[sweep]]\nkey = \"suspension.gyro\"\n{list}\n");
    refused(
        &sweep("list = [\"LGK-400\", \"LG\"]"),
        "8:20",
        &["there is no \"LG\"", "accepted: LGK-400, LGV-1"],
    );
    refused(&sweep("list = [\"LGV-1\", \"LGV-1\"]"), "8:18", &["takes LGV-1 twice"]);
    refused(&sweep("linear = { from = 1, to = 2, points = 2 }"), "7:7", &["needs list, it is over names"]);
}

#[test]
fn lists_of_columns_that_make_no_sense_are_refused() {
    let chart = |lines: &str| format!("{BUDGET}{RUNS}[chart]\nx = \"duration\"\n{lines}\n");
    refused(&chart("y = [\"bound\"]"), "17:5", &["chart.y lists 1 columns", "2 to 8"]);
    refused(&chart("y = 5"), "17:5", &["`chart.y` is the number 5"]);
    refused(&chart("y = [\"bound\", \"bound\"]"), "17:15", &["`bound` is listed twice"]);
    refused(&chart("y = [\"bound\", \"optimum\"]"), "17:15", &["`optimum` is in s, a curve in ″/s"]);
    refused(&chart("y = [\"bound\", \"none\"]"), "17:15", &["no column is called `none`"]);
    let missing = format!("{BUDGET}{RUNS}[chart]\nx = \"duration\"\n");
    refused(&missing, "15:1", &["`chart.y` is missing", "y = \"bound\""]);
    let limited = "y = [\"bound\", \"mean_drift\"]\nlimit = \"10 s\"";
    refused(&chart(limited), "17:6", &["`bound` is in ″/s, a limit in s cannot be drawn on it"]);
    let series = "y = [\"bound\", \"mean_drift\"]\nseries = [\"duration\", \"switches\"]";
    refused(&chart(series), "18:10", &["series names two columns, but y lists several"]);
    let map = "y = [\"bound\", \"mean_drift\"]\nkind = \"heat-map\"\nz = \"bound\"";
    refused(&chart(map), "17:5", &["has one column y"]);
}
