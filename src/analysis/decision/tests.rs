use crate::analysis::decision::{Sheet, decide};
use sagnac_base::progress::Silent;
use sagnac_engine::device::{Cpu, Device};
use sagnac_engine::run::{Plan, Tables};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;
use sagnac_kernel::width::Width;
use sagnac_report::answer::{Fact, Status};

/// The problem of a newcomer: a pulse of 1.2 ″ in a recorded vibration, and a limit of 5 ″.
const PULSES: &str = r#"
title = "A pulse too heavy"
kind = "gap-fill"
trials = 20_000
limit = "5 arcsec"
[gyro]
tick = "1 ms"
tick_noise = { std = "0.2 arcsec" }
readout_lsb = "4 arcsec"
[motion]
amplitude = "2000 arcsec/s"
frequency = "10 Hz"
[switching]
gap_ticks = 4
fillers = ["const", "quadratic"]
errors = ["residual"]
"#;

fn ran(text: &str) -> (Study, Tables) {
    let study = Study::parse("s.toml", text).unwrap();
    let plan = Plan::new(&study).unwrap();
    let mut store = Store::in_memory(&plan.identity());
    let mut device = Device::Cpu(Cpu::new(Width::PORTABLE, 2).unwrap());
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
    let tables = plan.tables(&store, &Silent).unwrap();
    drop(plan);
    (study, tables)
}

fn decided(text: &str) -> Sheet {
    let (study, tables) = ran(text);
    decide(&study, &tables, &Silent).unwrap().unwrap()
}

#[test]
fn the_sheet_names_the_cause_and_the_change_that_meets_the_limit() {
    let sheet = decided(PULSES);
    assert_eq!((sheet.is_met(), sheet.option.as_str()), (Some(false), "const"), "{:?}", sheet.facts());
    assert_eq!(sheet.budget[0].name, "whole pulses of the readout", "{:?}", sheet.budget);
    let lever = sheet.lever.clone().unwrap();
    assert_eq!(lever.change.key, "gyro.readout_lsb");
    let needed = lever.meets[0].to;
    // The lever, applied, does what the sheet says.
    let applied = PULSES.replace("\"4 arcsec\"", &format!("\"{} arcsec\"", needed.value));
    let applied = decided(&applied);
    assert_eq!(applied.is_met(), Some(true));
    assert!((4.9..=5.0).contains(&applied.value.value), "{:?}", applied.value);
    let tried = decided(&PULSES.replace("\"4 arcsec\"", "\"3.2 arcsec\""));
    let gain = 1.0 - tried.value.value / sheet.value.value;
    let (low, high) = lever.gain.interval.unwrap();
    assert!((low - 0.02..high + 0.02).contains(&gain), "{gain} against {:?}", lever.gain);
}

#[test]
fn a_study_without_a_limit_has_a_best_option_that_is_neither_met_nor_missed() {
    let sheet = decided(&PULSES.replace("limit = \"5 arcsec\"\n", ""));
    assert_eq!((sheet.is_met(), sheet.options), (None, 2));
    let facts = sheet.facts();
    let headings: Vec<&str> = facts.iter().map(Fact::label).collect();
    assert_eq!(headings, ["Error budget", "Most effective change"]);
    assert_eq!(sheet.status(), Status::NoLimit);
}

#[test]
fn the_same_results_give_the_same_sheet() {
    let (study, tables) = ran(PULSES);
    assert_eq!(decide(&study, &tables, &Silent).unwrap(), decide(&study, &tables, &Silent).unwrap());
}

#[test]
fn an_option_that_meets_the_limit_more_often_says_so() {
    // With a light pulse both fillers meet a limit between their errors with a heavy one.
    let sweep = "\n[[sweep]]\nkey = \"gyro.readout_lsb\"\nlist = [\"0.05 arcsec\", \"4 arcsec\"]\n";
    let both = format!("{PULSES}{sweep}");
    let limit = |arcsec: f64| both.replace("limit = \"5 arcsec\"", &format!("limit = \"{arcsec} arcsec\""));
    let worst = |name: &str| {
        decided(&both.replace("[\"const\", \"quadratic\"]", &format!("[\"{name}\"]"))).value.value
    };
    let between = 0.5 * (worst("const") + worst("quadratic"));
    let sheet = decided(&limit(between));
    assert_eq!((sheet.met, sheet.status()), ([2, 2], Status::Met));
    let partly = decided(&limit(0.5 * worst("const")));
    assert_eq!(partly.status(), Status::PartlyMet { met: 1, of: 2 });
    let worst_case = partly.facts().into_iter().find(|fact| fact.label() == "Worst case").unwrap();
    assert!(worst_case.text().ends_with("at 4″, with const (2 × limit)"), "{}", worst_case.text());
}

