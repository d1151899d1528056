//! The answers of pages, and what messages say to do next.

use serde_json::{Value, json};

use crate::desk::{Desk, replaced, with};

const FREQUENCIES: &str =
    "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\", \"20 Hz\", \"40 Hz\"]\n";

/// Two fillers, ten minutes, at intervals of which even numbers make the run.
const RUNS: &str = r#"title = "Two fillers"
kind = "switched-run"
trials = 2048
streams = "common"
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

/// The headline of a study, which is that of its page and of a quiet run.
fn headline(study: &str) -> String {
    let desk = Desk::with(study);
    let said = desk.done("run study.toml --device cpu --trials 2000 --quiet").stdout;
    let page = desk.read("results/study/report.html");
    let answer = page.split("<h2 class=\"headline\">").nth(1).and_then(|rest| rest.split("</h2>").next());
    assert_eq!(answer, Some(said.trim_end()), "{page}");
    said.trim_end().to_owned()
}

/// The answer of a study as JSON.
fn answer(study: &str) -> Value {
    let desk = Desk::with(study);
    let ended = desk.done("run study.toml --device cpu --trials 2000 --json");
    serde_json::from_str::<Value>(&ended.stdout).unwrap()["answer"].take()
}

/// The texts of a row of an answer's table.
fn row(answer: &Value, row: usize) -> Vec<&str> {
    let cells = answer["table"]["rows"][row].as_array().unwrap();
    cells.iter().map(|cell| cell["text"].as_str().unwrap()).collect()
}

fn chart(lines: &str) -> String {
    format!("[[chart]]\n{lines}\n")
}

#[test]
fn a_chosen_interval_is_answered_by_the_best_one_and_by_what_costs_as_much() {
    let sweep =
        "[[sweep]]\nkey = \"switching.interval\"\nlist = [\"5 s\", \"10 s\", \"20 s\", \"30 s\", \"60 s\"]\n";
    let over = chart("x = \"interval\"\ny = \"drift_p99_73\"\nseries = [\"filler\"]");
    let said = headline(&format!("{RUNS}{sweep}{over}"));
    assert!(said.starts_with("Best switching interval: ") && said.contains("(quadratic)"), "{said}");
    // The length of a run is given, so that each has a best interval, and the one that costs most is told.
    let lengths = "[[sweep]]\nkey = \"run.duration\"\nlist = [\"10 min\", \"20 min\"]\n";
    let by_length = chart(
        "x = \"interval\"\ny = \"drift_p99_73\"\nseries = [\"duration\"]\nwhere = { filler = \"const\" }",
    );
    let found = answer(&format!("{RUNS}{lengths}{sweep}{by_length}"));
    assert_eq!(found["kind"], "optimum");
    assert_eq!([row(&found, 0)[0], row(&found, 1)[0]], ["10 min", "20 min"]);
    // Of fillers the one that firmware cannot have is told as such.
    let free = RUNS.replace("\"quadratic\"]", "{ kind = \"minimum-variance\", name = \"mv\" }]");
    let found = answer(&format!("{free}{sweep}{over}"));
    let caveat = found["facts"].as_array().unwrap().iter().find(|fact| fact["fact"] == "caveat").unwrap();
    assert!(caveat["text"].as_str().unwrap().starts_with("mv: designed for exactly this motion"), "{caveat}");
    // With a limit the question is for which intervals it is met.
    let limited = over.trim_end().to_owned() + "\nlimit = \"1 deg/h\"\n";
    let found = answer(&format!("{RUNS}{sweep}{limited}"));
    assert_eq!((&found["kind"], &found["limit"]["value"]), (&json!("threshold"), &json!(1.0)));
    // Names side by side are judged each for itself.
    let beside =
        chart("x = \"filler\"\ny = \"drift_p99_73\"\nwhere = { interval = \"20 s\" }\nlimit = \"0.3 deg/h\"");
    let found = answer(&format!("{RUNS}{sweep}{beside}"));
    assert_eq!([0, 1].map(|at| row(&found, at)[0]), ["quadratic", "const"]);
    assert_eq!([0, 1].map(|at| *row(&found, at).last().unwrap()), ["met", "not met"]);
    assert!(
        found["headline"].as_str().unwrap().starts_with("Quadratic meets the 0.3 °/h limit: "),
        "{found}"
    );
}

#[test]
fn names_side_by_side_are_answered_by_what_their_chart_shows() {
    let one = headline(&with(""));
    assert!(one.starts_with("Quadratic: 99.73 % error "), "{one}");
    let open = chart("x = \"filler\"\ny = \"rms\"\nwhere = { error = \"extrapolation\" }");
    let said = headline(&with(&open));
    assert!(said.contains(": rms error "), "{said}");
    let at_20_hz = chart("x = \"filler\"\ny = \"rms\"\nwhere = { frequency = \"20 Hz\" }");
    let said = headline(&with(&format!("{FREQUENCIES}{at_20_hz}")));
    assert!(said.starts_with("Quadratic: rms error "), "{said}");
}

