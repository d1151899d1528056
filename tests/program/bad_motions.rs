//! Bad motions, records, fillers and precisions: refused with their place, what was found and what is accepted.

use crate::desk::{Desk, STUDY, record_refused, refused, replaced, with, with_motion};

const RECORD: &str = "time [s], rate [deg/s]\n";

/// Rows of `count` samples, 5 ms apart.
fn samples(count: usize) -> String {
    (0..count).map(|i| format!("{:.3}, {}\n", i as f64 * 0.005, i % 7)).collect()
}

/// 100 good samples between a header and a last row, which is line 102.
fn record(header: &str, last: &str) -> String {
    format!("{header}{}{last}", samples(100))
}

#[test]
fn a_record_that_is_not_there_is_pointed_at_in_the_study() {
    refused(
        &with_motion("profile = { file = \"none.csv\" }"),
        "7:20",
        &["cannot read the record", "none.csv", "No such file", "`time [s]` and `rate [deg/s]`"],
    );
}

#[test]
fn records_without_good_samples_are_refused() {
    let bad = |text: &str, place: &str, pieces: &[&str]| {
        record_refused(text.as_bytes(), &[&[&*format!("record.csv:{place}]")], pieces].concat());
    };
    bad(
        &record(RECORD, "0.53, 1\n"),
        "102:1",
        &["not evenly spaced: a step of 0.035 s", "the median is 0.005 s", "within 1 %"],
    );
    bad(&record(RECORD, "0.49, 1\n"), "102:1", &["the time does not increase: 0.49 after 0.495"]);
    bad(&record(RECORD, "0.5, NaN\n"), "102:6", &["the rate is missing"]);
    bad(&record(RECORD, "0.5, inf\n"), "102:6", &["`rate [deg/s]` is infinite here"]);
    bad(&record(RECORD, "0.5, fast\n"), "102:6", &["\"fast\", which is not a number"]);
    bad(&record(RECORD, "0.5\n"), "102:1", &["this row has 1 cell, the header has 2"]);
    bad(&record("time [s], rate\n", ""), "1:11", &["`rate` has no unit", "`rate [deg/s]`"]);
    bad(&record("time, rate [deg/s]\n", ""), "1:1", &["`time` has no unit", "time [s]"]);
    record_refused(b"", &["record.csv is empty", "one line for each sample"]);
    bad(RECORD, "1:1", &["at least 2 samples, this one has 0"]);
    let binary: Vec<u8> = (0..=255).cycle().take(4096).collect();
    record_refused(&binary, &["[study.toml:7:20]", "not UTF-8"]);
    record_refused(
        format!("{RECORD}{}", samples(6)).as_bytes(),
        &["[study.toml:7:11]", "has 5 whole ticks, too few for a gap of 3", "record for longer"],
    );
}

#[test]
fn spectra_and_bands_that_make_no_sense_are_refused() {
    let spectrum = |second: &str| {
        with_motion(&format!("gaussian = {{ psd = [[\"2 Hz\", \"10 (deg/s)^2/Hz\"], {second}] }}"))
    };
    refused(&spectrum("[\"3 Hz\", \"-1 (deg/s)^2/Hz\"]"), "7:59", &["at 3 Hz", "negative", "above 0"]);
    refused(&spectrum("[\"1 Hz\", \"1 (deg/s)^2/Hz\"]"), "7:51", &["does not rise at 1 Hz", "sort the rows"]);
    refused(&spectrum("[\"3 Hz\", \"1 deg/s\"]"), "7:59", &["is an angular rate", "(deg/s)^2/Hz"]);
    let gaussian = |high: &str| {
        with_motion(&format!("gaussian = {{ rms = \"100 arcsec/s\", band = [\"18 Hz\", \"{high}\"] }}"))
    };
    refused(
        &gaussian("2001 Hz"),
        "7:12",
        &["motion.gaussian = 2001 Hz is too fast for a tick rate of 200 Hz", "2000 Hz here"],
    );
    refused(&gaussian("17 Hz"), "7:43", &["runs from 18 Hz down to 17 Hz", "lower end first"]);
    refused(
        &with_motion("amplitude = \"1 deg/s\"\nfrequency = [\"18 Hz\", \"2001 Hz\"]"),
        "8:13",
        &["motion.frequency = 2001 Hz is too fast for a tick rate of 200 Hz", "2000 Hz here"],
    );
}