#[test]
fn a_response_is_judged_by_a_limit_only() {
    let study = |limit: &str| {
        format!(
            "title = \"t\"\nkind = \"suspension\"\n{limit}[suspension]\ngyro = \"LGK-400\"\n\
             [[sweep]]\nkey = \"suspension.gyro\"\nlist = [\"LGK-400\", \"LGV-1\"]\n\
             [[sweep]]\nkey = \"suspension.frequency\"\nlist = [\"100 Hz\", \"300 Hz\", \"380 Hz\", \"700 Hz\"]\n"
        )
    };
    let (unlimited, tables) = ran(&study(""));
    let sheet = decide(&unlimited, &tables, &Silent).unwrap();
    assert_eq!(sheet, None);
    // The useful modes are at 380 Hz and 300 Hz; only LGK-400 has another one, at 700 Hz.
    let sheet = decided(&study("limit = \"5000 arcsec/s/g\"\n"));
    assert_eq!((sheet.option.as_str(), sheet.met), ("LGV-1", [3, 4]), "{:?}", sheet.facts());
}

#[test]
fn every_input_that_meets_the_limit_by_itself_is_named_and_a_tick_says_what_it_keeps() {
    // Motion and noise are about as large, so that either can be lowered.
    let text = PULSES
        .replace("readout_lsb = \"4 arcsec\"\n", "")
        .replace("\"0.2 arcsec\"", "\"0.6 arcsec\"")
        .replace("2000 arcsec/s", "300000 arcsec/s")
        .replace("limit = \"5 arcsec\"", "limit = \"8 arcsec\"");
    let sheet = decided(&text);
    let lever = sheet.lever.clone().unwrap();
    assert!(lever.meets.len() > 1, "{lever:?}");
    let Some(Fact::ChangeToMeet { alternatives }) =
        sheet.facts().into_iter().find(|fact| fact.label() == "To meet the limit")
    else {
        panic!("{:?}", sheet.facts())
    };
    let keys: Vec<&str> = alternatives.iter().map(|one| one.key.as_str()).collect();
    let expected: Vec<&str> = lever.meets.iter().map(|change| change.key).take(3).collect();
    assert_eq!(keys, expected);
}

#[test]
fn what_meets_the_limit_does_so_under_all_conditions() {
    // The worst of these frequencies is the first with ticks of 5 ms, and the second where the tick alone is so short that the first
    // is within the limit.
    let sweep =
        "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"35 Hz\", \"60 Hz\", \"75 Hz\", \"90 Hz\"]\n";
    let text = PULSES
        .replace("readout_lsb = \"4 arcsec\"\n", "")
        .replace("tick = \"1 ms\"", "tick = \"5 ms\"")
        .replace("gap_ticks = 4", "gap_ticks = 3")
        .replace("[\"const\", \"quadratic\"]", "[\"const\"]")
        .replace("limit = \"5 arcsec\"", "limit = \"20 arcsec\"");
    let text = format!("{text}{sweep}");
    let sheet = decided(&text);
    assert!(sheet.condition.contains("35 Hz") && sheet.met == [3, 4], "{:?}", sheet.facts());
    let lever = sheet.lever.clone().unwrap();
    assert_eq!(lever.change.key, "gyro.tick");
    let tick = lever.meets[0].to;
    let applied = decided(&text.replace("tick = \"5 ms\"", &format!("tick = \"{} s\"", tick.value)));
    assert!(!applied.condition.contains("35 Hz"), "{:?}", applied.facts());
    assert!((19.5..=20.2).contains(&applied.value.value), "{tick}: {:?}", applied.facts());
}

#[test]
fn of_records_that_meet_the_limit_the_shortest_is_the_best() {
    let text = "title = \"t\"\nkind = \"allan\"\ntrials = 200\n[record]\nsample = \"1 s\"\nlength = \"1 h\"\n[noise]\n\
                angle_random_walk = \"0.003 deg/sqrt(h)\"\n[allan]\nfit = [\"N\"]\n\
                [[sweep]]\nkey = \"record.length\"\nlist = [\"100 s\", \"1000 s\", \"10000 s\"]\n\
                [[chart]]\ntable = \"coefficients\"\nx = \"length\"\ny = \"relative_rmse\"\nlimit = \"6 %\"\n";
    let sheet = decided(text);
    assert_eq!((sheet.option.as_str(), sheet.is_met()), ("16.7 min", Some(true)), "{:?}", sheet.facts());
}

