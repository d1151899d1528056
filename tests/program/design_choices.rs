//! `sagnac design` over swept keys, within constraints, and with a search for fillers.

use crate::desk::Desk;
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

fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|one| one["filler"].as_str().unwrap()).collect()
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
        alone.iter().all(|one| one.get("variants").is_none()),
        "a design of one variant has no further keys"
    );
    let variants = found["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 2);
    for (variant, alone) in variants.iter().zip(&alone) {
        for key in [
            "fillers",
            "filler",
            "interval_s",
            "interval_lo_s",
            "drift",
            "drift_lo",
            "drift_hi",
            "angle_arcsec",
        ] {
            assert_eq!(variant[key], alone[key], "{key}");
        }
    }
    let drifts = alone.each_ref().map(|one| number(one, "drift"));
    let best = usize::from(drifts[1] < drifts[0]);
    for key in ["drift", "interval_s", "filler", "fillers", "interval_by_paper_rule_s"] {
        assert_eq!(found[key], alone[best][key], "{key}");
    }
    assert_eq!(variants[best]["times_least"], 1.0);
    assert_eq!(variants[best]["swept"]["gyro.tick_s"], [0.005, 0.004][best]);
    let times = number(&variants[1 - best], "times_least") / (drifts[1 - best] / drifts[best]);
    assert!((times - 1.0).abs() < 1e-12, "{times}");
    let answer = found["answer"]["headline"].as_str().unwrap();
    assert!(answer.contains(&format!(", tick {} ms: ", [5, 4][best])), "{answer}");
    let option = found["decision"]["best"]["option"].as_str().unwrap();
    assert!(option.contains(&format!("tick {} ms", [5, 4][best])), "{option}");
    assert_eq!(found["decision"]["best"]["of"], 4);
}

#[test]
fn the_table_has_the_swept_keys_in_front_and_the_front_is_what_no_other_choice_beats() {
    let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"4 ms\", \"5 ms\"]\n";
    let desk = Desk::with(&format!("{STUDY}{sweep}").replace("trials", "limit = \"0.3 deg/h\"\ntrials"));
    let found = designed(&desk, "");
    let table = desk.read("out/design.csv");
    assert!(table.starts_with("gyro.tick_s,filler,interval_s,"), "{table}");
    let tried = |variant: &Value| -> usize {
        variant["fillers"].as_array().unwrap().iter().map(|own| own["tried"].as_array().unwrap().len()).sum()
    };
    let all: usize = found["variants"].as_array().unwrap().iter().map(tried).sum();
    assert_eq!(table.lines().count() - 1, all);
    // Every choice by its drift, latency and memory.
    let mut choices: Vec<[f64; 3]> = Vec::new();
    for (tick, variant) in [0.004, 0.005].into_iter().zip(found["variants"].as_array().unwrap()) {
        for filler in variant["fillers"].as_array().unwrap() {
            // Ticks and weights of both rules, two rules of 24 bytes; the ticks, two rows each and the sum.
            let counts: [f64; 2] = [4.0, 4.0];
            let constants = 48.0 + counts.iter().map(|count| 4.0 * count * 3.0).sum::<f64>();
            let state = 8.0 + counts.iter().map(|count| 4.0 * count + 16.0).sum::<f64>();
            let after = if filler["filler"] == "soon" { 1.0 } else { 2.0 };
            choices.push([number(filler, "drift"), after * tick, constants + state]);
        }
    }
    let beaten =
        |own: &[f64; 3]| choices.iter().any(|other| other != own && (0..3).all(|k| other[k] <= own[k]));
    let mut expected: Vec<[f64; 3]> = choices.iter().filter(|own| !beaten(own)).copied().collect();
    expected.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[2].total_cmp(&b[2])).then(a[0].total_cmp(&b[0])));
    let front = found["pareto"].as_array().unwrap();
    let shown: Vec<[f64; 3]> =
        front.iter().map(|one| ["drift", "latency_s", "memory_bytes"].map(|key| number(one, key))).collect();
    assert_eq!(shown, expected, "of {choices:?}");
    assert_eq!(desk.read("out/pareto.csv").lines().count() - 1, front.len());
    assert!(desk.read("out/pareto.svg").contains("limit 0.3 °/h"));
    assert_eq!(found["constraints"]["limit_deg_per_h"], 0.3);
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
        assert_eq!(names(&found["fillers"]), kept, "{latency}");
        let left_out = &found["constraints"]["left_out"];
        assert_eq!(left_out.as_array().unwrap().len(), 2 - kept.len(), "{latency}");
        if kept.len() == 1 {
            let note = "left out, because a latency of at most";
            assert!(found["notes"].to_string().contains(note), "{:#}", found["notes"]);
            assert_eq!(left_out[0]["why"], "a latency of 10 ms");
        }
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
    assert_eq!(names(&designed(&desk, &format!("--memory {bytes}"))["fillers"]), ["const", "soon"]);
    desk.fails(
        &format!("design study.toml --device cpu --memory {}", bytes - 1),
        3,
        &["no filler has at most 215 bytes of memory", "has 216 bytes"],
    );
    // A filler may break a constraint in one variant alone.
    let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"4 ms\", \"5 ms\"]\n";
    desk.write("study.toml", &format!("{STUDY}{sweep}"));
    let found = designed(&desk, "--latency 8ms");
    let fillers: Vec<Vec<&str>> =
        found["variants"].as_array().unwrap().iter().map(|variant| names(&variant["fillers"])).collect();
    assert_eq!(fillers, [vec!["const", "soon"], vec!["soon"]]);
    assert_eq!(found["constraints"]["left_out"][0]["variants"], 1);
}

#[test]
fn a_search_adds_fillers_that_meet_the_constraints_and_beat_those_of_the_study() {
    let desk = Desk::with(STUDY);
    let plain = designed(&desk, "");
    let found = designed(&desk, "--search --latency 20ms --memory 400");
    let fillers = names(&found["fillers"]);
    assert_eq!(fillers[..2], ["const", "soon"]);
    assert!((3..=8).contains(&fillers.len()), "{fillers:?}");
    assert!(fillers[2..].iter().all(|name| name.starts_with("searched ")), "{fillers:?}");
    for one in found["pareto"].as_array().unwrap() {
        assert!(number(one, "latency_s") <= 0.02 && number(one, "memory_bytes") <= 400.0, "{one}");
    }
    assert!(
        number(&found, "drift") < number(&plain, "drift"),
        "{} with, {} without",
        found["drift"],
        plain["drift"]
    );
    assert!(desk.read("out/report.html").contains("searched"), "the page has the study with its fillers");
    let wide = designed(&desk, "--search --band 15Hz,25Hz --latency 20ms");
    assert!(wide["fillers"].as_array().unwrap().len() > 2, "{wide:#}");
    let own = |found: &Value| {
        found["fillers"]
            .as_array()
            .unwrap()
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