#[test]
fn tones_that_make_no_sense_are_refused() {
    let tones: Vec<String> =
        (1..=9).map(|k| format!("{{ amplitude = \"1 deg/s\", frequency = \"{k} Hz\" }}")).collect();
    refused(&with_motion(&format!("tones = [{}]", tones.join(", "))), "7:9", &["has 9 tones, more than 8"]);
    refused(&with_motion("tones = []"), "7:9", &["motion.tones is empty", "1 to 8 tones"]);
    refused(&with_motion(""), "6:1", &["[motion] is empty", "rate = \"0 deg/s\" for none"]);
    refused(&with_motion("amplitude = \"1 deg/s\""), "7:13", &["motion.frequency is missing", "20 Hz"]);
    refused(
        &with_motion("amplitude = { rayleigh = \"9 deg/s\" }\nfrequency = \"9 Hz\"\nphase = \"extremum\""),
        "9:9",
        &["Rayleigh", "random phase", "draw the amplitude uniformly"],
    );
    refused(
        &with_motion("amplitude = { uniform = [\"2 deg/s\", \"1 deg/s\"] }\nfrequency = \"9 Hz\""),
        "7:25",
        &["runs from 2 °/s down to 1 °/s", "lower end first"],
    );
    refused(
        &with_motion("amplitude = { uniform = [\"2 deg/s\", \"1 deg\"] }\nfrequency = \"9 Hz\""),
        "7:25",
        &["mixes a rate and an angle"],
    );
    refused(
        &with("[[sweep]]\nkey = \"motion.gaussian.rms\"\nlist = [\"1 deg/s\"]"),
        "13:7",
        &["motion.gaussian.rms is swept, but the motion has none", "motion.amplitude, motion.frequency"],
    );
}

#[test]
fn vibration_above_half_the_tick_rate_is_refused_unless_it_may_be_aliased() {
    let shaken = |lines: &str| with_motion(&format!("suspension = {{ {lines} }}"));
    let sine = |nu: &str| format!("sine = {{ acceleration = \"1 g\", frequency = \"{nu}\" }}");
    refused(
        &shaken(&format!("gyro = \"LGK-400\", {}", sine("50 Hz"))),
        "7:23",
        &[
            "the mode of 380 Hz is above 100 Hz, the Nyquist frequency of ticks of 0.005 s",
            "add alias = true",
        ],
    );
    let low = "modes = [{ frequency = \"80 Hz\", q = 50, response = \"1 deg/s/g\" }]";
    refused(
        &shaken(&format!("{low}, {}", sine("120 Hz"))),
        "7:126",
        &["a vibration of 120 Hz is above 100 Hz"],
    );
    let random = "random = { psd = [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"2000 Hz\", \"0.01 g^2/Hz\"]] }";
    refused(&shaken(&format!("{low}, {random}")), "7:100", &["a vibration of 2000 Hz is above 100 Hz"]);
    refused(
        &shaken(&format!("{low}, {}, alias = true", sine("2001 Hz"))),
        "7:126",
        &["a vibration of 2001 Hz is too fast for a tick rate of 200 Hz", "2000 Hz here"],
    );
}

#[test]
fn vibration_that_makes_no_sense_is_refused() {
    let shaken =
        |lines: &str| with_motion(&format!("suspension = {{ gyro = \"LGV-1\", alias = true{lines} }}"));
    let sine = ", sine = { acceleration = \"1 g\", frequency = \"50 Hz\" }";
    let random = |first: &str| format!(", random = {{ psd = [{first}, [\"2000 Hz\", \"0.01 g^2/Hz\"]] }}");
    let good = random("[\"20 Hz\", \"0.01 g^2/Hz\"]");
    refused(&shaken(""), "7:14", &["motion.suspension needs exactly one of sine, random"]);
    refused(&shaken(&format!("{sine}{good}")), "7:14", &["exactly one of sine, random"]);
    refused(
        &shaken(&sine.replace("1 g", "1 deg/s")),
        "7:70",
        &["is an angular rate", "an acceleration in g"],
    );
    let density = shaken(&random("[\"20 Hz\", \"0 g^2/Hz\"]"));
    refused(&density, "7:74", &["motion.suspension.random.psd has a density of 0 g²/Hz at 20 Hz"]);
    let backwards = shaken(&random("[\"3 kHz\", \"1 g^2/Hz\"]"));
    refused(&backwards, "7:88", &["motion.suspension.random.psd does not rise at 2000 Hz"]);
    refused(
        &shaken(sine).replace("alias = true", "alias = 1"),
        "7:40",
        &["`motion.suspension.alias`", "true or false"],
    );
    let beside = "\ngaussian = { rms = \"1 deg/s\", band = [\"1 Hz\", \"9 Hz\"] }";
    let both = with_motion(&format!("suspension = {{ gyro = \"LGV-1\", alias = true{good} }}{beside}"));
    refused(&both, "7:14", &["motion.suspension.random conflicts with motion.gaussian"]);
    refused(
        &with("[[sweep]]\nkey = \"motion.suspension.gyro\"\nlist = [\"LGV-1\"]"),
        "13:7",
        &["motion.suspension.gyro is swept, but the motion has no suspension"],
    );
    let swept = "[[sweep]]\nkey = \"motion.suspension.random.rms\"\nlist = [\"1 g\"]\n";
    refused(
        &format!("{}{swept}", shaken(sine)),
        "12:7",
        &["motion.suspension.random.rms is swept, but the motion has none"],
    );
}