#[test]
fn an_interval_is_no_lever_where_the_end_of_a_run_is_exact() {
    // With 50 s instead of 40 s an even number of intervals would fit into the run, which gains most.
    let sheet = decided(
        "title = \"t\"\nkind = \"switched-run\"\ntrials = 2000\n[drift]\nmagnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\"\n\
         non_magnetic = \"0.05 arcsec/s\"\nresidual_max = \"10 arcsec\"\n[switching]\ninterval = \"40 s\"\n[run]\n\
         duration = \"600 s\"\nend = \"exact\"\n",
    );
    assert_eq!(sheet.lever.map(|lever| lever.change.key), Some("drift.magnetic"));
}

/// A navigator whose gyros switch modes, with a magnetic drift that a sweep varies, and a coefficient that is drawn.
const SWITCHED: &str = r#"
title = "Switched"
kind = "navigation"
trials = 64
limit = "1 nmi"
[navigation]
duration = "10 min"
alignment = "80 s"
calibration = true
latitude = "60 deg"
sample = "1 s"
draws = 4
[noise]
angle_random_walk = "0.01 deg/sqrt(h)"
[noise.switching]
interval = "40 s"
magnetic = "1 arcsec/s"
warm_up_time = "3000 s"
[[sensitivity]]
key = "noise.angle_random_walk"
interval = { value = "0.01 deg/sqrt(h)", low = "0.008 deg/sqrt(h)", high = "0.012 deg/sqrt(h)" }
[[sweep]]
key = "noise.switching.magnetic"
list = ["0 arcsec/s", "14 arcsec/s"]
"#;

#[test]
fn parts_that_are_swept_or_drawn_are_in_the_error_budget() {
    let sheet = decided(SWITCHED);
    let share = |sheet: &Sheet, name: &str| {
        let part = sheet.budget.iter().find(|part| part.name == name);
        part.map(|part| part.share.value).unwrap_or_else(|| panic!("{name}: {:?}", sheet.budget))
    };
    let parts = ["magnetic drift of the modes", "angle random walk"].map(|name| share(&sheet, name));
    // Independent parts add up.
    assert!(parts[0] > 0.05 && parts[1] > 0.05 && (parts[0] + parts[1] - 1.0).abs() < 0.02, "{parts:?}");
    let alone = decided(&SWITCHED.replace("\"14 arcsec/s\"]", "\"0.001 arcsec/s\"]"));
    assert!(share(&alone, "angle random walk") > 0.99, "{:?}", alone.budget);
}

/// A dither without randomization, whose zones lie at multiples of 800 ″/s.
const ZONES: &str = r#"
title = "Zones"
kind = "lock-in"
trials = 4
[gyro]
scale_factor = "2 arcsec/pulse"
[lock_in]
threshold = "180 arcsec/s"
beam_noise = "0.00002 deg/sqrt(h)"
[dither]
frequency = "400 Hz"
rate = "4000 arcsec/s"
[record]
length = "0.5 s"
[[sweep]]
key = "input.rate"
linear = { from = "10 arcsec/s", to = "1610 arcsec/s", points = 81 }
[[chart]]
x = "input.rate"
y = "rate_error"
y_scale = "linear"
"#;

#[test]
fn a_lever_that_moves_the_largest_error_to_another_condition_is_none() {
    let sheet = decided(ZONES);
    assert_eq!(sheet.options, 1, "an input rate is no option");
    assert!(sheet.value.value > 40.0, "{:?}", sheet.value);
    // Another dither frequency moves the zone away from this input, and onto another one.
    let moved = decided(&ZONES.replace("\"400 Hz\"", "\"500 Hz\""));
    assert!(moved.value.value > 0.9 * sheet.value.value, "{:?}", moved.value);
    let key = sheet.lever.as_ref().map(|lever| lever.change.key);
    assert!(key.is_none_or(|key| key != "dither.frequency" && key != "input.rate"), "{key:?}");
}

/// A threshold that narrows the zones, or a frequency that moves them, leaves the sampled inputs outside all zones.
#[test]
fn no_lever_takes_zones_off_the_inputs_that_are_sampled() {
    let sheet = decided(&format!("limit = \"3 arcsec/s\"\n{ZONES}"));
    assert!(sheet.value.value > 40.0, "{:?}", sheet.value);
    let changes = sheet.lever.iter().flat_map(|lever| lever.meets.iter().chain([&lever.change]));
    let keys: Vec<&str> = changes.map(|change| change.key).collect();
    let of_zones = ["lock_in.threshold", "gyro.scale_factor", "dither.frequency"];
    assert!(keys.iter().all(|key| !of_zones.contains(key)), "{keys:?}");
}