#[test]
fn a_limit_is_answered_by_where_each_curve_crosses_it_with_the_interval_of_that_place() {
    let over = chart("x = \"frequency\"\ny = \"p99_73\"\nseries = [\"filler\"]\nlimit = \"20 arcsec\"");
    let found = answer(&with(&format!("{FREQUENCIES}{over}")));
    assert_eq!((&found["kind"], &found["status"]["is"]), (&json!("threshold"), &json!("partly_met")));
    let value = &found["value"];
    let ends =
        value["interval"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap()).collect::<Vec<_>>();
    let place = value["value"].as_f64().unwrap();
    assert!(ends[0] < place && place < ends[1] && value["unit"] == "Hz", "{value}");
    // The same value in the table and in the headline.
    assert_eq!(found["table"]["best"], 0);
    assert_eq!(row(&found, 0)[0], "quadratic");
    assert_eq!(found["table"]["rows"][0][1]["value"]["value"].as_f64(), Some(place));
    assert!(found["headline"].as_str().unwrap().starts_with("Quadratic: good up to "), "{found}");
    // Equal options share a row.
    let three = replaced("[\"const\", \"quadratic\"]", "[\"const\", \"linear\", \"quadratic\"]");
    let found = answer(&format!("{three}{FREQUENCIES}{over}"));
    assert_eq!(row(&found, 1)[0], "const = linear");
}

#[test]
fn several_values_at_one_name_are_refused() {
    let mixed = chart("x = \"filler\"\ny = \"rms\"");
    Desk::with(&with(&format!("{FREQUENCIES}{mixed}"))).fails(
        "run study.toml --device cpu",
        3,
        &["motion.frequency"],
    );
}

#[test]
fn a_chart_of_another_table_has_another_limit() {
    let allan = "title = \"a\"\nkind = \"allan\"\ntrials = 32\n[record]\nsample = \"1 s\"\nlength = \"30 min\"\n[noise]\n\
                 angle_random_walk = \"0.003 deg/sqrt(h)\"\n[allan]\nfit = [\"N\"]\n[[sweep]]\nkey = \"record.length\"\n\
                 list = [\"15 min\", \"30 min\"]\n[[chart]]\ntable = \"coefficients\"\nx = \"length\"\ny = \"relative_rmse\"\n\
                 where = { coefficient = \"N\" }\nlimit = \"10 %\"\n";
    let desk = Desk::with(allan);
    desk.done("run study.toml --device cpu --quiet");
    desk.done("chart results/study --table points --x tau --y adev --series length");
    desk.done("chart results/study --limit 5%");
}

#[test]
fn the_command_that_puts_shares_together_can_be_pasted() {
    let said = |desk: &Desk, words: &str| {
        let ended = desk.done(&format!("run {words} --device cpu --trials 1024"));
        ended.stderr.lines().last().unwrap_or_default().to_owned()
    };
    let desk = Desk::with(&with(""));
    let first = said(&desk, "study.toml --shard 1/2");
    assert!(first.ends_with("sagnac merge results/study/shard-*-of-2 --out results/study"), "{first}");
    said(&desk, "study.toml --shard 2/2");
    desk.done("merge results/study/shard-1-of-2 results/study/shard-2-of-2 --out results/study");
    let here = said(&desk, "study.toml --shard 1/2 --out shard-1-of-2");
    assert!(here.ends_with("sagnac merge shard-*-of-2 --out whole"), "{here}");
    let elsewhere = said(&desk, "study.toml --shard 1/2 --out mine");
    assert!(elsewhere.contains("sagnac merge SHARE… --out DIR"), "{elsewhere}");
}

#[test]
fn folders_of_folders_negative_numbers_and_terms_are_understood() {
    let desk = Desk::with(&replaced("[gyro]", "trials = 1000\n[gyro]"));
    desk.done("run study.toml --device cpu --quiet");
    desk.fails("check results", 2, &["results holds folders of results", "give one of them: results/study"]);
    desk.fails("run study.toml --trials -5", 2, &["not a whole number: write a whole number"]);
    desk.write("g.csv", "0\n");
    for (given, message) in [
        ("--rate -5Hz", "--rate -5Hz: the rate is not positive"),
        ("--rate -.5Hz", "--rate -.5Hz: the rate is not positive"),
        ("--skip -5s", "a time before the start of the file"),
    ] {
        desk.fails(&format!("allan g.csv --data rate {given}"), 2, &[message]);
    }
    for (word, meaning) in
        [("N", "angle random walk"), ("arw", "angle random walk"), ("lsb", "one pulse"), ("shard", "merge")]
    {
        let said = desk.done(&format!("explain {word}")).stdout;
        assert!(said.contains("(term)") && said.contains(meaning), "{said}");
    }
    // A word comes before keys that only end so.
    assert!(desk.done("explain residual").stdout.starts_with("residual (word of a study file)"));
}