#[test]
fn fillers_that_make_no_sense_are_refused() {
    let filler = |entry: &str| replaced("\"const\", \"quadratic\"", entry);
    let weights = |weights: &str| filler(&format!("{{ kind = \"weights\", weights = {weights} }}"));
    refused(
        &weights("[-1, 1, 1, 1]"),
        "11:12",
        &["the weights sum to 2, not to n = 3", "a constant rate Ω would leave an error of -1·Ω·T"],
    );
    refused(&weights("[1, 1, 1]"), "11:12", &["3 weights stand for 4 ticks [-1, 0, 4, 5]"]);
    refused(&weights("[1, 1, \"x\", 1]"), "11:49", &["is not a weight", "fractions such as"]);
    refused(&filler("{ kind = \"weights\" }"), "11:12", &["needs weights"]);
    refused(&filler("\"const\", \"const\""), "11:21", &["lists \"const\" twice"]);
    refused(
        &filler("\"linear\", { kind = \"minimum-variance\", name = \"linear\" }"),
        "11:22",
        &["lists \"linear\" twice", "another name"],
    );
    refused(&filler("\"cubic\""), "11:12", &["\"cubic\" is not a filler", "const, linear, quadratic"]);
    let many = "{ kind = \"minimum-variance\", fit_ticks = [\"-7..0\", \"n+1..n+4\"] }";
    refused(
        &filler(many).replace("1 arcsec", "0 arcsec"),
        "5:22",
        &[
            "gyro.tick_noise: the covariance of the ticks of `minimum-variance` is singular",
            "fewer fit ticks",
        ],
    );
    refused(&with("errors = [\"residul\"]"), "12:11", &["did you mean `residual`?", "in-gap"]);
    refused(&with("errors = []"), "12:10", &["switching.errors is empty"]);
}

#[test]
fn readouts_and_relocks_that_make_no_sense_are_refused() {
    let gyro = |line: &str| replaced("[motion]", &format!("{line}\n[motion]"));
    refused(&gyro("readout_lsb = \"-1 arcsec\""), "6:15", &["readout_lsb = -1″", "negative"]);
    refused(&gyro("relock = [\"1 s\"]"), "6:11", &["\"1 s\" is a time", "an angle in arcsec"]);
}

#[test]
fn precisions_that_make_no_sense_are_refused() {
    let precision = |value: &str| format!("precision = {value}\n{STUDY}");
    refused(&precision("\"fine\""), "1:13", &["\"fine\" is not a percentage", "p99_73 = \"2 %\""]);
    refused(&precision("\"0 %\""), "1:13", &["precision = 0 % is out of range", "0.0001 % … 50 %"]);
    refused(&precision("0.5"), "1:13", &["0.5 is not a percentage"]);
    let level = |part: &str| {
        let desk = Desk::with(&precision(&format!("{{ p99_73 = \"{part} %\" }}")));
        crate::desk::unwrapped(&desk.done("run study.toml --device cpu --trials 1000").stderr)
    };
    assert!(level("0.7").contains("some may not reach the 0.7 % requested, and take all trials"));
    assert!(
        level("0.1").contains("none reaches the 0.1 %")
            && !level("1").contains("levels are only known to a bin")
    );
    refused(&precision("{}"), "1:13", &["names no estimate"]);
    let desk = Desk::with(&format!(
        "precision = \"1 %\"\n{}",
        with_motion("profile = { file = \"r.csv\", position = \"every\" }")
    ));
    desk.write("r.csv", &record(RECORD, &samples(1000).split_off(samples(100).len())));
    desk.fails(
        "run study.toml",
        3,
        &["[study.toml:1:13]", "exact in whole replays", "position = \"random\""],
    );
}
