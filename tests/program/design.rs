//! `sagnac design` as a user meets it: the recommendation, its evidence, and what is refused.

use crate::desk::{Desk, rows_of};
use serde_json::Value;

/// The paper's case, one hour.
const PAPER: &str = r#"title = "The paper's gyro"
kind = "switched-run"
trials = 4096
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

/// Two fillers, ten minutes.
const FILLED: &str = r#"title = "Two fillers"
kind = "switched-run"
trials = 8192
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[drift]
magnetic = "14 arcsec/s"
warm_up_time = "3000 s"
[switching]
interval = "40 s"
gap_ticks = 1
fillers = ["const", "quadratic"]
[run]
duration = "10 min"
"#;

fn designed(desk: &Desk, options: &str) -> Value {
    let ended = desk.done(&format!("design study.toml --device cpu --json --out out {options}"));
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}:\n{}", ended.stdout))
}

/// The row of the best filler.
fn best(found: &Value) -> &Value {
    rows_of(found, "fillers").iter().find(|row| row["times_least"] == 1.0).unwrap()
}

fn number(found: &Value, key: &str) -> f64 {
    found[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {found:#}"))
}

/// A study of which there is no design: exit 3, its place, every piece, and nothing left behind.
fn refused(text: &str, place: &str, pieces: &[&str]) {
    let desk = Desk::with(text);
    let place = format!("[study.toml:{place}]");
    let all: Vec<&str> = [place.as_str(), "help:"].iter().chain(pieces).copied().collect();
    desk.fails("design study.toml --device cpu --trials 100", 3, &all);
    assert_eq!(desk.names("."), ["study.toml"], "something was left behind");
}

#[test]
fn the_best_interval_of_the_papers_gyro_is_that_of_the_closed_form() {
    let desk = Desk::with(PAPER);
    let found = designed(&desk, "--by drift_rms");
    let of_best = |key: &str| number(best(&found), key);
    let [low, best, high] = ["interval_lo_s", "interval_s", "interval_hi_s"].map(of_best);
    assert!(low <= best && best <= high, "{best} s is not within {low} to {high} s");
    // [6σ²t/(A²(1 − e^{−t/τ})²)]^{1/3}, σ = 10/√2: the end is averaged over the phase of switching.
    let warmed = 1.0 - (-3600.0_f64 / 3000.0).exp();
    let exact = (6.0 * 50.0 * 3600.0 / (14.0 * warmed).powi(2)).cbrt();
    assert!((22.40..22.45).contains(&exact), "{exact}");
    assert!(low < exact && exact < high, "{exact:.2} s is not within {low:.2} to {high:.2} s");
    assert!((high / low).ln() < 0.4, "{low:.2} to {high:.2} s says little");
    // 0.0304 ″/s of switching and Ω_nm = 0.05 ″/s.
    let drift = of_best("drift_deg_per_h");
    assert!((drift / 0.0304_f64.hypot(0.05) - 1.0).abs() < 0.03, "{drift}");
    assert!((of_best("angle_arcsec") / (3600.0 * drift) - 1.0).abs() < 1e-12, "{found:#}");
    // Z(7): 0.4979 ″/s at 44.80 s.
    let bound = ["rule_interval_s", "rule_bound_deg_per_h"].map(of_best);
    assert!((bound[0] - 44.80).abs() < 0.01 && (bound[1] - 0.4979).abs() < 1e-4, "{bound:?}");
    let by_rule = of_best("rule_drift_deg_per_h");
    assert!(by_rule > 1.05 * drift && by_rule < 0.2 * bound[1], "{by_rule} beside {drift}");
    for tried in rows_of(&found, "design") {
        let [drift, low, high, exact] = ["drift_rms", "drift_rms_lo", "drift_rms_hi", "closed_form_rms"]
            .map(|key| number(tried, &format!("{key}_deg_per_h")));
        // 95 % intervals of 18 candidates on the same random numbers: 5 standard errors.
        let se = (high - low) / (2.0 * 1.96);
        assert!((drift - exact).abs() < 5.0 * se, "{drift} instead of {exact}, standard error {se}: {tried}");
        assert!((number(tried, "switched_deg_per_h").hypot(0.05) / drift - 1.0).abs() < 0.03, "{tried}");
    }
}

/// The drift of a design at its best interval and 10 % beside it is that of `run` there, with other random numbers.
#[test]
fn a_run_at_the_best_interval_and_beside_it_has_the_drift_of_the_design() {
    for text in [PAPER, FILLED] {
        let desk = Desk::with(&text.replace("trials = 4096", "trials = 8192"));
        let best = number(best(&designed(&desk, "--by drift_rms")), "interval_s");
        let at = |part: f64| format!("\"{:.3} s\"", (part * best / 0.005).round() * 0.005);
        let list = [0.9, 1.0, 1.1].map(at).join(", ");
        let sweep = format!("[[sweep]]\nkey = \"switching.interval\"\nlist = [{list}]\n");
        desk.write("study.toml", &format!("{}{sweep}", text.replace("trials = 4096", "trials = 8192")));
        let found = designed(&desk, "--by drift_rms");
        desk.done("run study.toml --device cpu --quiet --out run");
        let table = desk.read("run/points.csv");
        let mut lines = csv::Reader::from_reader(table.as_bytes());
        let headers = lines.headers().unwrap().clone();
        let cell = |row: &csv::StringRecord, name: &str| {
            row[headers.iter().position(|header| header == name).unwrap()].to_owned()
        };
        let rows: Vec<_> =
            lines.records().map(Result::unwrap).filter(|row| cell(row, "angle") == "end").collect();
        let mut compared = 0;
        for tried in rows_of(&found, "design") {
            let same = |row: &&csv::StringRecord| {
                let interval: f64 = cell(row, "switching.interval_s").parse().unwrap();
                (interval - number(tried, "interval_s")).abs() < 1e-9
                    && (tried["filler"] == "as given"
                        || cell(row, "filler") == tried["filler"].as_str().unwrap())
            };
            let row = rows.iter().find(same).unwrap_or_else(|| panic!("no run at {tried}"));
            let number_of = |name: &str| cell(row, name).parse::<f64>().unwrap();
            let se = number_of("rms_se_arcsec") / number_of("time_s");
            let of_design = (number(tried, "drift_rms_hi_deg_per_h")
                - number(tried, "drift_rms_lo_deg_per_h"))
                / (2.0 * 1.96);
            let apart = number_of("drift_rms_deg_per_h") - number(tried, "drift_rms_deg_per_h");
            assert!(apart.abs() < 4.0 * se.hypot(of_design), "{apart} °/h apart: {tried}, {row:?}");
            compared += 1;
        }
        assert_eq!(compared, rows.len());
    }
}

#[test]
fn the_recommendation_has_the_documented_keys_and_files() {
    let desk = Desk::with(FILLED);
    let found = designed(&desk, "");
    assert_eq!(
        desk.names("out"),
        [
            "card.json",
            "design.csv",
            "design.json",
            "design.png",
            "design.svg",
            "fillers.csv",
            "report.html",
            "tallies.lock",
            "written_by_sagnac.jsonl"
        ]
    );
    assert_eq!(serde_json::from_str::<Value>(&desk.read("out/design.json")).unwrap(), found);
    for key in [
        "interval_s",
        "interval_lo_s",
        "interval_hi_s",
        "drift_deg_per_h",
        "drift_lo_deg_per_h",
        "drift_hi_deg_per_h",
        "rule_drift_deg_per_h",
        "rule_interval_s",
        "rule_bound_deg_per_h",
        "duration_s",
        "angle_arcsec",
        "residual_rms_arcsec",
        "residual_max_arcsec",
    ] {
        assert!(number(best(&found), key) >= 0.0, "{key}");
    }
    let provenance = &found["provenance"];
    assert_eq!((&provenance["trials"], &provenance["seed"]), (&8192.into(), &1.into()));
    assert_eq!(best(&found)["filler"], "quadratic");
    let fillers = rows_of(&found, "fillers");
    assert_eq!(fillers.iter().map(|filler| &filler["filler"]).collect::<Vec<_>>(), ["const", "quadratic"]);
    let [constant, quadratic] = [0, 1].map(|row| number(&fillers[row], "drift_deg_per_h"));
    assert!(constant > 2.0 * quadratic, "the constant leaves more");
    let tried = rows_of(&found, "design");
    let rows = desk.read("out/design.csv").lines().count() - 1;
    assert_eq!(rows, tried.len(), "each candidate has a row");
    assert!(tried.iter().all(|row| row["drift_p99_73_deg_per_h"].is_number()), "{found:#}");
    // Every interval is a whole number of ticks.
    for tried in tried {
        let ticks = number(tried, "interval_s") / 0.005;
        assert!((ticks - ticks.round()).abs() < 1e-6, "{ticks} ticks");
    }
}

#[test]
fn the_answer_of_a_design_has_the_numbers_of_its_json() {
    let desk = Desk::with(FILLED);
    let ended = desk.done("design study.toml --device cpu --out out");
    let said = &ended.stdout;
    for piece in ["▸ quadratic", "  const ", "after 10 min", "Paper's rule", "Error budget"] {
        assert!(said.contains(piece), "`{piece}` is missing:\n{said}");
    }
    let ended = desk.done("design study.toml --device cpu --quiet --out out");
    assert_eq!(ended.stderr, "");
    let json: Value = serde_json::from_str(&desk.read("out/design.json")).unwrap();
    let said = &ended.stdout;
    assert_eq!(json["answer"]["headline"], said.trim_end());
    assert_eq!(json["answer"]["value"]["value"], best(&json)["drift_deg_per_h"]);
    let word = said.split_whitespace().nth(2).unwrap();
    let [said, found] = [word.parse().unwrap(), number(best(&json), "interval_s")];
    assert!((said / found - 1.0_f64).abs() < 5e-3, "{said} s, {found} s");
}

#[test]
fn a_design_is_the_same_on_any_number_of_threads_and_any_width() {
    let desk = Desk::with(FILLED);
    designed(&desk, "--trials 1024");
    let [json, table] = ["out/design.json", "out/design.csv"].map(|name| desk.read(name));
    let command = "design study.toml --device cpu --trials 1024 --quiet --out one";
    desk.sagnac_with(command, &[("RAYON_NUM_THREADS", "1")]);
    desk.done("design study.toml --device portable --trials 1024 --quiet --out portable");
    for folder in ["one", "portable"] {
        assert_eq!(desk.read(&format!("{folder}/design.json")), json, "{folder}");
        assert_eq!(desk.read(&format!("{folder}/design.csv")), table, "{folder}");
    }
}

#[test]
fn a_study_that_sweeps_the_interval_has_those_tried_and_no_others() {
    let list = "[[sweep]]\nkey = \"switching.interval\"\nlist = [\"30 s\", \"10 s\", \"20 s\", \"15 s\"]\n";
    let desk = Desk::with(&format!("{PAPER}{list}"));
    let found = designed(&desk, "--by drift_rms");
    let tried = rows_of(&found, "design").iter();
    assert_eq!(tried.map(|tried| number(tried, "interval_s")).collect::<Vec<_>>(), [10.0, 15.0, 20.0, 30.0]);
    assert_eq!(number(best(&found), "interval_s"), 20.0);
    // Four are too few for the law of the drift.
    assert!(["interval_lo_s", "interval_hi_s"].iter().all(|end| best(&found)[end].is_null()), "{found:#}");
}

/// With an exact end, intervals of which no even number makes the run leave the last one uncancelled.
#[test]
fn a_design_for_exact_ends_tries_intervals_of_which_an_even_number_makes_the_run() {
    let desk = Desk::with(&PAPER.replace("duration = \"1 h\"", "duration = \"1 h\"\nend = \"exact\""));
    let found = designed(&desk, "--by drift_rms");
    for tried in rows_of(&found, "design") {
        let [pairs, drift] = [1800.0 / number(tried, "interval_s"), number(tried, "drift_rms_deg_per_h")];
        assert!((pairs - pairs.round()).abs() < 1e-6 * pairs, "{pairs} pairs of intervals");
        assert!((drift / number(tried, "closed_form_rms_deg_per_h") - 1.0).abs() < 0.1, "{tried}");
    }
    // [2σ²t/(A²(1 − e^{−t/τ})²)]^{1/3}
    let [low, high] = ["interval_lo_s", "interval_hi_s"].map(|key| number(best(&found), key));
    assert!(low < 15.6 && 15.6 < high, "15.6 s is not within {low:.2} to {high:.2} s");
    assert!(found["notes"].to_string().contains("run.end = \\\"exact\\\""), "{:#}", found["notes"]);
}

#[test]
fn a_best_interval_at_the_end_of_what_was_tried_is_called_that() {
    let residuals_alone =
        PAPER.replace("magnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"\nnon_", "non_");
    let desk = Desk::with(&residuals_alone);
    let ended = desk.done("design study.toml --device cpu --trials 1024");
    assert!(ended.stdout.contains("the best interval is an end of those tried"), "{}", ended.stdout);
    let table = desk.read("results/study/design/design.csv");
    let intervals: Vec<&str> = table.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect();
    let mut once = intervals.clone();
    once.dedup();
    assert_eq!(intervals, once, "an interval is there twice");
}

#[test]
fn other_kinds_and_gyros_without_drift_are_refused() {
    let budget = PAPER.replace("switched-run", "drift-budget").replace("trials = 4096\n", "");
    refused(
        &budget,
        "2:8",
        &["kind = \"drift-budget\" has no switching interval", "kind = \"switched-run\""],
    );
    let nothing = PAPER
        .replace("magnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"\n", "")
        .replace("residual_max = \"10 arcsec\"\n", "");
    refused(&nothing, "5:16", &["there is no drift and no residual", "give drift.magnetic"]);
    let sweep = "[[sweep]]\nkey = \"run.duration\"\nlist = [\"1 h\", \"2 h\"]\n";
    let at = ["there is no drift and no residual", "at run.duration = 3600 s"];
    refused(&format!("{nothing}{sweep}"), "5:16", &at);
}

#[test]
fn options_that_make_no_sense_end_with_2() {
    let desk = Desk::with(PAPER);
    desk.fails("design study.toml --by best", 2, &["drift_p99_73, drift_rms, largest_p99_73, largest_rms"]);
    desk.fails("design study.toml --trials 0", 2, &["--trials"]);
    desk.fails("design study.toml --device abacus", 2, &["no device is called `abacus`"]);
    desk.fails("design none.toml", 3, &["cannot read the study none.toml"]);
    assert_eq!(desk.names("."), ["study.toml"]);
}

#[test]
fn a_compensated_relock_has_a_design_too_whose_interval_lets_the_loop_settle() {
    let relock = "[relock]\nmiss = 0.05\nhalf_wave_error = 0.005\nloop_time = \"31 ms\"\nbias_frequency = \"80 kHz\"\n\
                  pulse_weight = \"2.6 arcsec\"\ncurvature = 40\nadc_noise = 0.0002\nticks = 8\ncompensation = \"detuning\"\n";
    let found = designed(&Desk::with(&format!("{FILLED}{relock}")), "");
    let of_best = |key: &str| number(best(&found), key);
    assert!(of_best("interval_s") > 0.17, "{found:#}");
    assert!(of_best("drift_deg_per_h") <= of_best("rule_drift_deg_per_h"), "{found:#}");
}
