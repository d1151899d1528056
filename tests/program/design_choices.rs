//! `sagnac design` over swept keys, within constraints, and with a search for fillers.

use crate::desk::{Desk, rows_of};
use serde_json::Value;

/// Ten minutes with two fillers, of which `soon` reads one tick after the gap and the constant two.
const STUDY: &str = r#"title = "Choices"
kind = "switched-run"
trials = 4096
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
gap_ticks = 2
fillers = ["const", { kind = "quadratic", name = "soon", fit_ticks = ["-2..0", "n+1"] }]
[run]
duration = "10 min"
"#;

fn designed(desk: &Desk, options: &str) -> Value {
    let ended = desk.done(&format!("design study.toml --device cpu --json --out out {options}"));
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}:\n{}", ended.stdout))
}

fn number(found: &Value, key: &str) -> f64 {
    found[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {found:#}"))
}

/// The names of the fillers in a document.
fn names(found: &Value) -> Vec<&str> {
    rows_of(found, "fillers").iter().map(|one| one["filler"].as_str().unwrap()).collect()
}

/// The row of the best filler.
fn best(found: &Value) -> &Value {
    rows_of(found, "fillers").iter().find(|row| row["times_least"] == 1.0).unwrap()
}

#[test]
fn the_best_of_two_variants_is_the_better_of_two_designs_bit_for_bit() {
    let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"5 ms\", \"4 ms\"]\n";
    let found = designed(&Desk::with(&format!("{STUDY}{sweep}")), "");
    let alone = ["5 ms", "4 ms"].map(|tick| {
        let desk = Desk::with(&STUDY.replace("tick = \"5 ms\"", &format!("tick = \"{tick}\"")));
        designed(&desk, "")
    });
    assert!(
        alone.iter().all(|one| one["tables"].get("pareto").is_none()),
        "a design of one variant has nothing to trade"
    );
    // But for what compares a row with the best of all variants.
    let without = |row: &Value| {
        let mut row = row.clone();
        let cells = row.as_object_mut().unwrap();
        cells.retain(|key, _| key != "gyro.tick_s" && key != "as_good" && !key.starts_with("times_least"));
        row
    };
    for table in ["fillers", "design"] {
        let all: Vec<Value> = rows_of(&found, table).iter().map(without).collect();
        let each: Vec<Value> = alone.iter().flat_map(|one| rows_of(one, table)).map(without).collect();
        assert_eq!(all, each, "{table}");
    }
    let drifts = alone.each_ref().map(|one| number(best(one), "drift_deg_per_h"));
    let least = usize::from(drifts[1] < drifts[0]);
    assert_eq!(without(best(&found)), without(best(&alone[least])));
    assert_eq!(best(&found)["gyro.tick_s"], [0.005, 0.004][least]);
    let other_tick = [0.005, 0.004][1 - least];
    let others = rows_of(&found, "fillers").iter().filter(|row| row["gyro.tick_s"] == other_tick);
    let times = others.map(|row| number(row, "times_least")).fold(f64::INFINITY, f64::min);
    let times = times / (drifts[1 - least] / drifts[least]);
    assert!((times - 1.0).abs() < 1e-12, "{times}");
    let answer = found["answer"]["headline"].as_str().unwrap();
    assert!(answer.contains(&format!(", tick {} ms: ", [5, 4][least])), "{answer}");
    assert_eq!(found["answer"]["table"]["rows"].as_array().unwrap().len(), 4);
}

#[test]
fn the_table_has_the_swept_keys_in_front_and_the_front_is_what_no_other_choice_beats() {
    let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"4 ms\", \"5 ms\"]\n";
    let desk = Desk::with(&format!("{STUDY}{sweep}").replace("trials", "limit = \"0.3 deg/h\"\ntrials"));
    let found = designed(&desk, "");
    let table = desk.read("out/design.csv");
    assert!(table.starts_with("gyro.tick_s,filler,interval_s,"), "{table}");
    assert_eq!(table.lines().count() - 1, rows_of(&found, "design").len());
    // Every choice by its drift, latency and memory.
    let mut choices: Vec<[f64; 3]> = Vec::new();
    for filler in rows_of(&found, "fillers") {
        // Ticks and weights of both rules, two rules of 24 bytes; the ticks, two rows each and the sum.
        let counts: [f64; 2] = [4.0, 4.0];
        let constants = 48.0 + counts.iter().map(|count| 4.0 * count * 3.0).sum::<f64>();
        let state = 8.0 + counts.iter().map(|count| 4.0 * count + 16.0).sum::<f64>();
        let after = if filler["filler"] == "soon" { 1.0 } else { 2.0 };
        let latency = after * number(filler, "gyro.tick_s");
        choices.push([number(filler, "drift_deg_per_h"), latency, constants + state]);
    }
    assert_eq!(choices.len(), 4);
    let beaten =
        |own: &[f64; 3]| choices.iter().any(|other| other != own && (0..3).all(|k| other[k] <= own[k]));
    let mut expected: Vec<[f64; 3]> = choices.iter().filter(|own| !beaten(own)).copied().collect();
    expected.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[2].total_cmp(&b[2])).then(a[0].total_cmp(&b[0])));
    let front = rows_of(&found, "pareto");
    let merits = ["drift_deg_per_h", "latency_s", "memory"];
    let shown: Vec<[f64; 3]> = front.iter().map(|one| merits.map(|key| number(one, key))).collect();
    assert_eq!(shown, expected, "of {choices:?}");
    assert_eq!(desk.read("out/pareto.csv").lines().count() - 1, front.len());
    assert!(desk.read("out/pareto.svg").contains("limit 0.3 °/h"));
    assert_eq!(found["answer"]["limit"]["value"], 0.3);
    // Without choices beyond the interval and the filler, earlier files of them are removed.
    desk.write("study.toml", STUDY);
    designed(&desk, "");
    assert!(!desk.names("out").iter().any(|name| name.starts_with("pareto")), "{:?}", desk.names("out"));
}

