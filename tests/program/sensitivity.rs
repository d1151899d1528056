//! `sagnac sensitivity`.

use serde_json::Value;

use crate::desk::{Desk, STUDY, rows_of};

const NOISE: &str =
    "[[sensitivity]]\nkey = \"gyro.tick_noise.std\"\nnormal = { mean = \"1 arcsec\", sd = \"0.1 arcsec\" }\n";
const FREQUENCY: &str =
    "[[sensitivity]]\nkey = \"motion.frequency\"\nuniform = { from = \"19 Hz\", to = \"21 Hz\" }\n";

/// One filler and one error, with these uncertain inputs.
fn study(end: &str) -> String {
    let one = STUDY.replace(
        "fillers = [\"const\", \"quadratic\"]",
        "fillers = [\"quadratic\"]\nerrors = [\"residual\"]",
    );
    format!("{one}{end}")
}

fn found(desk: &Desk, options: &str) -> Value {
    let ended = desk.done(&format!("sensitivity study.toml --device cpu --json --out out {options}"));
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}:\n{}", ended.stdout))
}

fn of<'v>(found: &'v Value, key: &str) -> &'v Value {
    rows_of(found, "sensitivity")
        .iter()
        .find(|input| input["input"] == key)
        .unwrap_or_else(|| panic!("no {key}: {found:#}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// The ends of an index of an input.
fn ends(input: &Value, index: &str) -> [f64; 2] {
    ["lo", "hi"].map(|end| number(&input[format!("{index}_{end}")]))
}

fn contains([low, high]: [f64; 2], exact: f64) -> bool {
    low <= exact && exact <= high
}

/// A number of the distribution of the answer.
fn of_answer(found: &Value, quantity: &str) -> f64 {
    let row = rows_of(found, "distribution").iter().find(|row| row["quantity"] == quantity).unwrap();
    number(&row["value"])
}

/// A study that cannot be read: exit 3, its place, every piece.
fn refused(end: &str, pieces: &[&str]) {
    let desk = Desk::with(&study(end));
    let all: Vec<&str> = ["[study.toml:", "help:"].iter().chain(pieces).copied().collect();
    desk.fails("sensitivity study.toml --device cpu", 3, &all);
    // Every command reads the inputs.
    desk.fails("run study.toml --device cpu", 3, &all);
}

/// The square of the rms is a² σ² + (b ν-dependent)², so that both parts of its variance are known.
#[test]
fn of_a_steady_motion_the_noise_alone_decides_and_its_ends_are_the_closed_form() {
    let still = study(NOISE).replace("amplitude = \"12000 arcsec/s\"", "amplitude = \"0 arcsec/s\"");
    let desk = Desk::with(&still);
    let found = found(&desk, "--by theory_rms --samples 1024");
    let noise = of(&found, "gyro.tick_noise.std");
    assert!(["first", "total"].iter().all(|index| contains(ends(noise, index), 1.0)), "{found:#}");
    // The rms is the gain of the quadratic, 3.808, times σ; 5 % and 95 % of a normal distribution are 1.645 σ away.
    let gain = 3.807_886;
    for (key, sigma) in [("at_from_arcsec", 1.0 - 0.164_485), ("at_to_arcsec", 1.0 + 0.164_485)] {
        assert!((number(&noise[key]) / (gain * sigma) - 1.0).abs() < 1e-4, "{key}: {noise}");
    }
    assert!((of_answer(&found, "sd") / (0.1 * gain) - 1.0).abs() < 0.01, "{found:#}");
    assert_eq!((found.get("provenance"), of_answer(&found, "noise")), (None, 0.0));
}

#[test]
fn a_sampled_answer_decides_as_its_closed_form_does() {
    // So narrow a band that the noise matters too.
    let narrow = FREQUENCY.replace("19 Hz", "19.9 Hz").replace("21 Hz", "20.1 Hz");
    let desk = Desk::with(&study(&format!("{NOISE}{narrow}")));
    let exact = found(&desk, "--by theory_rms --samples 1024");
    let sampled = found(&desk, "--by rms --samples 256 --trials 65536");
    assert_eq!(sampled["provenance"]["trials"], 65536);
    for key in ["gyro.tick_noise.std", "motion.frequency"] {
        for index in ["first", "total"] {
            let [exact, sampled] = [&exact, &sampled].map(|found| ends(of(found, key), index));
            let overlap = exact[0] <= sampled[1] && sampled[0] <= exact[1];
            assert!(overlap, "{key}, {index}: {exact:?}, {sampled:?}");
        }
    }
    let [exact, sampled] = [exact, sampled].map(|found| rows_of(&found, "sensitivity")[0]["input"].clone());
    assert_eq!(exact, sampled);
}

#[test]
fn the_result_has_its_files_and_words_and_repeats_with_its_seed() {
    let desk = Desk::with(&study(&format!(
        "{NOISE}{FREQUENCY}[chart]\nx = \"filler\"\ny = \"rms\"\nlimit = \"30 arcsec\"\n"
    )));
    let ended =
        desk.done("sensitivity study.toml --device cpu --by rms --samples 64 --trials 256 --quiet --out out");
    assert_eq!(ended.stderr, "");
    assert!(ended.stdout.starts_with("Vibration frequency drives "), "{}", ended.stdout);
    let ended = desk.done("sensitivity study.toml --device cpu --by rms --samples 64 --trials 256 --out out");
    for piece in ["of the variance", "Nominal", "Within the limit", "limit 30″"] {
        assert!(ended.stdout.contains(piece), "`{piece}` is missing:\n{}", ended.stdout);
    }
    let files = [
        "card.json",
        "distribution.csv",
        "report.html",
        "sensitivity.csv",
        "sensitivity.json",
        "sensitivity.png",
        "sensitivity.svg",
        "tallies.lock",
        "written_by_sagnac.jsonl",
    ];
    assert_eq!(desk.names("out"), files);
    let [json, table] = ["out/sensitivity.json", "out/sensitivity.csv"].map(|name| desk.read(name));
    let again =
        "sensitivity study.toml --device portable --by rms --samples 64 --trials 256 --quiet --out again";
    desk.sagnac_with(again, &[("RAYON_NUM_THREADS", "1")]);
    assert_eq!(desk.read("again/sensitivity.json"), json);
    assert_eq!(desk.read("again/sensitivity.csv"), table);
    desk.done(
        "sensitivity study.toml --device cpu --by rms --samples 64 --trials 256 --seed 2 --quiet --out other",
    );
    assert_ne!(desk.read("other/sensitivity.json"), json);
}

#[test]
fn the_answer_judges_nearly_all_answers_by_the_limit_of_the_study() {
    let decided = |limit: &str| {
        let desk = Desk::with(&format!("limit = \"{limit}\"\n{}", study(&format!("{NOISE}{FREQUENCY}"))));
        found(&desk, "--samples 64 --trials 256")
    };
    let loose = decided("100 deg");
    assert_eq!(loose["answer"]["status"]["is"], "met");
    let most = of_answer(&loose, "quantile_0.95");
    let tight = decided(&format!("{} arcsec", 0.5 * most));
    assert_eq!(tight["answer"]["status"]["is"], "not_met");
}

#[test]
fn whole_numbers_and_truncated_distributions_are_inputs_too() {
    let wide = NOISE.replace("sd = \"0.1", "sd = \"0.6").replace("1 arcsec\", sd", "2 arcsec\", sd");
    let gap = "[[sensitivity]]\nkey = \"switching.gap_ticks\"\nuniform = { from = 1, to = 3 }\n";
    let desk = Desk::with(&study(&format!("{wide}{gap}")));
    let ended = desk.done("sensitivity study.toml --device cpu --by theory_rms --samples 256 --out out");
    let note = "% of the distribution of gyro.tick_noise.std lies outside its limits";
    assert!(ended.stderr.contains(note), "{}", ended.stderr);
    assert!(ended.stdout.contains("\nLost ticks n drives "), "{}", ended.stdout);
    assert!(
        desk.read("out/sensitivity.csv").contains("switching.gap_ticks,,1,3,"),
        "{}",
        desk.read("out/sensitivity.csv")
    );
}

#[test]
fn inputs_that_are_none_are_refused_at_their_place() {
    let desk = Desk::with(&format!("sensitivity = []\n{}", study("")));
    desk.fails(
        "sensitivity study.toml",
        3,
        &["[study.toml:1:15]", "sensitivity has no inputs", "leave it out"],
    );
    refused(&NOISE.replace("std", "sdt"), &["there is no key `gyro.tick_noise.sdt` to vary"]);
    refused(
        &NOISE.replace("gyro.tick_noise.std", "drift.magnetic"),
        &["there is no key `drift.magnetic` to vary"],
    );
    refused(&NOISE.replace("\"0.1", "\"-0.1"), &["gyro.tick_noise.std = -0.1″", "negative", "above 0"]);
    refused(&NOISE.replace("0.1 arcsec", "0.1 Hz"), &["gyro.tick_noise.std"]);
    refused(&FREQUENCY.replace("19 Hz", "22 Hz"), &["to = 21 Hz is not above from = 22 Hz", "backwards"]);
    refused(&FREQUENCY.replace("\"19", "\"-19"), &["motion.frequency = -19 Hz is out of range"]);
    let log =
        NOISE.replace("normal", "log").replace("mean = \"1", "from = \"0").replace("sd = \"0.1", "to = \"1");
    refused(&log, &["a log range of gyro.tick_noise.std cannot contain 0″"]);
    refused(
        "[[sensitivity]]\nkey = \"motion.frequency\"\n",
        &["exactly one of uniform, log, normal, interval"],
    );
    let both = FREQUENCY.replace("uniform", "log = { from = \"1 Hz\", to = \"2 Hz\" }\nuniform");
    refused(&both, &["exactly one of uniform, log, normal, interval"]);
    refused(&format!("{NOISE}{NOISE}"), &["uncertain although gyro.tick_noise.std is already"]);
    let other = NOISE.replace("std", "three_sigma");
    refused(&format!("{NOISE}{other}"), &["gyro.tick_noise.three_sigma is uncertain although"]);
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";
    refused(
        &format!("{FREQUENCY}{sweep}"),
        &["motion.frequency is uncertain although motion.frequency is swept"],
    );
    let interval = "interval = { value = \"23 Hz\", low = \"19 Hz\", high = \"21 Hz\" }";
    refused(
        &FREQUENCY.replace("uniform = { from = \"19 Hz\", to = \"21 Hz\" }", interval),
        &["high = 21 Hz is not above value = 23 Hz"],
    );
    let gap = "[[sensitivity]]\nkey = \"switching.gap_ticks\"\nlog = { from = 1, to = 3 }\n";
    refused(gap, &["switching.gap_ticks takes whole numbers only", "uniform"]);
}

#[test]
fn answers_that_are_none_say_what_to_do() {
    let desk = Desk::with(STUDY);
    desk.fails("sensitivity study.toml --device cpu", 3, &["no uncertain inputs", "[[sensitivity]]"]);
    desk.write("study.toml", &format!("{STUDY}{NOISE}"));
    let several = ["each point has several answers: filler is const, quadratic", "--where COLUMN=VALUE"];
    desk.fails("sensitivity study.toml --device cpu", 2, &several);
    desk.fails("sensitivity study.toml --device cpu --where filler=cubic", 2, &["filler = `cubic`"]);
    desk.fails("sensitivity study.toml --device cpu --by rsm", 2, &["no column is called `rsm`"]);
    desk.write("study.toml", &study(NOISE));
    desk.fails("sensitivity study.toml --device cpu --by dt_nu", 3, &["dt_nu is 0.2 everywhere"]);
    desk.fails(
        "sensitivity study.toml --device cpu --by filler",
        3,
        &["filler has no value at", "--by COLUMN"],
    );
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";
    desk.write("study.toml", &study(&format!("{NOISE}{sweep}")));
    desk.fails("sensitivity study.toml --device cpu", 3, &["motion.frequency is swept", "one point"]);
    let coarse =
        "[[sensitivity]]\nkey = \"gyro.readout_lsb\"\nlog = { from = \"1e-6 arcsec\", to = \"1 arcsec\" }\n";
    desk.write("study.toml", &study(coarse));
    let lost = ["gyro.readout_lsb = ", "″ is less than a unit"];
    desk.fails("sensitivity study.toml --device cpu --by theory_rms --samples 256", 3, &lost[1..]);
    desk.fails("sensitivity study.toml --samples 0", 2, &["--samples"]);
}
