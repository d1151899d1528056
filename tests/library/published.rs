//! The numbers of the theory, found again by whole studies: fillers of least variance, relock in the fill.

use std::collections::HashMap;
use std::sync::Mutex;

use crate::studies::{Silent, parsed, rows, run, run_afresh};
use sagnac::progress::Progress;
use sagnac::run::Plan;
use sagnac::store::Store;
use sagnac::study::Precision;
use sagnac::tally::Share;
use sagnac::verify::select;

/// The paper's gyro under a motion, with fillers of least variance for a band beside the polynomials.
fn text(motion: &str, n: u32, design: &str, fillers: &[(&str, &str)]) -> String {
    let table = |(name, ticks): &(&str, &str)| {
        format!("{{ kind = \"minimum-variance\", name = \"{name}\", fit_ticks = [{ticks}]{design} }}")
    };
    let fillers: Vec<String> = fillers.iter().map(table).collect();
    format!(
        "title = \"Theory\"\nkind = \"gap-fill\"\ntrials = 1_000_000\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ three_sigma = \
         \"1.6 arcsec\" }}\n[motion]\namplitude = \"12000 arcsec/s\"\nfrequency = {motion}\n[switching]\ngap_ticks = \
         {n}\nfillers = [\"const\", \"quadratic\", {}]\nerrors = [\"residual\"]\n",
        fillers.join(", ")
    )
}

const FOUR: (&str, &str) = ("4", "-1, 0, \"n+1\", \"n+2\"");
const EIGHT_AND_TWO: (&str, &str) = ("8+2", "\"-7..0\", \"n+1\", \"n+2\"");

/// Runs a study and compares the rms of its fillers, sampled and in closed form, with printed numbers.
fn check(text: &str, printed: &[(&str, f64, f64)]) {
    let table = run_afresh(&parsed("study.toml", text));
    let found: HashMap<String, _> = rows(&table).map(|row| (row.text("filler"), row)).collect();
    for &(filler, expected, last_digit) in printed {
        let row = &found[filler];
        let (rms, se, theory) = (row.number("rms"), row.number("rms_se"), row.number("theory_rms"));
        // Rounding of the printed number, and of weights and angles in fixed point.
        let rounding = 0.51 * last_digit + 2e-4 * expected;
        assert!((theory - expected).abs() < rounding, "{theory}, not {expected}: {}", row.place());
        assert!(
            (rms - expected).abs() < rounding + 5.0 * se,
            "{rms} ± {se}, not {expected}: {}",
            row.place()
        );
    }
}

#[test]
fn fillers_of_least_variance_have_the_errors_of_the_theories_table() {
    let motions = [
        ("\"20 Hz\"", 1, [18.41, 1.14, 0.54, 0.33]),
        ("\"20 Hz\"", 3, [109.26, 19.09, 2.40, 1.13]),
        ("[\"18 Hz\", \"22 Hz\"]", 3, [109.48, 19.76, 3.79, 2.16]),
        ("[\"1 Hz\", \"25 Hz\"]", 3, [75.96, 15.08, 6.71, 2.85]),
        ("[\"1 Hz\", \"60 Hz\"]", 3, [113.39, 136.99, 111.85, 59.85]),
    ];
    for (motion, n, errors) in motions {
        let names = ["const", "quadratic", "4", "8+2"];
        let printed: Vec<(&str, f64, f64)> =
            names.iter().zip(errors).map(|(name, error)| (*name, error, 0.01)).collect();
        check(&text(motion, n, "", &[FOUR, EIGHT_AND_TWO]), &printed);
    }
}

#[test]
fn more_ticks_after_the_gap_bridge_a_wide_band() {
    let fillers = [("8+8", "\"-7..0\", \"n+1..n+8\""), ("20+20", "\"-19..0\", \"n+1..n+20\"")];
    check(&text("[\"1 Hz\", \"60 Hz\"]", 3, "", &fillers), &[("8+8", 15.5, 0.1), ("20+20", 9.3, 0.1)]);
}

#[test]
fn fillers_tuned_to_one_frequency_are_fragile() {
    let at_20 = ", band = [\"20 Hz\", \"20 Hz\"]";
    check(&text("\"19 Hz\"", 3, at_20, &[FOUR, EIGHT_AND_TWO]), &[("8+2", 21.6, 0.1), ("4", 3.3, 0.1)]);
}

#[test]
fn relock_in_the_first_ticks_after_the_gap_biases_the_fill() {
    let still = text("\"20 Hz\"", 3, "", &[])
        .replace("tick_noise = { three_sigma = \"1.6 arcsec\" }", "tick_noise = { std = \"0.01 arcsec\" }")
        .replace("amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"", "rate = \"0 deg/s\"")
        .replace("[motion]", "relock = [\"20.3 arcsec\", \"14.8 arcsec\"]\n[motion]");
    let table = run_afresh(&parsed("study.toml", &still));
    let means: Vec<f64> = rows(&table).map(|row| row.number("mean")).collect();
    // 26.3 and 35.9 ″ in print.
    for (mean, expected) in means.iter().zip([0.75 * (20.3 + 14.8), 2.5 * 20.3 - 14.8]) {
        assert!((mean - expected).abs() < 1e-3, "{mean}, not {expected}");
    }
}