#[test]
fn constraints_leave_out_what_breaks_them_and_keep_what_just_meets_them() {
    let desk = Desk::with(STUDY);
    for (latency, kept) in [("10ms", vec!["const", "soon"]), ("9.999ms", vec!["soon"]), ("5ms", vec!["soon"])]
    {
        let found = designed(&desk, &format!("--latency {latency}"));
        assert_eq!(names(&found), kept, "{latency}");
        let (notes, note) = (found["notes"].to_string(), "left out, because a latency of at most");
        assert_eq!(notes.contains(note), kept.len() == 1, "{notes}");
        assert_eq!(notes.contains("a latency of 10 ms"), kept.len() == 1, "{notes}");
    }
    desk.fails(
        "design study.toml --device cpu --latency 4.9ms",
        3,
        &[
            "no filler has a latency of at most 4.9 ms",
            "the nearest, soon, has a latency of 5 ms",
            "[study.toml:16:",
            "help:",
        ],
    );
    // 48 + 2 · 4 · 4 · 3 bytes of constants, 8 + 2 · (16 + 16) bytes of state.
    let bytes = 48 + 96 + 8 + 64;
    assert_eq!(names(&designed(&desk, &format!("--memory {bytes}"))), ["const", "soon"]);
    desk.fails(
        &format!("design study.toml --device cpu --memory {}", bytes - 1),
        3,
        &["no filler has at most 215 bytes of memory", "has 216 bytes"],
    );
    // A filler may break a constraint in one variant alone.
    let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"4 ms\", \"5 ms\"]\n";
    desk.write("study.toml", &format!("{STUDY}{sweep}"));
    let found = designed(&desk, "--latency 8ms");
    let ticks = rows_of(&found, "fillers").iter().map(|row| number(row, "gyro.tick_s"));
    let fillers: Vec<(&str, f64)> = names(&found).into_iter().zip(ticks).collect();
    assert_eq!(fillers, [("const", 0.004), ("soon", 0.004), ("soon", 0.005)]);
}