/// The paper's point with a stop rule; `trials` is the cap.
fn stopping(trials: &str, precision: &str) -> String {
    text("\"20 Hz\"", 3, "", &[EIGHT_AND_TWO])
        .replace("trials = 1_000_000", &format!("trials = {trials}\nprecision = {precision}"))
}

#[test]
fn sampling_stops_at_the_same_trial_wherever_it_is_begun() {
    let study = parsed("study.toml", &stopping("1_000_000", "\"0.5 %\""));
    assert_eq!(study.precision, Some(Precision { rms: Some(0.005), p99_73: None }));
    let at_once = run_afresh(&study);
    let trials: Vec<f64> = rows(&at_once).map(|row| row.number("trials")).collect();
    assert!(trials[0] < 1e6 && trials.iter().all(|&other| other == trials[0]), "{trials:?}");
    let half_widths = rows(&at_once).map(|row| 1.96 * row.number("rms_se") / row.number("rms"));
    let worst = half_widths.fold(0.0, f64::max);
    // Half as many were not enough, or the rule would have stopped there.
    assert!(worst <= 0.005 && worst * 2.0_f64.sqrt() > 0.0045, "{worst}");
    let folder = tempfile::tempdir().unwrap();
    // Begun with another cap and a coarser rule, then with the one above.
    run(&parsed("study.toml", &stopping("3_000", "\"20 %\"")), folder.path());
    assert_eq!(run(&study, folder.path()), at_once);
    // What a run without a rule has left is more than enough, in rows that are larger than what the rule looks at first.
    let folder = tempfile::tempdir().unwrap();
    let ruleless = stopping("300_000", "\"0.5 %\"").replace("precision = \"0.5 %\"\n", "");
    let held = run(&parsed("study.toml", &ruleless), folder.path());
    assert_eq!(run(&study, folder.path()), held);
}

#[test]
fn the_trials_of_all_rounds_are_told_of_who_made_them() {
    let study = parsed("study.toml", &stopping("1_000_000", "\"0.5 %\""));
    let (plan, folder) = (Plan::new(&study).unwrap(), tempfile::tempdir().unwrap());
    let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
    let mut device = select("cpu", 2).unwrap().device;
    let done = plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
    let told: u64 = store.provenance().unwrap().iter().map(|by| by.trials).sum();
    let of_point =
        rows(&plan.tables(&store, &Silent).unwrap().points).next().unwrap().number("trials") as u64;
    assert!(
        told == done.trials && told >= of_point && told.is_multiple_of(of_point),
        "{told}, {}, {of_point}",
        done.trials
    );
}

/// Collects the totals that a run announces.
#[derive(Default)]
struct Totals(Mutex<Vec<u64>>);

impl Progress for Totals {
    fn start(&self, _: &'static str, _: u64, total: u64) {
        self.0.lock().unwrap().push(total);
    }
}

#[test]
fn with_a_precision_the_total_is_that_of_the_round() {
    let study = parsed("study.toml", &stopping("32_000_000", "\"0.08 %\""));
    let (plan, folder) = (Plan::new(&study).unwrap(), tempfile::tempdir().unwrap());
    let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
    let (mut device, totals) = (select("cpu", 2).unwrap().device, Totals::default());
    let done = plan.run(&mut store, &mut device, Share::WHOLE, &totals).unwrap();
    let told = totals.0.into_inner().unwrap();
    assert!(told.len() >= 3 && told.windows(2).all(|pair| pair[0] < pair[1]), "{told:?}");
    assert_eq!(told.last(), Some(&done.trials), "{told:?}");
}

#[test]
fn the_cap_ends_what_is_not_precise_enough() {
    let table =
        run_afresh(&parsed("study.toml", &stopping("5_000", "{ rms = \"0.01 %\", p99_73 = \"1 %\" }")));
    assert!(rows(&table).all(|row| row.number("trials") == 5000.0));
}

#[test]
fn a_record_with_room_for_few_places_is_replayed_at_those_and_nowhere_else() {
    // 64 ticks on either side of a gap of three: as many whole ticks as samples less one.
    for places in [1, 2, 3, 4, 64] {
        let folder = tempfile::tempdir().unwrap();
        let samples: String =
            (0..130 + places + 1).map(|i| format!("{}, {}\n", 5 * i, (i * i % 37) - 18)).collect();
        std::fs::write(folder.path().join("record.csv"), format!("time [ms], rate [deg/s]\n{samples}"))
            .unwrap();
        let still = text("\"20 Hz\"", 3, "", &[])
            .replace("tick_noise = { three_sigma = \"1.6 arcsec\" }", "tick_noise = { std = \"0 arcsec\" }")
            .replace(
                "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"",
                "profile = { file = \"record.csv\", position = \"every\" }",
            )
            .replace("trials = 1_000_000", "trials = 1000");
        let table = run_afresh(&parsed(&folder.path().join("study.toml").display().to_string(), &still));
        for row in rows(&table) {
            let (rms, theory) = (row.number("rms"), row.number("theory_rms"));
            assert!((rms - theory).abs() < 1e-3, "{places} places: {rms}, not {theory}: {}", row.place());
            assert_eq!(row.number("trials") as usize % places as usize, 0);
        }
    }
}