#[test]
fn a_search_adds_fillers_that_meet_the_constraints_and_beat_those_of_the_study() {
    let desk = Desk::with(STUDY);
    let plain = designed(&desk, "");
    let found = designed(&desk, "--search --latency 20ms --memory 400");
    let fillers = names(&found);
    assert_eq!(fillers[..2], ["const", "soon"]);
    assert!((3..=8).contains(&fillers.len()), "{fillers:?}");
    assert!(fillers[2..].iter().all(|name| name.starts_with("searched ")), "{fillers:?}");
    for one in rows_of(&found, "pareto") {
        assert!(number(one, "latency_s") <= 0.02 && number(one, "memory") <= 400.0, "{one}");
    }
    let [with, without] = [&found, &plain].map(|found| number(best(found), "drift_deg_per_h"));
    assert!(with < without, "{with} with, {without} without");
    assert!(desk.read("out/report.html").contains("searched"), "the page has the study with its fillers");
    let wide = designed(&desk, "--search --band 15Hz,25Hz --latency 20ms");
    assert!(names(&wide).len() > 2, "{wide:#}");
    let own = |found: &Value| {
        rows_of(found, "fillers")
            .iter()
            .skip(2)
            .map(|one| number(one, "residual_rms_arcsec"))
            .fold(f64::INFINITY, f64::min)
    };
    let narrow = designed(&desk, "--search --latency 20ms");
    assert!(
        own(&wide) > own(&narrow),
        "a wider band leaves more at 20 Hz: {} and {}",
        own(&wide),
        own(&narrow)
    );
}

#[test]
fn a_motion_that_gives_no_weights_is_said_in_one_line() {
    let still =
        STUDY.replace("amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"", "rate = \"1 arcsec/s\"");
    let desk = Desk::with(&still.replace("three_sigma = \"1.6 arcsec\"", "std = \"0 arcsec\""));
    let ended = desk.sagnac("design study.toml --device cpu --search --trials 1024 --out out");
    assert!(ended.stderr.contains("the search adds no filler"), "{}\n{}", ended.stdout, ended.stderr);
}

#[test]
fn constraints_and_bands_that_make_no_sense_are_refused() {
    let desk = Desk::with(STUDY);
    for (options, pieces) in [
        ("--latency 5Hz", &["--latency = 5Hz"][..]),
        ("--latency=-1ms", &["it is below 0"]),
        ("--memory many", &["--memory", "not a whole number"]),
        ("--memory=-1", &["--memory"]),
        ("--band 18Hz,22Hz", &["--search"]),
        ("--search --band 22Hz,18Hz", &["the band runs backwards"]),
        ("--search --band 5ms", &["--band = 5ms"]),
    ] {
        desk.fails(&format!("design study.toml --device cpu {options}"), 2, pieces);
    }
    desk.fails(
        "design study.toml --device cpu --search --band 90Hz,110Hz",
        3,
        &["the band reaches 110 Hz, above the Nyquist frequency", "[study.toml:5:"],
    );
    desk.fails(
        "design study.toml --device cpu --search --latency 0ms --memory 10",
        3,
        &["no filler has a latency"],
    );
    let (before, after) = STUDY.split_once("gap_ticks").unwrap();
    let run = after.split_once("[run]").unwrap().1;
    let before = before.replace("warm_up", "residual_max = \"10 arcsec\"\nwarm_up");
    let (drift, motion) = (before.find("[drift]").unwrap(), before.find("[gyro]").unwrap());
    desk.write("study.toml", &format!("{}{}[run]{run}", &before[..motion], &before[drift..]));
    for option in ["--latency 5ms", "--memory 500", "--search"] {
        let pieces = ["latency and memory are those of fillers, and the study has none", "help:"];
        desk.fails(&format!("design study.toml --device cpu {option}"), 3, &pieces);
    }
    assert_eq!(desk.names("."), ["study.toml"]);
}
